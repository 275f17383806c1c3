//! # Configuration
//!
//! What can be chosen of a show, as checked values with the product's defaults. Knows what a choice means; knows no file, no
//! argument and no device.

pub mod night;
pub mod season;

use crate::{
    effect::{
        autumn, kaleidoscope,
        shimmer::{self, Range},
    },
    noise::{Kind, drive},
};

/// Frames a second that can be asked for. Below 12 the motion is seen as steps; above 60 no panel shows more.
pub const FRAMES_PER_SECOND: core::ops::RangeInclusive<u32> = 12..=60;

/// The paper's frame rate, and the default.
pub const DEFAULT_FRAMES_PER_SECOND: u32 = 12;

/// How a photo lives, at [`DEFAULT_FRAMES_PER_SECOND`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Life {
    /// What drives it.
    pub drive: drive::Settings,
    /// How a shimmer looks.
    pub shimmer: shimmer::Settings,
    /// How a kaleidoscope looks.
    pub kaleidoscope: kaleidoscope::Settings,
    /// How an autumn looks.
    pub autumn: autumn::Settings,
}

impl Life {
    /// The same life at `frames_per_second`: as many seconds, in other numbers of frames.
    #[must_use]
    pub fn at(mut self, frames_per_second: u32) -> Self {
        let drive = &mut self.drive;
        for frames in [&mut drive.period_frames, &mut drive.response_frames, &mut drive.glide_frames] {
            *frames = (*frames * frames_per_second).div_ceil(DEFAULT_FRAMES_PER_SECOND);
        }
        let fall = &mut self.autumn.fall_frames;
        *fall = (*fall * frames_per_second).div_ceil(DEFAULT_FRAMES_PER_SECOND);
        self
    }
}

/// The paper's set-ups: a kind of object, its range mode (section 4.1) and the noises that were judged best for it (Table 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Trees seen from afar.
    Poplar,
    /// A tree seen from near.
    Rowan,
    /// Running water.
    River,
    /// Falling water.
    Waterfall,
}

named!(Preset, "preset", Poplar = "poplar", Rowan = "rowan", River = "river", Waterfall = "waterfall");

impl Preset {
    /// Gives `life` the range mode and the noises of this kind of object; the rest stays.
    pub const fn apply(self, life: &mut Life) {
        life.shimmer.range = match self {
            Self::Poplar | Self::Rowan => Range::Full,
            Self::River | Self::Waterfall => Range::Neighbourhood,
        };
        (life.drive.amplitude, life.drive.frequency) = match self {
            Self::Poplar => (Kind::Brown, Kind::Brown),
            Self::Rowan | Self::River | Self::Waterfall => (Kind::Filter, Kind::Constant),
        };
    }
}

/// In which order photos are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By chance, none twice before all were shown.
    #[default]
    Shuffle,
    /// By the names of their files, 2 before 10.
    Name,
    /// By the date at which they were taken.
    Date,
}

named!(Order, "order", Shuffle = "shuffle", Name = "name", Date = "date");

/// Which effect brings a photo to life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffectChoice {
    /// [`crate::effect::shimmer`].
    #[default]
    Shimmer,
    /// [`crate::effect::kaleidoscope`].
    Kaleidoscope,
    /// [`crate::effect::autumn`].
    Autumn,
}

named!(EffectChoice, "effect", Shimmer = "shimmer", Kaleidoscope = "kaleidoscope", Autumn = "autumn");
