//! The look of a frame made that of the picture: the texture matching of Heeger and Bergen (1995), cell by cell.
//!
//! They match the histograms of the bands of a steerable pyramid, and of the pixels, and repeat. Departures: 1) the bands are those of a
//! Laplacian pyramid; 2) it is done once; 3) one mapping serves the whole clip, since a mapping of each frame would take away what makes
//! frames differ; 4) mappings of neighbouring cells are mixed, so that no cell shows; 5) no mapping is steeper or flatter than
//! [`SLOPES`].

use super::pyramid::{self, Laplacian};
use crate::plane::Plane;
use rayon::prelude::*;

/// Levels of the pyramid; the last is left as it is.
const LEVELS: usize = 4;

/// From the middle of a cell to the next, in pixels. A cell looks at twice as much.
const CELL: usize = 40;

/// Frames that are looked at.
const SAMPLES: usize = 8;

/// Quantiles that are matched.
const KNOTS: usize = 17;

/// Steps of a mapping.
const STEPS: usize = 32;

/// Slopes of a mapping.
const SLOPES: (f32, f32) = (0.4, 1.5);

/// A cell with fewer pixels of the fluid is left as it is.
const FEWEST: usize = 60;

/// A mapping of values, evenly spaced.
#[derive(Clone, Copy, Debug)]
struct Curve {
    low: f32,
    step: f32,
    values: [f32; STEPS + 1],
}

impl Curve {
    const SAME: Self = Self { low: 0.0, step: 0.0, values: [0.0; STEPS + 1] };

    /// The mapping that gives `ours` the histogram of `theirs`; both are sorted here.
    fn matching(ours: &mut [f32], theirs: &mut [f32]) -> Self {
        if ours.len() < FEWEST || theirs.len() < FEWEST {
            return Self::SAME;
        }
        let (from, to) = (quantiles(ours), quantiles(theirs));
        let middle = KNOTS / 2;
        let (low, high) = (from[0], from[KNOTS - 1]);
        if high - low < 0.5 || to[KNOTS - 1] - to[0] < 0.5 {
            return Self::SAME;
        }
        // From the middle outwards, so that limits to the slope move the tails and not the whole.
        let mut limited = to;
        let slope = |a: usize, b: usize| {
            let run = (from[b] - from[a]).max(1e-3);
            ((to[b] - to[a]) / run).clamp(SLOPES.0, SLOPES.1) * (from[b] - from[a])
        };
        for knot in middle + 1..KNOTS {
            limited[knot] = limited[knot - 1] + slope(knot - 1, knot);
        }
        for knot in (0..middle).rev() {
            limited[knot] = limited[knot + 1] - slope(knot, knot + 1);
        }
        let step = (high - low) / STEPS as f32;
        let mut knot = 0;
        let values = core::array::from_fn(|i| {
            let value = low + i as f32 * step;
            while knot + 2 < KNOTS && from[knot + 1] < value {
                knot += 1;
            }
            let part = ((value - from[knot]) / (from[knot + 1] - from[knot]).max(1e-3)).clamp(0.0, 1.0);
            limited[knot] + (limited[knot + 1] - limited[knot]) * part
        });
        Self { low, step, values }
    }

    fn at(&self, value: f32) -> f32 {
        if self.step == 0.0 {
            return value;
        }
        let place = (value - self.low) / self.step;
        let inside = place.clamp(0.0, STEPS as f32 - 0.001);
        let (step, part) = (inside as usize, inside.fract());
        let mapped = self.values[step] + (self.values[step + 1] - self.values[step]) * part;
        // Beyond its ends a value keeps its distance.
        mapped + (place - inside) * self.step * if place == inside { 0.0 } else { 1.0 }
    }
}

fn quantiles(values: &mut [f32]) -> [f32; KNOTS] {
    values.sort_unstable_by(f32::total_cmp);
    let last = values.len() - 1;
    core::array::from_fn(|knot| {
        let share = 0.01 + 0.98 * knot as f32 / (KNOTS - 1) as f32;
        values[(share * last as f32).round() as usize]
    })
}

/// The mappings of one band.
struct Curves {
    cell: usize,
    columns: usize,
    curves: Vec<Curve>,
}

impl Curves {
    /// Those that give `ours`, of several frames, the look of `theirs`.
    fn learn(ours: &[&Plane], theirs: &Plane, matte: &Plane, cell: usize) -> Self {
        let (columns, rows) = (theirs.width.div_ceil(cell) + 1, theirs.height.div_ceil(cell) + 1);
        // A few hundred of a band's pixels tell its histogram.
        let every = (cell / 14).max(1);
        let learn = |index: usize| {
            let (x, y) = (index % columns * cell, index / columns * cell);
            let across = x.saturating_sub(cell)..(x + cell).min(theirs.width);
            let places = (y.saturating_sub(cell)..(y + cell).min(theirs.height)).step_by(every);
            let places =
                places.flat_map(|y| across.clone().step_by(every).map(move |x| y * theirs.width + x));
            let places: Vec<_> = places.filter(|&place| matte.values[place] > 0.5).collect();
            let mut from: Vec<_> =
                ours.iter().flat_map(|plane| places.iter().map(|&place| plane.values[place])).collect();
            let mut to: Vec<_> = places.iter().map(|&place| theirs.values[place]).collect();
            Curve::matching(&mut from, &mut to)
        };
        Self { cell, columns, curves: (0..columns * rows).into_par_iter().map(learn).collect() }
    }

    /// Maps a band, with the mappings of the four nearest cells mixed.
    fn map(&self, band: &mut Plane, matte: &Plane) {
        let width = band.width;
        for (y, row) in band.values.chunks_exact_mut(width).enumerate() {
            let (top, down) = (y / self.cell * self.columns, (y % self.cell) as f32 / self.cell as f32);
            for (x, (value, &weight)) in row.iter_mut().zip(matte.row(y)).enumerate() {
                if weight <= 0.0 {
                    continue;
                }
                let (left, right) = (x / self.cell, (x % self.cell) as f32 / self.cell as f32);
                let at = |index: usize| self.curves[index].at(*value);
                let mix = |index: usize| at(index) + (at(index + 1) - at(index)) * right;
                let (above, below) = (mix(top + left), mix(top + self.columns + left));
                *value = above + (below - above) * down;
            }
        }
    }
}

/// One mapping for a clip.
pub(super) struct Look {
    bands: Vec<Curves>,
    pixels: Curves,
    mattes: Vec<Plane>,
}

impl Look {
    /// What gives the picture with these changes the look of the picture alone.
    pub(super) fn learn(picture: &Plane, matte: &Plane, changes: &[Plane]) -> Self {
        let every = changes.len().div_ceil(SAMPLES).max(1);
        let mattes = Laplacian::new(matte.width, matte.height, LEVELS - 1).levels;
        let mattes = mattes.into_iter().scan(matte.clone(), |finer, mut level| {
            if level.width == finer.width {
                level.values.copy_from_slice(&finer.values);
            } else {
                pyramid::reduce(finer, &mut level);
            }
            finer.clone_from(&level);
            Some(level)
        });
        let mattes: Vec<_> = mattes.collect();
        let theirs = Laplacian::of(picture, LEVELS);
        let shown: Vec<_> = changes
            .par_iter()
            .step_by(every)
            .map(|change| Laplacian::of(&sum(picture, change), LEVELS))
            .collect();
        let bands = (0..LEVELS - 1).map(|level| {
            let ours: Vec<_> = shown.iter().map(|pyramid| &pyramid.levels[level]).collect();
            Curves::learn(&ours, &theirs.levels[level], &mattes[level], CELL >> level)
        });
        let bands: Vec<_> = bands.collect();
        let joined = |mut pyramid: Laplacian| {
            bands
                .iter()
                .zip(&mut pyramid.levels)
                .zip(&mattes)
                .for_each(|((curves, band), matte)| curves.map(band, matte));
            pyramid.join()
        };
        let shown: Vec<_> = shown.into_par_iter().map(joined).collect();
        let pixels = Curves::learn(&shown.iter().collect::<Vec<_>>(), picture, matte, CELL);
        Self { bands, pixels, mattes }
    }

    /// A change made so that picture and change together look like the picture.
    pub(super) fn give(&self, picture: &Plane, change: &mut Plane) {
        let mut pyramid = Laplacian::of(&sum(picture, change), LEVELS);
        self.bands
            .iter()
            .zip(&mut pyramid.levels)
            .zip(&self.mattes)
            .for_each(|((curves, band), matte)| curves.map(band, matte));
        let mut shown = pyramid.join();
        self.pixels.map(&mut shown, &self.mattes[0]);
        for (change, (shown, picture)) in
            change.values.iter_mut().zip(shown.values.iter().zip(&picture.values))
        {
            *change = shown - picture;
        }
    }
}

fn sum(a: &Plane, b: &Plane) -> Plane {
    Plane { values: a.values.iter().zip(&b.values).map(|(a, b)| a + b).collect(), ..*a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grain that depends on its seed alone.
    fn grain(seed: u32, contrast: f32) -> Plane {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as f32 / 65536.0 - 0.5
        };
        Plane { width: 120, height: 80, values: (0..9600).map(|_| 128.0 + contrast * next()).collect() }
    }

    fn deviation(plane: &Plane) -> f32 {
        let mean = plane.values.iter().sum::<f32>() / 9600.0;
        (plane.values.iter().map(|value| (value - mean).powi(2)).sum::<f32>() / 9600.0).sqrt()
    }

    #[test]
    fn a_frame_gets_the_contrast_of_the_picture() {
        let (picture, matte) = (grain(1, 40.0), Plane { width: 120, height: 80, values: vec![1.0; 9600] });
        let changes = (2..12).map(|seed| {
            let mut change = grain(seed, 40.0);
            change.values.iter_mut().for_each(|value| *value -= 128.0);
            change
        });
        let changes: Vec<_> = changes.collect();
        let look = Look::learn(&picture, &matte, &changes);
        let mut change = changes[3].clone();
        look.give(&picture, &mut change);
        let ratio = deviation(&sum(&picture, &change)) / deviation(&picture);
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn what_is_outside_of_the_matte_is_left() {
        let (picture, matte) = (grain(1, 40.0), Plane::new(120, 80));
        let changes = vec![Plane::new(120, 80); 2];
        let mut change = changes[0].clone();
        Look::learn(&picture, &matte, &changes).give(&picture, &mut change);
        assert!(change.values.iter().all(|change| change.abs() < 1e-2));
    }

    #[test]
    fn a_flat_picture_is_no_model() {
        let (mut ours, mut theirs) = ((0..100).map(|i| i as f32).collect::<Vec<_>>(), vec![255.0; 100]);
        assert_eq!(Curve::matching(&mut ours, &mut theirs).at(3.0), 3.0);
    }
}
