//! Fluid: water, fire and smoke move as in a film.
//!
//! Source: "creating fluid animation from a single picture with a video database" ("the paper"), section 6: what moves is the difference of a film's frames
//! from their mean, laid over a picture that stands still. A tool of the PC makes a **clip** of it, once; this plays it. A clip ([`Clip`]) has a
//! base picture, a matte that says where it moves, and frames of signed changes D, which are coarser than the picture:
//!
//! ```text
//! shown(x, t) = base(x) + onset·s(t)·matte(x)·tint(luma(base(x)))·D(x, t),   s = m·(1/2 + X_A(t))
//! ```
//!
//! m the strength. Between pixels D is interpolated bilinearly, between frames such that its contrast stays. θ turns the play position: by
//! the frames of 5/3 seconds a turn, so that with the default oscillation and X_f = 1 the film runs as it was taken, and X_f bends its speed. Amplitude
//! and speed wander, so no round of the clip is like another. In a lull half of the change is left: water that stands still looks broken.
//!
//! The paper's moving outline of fire and smoke (section 6) has no place of its own here: what the tool makes of outline, flame and what comes out
//! from behind is a change of colour as any other, in [`Kind::Colour`]. That keeps one kernel for all, and the frame needs to know nothing of mattes that move.
//!
//! Files: [`clip`] their layout, [`code`] how a frame is packed; `yurameki::os::clip` writes and opens them.

pub mod clip;
pub mod code;
mod huffman;
mod prepare;
mod render;
mod storage;
mod view;

#[cfg(test)]
mod reference;

pub use clip::{Clip, ClipError, Header, Kind, Shape, Source, Tint};
pub use render::Moment;
pub use view::View;

use super::{Effect, StorageTooSmall};
use crate::{
    frame::{Rotation, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
};
use core::fmt;
use render::{Shares, fetch, mix, spread};
use storage::{Measures, Memory};
use view::Axis;

/// A clip's base as the panel shows it.
#[derive(Clone, Copy, Debug)]
pub struct Base<'a> {
    /// Width and height in pixels: those of the panel as it is mounted.
    pub size: Size,
    /// Red, green, blue of every pixel, row by row, sRGB: 3 bytes a pixel.
    pub rgb: &'a [u8],
    /// Where on it the base lies.
    pub view: View,
}

/// Why a clip cannot be prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrepareError {
    /// There is too little memory for it.
    Storage(StorageTooSmall),
    /// Its matte or its tint is damaged.
    Clip(ClipError),
}

impl From<StorageTooSmall> for PrepareError {
    fn from(error: StorageTooSmall) -> Self {
        Self::Storage(error)
    }
}

impl From<ClipError> for PrepareError {
    fn from(error: ClipError) -> Self {
        Self::Clip(error)
    }
}

impl fmt::Display for PrepareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Storage(error) => error.fmt(f),
            Self::Clip(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PrepareError {}

/// Words of 64 bits that [`Fluid::prepare`] needs for a clip with this `header` on a panel of `size`, mounted so.
///
/// For a panel of p pixels and a grid of g, with one plane of luma, 8 p + 5 g bytes and the longest frame; with three of colour 12 p + 15 g.
pub const fn storage_len(header: &Header, size: Size, rotation: Rotation) -> usize {
    Measures::new(header, size, !matches!(rotation, Rotation::None)).storage_len()
}

/// A clip that plays, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`), from the source `C`.
#[derive(Debug)]
pub struct Fluid<S, C> {
    clip: Clip<C>,
    measures: Measures,
    rotation: Rotation,
    rows: Axis,
    strength: Factor,
    position: Position,
    /// The numbers of the two frames that are decoded.
    slots: [Option<u32>; 2],
    storage: S,
}

impl<S: AsMut<[u64]>, C: Source> Fluid<S, C> {
    /// Prepares `clip` with its `base` in `storage`, which must hold [`storage_len`] words. The `strength` of 0..=4 is 1 for changes that are, in the mean
    /// over time, as large as they were recorded.
    ///
    /// # Errors
    /// If there is less memory, or the matte or the tint is damaged.
    ///
    /// # Panics
    /// If `base.rgb` does not have the length that `base.size` asks for.
    pub fn prepare(
        clip: Clip<C>,
        base: Base<'_>,
        strength: Factor,
        mut storage: S,
    ) -> Result<Self, PrepareError> {
        assert_eq!(base.rgb.len(), base.size.pixels() * 3, "the base has another size");
        let header = clip.header();
        let rotation = base.view.rotation;
        let measures = Measures::new(header, base.size, rotation != Rotation::None);
        let axes = base.view.axes(&header.shape, base.size);
        let mut memory = Memory::carve(&measures, storage.as_mut())?;
        let tint = match header.shape.kind {
            Kind::Luma => clip.read_tint()?,
            Kind::Colour => Tint::GREY,
        };
        clip.read_matte(memory.packed, memory.residuals, memory.extents, memory.frames[0])?;
        prepare::fill(&mut memory, &measures, base.rgb.as_chunks().0, &tint, rotation, &axes);
        let position = Position::new(header);
        let strength = strength.clamp(Factor::ZERO, Factor::from_num(4));
        let [_, rows] = axes;
        Ok(Self { clip, measures, rotation, rows, strength, position, slots: [None; 2], storage })
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

impl<S: AsMut<[u64]>, C: Source> Effect for Fluid<S, C> {
    type Moment<'a>
        = Moment<'a>
    where
        S: 'a,
        C: 'a;

    fn at(&mut self, drive: Drive) -> Moment<'_> {
        let Ok(mut memory) = Memory::carve(&self.measures, self.storage.as_mut()) else {
            unreachable!("the storage was long enough when the clip was prepared")
        };
        self.position.follow(drive.phase);
        let (wanted, between) = self.position.frames();
        let mut chosen = [0; 2];
        for (i, number) in wanted.into_iter().enumerate() {
            let held = self.slots.iter().position(|&slot| slot == Some(number));
            chosen[i] = held.unwrap_or_else(|| {
                let kept = |slot: Option<u32>| slot.is_some_and(|number| wanted.contains(&number));
                let free = usize::from(kept(self.slots[0]));
                fetch(&self.clip, number, &mut memory, free);
                self.slots[free] = Some(number);
                free
            });
        }
        let Header { shape, correlation, .. } = self.clip.header();
        let strength = drive.onset * self.strength * (Factor::ONE / 2 + drive.amplitude);
        let shares = Shares::new(between, *correlation, strength, shape.step);
        mix(&mut memory, chosen, shares, &self.measures, self.rotation);
        spread(&mut memory, &self.measures, self.rotation, &self.rows);
        Moment::new(memory, &self.measures)
    }
}

/// Where in a clip is played.
#[derive(Clone, Copy, Debug)]
struct Position {
    /// In frames, Q32.
    at: i64,
    frames: u32,
    millihertz: u32,
    /// θ of the frame before.
    phase: Option<Turns>,
}

impl Position {
    const fn new(header: &Header) -> Self {
        Self { at: 0, frames: header.frames, millihertz: header.shape.millihertz, phase: None }
    }

    /// Goes on as far as θ has turned: at the most half a turn, forwards or back.
    fn follow(&mut self, phase: Turns) {
        let before = self.phase.replace(phase).unwrap_or(phase);
        let turned = phase.0.wrapping_sub(before.0) as i32;
        // 5/3 seconds a turn: 20 frames at 12 a second, the default oscillation.
        let step = i64::from(turned) * i64::from(self.millihertz) * 5 / 3_000;
        self.at = (self.at + step).rem_euclid(i64::from(self.frames) << 32);
    }

    /// The two frames around the position, and how far it is from the first to the second, Q16.
    const fn frames(&self) -> ([u32; 2], u32) {
        let first = (self.at >> 32) as u32;
        ([first, (first + 1) % self.frames], (self.at as u32) >> 16)
    }
}
