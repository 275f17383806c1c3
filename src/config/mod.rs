//! # Configuration
//!
//! What can be chosen of a show, as checked values with the product's defaults. Knows what a choice means; knows no file, no
//! argument and no device.

pub mod night;

use crate::{
    effect::shimmer::{self, Range},
    noise::{Kind, drive},
};
use core::{fmt, str::FromStr};

/// Frames a second that can be asked for. Below 12 the motion is seen as steps; above 60 no panel shows more.
pub const FRAMES_PER_SECOND: core::ops::RangeInclusive<u32> = 12..=60;

/// The paper's frame rate, and the default.
pub const DEFAULT_FRAMES_PER_SECOND: u32 = 12;

/// How a photo lives, at [`DEFAULT_FRAMES_PER_SECOND`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Life {
    /// What drives it.
    pub drive: drive::Settings,
    /// How the driven picture looks.
    pub shimmer: shimmer::Settings,
}

impl Life {
    /// The same life at `frames_per_second`: as many seconds, in other numbers of frames.
    #[must_use]
    pub fn at(mut self, frames_per_second: u32) -> Self {
        let drive = &mut self.drive;
        for frames in [&mut drive.period_frames, &mut drive.response_frames, &mut drive.glide_frames] {
            *frames = (*frames * frames_per_second).div_ceil(DEFAULT_FRAMES_PER_SECOND);
        }
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

impl Preset {
    /// Every preset, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Poplar, Self::Rowan, Self::River, Self::Waterfall];

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Poplar => "poplar",
            Self::Rowan => "rowan",
            Self::River => "river",
            Self::Waterfall => "waterfall",
        }
    }

    /// The life that the paper gave to this kind of object.
    pub fn life(self) -> Life {
        let range = match self {
            Self::Poplar | Self::Rowan => Range::Full,
            Self::River | Self::Waterfall => Range::Neighbourhood,
        };
        let (amplitude, frequency) = match self {
            Self::Poplar => (Kind::Brown, Kind::Brown),
            Self::Rowan | Self::River | Self::Waterfall => (Kind::Filter, Kind::Constant),
        };
        let mut life = Life::default();
        life.shimmer.range = range;
        (life.drive.amplitude, life.drive.frequency) = (amplitude, frequency);
        life
    }
}

/// A word that names no [`Preset`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownPreset;

impl fmt::Display for UnknownPreset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown preset; the known ones are poplar, rowan, river, waterfall")
    }
}

impl core::error::Error for UnknownPreset {}

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(word: &str) -> Result<Self, UnknownPreset> {
        Self::ALL.into_iter().find(|preset| preset.name() == word).ok_or(UnknownPreset)
    }
}
