//! Which pixels count.

use crate::Clip;

/// The pixels that are compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    width: usize,
    inside: Vec<bool>,
}

impl Region {
    /// Every pixel of `clip`.
    pub fn whole(clip: &Clip) -> Self {
        Self { width: clip.width, inside: vec![true; clip.pixels()] }
    }

    /// The pixels of a mask that are at least half white.
    pub fn of_mask(width: usize, mask: &[u8]) -> Self {
        Self { width, inside: mask.iter().map(|&level| level >= 128).collect() }
    }

    /// The share of `clip`'s pixels that move most, by their deviation over time.
    pub fn moving(clip: &Clip, share: f32) -> Self {
        let deviation = crate::statistics::deviation(clip);
        let mut sorted = deviation.clone();
        sorted.sort_by(f32::total_cmp);
        let rank = ((1.0 - share.clamp(0.0, 1.0)) * sorted.len() as f32) as usize;
        let least = sorted.get(rank).copied().unwrap_or(f32::INFINITY);
        Self { width: clip.width, inside: deviation.iter().map(|&value| value >= least).collect() }
    }

    /// Whether the pixel counts.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        self.inside[y * self.width + x]
    }

    /// Whether it counts, for every pixel, row by row.
    pub fn pixels(&self) -> &[bool] {
        &self.inside
    }

    /// The upper left corners of the squares of `side` pixels, side by side, of which at least half counts.
    pub fn squares(&self, side: usize) -> Vec<(usize, usize)> {
        let height = self.inside.len() / self.width.max(1);
        let corners = |length: usize| (0..length / side).map(move |number| number * side);
        let mut squares = Vec::new();
        for y in corners(height) {
            for x in corners(self.width) {
                let rows = (y..y + side).map(|row| &self.inside[row * self.width + x..][..side]);
                let count = rows.flatten().filter(|&&inside| inside).count();
                if 2 * count >= side * side {
                    squares.push((x, y));
                }
            }
        }
        squares
    }
}
