//! A photo with its mask, as a panel needs them.

use super::{
    Failure,
    args::MaskChoice,
    autumn, caption,
    clip::{self, ClipFile},
    config::{Config, Look},
    once::once,
    photo,
};
use crate::{
    app::{self, Subject},
    config::{EffectChoice, Life},
    effect::{
        Photo,
        autumn::{Plates, Species, Tree},
        fluid::{Base, Clip, ClipError, View},
        kaleidoscope::{Mode, Reference},
        shimmer::automatic_mask::{HARDLY_ANYTHING_PER_MILLE, automatic_mask, moving_per_mille, scratch_len},
    },
    frame::{Rotation, Size, rotate},
    math::Turns,
};
use log::Level;
use std::path::{Path, PathBuf};

/// A photo or a clip that lives.
pub type Picture = app::Picture<Vec<u64>, ClipFile>;

/// Which photo.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// A file.
    File(&'a Path),
    /// The one that the program carries; for an autumn, no photo but a tree.
    Demo,
}

/// "Forest" by Moritz Reisinger, CC BY-SA 3.0: see tests/data/README.md.
static DEMO: &[u8] = include_bytes!("../../tests/data/demo.jpg");

/// What buttons choose of how photos live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Way {
    pub(super) effect: EffectChoice,
    /// The mode of a kaleidoscope.
    pub(super) mode: Mode,
}

impl Way {
    /// The way after this one: the shimmer, the kaleidoscope from its finest mode to the paper's, then the autumn.
    pub(super) const fn next(self) -> Self {
        let (effect, mode) = match (self.effect, self.mode) {
            (EffectChoice::Shimmer, _) => (EffectChoice::Kaleidoscope, Mode::Watercolour),
            (EffectChoice::Kaleidoscope, Mode::Watercolour) => (EffectChoice::Kaleidoscope, Mode::Tonal),
            (EffectChoice::Kaleidoscope, Mode::Tonal) => (EffectChoice::Kaleidoscope, Mode::Literal),
            (EffectChoice::Kaleidoscope, Mode::Literal) => (EffectChoice::Autumn, self.mode),
            (EffectChoice::Autumn, _) => (EffectChoice::Shimmer, self.mode),
        };
        Self { effect, mode }
    }

    /// Whether a picture that lives in this way looks as one that lives in the `other`.
    pub(super) fn looks_as(self, other: Self) -> bool {
        self.effect == other.effect && (self.effect != EffectChoice::Kaleidoscope || self.mode == other.mode)
    }
}

/// The photo whose colours a kaleidoscope is to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Colours {
    /// Where the configuration names no other.
    Offered(PathBuf),
    /// By a button, which goes before the configuration.
    Chosen(PathBuf),
}

/// A photo and its mask at the panel's size, turned as the panel is mounted.
#[derive(Debug)]
pub struct Scene {
    caption: String,
    size: Size,
    rgb: Vec<u8>,
    mask: Vec<u8>,
    look: Look,
    reference: Option<photo::Photo>,
    /// Where the photo is whose colours were asked for; one that is bad is not the `reference`.
    colours: Option<PathBuf>,
    tree: Option<Grove>,
    /// The clip whose base the photo is, where it plays.
    clip: Option<(Clip<ClipFile>, View)>,
}

/// What an autumn is made of.
#[derive(Debug)]
struct Grove {
    species: Box<Species>,
    plates: Option<Box<Plates>>,
    /// Whether it is the photo whose foliage turns.
    in_photo: bool,
}

impl Grove {
    fn load(look: &Look, in_photo: bool) -> Result<Self, Failure> {
        let species = Box::new(autumn::species(&look.tree)?);
        Ok(Self { species, plates: autumn::plates(&look.plates)?, in_photo })
    }

    fn tree(&self) -> Tree<'_> {
        Tree { species: &self.species, plates: self.plates.as_deref() }
    }
}

impl Scene {
    /// Loads the photo at `source`, its mask and its sidecar for a panel of `size` that is mounted as `config` says.
    ///
    /// # Errors
    /// A photo, mask or reference that cannot be used; one line that names it, what is wrong and the cure.
    pub fn load(source: Source<'_>, size: Size, config: &Config) -> Result<Self, Failure> {
        Self::load_as(source, None, None, size, config)
    }

    /// As [`Self::load`]; a kaleidoscope takes `colours`, and the photo lives in the `way` that a button has chosen.
    pub(super) fn load_as(
        source: Source<'_>,
        colours: Option<Colours>,
        way: Option<Way>,
        size: Size,
        config: &Config,
    ) -> Result<Self, Failure> {
        let mut look = match source {
            Source::File(path) => config.look(path),
            Source::Demo => config.plain_look(),
        };
        if let Some(way) = way {
            (look.effect, look.life.kaleidoscope.mode) = (way.effect, way.mode);
        }
        let rotation = config.rotation;
        let upright = rotation.turned(size);
        let limits = photo::Limits { bytes: config.memory_ceiling_bytes, ..photo::Limits::default() };
        let options = photo::Options { size: upright, fit: look.fit, background: look.background, limits };
        let photo = match source {
            Source::File(path) => photo::load(path, &options)?,
            Source::Demo => photo::from_bytes("the demo photo", DEMO, &options)?,
        };
        let clip = match (source, look.effect) {
            (Source::File(path), EffectChoice::Shimmer) => load_clip(path, &photo, rotation)?,
            _ => None,
        };
        let colours = match (colours, &look.reference) {
            _ if look.effect != EffectChoice::Kaleidoscope => None,
            (Some(Colours::Offered(_)) | None, Some(written)) => Some(written.clone()),
            (Some(Colours::Chosen(path) | Colours::Offered(path)), _) => Some(path),
            (None, None) => None,
        };
        let (mask, reference) = match look.effect {
            // It has its own.
            _ if clip.is_some() => (vec![0; upright.pixels()], None),
            EffectChoice::Shimmer | EffectChoice::Autumn => {
                (choose_mask(source, &photo, &look, &options.limits)?, None)
            }
            // All of it moves.
            EffectChoice::Kaleidoscope => {
                (vec![255; upright.pixels()], load_reference(colours.as_deref(), &look, &options.limits)?)
            }
        };
        let mut caption = match source {
            Source::File(path) => caption::of_file(path),
            Source::Demo => "\"Forest\" by Moritz Reisinger\nCC BY-SA 3.0".into(),
        };
        if let Some(path) = colours.as_ref().filter(|_| reference.is_some()) {
            caption += "\nin the colours of ";
            caption += &caption::name_of(path);
        }
        let reference = match reference {
            // Its own colours, as the person sees it: seen by the panel's side, others would be chosen.
            None if look.effect == EffectChoice::Kaleidoscope && rotation != Rotation::None => {
                Some(photo.clone())
            }
            reference => reference,
        };
        let grove = || Grove::load(&look, matches!(source, Source::File(_)));
        let tree = (look.effect == EffectChoice::Autumn).then(grove).transpose()?;
        if rotation == Rotation::None {
            return Ok(Self { caption, size, rgb: photo.rgb, mask, look, reference, colours, tree, clip });
        }
        let (mut rgb, mut turned_mask) = (vec![[0; 3]; size.pixels()], vec![0; size.pixels()]);
        rotate(rotation, photo.rgb.as_chunks::<3>().0, upright, &mut rgb);
        rotate(rotation, &mask, upright, &mut turned_mask);
        Ok(Self {
            caption,
            size,
            rgb: rgb.into_flattened(),
            mask: turned_mask,
            look,
            reference,
            colours,
            tree,
            clip,
        })
    }

    /// What the information on the picture says of the photo: a line or a few.
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// How the photo is shown: as its sidecar says, or as all are.
    pub const fn look(&self) -> &Look {
        &self.look
    }

    /// The effect, and its mode.
    pub(super) const fn way(&self) -> Way {
        Way { effect: self.look.effect, mode: self.look.life.kaleidoscope.mode }
    }

    /// The photo whose colours were asked for.
    pub(super) fn colours(&self) -> Option<&Path> {
        self.colours.as_deref()
    }

    /// Whether it is a tree of the program's own, and not of a photo.
    pub(super) fn is_grown(&self) -> bool {
        self.tree.as_ref().is_some_and(|grove| !grove.in_photo)
    }

    /// The photo with the effect that was chosen for it, or the clip, which lives as `life` says. `progress` is told how much of a kaleidoscope is
    /// coded, in per cent.
    ///
    /// # Errors
    /// If there is less memory than that takes, or a clip is damaged.
    pub fn prepare(
        &self,
        life: &Life,
        mut storage: Vec<u64>,
        progress: impl FnMut(u8),
    ) -> Result<Picture, Failure> {
        let effect = self.look.effect;
        // Without another, a photo gives its own colours.
        let own = Reference { size: self.size, rgb: &self.rgb };
        let reference =
            self.reference.as_ref().map_or(own, |other| Reference { size: other.size, rgb: &other.rgb });
        let subject = match (effect, &self.tree) {
            _ if let Some((clip, view)) = &self.clip => {
                Subject::Clip(Base { size: self.size, rgb: &self.rgb, view: *view }, clip.clone())
            }
            (EffectChoice::Autumn, Some(grove)) if grove.in_photo => {
                Subject::Foliage(self.photo(), grove.tree())
            }
            (EffectChoice::Autumn, Some(grove)) => Subject::Tree(self.size, grove.tree()),
            (EffectChoice::Kaleidoscope, _) => Subject::Kaleidoscope(self.photo(), reference),
            (EffectChoice::Shimmer | EffectChoice::Autumn, _) => Subject::Shimmer(self.photo()),
        };
        let needed = subject.storage_len(life);
        storage.try_reserve_exact(needed.saturating_sub(storage.len()))?;
        storage.resize(needed, 0);
        Ok(Picture::prepare(subject, life, storage, progress)?)
    }

    /// What an effect is prepared from.
    pub fn photo(&self) -> Photo<'_> {
        Photo { size: self.size, rgb: &self.rgb, mask: &self.mask }
    }
}

/// The life of a picture whose panel is mounted turned: light and wind turn with the picture, and a kaleidoscope is coded upright.
pub(super) fn turned(mut life: Life, rotation: Rotation) -> Life {
    let turn = Turns::from_degrees(rotation.degrees() as i32);
    let shimmer = &mut life.shimmer;
    shimmer.light.azimuth = shimmer.light.azimuth.plus(turn);
    shimmer.wind = shimmer.wind.plus(turn);
    life.kaleidoscope.rotation = rotation;
    life.autumn.rotation = rotation;
    life
}

/// The clip at `path`, if it is one, whose base is `photo`. A clip plays wherever a photo would shimmer; for every other effect it is the photo that
/// its base is.
fn load_clip(
    path: &Path,
    photo: &photo::Photo,
    rotation: Rotation,
) -> Result<Option<(Clip<ClipFile>, View)>, photo::PhotoError> {
    let Some(clip) = clip::open(path)? else { return Ok(None) };
    if clip.header().shape.base != photo.source_size {
        let fault = photo::Fault::Clip(ClipError::Picture(photo.source_size));
        return Err(photo::PhotoError::new(&photo.name, fault));
    }
    let view = View { rotation, picture: photo.picture, shown: photo.shown() };
    Ok(Some((clip, view)))
}

/// A reference is looked at no more closely than this.
const REFERENCE_SIZE: Size = Size::new(1024, 1024);

/// The photo at `colours`. One that the configuration names must be good; any other may be as bad as any of a show.
pub(super) fn load_reference(
    colours: Option<&Path>,
    look: &Look,
    limits: &photo::Limits,
) -> Result<Option<photo::Photo>, Failure> {
    let Some(path) = colours else { return Ok(None) };
    match photo::load_within(path, REFERENCE_SIZE, limits) {
        Err(error) if look.reference.as_deref() == Some(path) => Err(error.into()),
        loaded => Ok(loaded.ok()),
    }
}

/// The mask that was asked for; without a word, the one beside the photo, else the automatic one.
fn choose_mask(
    source: Source<'_>,
    photo: &photo::Photo,
    look: &Look,
    limits: &photo::Limits,
) -> Result<Vec<u8>, Failure> {
    let beside = match source {
        Source::File(path) => Some(photo::mask_path(path)).filter(|path| path.exists()),
        Source::Demo => None,
    };
    let mut mask = match (&look.mask, beside) {
        (Some(MaskChoice::Everything), _) => everything(photo),
        (Some(MaskChoice::File(path)), _) => photo::load_mask(path, photo, limits)?,
        (None, Some(path)) => match photo::load_mask(&path, photo, limits) {
            Ok(mask) => {
                once(Level::Info, format!("{}: moves as {} says", photo.name, path.display()));
                mask
            }
            // A picture that happens to have such a name, or that was damaged, takes no photo out of the show.
            Err(error) => {
                once(Level::Warn, format!("{}: {error}; the automatic mask takes its place", photo.name));
                automatic(photo)
            }
        },
        (None | Some(MaskChoice::Automatic), _) => automatic(photo),
    };
    feather(&mut mask, photo);
    Ok(mask)
}

/// How far from a border around the photo its motion fades out, in parts of its shorter side: the relief is found over the whole panel, and
/// would run along the seam.
const SEAM: u32 = 40;

/// Fades the mask out where the photo ends before the panel does.
fn feather(mask: &mut [u8], photo: &photo::Photo) {
    let (rect, panel) = (photo.picture, photo.size);
    let seam = (rect.size.width.min(rect.size.height) / SEAM).max(1);
    // Pixels to the nearer of the two ends that are seams.
    let distance = |at: u32, start: u32, length: u32, whole: u32| {
        let left = if start > 0 { at } else { seam };
        let right = if start + length < whole { length - 1 - at } else { seam };
        left.min(right).min(seam)
    };
    for y in 0..rect.size.height {
        let down = distance(y, rect.y, rect.size.height, panel.height);
        for x in 0..rect.size.width {
            let share = down.min(distance(x, rect.x, rect.size.width, panel.width));
            let i = ((rect.y + y) * panel.width + rect.x + x) as usize;
            mask[i] = (u32::from(mask[i]) * share / seam) as u8;
        }
    }
}

/// The whole photo moves; the border around it does not.
fn everything(photo: &photo::Photo) -> Vec<u8> {
    let mut mask = vec![0; photo.size.pixels()];
    paste(&mut mask, photo, &vec![255; photo.picture.size.pixels()]);
    mask
}

/// What plausibly moves of the photo itself; the border around it does not.
pub(super) fn automatic(photo: &photo::Photo) -> Vec<u8> {
    let size = photo.picture.size;
    let mut picture = Vec::with_capacity(size.pixels() * 3);
    for row in rows(photo) {
        picture.extend_from_slice(&photo.rgb[row.start * 3..row.end * 3]);
    }
    let mut part = vec![0; size.pixels()];
    automatic_mask(&picture, size, &mut vec![0; scratch_len(size)], &mut part);
    if moving_per_mille(&part) < HARDLY_ANYTHING_PER_MILLE {
        let line = "hardly anything in it seems to move; a mask beside it can say what does";
        once(Level::Info, format!("{}: {line}", photo.name));
    }
    let mut mask = vec![0; photo.size.pixels()];
    paste(&mut mask, photo, &part);
    mask
}

/// The pixels of the panel that the photo itself takes, row by row.
fn rows(photo: &photo::Photo) -> impl Iterator<Item = std::ops::Range<usize>> {
    let (rect, width) = (photo.picture, photo.size.width as usize);
    (0..rect.size.height as usize).map(move |y| {
        let start = (rect.y as usize + y) * width + rect.x as usize;
        start..start + rect.size.width as usize
    })
}

fn paste(mask: &mut [u8], photo: &photo::Photo, part: &[u8]) {
    for (row, part) in rows(photo).zip(part.chunks_exact(photo.picture.size.width as usize)) {
        mask[row].copy_from_slice(part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::os::args;
    use crate::{
        effect::{
            Effect, Paint,
            shimmer::{Range, Shimmer, storage_len},
        },
        frame::{FrameMut, Layout, PixelFormat},
        math::Factor,
        noise::drive::Drive,
    };
    use clap::Parser;

    #[derive(Parser)]
    struct Words {
        #[command(flatten)]
        look: args::Look,
    }

    /// The demo photo at a moment of its life on a panel that is mounted turned, seen upright.
    fn upright(size: Size, rotation: Rotation, range: Range) -> Vec<[u8; 3]> {
        let typed = Words::parse_from(["", "--light", "20,35", "--wind", "65", "--strength", "1.5"]).look;
        let config = Config { typed, rotation, ..Config::default() };
        let panel = rotation.turned(size);
        let scene = Scene::load(Source::Demo, panel, &config).unwrap();
        let mut life = turned(scene.look().life, rotation);
        life.shimmer.range = range;
        let mut storage = vec![0; storage_len(panel)];
        let mut shimmer = Shimmer::prepare(scene.photo(), &life.shimmer, &mut storage).unwrap();
        let layout = Layout::new(panel, PixelFormat::Bgr888, None).unwrap();
        let mut bytes = vec![0; layout.len_bytes()];
        let drive = Drive {
            amplitude: Factor::ONE,
            frequency: Factor::ONE,
            phase: Turns::from_degrees(110),
            onset: Factor::ONE,
        };
        shimmer.render(drive, Paint::Everything, &mut FrameMut::new(&mut bytes, layout).unwrap());
        let mut picture = vec![[0; 3]; panel.pixels()];
        rotate(rotation.inverse(), bytes.as_chunks::<3>().0, panel, &mut picture);
        picture
    }

    /// The demo photo as a kaleidoscope of its own colours after a few frames on a panel that is mounted turned, seen upright.
    fn upright_kaleidoscope(size: Size, rotation: Rotation) -> Vec<[u8; 3]> {
        let typed =
            Words::parse_from(["", "--effect", "kaleidoscope", "--mode", "tonal", "--search", "none"]);
        let config = Config { typed: typed.look, rotation, ..Config::default() };
        let panel = rotation.turned(size);
        let scene = Scene::load(Source::Demo, panel, &config).unwrap();
        let life = turned(scene.look().life, rotation);
        let mut picture = scene.prepare(&life, Vec::new(), |_| ()).unwrap();
        let layout = Layout::new(panel, PixelFormat::Bgr888, None).unwrap();
        let mut bytes = vec![0; layout.len_bytes()];
        for frame in 0..20 {
            let phase = Turns::from_degrees(frame * 40);
            let drive = Drive { amplitude: Factor::ONE, frequency: Factor::ONE, phase, onset: Factor::ONE };
            picture.render(drive, Paint::Everything, &mut FrameMut::new(&mut bytes, layout).unwrap());
        }
        let mut seen = vec![[0; 3]; panel.pixels()];
        rotate(rotation.inverse(), bytes.as_chunks::<3>().0, panel, &mut seen);
        seen
    }

    #[test]
    fn a_kaleidoscope_moves_upright_on_a_panel_that_is_mounted_turned() {
        let size = Size::new(240, 128);
        let want = upright_kaleidoscope(size, Rotation::None);
        for rotation in [Rotation::Quarter, Rotation::Half, Rotation::ThreeQuarter] {
            let got = upright_kaleidoscope(size, rotation);
            let most = got.as_flattened().iter().zip(want.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
            // The dither is the panel's.
            assert!(most <= Some(1), "turned by {rotation}: {most:?} levels from upright");
        }
    }

    #[test]
    fn light_and_wind_turn_with_the_picture() {
        let size = Size::new(240, 131);
        for &(name, range) in Range::NAMES {
            let want = upright(size, Rotation::None, range);
            for rotation in [Rotation::Quarter, Rotation::Half, Rotation::ThreeQuarter] {
                let got = upright(size, rotation, range);
                let worst =
                    got.as_flattened().iter().zip(want.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
                assert!(worst <= Some(2), "{name} turned by {rotation}: {worst:?} levels from upright");
            }
        }
    }
}
