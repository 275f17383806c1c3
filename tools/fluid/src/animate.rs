//! From a picture to a clip: what `animate` does, step by step.

use crate::{
    appearance,
    args::{self, SolverChoice},
    commands::Failure,
    database::Database,
    features::Features,
    footage::{Class, Footage},
    guidance::{self, Guidance},
    label::{self, Grid, Solver, Target},
    matte,
    plane::Plane,
    render::{self, Stage},
    video,
};
use image::{ImageReader, Limits, RgbImage, imageops::FilterType};
use indicatif::{ProgressBar, ProgressStyle};
use std::{error::Error, path::Path, sync::Mutex, time::Instant};

/// The largest size at which a picture is labelled and its detail drawn: that of the paper's videos.
const WORKING: (u32, u32) = (640, 360);

/// The picture's largest side in a file. What is larger would not fit into the memory of a small PC.
const LARGEST: u32 = 16_384;

/// `animate`.
///
/// # Errors
///
/// A line that names the file or the option at fault.
pub fn animate(args: &args::Animate) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let picture = open(&args.picture)?;
    let small = working(&picture);
    let size = (small.width() as usize, small.height() as usize);
    let database = Database::open(&args.db)?;
    clock.took("loading");

    let mut guidance = Guidance::default();
    if let Some(strokes) = &args.strokes {
        guidance.direct(strokes, size)?;
    }
    if let Some(speed) = &args.speed {
        guidance.hasten(speed, size)?;
    }
    let background = args.background.as_deref().map(open).transpose()?;

    let looks = Looks::of(&small, &database);
    let class = match args.class {
        Some(class) => class.into(),
        None => guess(&looks, &database)?,
    };
    clock.took("scene");
    let matte = if args.matte == Path::new("auto") {
        matte::automatic(&small, class)
    } else {
        guidance::matte(&args.matte, size)?
    };
    if let Some(file) = &args.show_direction {
        save(&guidance.show(&small, Some(&matte)), file)?;
    }
    let features = database.features(class)?;
    let mut target = looks.target(Some(&matte));
    guidance.ask(&mut target);
    let options =
        label::Options { solver: args.solver.into(), compare: args.energies, ..label::Options::default() };
    let labelled = label::label(&target, &features, &options)?;
    clock.took("labelling");
    println!("{}: {} from {} patches\n{labelled}", args.picture.display(), class.name(), features.len());

    let bar = Bar::new();
    let options = render::Options { seconds: Some(args.seconds), background, ..render::Options::new(class) };
    let animation =
        render::animate(&picture, &matte, &labelled.labelling, &database, &options, &|stage, done, of| {
            bar.tell(stage, done, of);
        })?;
    clock.took("rendering");
    let written = render::write_clip(&animation, &args.out, &|stage, done, of| bar.tell(stage, done, of))?;
    clock.took("writing");
    drop(bar);
    if let Some(file) = &args.show_assignment {
        save(&label::assignment(&small, &labelled.labelling, &database)?, file)?;
    }
    if let Some(file) = &args.show_speed {
        let speeds = guidance::speed_picture(Grid::of(size.0, size.1), &labelled.motions, size);
        speeds.save(file).map_err(|error| at(file, &error))?;
    }
    println!("{}: {} frames, {:.1} MB", args.out.display(), written.frames, written.bytes as f64 / 1e6);
    println!("{clock}");
    Ok(())
}

/// The words of a picture, with its luminance.
pub(crate) struct Looks {
    luma: Plane,
    words: Vec<crate::features::WordMap>,
}

impl Looks {
    /// Those of `small` in the vocabulary of `database`.
    pub(crate) fn of(small: &RgbImage, database: &Database) -> Self {
        let (width, height) = (small.width() as usize, small.height() as usize);
        let luma = Plane { width, height, values: video::luma(small).into_iter().map(f32::from).collect() };
        let words = appearance::describe(&luma, Grid::of(width, height), database.vocabulary());
        Self { luma, words }
    }

    /// What is to be labelled.
    pub(crate) fn target(&self, matte: Option<&Plane>) -> Target {
        Target::new(&self.luma, matte, self.words.clone())
    }
}

/// The class of the patches that look like the picture's.
fn guess(looks: &Looks, database: &Database) -> Result<Class, Failure> {
    let mut all: Vec<Features> = Vec::new();
    for class in Class::ALL {
        all.extend(database.features(class)?);
    }
    let class =
        label::scene_class(&looks.target(None), &all, |video| database.video(video).map(|video| video.class));
    class.ok_or_else(|| "the database has no patches: index some videos first".into())
}

impl From<SolverChoice> for Solver {
    fn from(choice: SolverChoice) -> Self {
        match choice {
            SolverChoice::Trws => Self::Trws,
            SolverChoice::Expansion => Self::Expansion,
            SolverChoice::Icm => Self::Icm,
            SolverChoice::Greedy => Self::Greedy,
        }
    }
}

/// Opens a picture that may be anything.
fn open(file: &Path) -> Result<RgbImage, Failure> {
    let reader = ImageReader::open(file)
        .and_then(ImageReader::with_guessed_format)
        .map_err(|error| at(file, &error))?;
    let mut reader = reader;
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST);
    limits.max_image_height = Some(LARGEST);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| at(file, &error))?.to_rgb8();
    let least = crate::patch::SIDE as u32;
    if picture.width() < least || picture.height() < least {
        return Err(format!(
            "{}: smaller than a patch: it must have {least} pixels at least each way",
            file.display()
        )
        .into());
    }
    Ok(picture)
}

/// The picture at the working size.
pub(crate) fn working(picture: &RgbImage) -> RgbImage {
    let share = (f64::from(WORKING.0) / f64::from(picture.width()))
        .min(f64::from(WORKING.1) / f64::from(picture.height()))
        .min(1.0);
    let side = |side: u32| ((f64::from(side) * share).round() as u32).max(crate::patch::SIDE as u32);
    image::imageops::resize(picture, side(picture.width()), side(picture.height()), FilterType::Triangle)
}

fn save(picture: &RgbImage, file: &Path) -> Result<(), Failure> {
    picture.save(file).map_err(|error| at(file, &error))
}

fn at(file: &Path, error: &dyn Error) -> Failure {
    format!("{}: {error}", file.display()).into()
}

/// A bar on stderr where that is a terminal.
struct Bar(Mutex<(ProgressBar, Option<Stage>)>);

impl Bar {
    fn new() -> Self {
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self(Mutex::new((ProgressBar::new(0).with_style(style), None)))
    }

    fn tell(&self, stage: Stage, done: usize, of: usize) {
        let mut bar = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if bar.1 != Some(stage) {
            bar.1 = Some(stage);
            bar.0.reset();
            bar.0.set_message(match stage {
                Stage::Detail => "videos",
                Stage::Look => "look",
                Stage::Outline => "outlines",
                Stage::Write => "writing",
            });
        }
        bar.0.set_length(of as u64);
        bar.0.set_position(done as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner).0.finish_and_clear();
    }
}

/// Accounts for every second.
struct Clock {
    last: Instant,
    steps: Vec<(&'static str, f64)>,
}

impl Clock {
    fn start() -> Self {
        Self { last: Instant::now(), steps: Vec::new() }
    }

    fn took(&mut self, step: &'static str) {
        self.steps.push((step, self.last.elapsed().as_secs_f64()));
        self.last = Instant::now();
    }
}

impl std::fmt::Display for Clock {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (step, seconds) in &self.steps {
            write!(f, "{step} {seconds:.2} s, ")?;
        }
        write!(f, "in all {:.2} s", self.steps.iter().map(|(_, seconds)| seconds).sum::<f64>())
    }
}
