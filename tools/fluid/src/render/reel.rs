//! The frames of one video in memory, as luminance, and its loop.

use super::RenderError;
use super::colour::luminance_of;
use super::seam::{self, Loop, Term};
use crate::footage::{Footage, Video};
use crate::patch::{PatchRef, SIDE, Version};
use crate::plane::Plane;
use rayon::prelude::*;

/// One frame's luminance in levels.
struct Shot(Vec<u8>);

/// The frames of a video, smoothed for versions of one size so that smaller ones do not flicker. Dropped when its patches are rendered:
/// one reel of 150 frames of 640 by 360 pixels takes 35 MB.
pub(super) struct Reel {
    width: usize,
    height: usize,
    shots: Vec<Shot>,
    /// The mean of the frames.
    mean: Plane,
    round: Loop,
}

/// Where the pixels of a patch lie in a reel.
pub(super) struct Taps(Vec<Tap>);

/// The upper left one of four pixels, and the shares of the right and of the lower ones, in 256ths.
#[derive(Clone, Copy)]
struct Tap {
    index: u32,
    right: u16,
    down: u16,
}

impl Reel {
    /// Reads as many frames as a clip of `seconds` needs; `free` is as in [`Loop::find`].
    pub(super) fn load(
        footage: &dyn Footage,
        video: &Video,
        seconds: f32,
        free: bool,
    ) -> Result<Self, RenderError> {
        let wanted = seconds * video.rate;
        let count = video.frames.min(seam::frames_to_read(wanted)) as usize;
        let (width, height) = (video.width as usize, video.height as usize);
        if count == 0 || width < 2 || height < 2 {
            return Err(RenderError::EmptyVideo(video.name.clone()));
        }
        let shots = (0..count as u32).into_par_iter().map(|index| {
            let frame = footage
                .frame(video.number, index)
                .map_err(|error| RenderError::Frame(video.name.clone(), index, error))?;
            if frame.dimensions() != (video.width, video.height) {
                return Err(RenderError::Frame(
                    video.name.clone(),
                    index,
                    std::io::Error::other("the frame has another size"),
                ));
            }
            Ok(Shot(frame.pixels().map(|pixel| luminance_of(pixel.0.map(f32::from)).round() as u8).collect()))
        });
        let shots = shots.collect::<Result<Vec<_>, _>>()?;
        let mut reel =
            Self { width, height, mean: mean_of(&shots, width, height), shots, round: Loop::default() };
        reel.round = Loop::find(&reel.small_changes(), wanted, free).at_rate(video.rate);
        Ok(reel)
    }

    /// The changes of every frame from the mean, in cells of 8 by 8 pixels.
    fn small_changes(&self) -> Vec<Plane> {
        const CELL: usize = 8;
        let (width, height) = (self.width.div_ceil(CELL), self.height.div_ceil(CELL));
        let change = |shot: &Shot| {
            let mut small = Plane::new(width, height);
            for y in 0..self.height {
                let (row, mean) = (&shot.0[y * self.width..][..self.width], self.mean.row(y));
                for (x, (value, mean)) in row.iter().zip(mean).enumerate() {
                    small.values[y / CELL * width + x / CELL] += f32::from(*value) - mean;
                }
            }
            small
        };
        self.shots.par_iter().map(change).collect()
    }

    /// The same frames, smoothed for versions that show them smaller.
    pub(super) fn smoothed(&mut self, version: Version) {
        // Half the size needs 1 2 1; three quarters, a little.
        let side: u32 = if version.scale() > 0.9 {
            return;
        } else if version.scale() > 0.6 {
            1
        } else {
            2
        };
        let (width, height) = (self.width, self.height);
        self.shots.par_iter_mut().for_each(|shot| smooth(&mut shot.0, width, height, side));
        self.mean = mean_of(&self.shots, width, height);
    }

    /// Its loop.
    pub(super) fn round(&self) -> &Loop {
        &self.round
    }

    /// The loop goes round so many times in a clip.
    pub(super) fn repeat(&mut self, rounds: usize) {
        self.round.repeat(rounds);
    }

    /// Where the pixels of `patch` lie.
    pub(super) fn taps(&self, patch: &PatchRef) -> Taps {
        let [[a, b], [c, d]] = patch.version.to_video();
        let middle = (SIDE as f32 - 1.0) / 2.0;
        let (right, bottom) = ((self.width - 1) as f32, (self.height - 1) as f32);
        let tap = |i: usize| {
            let (across, along) = (
                (i % SIDE) as f32 - middle + f32::from(patch.x),
                (i / SIDE) as f32 - middle + f32::from(patch.y),
            );
            let x = (a * across + b * along + right / 2.0).clamp(0.0, right - 0.01);
            let y = (c * across + d * along + bottom / 2.0).clamp(0.0, bottom - 0.01);
            let index = y as u32 * self.width as u32 + x as u32;
            Tap { index, right: (x.fract() * 256.0) as u16, down: (y.fract() * 256.0) as u16 }
        };
        Taps((0..SIDE * SIDE).map(tap).collect())
    }

    /// The patch's mean over time.
    pub(super) fn mean(&self, taps: &Taps) -> Vec<f32> {
        let at = |tap: &Tap| {
            let (index, right, down) =
                (tap.index as usize, f32::from(tap.right) / 256.0, f32::from(tap.down) / 256.0);
            let row = |index: usize| {
                self.mean.values[index] + (self.mean.values[index + 1] - self.mean.values[index]) * right
            };
            row(index) + (row(index + self.width) - row(index)) * down
        };
        taps.0.iter().map(at).collect()
    }

    /// Adds the patch in a frame to `out`, weighted.
    pub(super) fn add(&self, taps: &Taps, (frame, weight): Term, out: &mut [f32]) {
        let Shot(shot) = &self.shots[frame];
        let weight = weight / 65536.0;
        for (out, tap) in out.iter_mut().zip(&taps.0) {
            let index = tap.index as usize;
            let (right, down) = (u32::from(tap.right), u32::from(tap.down));
            let row =
                |index: usize| u32::from(shot[index]) * (256 - right) + u32::from(shot[index + 1]) * right;
            *out += (row(index) * (256 - down) + row(index + self.width) * down) as f32 * weight;
        }
    }
}

fn mean_of(shots: &[Shot], width: usize, height: usize) -> Plane {
    let mut mean = Plane::new(width, height);
    mean.values.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for shot in shots {
            row.iter_mut().zip(&shot.0[y * width..]).for_each(|(sum, &value)| *sum += f32::from(value));
        }
        row.iter_mut().for_each(|sum| *sum /= shots.len() as f32);
    });
    mean
}

/// Smooths by 1 2 1 across and down if `side` is 2, and by 1 6 1 if it is 1.
fn smooth(values: &mut [u8], width: usize, height: usize, side: u32) {
    let middle = 8 - 2 * side;
    let mean = |a: u8, b: u8, c: u8| ((u32::from(a) + u32::from(c)) * side + u32::from(b) * middle + 4) / 8;
    for row in values.chunks_exact_mut(width) {
        let mut left = row[0];
        for x in 0..width {
            let here = row[x];
            row[x] = mean(left, here, row[(x + 1).min(width - 1)]) as u8;
            left = here;
        }
    }
    let mut above = values[..width].to_vec();
    for y in 0..height {
        for x in 0..width {
            let here = values[y * width + x];
            let below = values[(y + 1).min(height - 1) * width + x];
            values[y * width + x] = mean(above[x], here, below) as u8;
            above[x] = here;
        }
    }
}
