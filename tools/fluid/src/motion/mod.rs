//! How patches move: optical flow, its spectrum over time, and what of it is a patch's (the paper, sections 4 and 5).
//!
//! All is computed once a video, on a [grid](GRID) of every fourth pixel, and carried over to the versions: places and the signed mean
//! are turned and mirrored, magnitudes are scaled.

pub mod cells;
pub mod field;
pub mod flow;
mod pyramid;

/// Pixels of the video from one point of the motion grid to the next: an eighth of a patch's side at half size.
pub const GRID: usize = 4;
