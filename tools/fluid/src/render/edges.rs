//! What the videos do not know of the picture: its own strong edges, and how much should move where.
//!
//! Both go beyond the paper.

use super::pyramid::blurred;
use crate::plane::Plane;
use rayon::prelude::*;

/// Every such frame is looked at.
const EVERY: usize = 5;

/// The exponent of the ratio by which motion is brought nearer to that of its surroundings: neighbours come from different videos, and one
/// that boils beside one that sleeps shows the patch.
const EVEN: f32 = 0.5;

/// Motion is scaled by no less and no more than this.
const GAINS: (f32, f32) = (0.6, 1.5);

/// Halvings of the blur of a patch's motion, and of that of its surroundings.
const NEAR: usize = 4;

/// See [`NEAR`].
const FAR: usize = 6;

/// An edge of the picture so many times as steep as the usual one of the moving detail begins to be kept, and from the second on it is.
const STEEP: (f32, f32) = (3.0, 6.0);

/// A slope in levels a pixel that is no edge.
const NO_EDGE: f32 = 4.0;

/// So much of the motion is taken from an edge.
const KEPT: f32 = 0.75;

/// Brings the motion of all places nearer to that of their surroundings, and takes it from strong edges of the picture.
pub(super) fn settle(picture: &Plane, changes: &mut [Plane]) {
    let (motion, slopes) = measured(changes);
    let covered = |value: &f32| if *value > 1e-3 { 1.0 } else { 0.0 };
    let known = Plane { values: motion.values.iter().map(covered).collect(), ..motion };
    let [near, far] = [NEAR, FAR].map(|halvings| (blurred(&motion, halvings), blurred(&known, halvings)));
    let steepness = slopes_of(picture);
    let factor = |place: usize| {
        let usual =
            |(motion, known): &(Plane, Plane)| (motion.values[place] / known.values[place].max(0.05)).sqrt();
        let even = ((usual(&far) + 0.5) / (usual(&near) + 0.5)).powf(EVEN).clamp(GAINS.0, GAINS.1);
        let steep = steepness.values[place] / (slopes.values[place].sqrt() + NO_EDGE);
        let edge = ((steep - STEEP.0) / (STEEP.1 - STEEP.0)).clamp(0.0, 1.0);
        even * (1.0 - KEPT * edge)
    };
    let values: Vec<f32> = (0..picture.values.len()).into_par_iter().map(factor).collect();
    let factors = blurred(&Plane { values, ..*picture }, 1);
    changes.par_iter_mut().for_each(|change| {
        change.values.iter_mut().zip(&factors.values).for_each(|(change, factor)| *change *= factor)
    });
}

/// The mean squares of the changes and of their slopes.
fn measured(changes: &[Plane]) -> (Plane, Plane) {
    let mut motion = Plane::new(changes[0].width, changes[0].height);
    let mut slopes = motion.clone();
    let count = changes.len().div_ceil(EVERY) as f32;
    for change in changes.iter().step_by(EVERY) {
        motion.values.iter_mut().zip(&change.values).for_each(|(sum, value)| *sum += value * value / count);
        slopes
            .values
            .iter_mut()
            .zip(&slopes_of(change).values)
            .for_each(|(sum, slope)| *sum += slope * slope / count);
    }
    (motion, slopes)
}

/// The steepness of every place, in levels a pixel.
fn slopes_of(plane: &Plane) -> Plane {
    let soft = blurred(plane, 1);
    let mut out = Plane::new(plane.width, plane.height);
    let (right, bottom) = (plane.width - 1, plane.height - 1);
    for (y, row) in out.values.chunks_exact_mut(plane.width).enumerate() {
        let (above, here, below) =
            (soft.row(y.saturating_sub(1)), soft.row(y), soft.row((y + 1).min(bottom)));
        for (x, value) in row.iter_mut().enumerate() {
            *value = (here[(x + 1).min(right)] - here[x.saturating_sub(1)]).hypot(below[x] - above[x]) / 2.0;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 128;

    /// Waves whose strength is that of their place.
    fn waves(strength: impl Fn(usize, usize) -> f32) -> Vec<Plane> {
        let frame = |frame: usize| {
            let value =
                |i: usize| ((i % SIDE) as f32 * 0.4 + frame as f32).sin() * strength(i % SIDE, i / SIDE);
            Plane { width: SIDE, height: SIDE, values: (0..SIDE * SIDE).map(value).collect() }
        };
        (0..20).map(frame).collect()
    }

    fn strength(changes: &[Plane], x: usize, y: usize) -> f32 {
        changes.iter().map(|change| change.row(y)[x].powi(2)).sum::<f32>()
    }

    #[test]
    fn a_patch_that_boils_is_calmed() {
        let mut changes =
            waves(|x, y| if (40..80).contains(&x) && (40..80).contains(&y) { 40.0 } else { 10.0 });
        let before = strength(&changes, 60, 60) / strength(&changes, 10, 60);
        settle(&Plane::new(SIDE, SIDE), &mut changes);
        let after = strength(&changes, 60, 60) / strength(&changes, 10, 60);
        assert!(after < 0.8 * before, "{before} became {after}");
    }

    #[test]
    fn an_edge_of_the_picture_stays() {
        let picture = Plane {
            width: SIDE,
            height: SIDE,
            values: (0..SIDE * SIDE).map(|i| if i % SIDE < 64 { 10.0 } else { 240.0 }).collect(),
        };
        let mut changes = waves(|_, _| 6.0);
        let before = changes.clone();
        settle(&picture, &mut changes);
        let share = |x: usize| strength(&changes, x, 60) / strength(&before, x, 60);
        assert!(share(64) < 0.4 * share(20), "{} at the edge, {} elsewhere", share(64), share(20));
    }
}
