//! A photo with the effect that was chosen for it.

use super::{
    Effect, Moment, Photo, StorageTooSmall,
    kaleidoscope::{self, Kaleidoscope, Reference},
    shimmer::{self, Shimmer},
};
use crate::{
    config::{EffectChoice, Life},
    frame::{Size, pack::Levels},
    noise::drive::Drive,
};
use core::ops::Range;

/// A photo that lives in one of the ways there are, in memory `S`.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are three of them at the most, and the core has no heap to put one in"
)]
pub enum Picture<S> {
    /// See [`shimmer`].
    Shimmer(Shimmer<S>),
    /// See [`kaleidoscope`].
    Kaleidoscope(Kaleidoscope<S>),
}

impl<S: AsMut<[u64]>> Picture<S> {
    /// Words of 64 bits that [`Self::prepare`] needs.
    pub const fn storage_len(effect: EffectChoice, size: Size, life: &Life) -> usize {
        match effect {
            EffectChoice::Shimmer => shimmer::storage_len(size),
            EffectChoice::Kaleidoscope => kaleidoscope::storage_len(size, &life.kaleidoscope),
        }
    }

    /// Prepares `photo` in `storage`; `reference` gives a kaleidoscope its colours.
    pub fn prepare(
        effect: EffectChoice,
        photo: Photo<'_>,
        reference: Reference<'_>,
        life: &Life,
        storage: S,
    ) -> Result<Self, StorageTooSmall> {
        Ok(match effect {
            EffectChoice::Shimmer => Self::Shimmer(Shimmer::prepare(photo, &life.shimmer, storage)?),
            EffectChoice::Kaleidoscope => {
                Self::Kaleidoscope(Kaleidoscope::prepare(photo, reference, &life.kaleidoscope, storage)?)
            }
        })
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        match self {
            Self::Shimmer(shimmer) => shimmer.into_storage(),
            Self::Kaleidoscope(kaleidoscope) => kaleidoscope.into_storage(),
        }
    }
}

impl<S: AsMut<[u64]>> Effect for Picture<S> {
    type Moment<'a>
        = PictureMoment<'a>
    where
        S: 'a;

    fn at(&mut self, drive: Drive) -> PictureMoment<'_> {
        match self {
            Self::Shimmer(shimmer) => PictureMoment::Shimmer(shimmer.at(drive)),
            Self::Kaleidoscope(kaleidoscope) => PictureMoment::Kaleidoscope(kaleidoscope.at(drive)),
        }
    }
}

/// A [`Picture`] at one moment.
#[derive(Debug)]
pub enum PictureMoment<'a> {
    /// Of a shimmer.
    Shimmer(shimmer::Moment<'a>),
    /// Of a kaleidoscope.
    Kaleidoscope(kaleidoscope::Moment<'a>),
}

impl Moment for PictureMoment<'_> {
    fn size(&self) -> Size {
        match self {
            Self::Shimmer(moment) => moment.size(),
            Self::Kaleidoscope(moment) => moment.size(),
        }
    }

    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let (shimmer, kaleidoscope) = match self {
            Self::Shimmer(moment) => (Some(moment.moving(y)), None),
            Self::Kaleidoscope(moment) => (None, Some(moment.moving(y))),
        };
        shimmer.into_iter().flatten().chain(kaleidoscope.into_iter().flatten())
    }

    #[inline]
    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        match self {
            Self::Shimmer(moment) => moment.levels(x, y, levels),
            Self::Kaleidoscope(moment) => moment.levels(x, y, levels),
        }
    }
}
