//! A photo with its mask, as a panel needs them.

use super::{
    Failure,
    args::MaskChoice,
    config::{Config, Look},
    photo,
};
use crate::{
    config::Life,
    effect::{
        Photo,
        shimmer::automatic_mask::{HARDLY_ANYTHING_PER_MILLE, automatic_mask, moving_per_mille, scratch_len},
    },
    frame::{Rotation, Size, rotate},
    math::Turns,
};
use std::path::Path;

/// Which photo.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source<'a> {
    /// A file.
    File(&'a Path),
    /// The one that the program carries.
    Demo,
}

/// "Forest" by Moritz Reisinger, CC BY-SA 3.0: see tests/data/README.md.
static DEMO: &[u8] = include_bytes!("../../tests/data/demo.jpg");

/// A photo and its mask at the panel's size, turned as the panel is mounted.
#[derive(Debug)]
pub(super) struct Scene {
    name: String,
    size: Size,
    rgb: Vec<u8>,
    mask: Vec<u8>,
    look: Look,
}

impl Scene {
    /// Loads the photo at `source`, its mask and its sidecar for a panel of `size` that is mounted as `config` says.
    pub(super) fn load(source: Source<'_>, size: Size, config: &Config) -> Result<Self, Failure> {
        let look = match source {
            Source::File(path) => config.look(path),
            Source::Demo => config.plain_look(),
        };
        let rotation = config.rotation;
        let upright = rotation.turned(size);
        let limits = photo::Limits { bytes: config.memory_ceiling_bytes, ..photo::Limits::default() };
        let options = photo::Options { size: upright, fit: look.fit, background: look.background, limits };
        let photo = match source {
            Source::File(path) => photo::load(path, &options)?,
            Source::Demo => photo::from_bytes("the demo photo", DEMO, &options)?,
        };
        let mask = choose_mask(source, &photo, &look, &options.limits)?;
        let name =
            Path::new(&photo.name).file_name().map_or(photo.name.clone(), |n| n.to_string_lossy().into());
        if rotation == Rotation::None {
            return Ok(Self { name, size, rgb: photo.rgb, mask, look });
        }
        let (mut rgb, mut turned_mask) = (vec![[0; 3]; size.pixels()], vec![0; size.pixels()]);
        rotate(rotation, photo.rgb.as_chunks::<3>().0, upright, &mut rgb);
        rotate(rotation, &mask, upright, &mut turned_mask);
        Ok(Self { name, size, rgb: rgb.into_flattened(), mask: turned_mask, look })
    }

    /// What people call the photo: the name of its file.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// How the photo is shown: as its sidecar says, or as all are.
    pub(super) const fn look(&self) -> &Look {
        &self.look
    }

    /// What an effect is prepared from.
    pub(super) fn photo(&self) -> Photo<'_> {
        Photo { size: self.size, rgb: &self.rgb, mask: &self.mask }
    }
}

/// The life of a picture whose panel is mounted turned: light and wind turn with the picture.
pub(super) fn turned(mut life: Life, rotation: Rotation) -> Life {
    let turn = Turns::from_degrees(rotation.degrees() as i32);
    let shimmer = &mut life.shimmer;
    shimmer.light.azimuth = shimmer.light.azimuth.plus(turn);
    shimmer.wind = shimmer.wind.plus(turn);
    life
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
    match (&look.mask, beside) {
        (Some(MaskChoice::Everything), _) => Ok(everything(photo)),
        (Some(MaskChoice::File(path)), _) => Ok(photo::load_mask(path, photo, limits)?),
        (None, Some(path)) => {
            log::info!("{}: moves as {} says", photo.name, path.display());
            Ok(photo::load_mask(&path, photo, limits)?)
        }
        (None | Some(MaskChoice::Automatic), _) => Ok(automatic(photo)),
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
        log::info!("{}: hardly anything in it seems to move; a mask beside it can say what does", photo.name);
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
