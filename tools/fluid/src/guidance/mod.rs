//! What a person asks for: where the fluid is, which way it goes, how fast (the paper, section 5, "user-specified motion").
//!
//! All is optional. Strokes of a drawing give the direction, which goes on smoothly between them; a grey picture gives the speed; a matte
//! says where the fluid is. The direction and the speed of a finished labelling can be written as pictures, changed in a paint program and
//! read back. [`Guidance::show`] draws what was understood.

mod direction;
mod map;
mod show;
mod strokes;

pub use self::{
    direction::DirectionField,
    map::{Map, direction_picture, speed_picture},
    strokes::{Stroke, strokes},
};

use crate::{
    label::{Target, Wanted},
    plane::Plane,
};
use image::RgbImage;
use std::{
    fmt,
    path::{Path, PathBuf},
};

/// Why a file of guidance cannot be used. Its text names the file, the fault and the cure.
#[derive(Debug)]
pub struct GuidanceError {
    file: PathBuf,
    fault: String,
}

impl GuidanceError {
    fn new(file: &Path, fault: impl Into<String>) -> Self {
        Self { file: file.to_owned(), fault: fault.into() }
    }
}

impl fmt::Display for GuidanceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.fault)
    }
}

impl std::error::Error for GuidanceError {}

/// Where the direction comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Direction {
    /// Strokes.
    Field(DirectionField),
    /// A picture of hues.
    Picture(Map),
}

/// All that was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guidance {
    /// Which way.
    pub direction: Option<Direction>,
    /// How fast.
    pub speed: Option<Map>,
}

impl Guidance {
    /// Takes the direction from a file: strokes if it is an SVG or JSON file, a picture of hues otherwise. The picture's size is in pixels.
    pub fn direct(&mut self, file: &Path, size: (usize, usize)) -> Result<(), GuidanceError> {
        let kind = file.extension().map(|kind| kind.to_ascii_lowercase());
        self.direction = Some(if kind.is_some_and(|kind| kind == "svg" || kind == "json") {
            Direction::Field(DirectionField::new(&strokes(file, size)?, size))
        } else {
            Direction::Picture(Map::directions(file, size)?)
        });
        Ok(())
    }

    /// Takes the speed from a grey picture.
    pub fn hasten(&mut self, file: &Path, size: (usize, usize)) -> Result<(), GuidanceError> {
        self.speed = Some(Map::speeds(file, size)?);
        Ok(())
    }

    /// What is wanted at a place of the picture.
    pub fn wanted(&self, x: f32, y: f32) -> Wanted {
        let direction = self.direction.as_ref().and_then(|direction| match direction {
            Direction::Field(field) => field.at(x, y),
            Direction::Picture(map) => map.direction(x, y),
        });
        Wanted { direction, speed: self.speed.as_ref().map(|map| map.speed(x, y)) }
    }

    /// Asks a picture's patches for it.
    pub fn ask(&self, target: &mut Target) {
        target.ask(|x, y| self.wanted(x, y));
    }

    /// The picture with what was understood: outside of the matte dark, the direction as hue and arrows, the arrows as long as a patch's
    /// way in 8 frames if the speed is known.
    pub fn show(&self, picture: &RgbImage, matte: Option<&Plane>) -> RgbImage {
        show::show(self, picture, matte)
    }
}

/// Reads a matte: white is fluid, black is not. Its values are 0..=1.
pub fn matte(file: &Path, size: (usize, usize)) -> Result<Plane, GuidanceError> {
    let grey = map::open(file, size)?.into_luma8();
    let values: Vec<_> = grey.pixels().map(|pixel| f32::from(pixel.0[0]) / 255.0).collect();
    if values.iter().all(|&value| value < 0.5) {
        return Err(GuidanceError::new(file, "the matte is black: paint the fluid white"));
    }
    Ok(Plane { width: size.0, height: size.1, values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, Luma};

    #[test]
    fn a_matte_must_fit_and_show_something() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("matte.png");
        GrayImage::from_fn(40, 30, |x, _| Luma([if x < 20 { 255 } else { 0 }])).save(&file).unwrap();
        let plane = matte(&file, (40, 30)).unwrap();
        assert_eq!((plane.row(3)[19], plane.row(3)[20]), (1.0, 0.0));
        let error = matte(&file, (640, 360)).unwrap_err().to_string();
        assert!(
            error.contains("matte.png") && error.contains("40 × 30") && error.contains("640 × 360"),
            "{error}"
        );
        GrayImage::new(40, 30).save(&file).unwrap();
        assert!(matte(&file, (40, 30)).unwrap_err().to_string().contains("black"));
        std::fs::write(&file, "no picture").unwrap();
        assert!(matte(&file, (40, 30)).is_err());
    }
}
