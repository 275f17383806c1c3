//! The frames of videos, as labelling and rendering ask for them.

use image::RgbImage;
use std::io;

/// What a fluid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Rivers, falls, fountains, the sea.
    Water,
    /// Flames.
    Fire,
    /// Smoke, steam and clouds.
    Smoke,
}

/// A video of the database.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// Its number.
    pub number: u32,
    /// Where it came from.
    pub name: String,
    /// What it shows.
    pub class: Class,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Frames there are.
    pub frames: u32,
    /// Frames a second.
    pub rate: f32,
}

/// Videos whose frames can be had.
pub trait Footage: Sync {
    /// The video of this number.
    fn video(&self, number: u32) -> Option<&Video>;

    /// A frame of it, denoised.
    fn frame(&self, number: u32, index: u32) -> io::Result<RgbImage>;

    /// The mean of its frames.
    fn mean(&self, number: u32) -> io::Result<RgbImage>;
}
