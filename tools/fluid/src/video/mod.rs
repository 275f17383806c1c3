//! Reading videos and folders of frames, and whether they suit.

pub mod class;
pub mod denoise;
mod ffmpeg;
pub mod source;
pub mod suitability;

use image::RgbImage;

/// A video is made at most this wide.
pub const MOST_WIDTH: u32 = 640;

/// A video is made at most this high.
pub const MOST_HEIGHT: u32 = 360;

/// The beginning of a video, in memory.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Frames of one size. One that is the same as the one before is left out: it is no motion of the fluid.
    pub frames: Vec<RgbImage>,
    /// Frames a second.
    pub rate: f32,
}

impl Clip {
    fn push(&mut self, frame: RgbImage) {
        if self.frames.last().is_none_or(|last| *last != frame) {
            self.frames.push(frame);
        }
    }
}

/// The luminance of a frame, of BT.601 weights, rounded.
pub fn luma(frame: &RgbImage) -> Vec<u8> {
    let pixels = frame.as_raw().as_chunks::<3>().0;
    pixels
        .iter()
        .map(|[r, g, b]| ((u32::from(*r) * 77 + u32::from(*g) * 150 + u32::from(*b) * 29 + 128) >> 8) as u8)
        .collect()
}
