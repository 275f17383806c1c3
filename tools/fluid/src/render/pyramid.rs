//! The pyramid of Burt and Adelson: every level has half the width and the height of the one before.
//!
//! Pixel (x, y) of a level lies at pixel (2x, 2y) of the finer one. The kernel is 1 4 6 4 1; beyond the border the nearest pixel counts.

use crate::plane::Plane;

/// Width or height of the next coarser level.
pub(super) fn halved(length: usize) -> usize {
    length.div_ceil(2)
}

/// Fills `coarse` with the next level of `fine`.
pub(super) fn reduce(fine: &Plane, coarse: &mut Plane) {
    let last = fine.height - 1;
    let mut tall = vec![0.0; fine.width];
    for y in 0..coarse.height {
        let near = |offset: usize| fine.row((2 * y + offset).saturating_sub(2).min(last));
        let rows = [near(0), near(1), near(2), near(3), near(4)];
        for (x, sum) in tall.iter_mut().enumerate() {
            *sum = (rows[0][x] + rows[4][x] + 4.0 * (rows[1][x] + rows[3][x]) + 6.0 * rows[2][x]) / 16.0;
        }
        let at = |x: usize| tall[x.min(fine.width - 1)];
        let out = &mut coarse.values[y * coarse.width..][..coarse.width];
        for (x, value) in out.iter_mut().enumerate() {
            let x = 2 * x;
            let left = tall[x.saturating_sub(2)] + 4.0 * tall[x.saturating_sub(1)];
            *value = (left + 6.0 * at(x) + 4.0 * at(x + 1) + at(x + 2)) / 16.0;
        }
    }
}

/// Adds `factor` times the enlarged `coarse` to `fine`.
pub(super) fn expand_onto(coarse: &Plane, fine: &mut Plane, factor: f32) {
    let last = coarse.height - 1;
    // One more at either end, so that the loop below needs no bounds of its own.
    let mut wide = vec![0.0; coarse.width + 2];
    for y in 0..fine.height {
        let middle = y / 2;
        let (above, here, below) =
            (coarse.row(middle.saturating_sub(1)), coarse.row(middle), coarse.row((middle + 1).min(last)));
        let inner = &mut wide[1..=coarse.width];
        if y % 2 == 0 {
            for (x, value) in inner.iter_mut().enumerate() {
                *value = (above[x] + 6.0 * here[x] + below[x]) * (factor / 8.0);
            }
        } else {
            for (x, value) in inner.iter_mut().enumerate() {
                *value = (here[x] + below[x]) * (factor / 2.0);
            }
        }
        wide[0] = wide[1];
        wide[coarse.width + 1] = wide[coarse.width];
        let row = &mut fine.values[y * fine.width..][..fine.width];
        for (pair, near) in row.chunks_mut(2).zip(wide.windows(3)) {
            pair[0] += (near[0] + 6.0 * near[1] + near[2]) / 8.0;
            if let Some(odd) = pair.get_mut(1) {
                *odd += (near[1] + near[2]) / 2.0;
            }
        }
    }
}

/// The sizes of `levels` levels, the finest first.
pub(super) fn sizes(width: usize, height: usize, levels: usize) -> impl Iterator<Item = (usize, usize)> {
    std::iter::successors(Some((width, height)), |&(width, height)| Some((halved(width), halved(height))))
        .take(levels)
}

/// A plane blurred by going so many levels down and up again: by a standard deviation of about 2^levels pixels.
pub(super) fn blurred(plane: &Plane, levels: usize) -> Plane {
    if levels == 0 || plane.width.min(plane.height) < 2 {
        return plane.clone();
    }
    let mut coarse = Plane::new(halved(plane.width), halved(plane.height));
    reduce(plane, &mut coarse);
    let mut out = Plane::new(plane.width, plane.height);
    expand_onto(&blurred(&coarse, levels - 1), &mut out, 1.0);
    out
}

/// A pyramid of differences; the last level is what remains.
#[derive(Clone, Debug)]
pub(super) struct Laplacian {
    /// The finest first.
    pub(super) levels: Vec<Plane>,
}

impl Laplacian {
    /// Zeros.
    pub(super) fn new(width: usize, height: usize, levels: usize) -> Self {
        Self {
            levels: sizes(width, height, levels).map(|(width, height)| Plane::new(width, height)).collect(),
        }
    }

    /// Splits level 0, which holds the picture, into the levels.
    pub(super) fn split(&mut self) {
        for level in 1..self.levels.len() {
            let (finer, coarser) = self.levels.split_at_mut(level);
            reduce(&finer[level - 1], &mut coarser[0]);
        }
        for level in 1..self.levels.len() {
            let (finer, coarser) = self.levels.split_at_mut(level);
            expand_onto(&coarser[0], &mut finer[level - 1], -1.0);
        }
    }

    /// The pyramid of a picture.
    pub(super) fn of(picture: &Plane, levels: usize) -> Self {
        let mut pyramid = Self::new(picture.width, picture.height, levels);
        pyramid.levels[0].values.copy_from_slice(&picture.values);
        pyramid.split();
        pyramid
    }

    /// The picture again.
    pub(super) fn join(mut self) -> Plane {
        while self.levels.len() > 1
            && let Some(coarse) = self.levels.pop()
            && let Some(fine) = self.levels.last_mut()
        {
            expand_onto(&coarse, fine, 1.0);
        }
        self.levels.swap_remove(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_split_and_joined_is_the_same() {
        for (width, height) in [(48, 48), (13, 7), (1, 1), (2, 5)] {
            let values = (0..width * height).map(|i| (i * 7919 % 251) as f32).collect();
            let picture = Plane { width, height, values };
            let again = Laplacian::of(&picture, 4).join();
            for (a, b) in picture.values.iter().zip(&again.values) {
                assert!((a - b).abs() < 1e-3, "{a} became {b} at {width}x{height}");
            }
        }
    }

    #[test]
    fn an_even_picture_has_no_differences() {
        let picture = Plane { width: 20, height: 11, values: vec![7.0; 220] };
        let pyramid = Laplacian::of(&picture, 3);
        assert!(pyramid.levels[..2].iter().flat_map(|level| &level.values).all(|value| value.abs() < 1e-4));
        assert!(pyramid.levels[2].values.iter().all(|value| (value - 7.0).abs() < 1e-4));
    }
}
