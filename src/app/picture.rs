//! A photo with the effect that was chosen for it.

use crate::{
    config::Life,
    effect::{
        Area, Effect, Moment, Photo,
        autumn::{self, Autumn, Stage, Tree},
        fluid::{self, Base, Clip, Fluid, PrepareError, Source},
        kaleidoscope::{self, Kaleidoscope, Reference},
        shimmer::{self, Shimmer},
    },
    frame::{FrameMut, Size, pack::Block},
    noise::{drive::Drive, guard::Sensitivity},
};
use core::ops::Range;

/// A photo that lives in one of the ways there are, in memory `S`; a clip comes from the source `C`.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are two of them at the most, and the core has no heap to put one in"
)]
pub enum Picture<S, C> {
    /// See [`shimmer`].
    Shimmer(Shimmer<S>),
    /// See [`kaleidoscope`].
    Kaleidoscope(Kaleidoscope<S>),
    /// See [`autumn`].
    Autumn(Autumn<S>),
    /// See [`fluid`].
    Fluid(Fluid<S, C>),
}

/// What a picture is made of.
#[derive(Clone, Debug)]
pub enum Subject<'a, C> {
    /// A photo that shimmers.
    Shimmer(Photo<'a>),
    /// A photo in the colours of another.
    Kaleidoscope(Photo<'a>, Reference<'a>),
    /// A photo whose foliage goes through the season.
    Foliage(Photo<'a>, Tree<'a>),
    /// A tree of the program's own, in pictures of this size.
    Tree(Size, Tree<'a>),
    /// A clip on its base.
    Clip(Base<'a>, Clip<C>),
}

impl<C: Source> Subject<'_, C> {
    /// Words of 64 bits that [`Picture::prepare`] needs for it.
    pub const fn storage_len(&self, life: &Life) -> usize {
        match self {
            Self::Shimmer(photo) => shimmer::storage_len(photo.size),
            Self::Kaleidoscope(photo, _) => kaleidoscope::storage_len(photo.size, &life.kaleidoscope),
            Self::Foliage(Photo { size, .. }, _) | Self::Tree(size, _) => autumn::storage_len(*size),
            Self::Clip(base, clip) => fluid::storage_len(clip.header(), base.size, base.view.rotation),
        }
    }
}

impl<S: AsMut<[u64]>, C: Source> Picture<S, C> {
    /// Prepares `subject` in `storage`, which must hold [`Subject::storage_len`] words. `progress` is told how much of a kaleidoscope is coded, in per cent; other effects take no time
    /// worth telling. The strength of a shimmer is that of a clip too.
    ///
    /// # Errors
    /// If there is less memory, or a clip is damaged.
    pub fn prepare(
        subject: Subject<'_, C>,
        life: &Life,
        storage: S,
        progress: impl FnMut(u8),
    ) -> Result<Self, PrepareError> {
        Ok(match subject {
            Subject::Shimmer(photo) => Self::Shimmer(Shimmer::prepare(photo, &life.shimmer, storage)?),
            Subject::Kaleidoscope(photo, reference) => Self::Kaleidoscope(Kaleidoscope::prepare(
                photo,
                reference,
                &life.kaleidoscope,
                storage,
                progress,
            )?),
            Subject::Foliage(photo, tree) => {
                Self::Autumn(Autumn::prepare_photo(photo, tree, &life.autumn, storage)?)
            }
            Subject::Tree(size, tree) => Self::Autumn(Autumn::prepare(size, tree, &life.autumn, storage)?),
            Subject::Clip(base, clip) => {
                Self::Fluid(Fluid::prepare(clip, base, life.shimmer.strength, storage)?)
            }
        })
    }

    /// From the next frame on, an autumn is at `stage` of its season; other effects know none.
    pub fn set_stage(&mut self, stage: Stage) {
        if let Self::Autumn(autumn) = self {
            autumn.set_stage(stage);
        }
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        match self {
            Self::Shimmer(shimmer) => shimmer.into_storage(),
            Self::Kaleidoscope(kaleidoscope) => kaleidoscope.into_storage(),
            Self::Autumn(autumn) => autumn.into_storage(),
            Self::Fluid(fluid) => fluid.into_storage(),
        }
    }
}

impl<S: AsMut<[u64]>, C: Source> Effect for Picture<S, C> {
    type Moment<'a>
        = PictureMoment<'a>
    where
        S: 'a,
        C: 'a;

    fn at(&mut self, drive: Drive) -> PictureMoment<'_> {
        match self {
            Self::Shimmer(shimmer) => PictureMoment::Shimmer(shimmer.at(drive)),
            Self::Kaleidoscope(kaleidoscope) => PictureMoment::Kaleidoscope(kaleidoscope.at(drive)),
            Self::Autumn(autumn) => PictureMoment::Autumn(autumn.at(drive)),
            Self::Fluid(fluid) => PictureMoment::Fluid(fluid.at(drive)),
        }
    }

    fn sensitivity(&self) -> Sensitivity {
        match self {
            Self::Shimmer(shimmer) => shimmer.sensitivity(),
            Self::Kaleidoscope(kaleidoscope) => kaleidoscope.sensitivity(),
            Self::Autumn(autumn) => autumn.sensitivity(),
            Self::Fluid(fluid) => fluid.sensitivity(),
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
    /// Of an autumn.
    Autumn(autumn::Moment<'a>),
    /// Of a clip.
    Fluid(fluid::Moment<'a>),
}

impl Moment for PictureMoment<'_> {
    fn size(&self) -> Size {
        match self {
            Self::Shimmer(moment) => moment.size(),
            Self::Kaleidoscope(moment) => moment.size(),
            Self::Autumn(moment) => moment.size(),
            Self::Fluid(moment) => moment.size(),
        }
    }

    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        match self {
            Self::Shimmer(moment) => One::Shimmer(moment.moving(y)),
            Self::Kaleidoscope(moment) => One::Kaleidoscope(moment.moving(y)),
            Self::Autumn(moment) => One::Autumn(moment.moving(y)),
            Self::Fluid(moment) => One::Fluid(moment.moving(y)),
        }
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        match self {
            Self::Shimmer(moment) => moment.colours(x, y, blocks),
            Self::Kaleidoscope(moment) => moment.colours(x, y, blocks),
            Self::Autumn(moment) => moment.colours(x, y, blocks),
            Self::Fluid(moment) => moment.colours(x, y, blocks),
        }
    }

    fn paint(&self, area: Area, out: &mut FrameMut<'_>) {
        match self {
            Self::Shimmer(moment) => moment.paint(area, out),
            Self::Kaleidoscope(moment) => moment.paint(area, out),
            Self::Autumn(moment) => moment.paint(area, out),
            Self::Fluid(moment) => moment.paint(area, out),
        }
    }
}

/// What one of the effects gives.
enum One<S, K, A, F> {
    Shimmer(S),
    Kaleidoscope(K),
    Autumn(A),
    Fluid(F),
}

impl<T, S, K, A, F> Iterator for One<S, K, A, F>
where
    S: Iterator<Item = T>,
    K: Iterator<Item = T>,
    A: Iterator<Item = T>,
    F: Iterator<Item = T>,
{
    type Item = T;

    fn next(&mut self) -> Option<T> {
        match self {
            Self::Shimmer(items) => items.next(),
            Self::Kaleidoscope(items) => items.next(),
            Self::Autumn(items) => items.next(),
            Self::Fluid(items) => items.next(),
        }
    }
}
