//! # Naturalness
//!
//! How far a moving picture is from a real recording of the same kind, without neural nets: every measure is a formula. No measure is to be
//! read alone: beside it belong the *ceiling* (one half of the recording against the other), a still, and a picture that slides.
//!
//! | measure | says |
//! |---|---|
//! | [`temporal::distance`] (tps) | how much moves at which frequency, and where |
//! | [`spacetime::distance`] (st) | which structures move at which frequency in which direction |
//! | [`temporal::slope`] | how the power falls with frequency: β of 1/f^β |
//! | [`statistics::amplitude_ratio`] | too calm or too wild |
//! | [`statistics::coherence`] | popping tiles and jelly |
//! | [`statistics::seam`], [`statistics::flicker`], [`statistics::sharpness`], [`statistics::leak`] | a cut in the loop, blinking, breathing, and what should stand still |
//! | [`patches::distance`] | the distribution of small blocks of space and time |
//! | [`strobe::Strobe`] | what could harm people with photosensitive epilepsy |

pub mod clip;
pub mod patches;
pub mod region;
pub mod spacetime;
pub mod statistics;
pub mod strobe;
pub mod temporal;

pub use clip::Clip;
pub use region::Region;
