//! The drive: noise turned into what every effect understands.

use crate::math::{Factor, Turns};

/// What an effect needs to know to render a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drive {
    /// X_A: the share of the full swing, 0..=1.
    pub amplitude: Factor,
    /// X_f: the oscillation's speed relative to its base frequency, 0..=2. Shown to people; effects follow `phase`.
    pub frequency: Factor,
    /// θ: where in its cycle the oscillation is.
    pub phase: Turns,
    /// How far the picture has come alive, 0..=1: at 0 every effect shows the photo as it is.
    pub onset: Factor,
}
