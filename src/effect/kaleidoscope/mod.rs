//! Kaleidoscope: a photo rebuilt in the colours of another.
//!
//! Source: Mochizuki and Cai, デジタル万華鏡 ("the paper"): the photo's luma is coded as a fractal ([`fractal`]), which gives every pixel an
//! address: where it comes from, and where that comes from (the paper's extended IFS address, section 7). A second, iterated system of maps
//! g_1 … g_16 lies on the reference photo, and a pixel gets the mean colour that it has at the same address (Barnsley's colour stealing, section 4):
//!
//! ```text
//! colour(x) = T[A(x)],   T[s1 s2 s3] = mean of the reference over g_s1(g_s2(g_s3(square)))
//! ```
//!
//! The drive moves the windows g_k of the reference: X_A says how far they leave their place, θ turns them. The photo's code stays, so a frame
//! is a table of 4,096 colours and one look-up a pixel.
//!
//! Departures from the paper:
//! 1. [`Mode::Tonal`]: symbols are classes of the decoded levels, and windows are chosen for their tones, so that the
//!    picture can still be seen. The paper's own symbols ([`Mode::Literal`]) destroy it.
//!    Each window is also brought nearer to the luma that its symbol has in the photo: many references have no darkness of their own.
//! 2. [`Mode::Watercolour`], the default: the mean of four codes whose ranges are shifted against each other. The block noise that
//!    the paper names as its limit is gone.
//! 3. Colours are means over the whole square of an address, in linear light, instead of single pixels; between the texels of the means they are
//!    interpolated in coded levels.
//! 4. The motion is ours; the paper's pictures stand still.

mod address;
pub mod fractal;
mod mirrors;
mod moving;
mod prepare;
mod render;
mod texture;
mod windows;

#[cfg(test)]
mod reference;

pub use moving::{Moving, MovingMoment, Still, moving_storage_len};
pub use prepare::{TOLERANCE_Q4, storage_len};
pub use render::Moment;
pub use texture::Reference;

use super::{Effect, Photo, StorageTooSmall};
use crate::{
    frame::{Rotation, Size},
    noise::drive::Drive,
};
use fractal::Search;
use mirrors::Mirrors;

/// What the symbols of an address are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Classes of contrast and brightness of the ranges, as the paper has it.
    Literal,
    /// Classes of the levels.
    Tonal,
    /// As tonal, and the mean of four codes with shifted ranges: what hangs well on a wall.
    #[default]
    Watercolour,
}

named!(Mode, "mode", Literal = "literal", Tonal = "tonal", Watercolour = "watercolour");

impl Mode {
    /// Where in the plane of each code the photo's upper left corner is.
    pub(super) const fn shifts(self) -> &'static [(u32, u32)] {
        match self {
            Self::Literal | Self::Tonal => &[(0, 0)],
            Self::Watercolour => &[(0, 0), (8, 8), (4, 12), (12, 4)],
        }
    }
}

/// What can be chosen of a kaleidoscope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// What the symbols are.
    pub mode: Mode,
    /// Where the coder looks for domains.
    pub search: Search,
    /// M: symbols of an address, 1 to 3. With fewer, colours are means over larger parts of the reference.
    pub depth: u8,
    /// How the panel is mounted, and so the photo turned: it is coded upright, the same on every panel.
    pub rotation: Rotation,
}

impl Settings {
    /// The numbers of symbols that an address can have.
    pub const DEPTHS: core::ops::RangeInclusive<u8> = 1..=address::DEPTH as u8;
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            search: Search::default(),
            depth: address::DEPTH as u8,
            rotation: Rotation::None,
        }
    }
}

/// A photo in the colours of another, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`).
#[derive(Debug)]
pub struct Kaleidoscope<S> {
    size: Size,
    mode: Mode,
    depth: u32,
    mirrors: Mirrors,
    storage: S,
}

impl<S: AsMut<[u64]>> Kaleidoscope<S> {
    /// Prepares `photo` with the colours of `reference` in `storage`, which must hold [`storage_len`] words. The photo's mask is not looked at.
    /// `progress` is told how much of the coding is done, in per cent.
    ///
    /// # Panics
    /// If the colours of the photo or the reference do not have the lengths that their sizes ask for.
    pub fn prepare(
        photo: Photo<'_>,
        reference: Reference<'_>,
        settings: &Settings,
        storage: S,
        progress: impl FnMut(u8),
    ) -> Result<Self, StorageTooSmall> {
        prepare::prepare(photo, reference, settings, storage, progress)
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

impl<S: AsMut<[u64]>> Effect for Kaleidoscope<S> {
    type Moment<'a>
        = Moment<'a>
    where
        S: 'a;

    fn at(&mut self, drive: Drive) -> Moment<'_> {
        Moment::new(self, drive)
    }
}

/// Luma of BT.709 on the coded channels, rounded. The weights sum to 1024.
pub const fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((r as u32 * 218 + g as u32 * 732 + b as u32 * 74 + 512) >> 10) as u8
}
