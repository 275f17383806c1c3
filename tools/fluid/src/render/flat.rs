//! Over-exposed places look like nothing in particular: they go on with what moves beside them.

use super::plan::neighbours;
use crate::footage::Footage;
use crate::label::Labelling;
use crate::patch::{PatchRef, SIDE, STRIDE};
use crate::plane::Plane;

/// Brighter than this on average, in levels, and with less contrast than [`FLAT`].
const BRIGHT: f32 = 238.0;

/// See [`BRIGHT`].
const FLAT: f32 = 3.0;

/// Whether a patch with this mean and deviation is over-exposed.
pub(super) fn is_flat(mean: f32, deviation: f32) -> bool {
    mean > BRIGHT && deviation < FLAT
}

/// The labelling with every over-exposed patch given what continues the patch beside it; from the border of such a place inwards.
pub(super) fn continued(labelling: &Labelling, picture: &Plane, footage: &dyn Footage) -> Labelling {
    let grid = labelling.grid;
    let mut out = labelling.clone();
    let flat = |index: usize| {
        let (mean, deviation) = under(picture, (index % grid.columns, index / grid.columns));
        is_flat(mean, deviation)
    };
    let mut open: Vec<usize> =
        (0..out.patches.len()).filter(|&index| out.patches[index].is_some() && flat(index)).collect();
    while !open.is_empty() {
        let found = open.iter().filter_map(|&index| {
            let place = (index % grid.columns, index / grid.columns);
            let near = neighbours(grid, place).filter(|(_, other)| !open.contains(other));
            let patch =
                near.filter_map(|(offset, other)| shifted(out.patches[other]?, offset, footage)).next()?;
            Some((index, patch))
        });
        let found: Vec<_> = found.collect();
        if found.is_empty() {
            break;
        }
        for &(index, patch) in &found {
            out.patches[index] = Some(patch);
        }
        open.retain(|index| found.iter().all(|(done, _)| done != index));
    }
    out
}

/// What lies beside a patch in its video, where the neighbour in direction `offset` is the patch; none if that is outside of the video.
fn shifted(patch: PatchRef, (right, down): (i32, i32), footage: &dyn Footage) -> Option<PatchRef> {
    let video = footage.video(patch.video)?;
    let beside = |place: i16, steps: i32| i16::try_from(i32::from(place) - steps * STRIDE as i32).ok();
    let (x, y) = (beside(patch.x, right)?, beside(patch.y, down)?);
    let [[a, b], [c, d]] = patch.version.to_video();
    let half = SIDE as f32 / 2.0;
    let inside =
        [(-half, -half), (half, -half), (-half, half), (half, half)].into_iter().all(|(across, along)| {
            let (x, y) = (f32::from(x) + across, f32::from(y) + along);
            (a * x + b * y).abs() <= video.width as f32 / 2.0
                && (c * x + d * y).abs() <= video.height as f32 / 2.0
        });
    inside.then_some(PatchRef { x, y, ..patch })
}

/// The mean and the standard deviation of the picture under a patch.
pub(super) fn under(picture: &Plane, (column, row): (usize, usize)) -> (f32, f32) {
    let (left, top) = ((column * STRIDE).min(picture.width), (row * STRIDE).min(picture.height));
    let (right, bottom) = ((left + SIDE).min(picture.width), (top + SIDE).min(picture.height));
    statistics((top..bottom).flat_map(|y| &picture.row(y)[left..right]).copied())
}

/// The mean and the standard deviation of values; zeros if there are none.
pub(super) fn statistics(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let (count, sum, squares) = values.fold((0.0_f64, 0.0, 0.0), |(count, sum, squares), value| {
        let value = f64::from(value);
        (count + 1.0, sum + value, squares + value * value)
    });
    let mean = sum / count.max(1.0);
    (mean as f32, (squares / count.max(1.0) - mean * mean).max(0.0).sqrt() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::footage::Video;
    use crate::label::Grid;
    use crate::patch::Version;
    use crate::render::tests::Waves;

    #[test]
    fn an_over_exposed_patch_goes_on_with_its_neighbour() {
        let version = Version::all().next().expect("there is a first version");
        let patch = |x| Some(PatchRef { video: 1, version, x, y: 0 });
        let labelling = Labelling {
            grid: Grid { columns: 4, rows: 1 },
            patches: vec![patch(-20), patch(-3), patch(7), patch(5)],
        };
        // White from the second patch on: the last two see nothing else; the second still sees something.
        let values = (0..120 * 48).map(|i| if i % 120 < 30 { (i % 7 * 9) as f32 } else { 255.0 }).collect();
        let picture = Plane { width: 120, height: 48, values };
        let footage = Waves(Video { width: 200, ..Waves::new(40).0 });
        let continued = continued(&labelling, &picture, &footage);
        let x: Vec<_> = continued.patches.iter().map(|patch| patch.map(|patch| patch.x)).collect();
        assert_eq!(x, [Some(-20), Some(-3), Some(21), Some(45)]);
    }
}
