//! The picture, cut as the videos were.

use super::Grid;
use crate::{
    features::{CELLS, CHANNELS, Features, WordMap},
    patch::{SIDE, STRIDE},
    plane::Plane,
};

/// A patch is of the fluid if the matte covers this share of it: less, and its motion would mostly be seen through the matte's edge.
const COVERED: f32 = 0.1;

/// A patch this bright on average has lost its texture to the light, if it is [flat](FLAT) besides.
const BLOWN: f32 = 245.0;

/// The contrast, in levels, under which a bright patch has no texture but the camera's noise.
const FLAT: f32 = 2.0;

/// Angles further from the wanted one than this differ markedly: 45°.
const NEAR: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// Speeds further from the wanted one than this factor differ markedly.
const FACTOR: f32 = 2.0;

/// Speeds below this, in pixels a frame, are as good as still: it is what indexing takes for no motion.
const STILL: f32 = 0.15;

/// The motion that somebody asked for at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// The direction, a vector of length 1.
    pub direction: Option<[f32; 2]>,
    /// The speed, in pixels a frame.
    pub speed: Option<f32>,
}

impl Wanted {
    /// By how much a motion differs from this: 0 if not markedly; otherwise 1 or more, and the more the worse.
    pub(super) fn missed(&self, motion: &Motion) -> f32 {
        let direction = self.direction.map_or(0.0, |[x, y]| {
            let length = motion.mean[0].hypot(motion.mean[1]);
            let cosine = if length > 0.0 { (motion.mean[0] * x + motion.mean[1] * y) / length } else { 0.0 };
            // What does not get on has no direction.
            if length >= STILL && cosine >= NEAR { 0.0 } else { 2.0 - cosine }
        });
        let speed = self.speed.map_or(0.0, |speed| {
            let factor = ((motion.speed + STILL) / (speed + STILL)).ln().abs() / FACTOR.ln();
            if factor <= 1.0 { 0.0 } else { factor }
        });
        direction + speed
    }
}

/// How a patch of the database moves as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Its mean motion, in pixels a frame.
    pub mean: [f32; 2],
    /// Its speed, in pixels a frame: boiling water has one, though its mean motion is 0.
    pub speed: f32,
    /// What changes from frame to frame: the mean magnitude of the spectrum but for its mean.
    pub amplitude: f32,
}

impl Motion {
    /// That of a patch.
    pub fn of(features: &Features) -> Self {
        let cells = (CELLS * CELLS) as f32;
        let mean = [0, 1].map(|axis| features.motion.iter().map(|cell| cell[axis]).sum::<f32>() / cells);
        let bands = |cell: &[f32; CHANNELS]| cell[2..8].iter().map(|band| band * band).sum::<f32>();
        let speed =
            features.motion.iter().map(|cell| (cell[0] * cell[0] + cell[1] * cell[1] + bands(cell)).sqrt());
        let amplitude = features.motion.iter().map(|cell| cell[2..8].iter().sum::<f32>() / 6.0);
        Self { mean, speed: speed.sum::<f32>() / cells, amplitude: amplitude.sum::<f32>() / cells }
    }
}

/// What is known of a patch of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Its words.
    pub words: WordMap,
    /// Standard deviation of its luminance, in levels.
    pub contrast: f32,
    /// Whether it is over-exposed: its words say nothing, and it moves as its neighbours do.
    pub blown: bool,
    /// The motion that was asked for.
    pub wanted: Wanted,
}

/// The picture's patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// How the picture is cut.
    pub grid: Grid,
    /// One a patch, row by row; none where there is no fluid.
    pub looks: Vec<Option<Look>>,
}

impl Target {
    /// Cuts a picture. `words` are those of [`crate::appearance::describe`] for its [`Grid::of`]; `matte` is 1 where the fluid is and 0
    /// where not, of the picture's size; without it, all is fluid.
    ///
    /// # Panics
    ///
    /// If the words are not those of the picture's grid, or the matte has another size.
    pub fn new(luma: &Plane, matte: Option<&Plane>, words: Vec<WordMap>) -> Self {
        let grid = Grid::of(luma.width, luma.height);
        assert_eq!(words.len(), grid.columns * grid.rows, "one map of words for each patch");
        assert!(matte.is_none_or(|matte| (matte.width, matte.height) == (luma.width, luma.height)));
        let look = |(number, words)| {
            let place = (number % grid.columns * STRIDE, number / grid.columns * STRIDE);
            let covered = matte.map_or(1.0, |matte| moments(matte, place).0);
            let (mean, contrast) = moments(luma, place);
            let blown = mean >= BLOWN && contrast < FLAT;
            (covered >= COVERED).then_some(Look { words, contrast, blown, wanted: Wanted::default() })
        };
        Self { grid, looks: words.into_iter().enumerate().map(look).collect() }
    }

    /// Asks for a motion at each patch, given the place of its centre in the picture.
    pub fn ask(&mut self, wanted: impl Fn(f32, f32) -> Wanted) {
        let columns = self.grid.columns;
        for (number, look) in self.looks.iter_mut().enumerate() {
            let centre = |patch: usize| (patch * STRIDE) as f32 + (SIDE as f32 - 1.0) / 2.0;
            if let Some(look) = look {
                look.wanted = wanted(centre(number % columns), centre(number / columns));
            }
        }
    }
}

/// Mean and standard deviation of the part of a patch that is in the picture.
fn moments(plane: &Plane, (left, top): (usize, usize)) -> (f32, f32) {
    let (right, bottom) = ((left + SIDE).min(plane.width), (top + SIDE).min(plane.height));
    let pixels = || (top..bottom).flat_map(|y| &plane.row(y)[left..right]).map(|&value| f64::from(value));
    let count = ((right - left) * (bottom - top)) as f64;
    let mean = pixels().sum::<f64>() / count;
    let variance = pixels().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    (mean as f32, variance.sqrt() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matte_and_the_light_are_seen() {
        let mut luma = Plane::new(120, 48);
        for (i, value) in luma.values.iter_mut().enumerate() {
            *value = if i % 120 < 60 { 250.0 } else { (i % 7 * 30) as f32 };
        }
        let mut matte = Plane::new(120, 48);
        matte.values.iter_mut().enumerate().for_each(|(i, value)| *value = f32::from(i % 120 < 74));
        let grid = Grid::of(120, 48);
        assert_eq!((grid.columns, grid.rows), (4, 1));
        let target = Target::new(&luma, Some(&matte), vec![[0; 81]; 4]);
        let blown: Vec<_> = target.looks.iter().map(|look| look.as_ref().map(|look| look.blown)).collect();
        assert_eq!(blown, [Some(true), Some(false), Some(false), None]);
    }

    #[test]
    fn the_last_patches_reach_the_border() {
        assert_eq!(Grid::of(640, 360), Grid { columns: 26, rows: 14 });
        assert_eq!(Grid::of(48, 48), Grid { columns: 1, rows: 1 });
        assert_eq!(Grid::of(49, 20), Grid { columns: 2, rows: 1 });
    }

    #[test]
    fn other_directions_and_speeds_are_missed_by_more() {
        let motion = |u: f32, v: f32| Motion { mean: [u, v], speed: u.hypot(v), amplitude: 0.0 };
        let up = Wanted { direction: Some([0.0, -1.0]), speed: None };
        assert_eq!(up.missed(&motion(0.5, -1.0)), 0.0);
        assert!(up.missed(&motion(0.0, 1.0)) > up.missed(&motion(1.0, 0.0)));
        assert!(up.missed(&motion(0.0, -0.01)) >= 1.0, "still");
        let fast = Wanted { direction: None, speed: Some(3.0) };
        assert_eq!(fast.missed(&motion(2.0, 0.0)), 0.0);
        assert!(fast.missed(&motion(0.2, 0.0)) > fast.missed(&motion(1.0, 0.0)));
        assert!(fast.missed(&motion(1.0, 0.0)) >= 1.0);
    }
}
