//! # Effects
//!
//! An effect turns a photo into frames. It is prepared once per photo, in memory that is lent to it, and may fail then;
//! after that it renders any frame from a [`Drive`], cannot fail and allocates nothing. Knows sizes, strides and the drive;
//! knows no device, file or clock.

pub mod shimmer;

use crate::{frame::FrameMut, noise::drive::Drive};

/// What part of a frame an effect must paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Every pixel: what the frame holds is unknown.
    Everything,
    /// What moves: the frame holds an earlier frame of the same effect, prepared as it is now.
    Motion,
}

/// A picture that moves.
pub trait Effect {
    /// Renders the frame for `drive` into `out`, whose size is the one the effect was prepared for.
    fn render(&mut self, drive: Drive, paint: Paint, out: &mut FrameMut<'_>);
}
