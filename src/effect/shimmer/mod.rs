//! Shimmer: trees, water and fire in a photo sway.
//!
//! Source: Yamamoto and Sakamoto, 写真に自然な揺らめき表現を付加した動画生成法 ("the paper"; equation numbers are its). The luma of
//! every pixel is taken for a height H that swings around a centre C (eq. 1, 4, 7):
//!
//! ```text
//! H(t) = C + A·X_A(t)·sin(θ(t) + α),   sin α = (H(0) − C)/A
//! ```
//!
//! and light from one side on the relief of heights makes the picture shimmer. With P = A·cos α and Q = A·sin α,
//!
//! ```text
//! ∇H(t) = ∇C + X_A·sin θ·∇P + X_A·cos θ·∇Q
//! ```
//!
//! so that [`Shimmer::prepare`] stores three gradients a pixel, and a frame needs two numbers and no sine.
//! A pixel's shade is S = max(0, n·L), n the normal of the relief and L the direction of the light (Lambert), and all its
//! channels are multiplied by 1 + onset·m·(S − S̄)/L_z, m the strength. The mask M scales A: what stays still has no P and no Q, and
//! is the photo.
//!
//! Departures from the paper:
//! 1. The phase is the integral of the noisy frequency (see [`crate::noise::drive`]).
//! 2. The branch of α, which the paper leaves open, is chosen by [`Branch`].
//! 3. [`Range::Travelling`] is ours: the relief runs along the wind instead of pulsing in place.
//! 4. The shade is compared with its mean over a cycle, S̄, not with the shade at rest, S(0): with S(0) a ghost of the resting
//!    relief would be subtracted for ever. That frame 0 is the photo is seen to by the onset.
//! 5. A relief steeper than 54.6° is flattened to that, at the steepest moment of its swing.

pub mod automatic_mask;
mod bands;
mod height;
mod relief;
mod render;
mod shade;
mod sliding;
mod spans;
mod storage;
mod tent;

#[cfg(test)]
mod reference;

pub use render::Moment;
pub use storage::storage_len;

use super::{Effect, Photo, StorageTooSmall, sensitivity};
use crate::{
    frame::Size,
    math::{
        Factor, Turns,
        lanes::{Lanes, Task, on_widest},
    },
    noise::{drive::Drive, guard::Sensitivity},
};
use storage::Planes;

/// How the centre and the amplitude of a pixel's swing are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Range {
    /// 全域振動: A = C = 127.5 everywhere; the paper's choice for trees.
    Full,
    /// 近傍考慮: from the largest and the smallest luma around the pixel; the paper's choice for water.
    Neighbourhood,
    /// From the picture's own local phase, by a Riesz transform along the wind; the relief travels.
    #[default]
    Travelling,
}

impl Range {
    /// The unit of [`Settings::relief`]: levels of luma. Chosen by eye, on the photos of brooks, trees and seas that the program was made
    /// with: in [`Range::Full`] and [`Range::Neighbourhood`] all the contrast of the picture swings, and at the 20 levels that suit
    /// [`Range::Travelling`] white water pulsed to black.
    pub const fn luma_for_45_degrees(self) -> i32 {
        match self {
            Self::Full | Self::Neighbourhood => 80,
            Self::Travelling => 20,
        }
    }
}

/// The sign of cos α, which the paper leaves open: does a pixel's height rise or fall at first?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Branch {
    /// All rise: neighbours move together.
    #[default]
    Rising,
    /// All fall.
    Falling,
    /// A hash of the pixel's place decides: grainy, for glitter.
    Scattered,
}

named!(Range, "range mode", Full = "full", Neighbourhood = "neighbourhood", Travelling = "travelling");
named!(Branch, "branch", Rising = "rising", Falling = "falling", Scattered = "scattered");

/// Where the light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// Clockwise from the top of the picture.
    pub azimuth: Turns,
    /// Above the plane of the picture, 0° to 90°.
    pub elevation: Turns,
}

/// What can be chosen of a shimmer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How centre and amplitude are found.
    pub range: Range,
    /// The sign of cos α, where the range mode leaves it open.
    pub branch: Branch,
    /// Where the light comes from.
    pub light: Light,
    /// How steep the relief is, 1 by default. At 1, heights that differ by [`Range::luma_for_45_degrees`] levels over 1/480 of the
    /// picture's shorter side make a slope of 45°.
    pub relief: Factor,
    /// m: how far the shade changes the photo, 0 to 4, and no more than 4·L_z: at an elevation of 45° up to 2.8.
    pub strength: Factor,
    /// Where the relief travels to in [`Range::Travelling`], clockwise from the top of the picture.
    pub wind: Turns,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            range: Range::default(),
            branch: Branch::default(),
            light: Light { azimuth: Turns::from_degrees(315), elevation: Turns::from_degrees(45) },
            relief: Factor::ONE,
            strength: Factor::ONE,
            wind: Turns::from_degrees(90),
        }
    }
}

/// A photo that shimmers, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`).
#[derive(Debug)]
pub struct Shimmer<S> {
    size: Size,
    storage: S,
    light: shade::Light,
    sensitivity: Sensitivity,
}

impl<S: AsMut<[u64]>> Shimmer<S> {
    /// Prepares `photo` in `storage`, which must hold [`storage_len`] words.
    ///
    /// # Panics
    /// If `photo.rgb` or `photo.mask` does not have the length that `photo.size` asks for.
    pub fn prepare(photo: Photo<'_>, settings: &Settings, mut storage: S) -> Result<Self, StorageTooSmall> {
        let light = shade::Light::new(settings.light, settings.strength);
        let mut planes = Planes::carve(photo.size, storage.as_mut())?;
        assert_eq!(photo.rgb.len(), photo.size.pixels() * 3, "the photo's colours do not have its size");
        assert_eq!(photo.mask.len(), photo.size.pixels(), "the photo's mask does not have its size");
        planes.find_spans(photo.mask);
        on_widest(Preparation { planes, photo, settings, light });
        let mut shimmer = Self { size: photo.size, storage, light, sensitivity: Sensitivity::NONE };
        shimmer.sensitivity = sensitivity::measure(&mut shimmer);
        Ok(shimmer)
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

/// What is left to do when the spans are found.
struct Preparation<'a, 'b> {
    planes: Planes<'a>,
    photo: Photo<'b>,
    settings: &'b Settings,
    light: shade::Light,
}

impl Task for Preparation<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        height::fill(&mut self.planes, self.photo, self.settings);
        relief::fill::<L>(&mut self.planes, self.photo, self.settings, self.light);
    }
}

impl<S: AsMut<[u64]>> Effect for Shimmer<S> {
    type Moment<'a>
        = Moment<'a>
    where
        S: 'a;

    fn at(&mut self, drive: Drive) -> Moment<'_> {
        Moment::new(self, drive)
    }

    fn sensitivity(&self) -> Sensitivity {
        self.sensitivity
    }
}
