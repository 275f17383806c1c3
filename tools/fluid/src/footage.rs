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

impl Class {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Water, Self::Fire, Self::Smoke];

    /// What people and files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Water => "water",
            Self::Fire => "fire",
            Self::Smoke => "smoke",
        }
    }

    /// The class of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }
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
