//! Leave one out: the first frame of a video that the database may not use is animated and compared with what the video truly shows.

use crate::{
    animate::Looks,
    args,
    commands::Failure,
    database::Database,
    features::Features,
    footage::{Class, Footage, Video},
    label::{self, Grid, Labelling, Solver},
    patch::{PatchRef, SIDE, STRIDE, Version},
    plane::Plane,
    render,
    video::{
        denoise::denoise,
        source::{Extent, Source},
    },
};
use image::RgbImage;
use std::collections::BTreeMap;
use yurameki::{
    app::Show,
    config::Life,
    display::sim::{Buffering, Sim, memory_len},
    effect::{
        Photo,
        shimmer::{Shimmer, storage_len},
    },
    frame::{Layout, PixelFormat, Size},
};
use yurameki_naturalness::{
    Clip, Region,
    clip::luminance,
    spacetime,
    statistics::{amplitude_ratio, coherence, median},
    temporal,
};

/// Seconds of every video.
const SECONDS: f32 = 6.0;

/// The pixels that move most, which are compared: the share of the table of slopes.
const MOVING: f32 = 0.4;

/// What is compared, in the order of the columns: tps and st, both to fall; log10 of the amplitude's ratio to the truth's; the coherence at 24 pixels.
type Measures = [Option<f32>; 4];

/// `evaluate`: a table a video, and the medians of each class.
///
/// # Errors
///
/// A video that cannot be read, or a database that cannot be used.
pub fn evaluate(args: &args::Evaluate) -> Result<(), Failure> {
    let database = Database::open(&args.db)?;
    let mut found: BTreeMap<(Class, &'static str), Vec<Measures>> = BTreeMap::new();
    for source in Source::list(&args.truth)? {
        let name = source.name();
        let truth = match Truth::read(&source, &database) {
            Ok(truth) => truth,
            Err(error) => {
                println!("{name}: skipped: {error}");
                continue;
            }
        };
        println!("{name} ({}, {} frames)", truth.class.name(), truth.clip.frames.len());
        for (method, clip) in truth.animations(&database, args.solver.into())? {
            let measures = truth.measure(&clip);
            println!("  {}", line(method, &measures));
            found.entry((truth.class, method)).or_default().push(measures);
        }
    }
    for ((class, method), measures) in found {
        let of = |column: usize| median(measures.iter().filter_map(|row| row[column]).collect());
        println!(
            "median {} ({}) {}",
            class.name(),
            measures.len(),
            line(method, &[of(0), of(1), of(2), of(3)])
        );
    }
    Ok(())
}

fn line(method: &str, measures: &Measures) -> String {
    let number = |value: &Option<f32>| value.map_or("     -".to_owned(), |value| format!("{value:6.3}"));
    let [tps, st, amplitude, coherence] = measures.each_ref().map(number);
    format!("{method:<10} tps {tps} st {st} amplitude {amplitude} coherence {coherence}")
}

/// A video that is kept out.
struct Truth {
    class: Class,
    frames: Vec<RgbImage>,
    clip: Clip,
    region: Region,
    /// Where the picture may move, 0..=1.
    matte: Plane,
    /// Its number, if the database has it.
    number: Option<u32>,
}

impl Truth {
    fn read(source: &Source, database: &Database) -> Result<Self, Failure> {
        let read = source.read(Extent { seconds: SECONDS, rate: 25.0 })?;
        let frames = denoise(&read.frames);
        let first = frames.first().ok_or("it has no frames")?;
        if frames.len() < 24 {
            return Err("it has fewer than 24 frames".into());
        }
        let name = source.name();
        let known = database.videos().find(|video| video.name == name);
        let class = known.map(|video| video.class).or_else(|| source.class_by_name());
        let class = class.ok_or("its name does not say whether it is water, fire or smoke")?;
        let (width, height) = (first.width() as usize, first.height() as usize);
        let luma = |frame: &RgbImage| frame.pixels().map(|pixel| luminance(pixel.0)).collect();
        let clip = Clip { width, height, rate: read.rate, frames: frames.iter().map(luma).collect() };
        let region = Region::moving(&clip, MOVING);
        let number = known.map(|video| video.number);
        let values = region.pixels().iter().map(|&inside| f32::from(u8::from(inside))).collect();
        Ok(Self { class, matte: Plane { width, height, values }, frames, clip, region, number })
    }

    /// What each method makes of the first frame.
    fn animations(&self, database: &Database, solver: Solver) -> Result<Vec<(&'static str, Clip)>, Failure> {
        let features: Vec<Features> = database
            .features(self.class)?
            .into_iter()
            .filter(|patch| Some(patch.patch.video) != self.number)
            .collect();
        let target = Looks::of(&self.frames[0], database).target(Some(&self.matte));
        let labelled = |solver| {
            label::label(&target, &features, &label::Options { solver, ..label::Options::default() })
        };
        let greedy = labelled(Solver::Greedy)?;
        let full = labelled(solver)?;
        let stretched = most_used(&greedy.labelling).and_then(|number| database.video(number));
        let half = self.clip.frames.len() / 2;
        let mut made = vec![
            ("full", self.render(&full.labelling, database)?),
            ("greedy", self.render(&greedy.labelling, database)?),
        ];
        if let Some(video) = stretched {
            made.push(("stretched", self.render(&self.stretch(&greedy.labelling, video), database)?));
        }
        made.push(("shimmer", self.shimmer()?));
        made.push(("still", self.clip.still()));
        made.push(("ceiling", self.clip.part(half, half)));
        Ok(made)
    }

    fn render(&self, labelling: &Labelling, database: &Database) -> Result<Clip, Failure> {
        let seconds = self.clip.frames.len() as f32 / self.clip.rate;
        let options = render::Options {
            seconds: Some(seconds),
            rate: Some(self.clip.rate),
            ..render::Options::new(self.class)
        };
        let animation =
            render::animate(&self.frames[0], &self.matte, labelling, database, &options, &|_, _, _| {})?;
        let luma = |index| animation.frame(index).pixels().map(|pixel| luminance(pixel.0)).collect();
        Ok(Clip { frames: (0..animation.frames()).map(luma).collect(), ..self.clip.part(0, 0) })
    }

    /// Each patch shows the place of `video` that lies where it does in the picture.
    fn stretch(&self, labelling: &Labelling, video: &Video) -> Labelling {
        let Some(version) = Version::new(0) else { return labelling.clone() };
        let place = |index: usize, size: usize, side: u32| {
            let reach = (side as f32 - SIDE as f32).max(0.0) / 2.0;
            let centre = (index * STRIDE + SIDE / 2) as f32 / size as f32 * side as f32 - side as f32 / 2.0;
            centre.clamp(-reach, reach) as i16
        };
        let Grid { columns, .. } = labelling.grid;
        let patch = |(index, patch): (usize, &Option<PatchRef>)| {
            patch.map(|_| PatchRef {
                video: video.number,
                version,
                x: place(index % columns, self.clip.width, video.width),
                y: place(index / columns, self.clip.height, video.height),
            })
        };
        Labelling { grid: labelling.grid, patches: labelling.patches.iter().enumerate().map(patch).collect() }
    }

    /// The same picture as the frame shows it without any video: the shimmer as it is by default.
    fn shimmer(&self) -> Result<Clip, Failure> {
        let size = Size::new(self.clip.width as u32, self.clip.height as u32);
        let mask: Vec<u8> = self.matte.values.iter().map(|value| (value * 255.0) as u8).collect();
        let life = Life::default();
        let photo = Photo { size, rgb: self.frames[0].as_raw(), mask: &mask };
        let mut shimmer = Shimmer::prepare(photo, &life.shimmer, vec![0; storage_len(size)])?;
        let layout = Layout::new(size, PixelFormat::Bgr888, None)?;
        let mut panel =
            Sim::new(vec![0; memory_len(layout, Buffering::Single)], layout, Buffering::Single, 0)?;
        let mut show = Show::new(life.drive, (self.clip.rate.round() as u32).clamp(1, 60), 7);
        show.come_alive();
        let mut frames = Vec::new();
        for _ in 0..self.clip.frames.len() {
            show.turn(&mut shimmer, "", &mut panel)?;
            let frame = panel.shown().ok_or("the simulated panel shows nothing")?;
            let mut luma = Vec::with_capacity(size.pixels());
            for row in frame.rows() {
                luma.extend(row.as_chunks().0.iter().take(self.clip.width).map(|&rgb| luminance(rgb)));
            }
            frames.push(luma);
        }
        Ok(Clip { frames, ..self.clip.part(0, 0) })
    }

    fn measure(&self, clip: &Clip) -> Measures {
        [
            temporal::distance(clip, &self.clip, &self.region),
            spacetime::distance(clip, &self.clip, &self.region),
            amplitude_ratio(clip, &self.clip, &self.region),
            coherence(clip, &self.region, STRIDE),
        ]
    }
}

/// The video that most patches were given.
fn most_used(labelling: &Labelling) -> Option<u32> {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    for patch in labelling.patches.iter().flatten() {
        *counts.entry(patch.video).or_default() += 1;
    }
    counts.into_iter().max_by_key(|&(_, count)| count).map(|(video, _)| video)
}
