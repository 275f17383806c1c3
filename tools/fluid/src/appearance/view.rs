//! The eighteen versions of a picture.

use crate::{
    patch::{PatchRef, SIDE, STRIDE, Version},
    plane::Plane,
};
use rayon::prelude::*;

/// A picture in the sizes of the versions, smoothed so that nothing finer than a pixel is left.
#[derive(Clone, Debug)]
pub struct Sizes(Vec<(f32, Plane)>);

impl Sizes {
    /// Smooths a picture for every size.
    pub fn of(plane: &Plane) -> Self {
        let mut scales: Vec<f32> = Version::all().map(Version::scale).collect();
        scales.sort_by(f32::total_cmp);
        scales.dedup();
        Self(scales.into_iter().map(|scale| (scale, smoothed(plane, scale))).collect())
    }

    /// The smoothed picture for a version. It keeps its own pixels.
    pub fn of_version(&self, version: Version) -> &Plane {
        let scale = version.scale();
        let found = self.0.iter().find(|(candidate, _)| *candidate == scale);
        &found.unwrap_or(&self.0[0]).1
    }

    /// A version of the picture as a whole, its middle in the middle; beyond the picture its border goes on. Both sides are multiples of
    /// twice the patches' stride, so that patches begin at multiples of their stride.
    pub fn view(&self, version: Version) -> Plane {
        let source = self.of_version(version);
        let (columns, rows) = reach(version, source.width, source.height);
        let mut view = Plane::new(2 * columns * STRIDE, 2 * rows * STRIDE);
        let width = view.width;
        let (left, top) = ((columns * STRIDE) as f32 - 0.5, (rows * STRIDE) as f32 - 0.5);
        view.values.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                let (x, y) = place(version, x as f32 - left, y as f32 - top, source.width, source.height);
                *value = source.sample(x, y);
            }
        });
        view
    }
}

/// Where a video's picture of this size shows a place of a version, in pixels whose centres are at whole numbers.
pub fn place(version: Version, x: f32, y: f32, width: usize, height: usize) -> (f32, f32) {
    let map = version.to_video();
    (
        map[0][0] * x + map[0][1] * y + (width as f32 - 1.0) / 2.0,
        map[1][0] * x + map[1][1] * y + (height as f32 - 1.0) / 2.0,
    )
}

/// The patches of a version that lie on the video's picture, from above: their centres are [`STRIDE`] apart, one in the middle.
pub fn patches(video: u32, version: Version, width: usize, height: usize) -> impl Iterator<Item = PatchRef> {
    let (columns, rows) = reach(version, width, height);
    let line = |reach: usize| (-(reach as i16)..=reach as i16).map(|step| step * STRIDE as i16);
    line(rows)
        .flat_map(move |y| line(columns).map(move |x| PatchRef { video, version, x, y }))
        .filter(move |patch| lies_within(patch, width, height))
}

fn lies_within(patch: &PatchRef, width: usize, height: usize) -> bool {
    let half = SIDE as f32 / 2.0;
    [(-half, -half), (half, -half), (-half, half), (half, half)].iter().all(|(dx, dy)| {
        let (x, y) = place(patch.version, f32::from(patch.x) + dx, f32::from(patch.y) + dy, width, height);
        // A hair's breadth for rounding.
        (-0.51..=width as f32 - 0.49).contains(&x) && (-0.51..=height as f32 - 0.49).contains(&y)
    })
}

/// How many strides the version's picture reaches from its middle, rounded up.
fn reach(version: Version, width: usize, height: usize) -> (usize, usize) {
    let map = version.from_video();
    let (x, y) = (width as f32 / 2.0, height as f32 / 2.0);
    let strides =
        |row: [f32; 2]| ((row[0].abs() * x + row[1].abs() * y) / STRIDE as f32 - 0.001).ceil() as usize;
    (strides(map[0]), strides(map[1]))
}

/// A Gaussian that takes a picture whose pixels see half a pixel's blur to the same at a smaller size.
fn smoothed(plane: &Plane, scale: f32) -> Plane {
    let sigma = 0.5 * (1.0 / (scale * scale) - 1.0).max(0.0).sqrt();
    if sigma < 0.1 {
        return plane.clone();
    }
    // Three pixels to each side hold 99.9 % of the widest, whose sigma is 0.87.
    let mut weights: [f32; 7] =
        core::array::from_fn(|tap| (-((tap as f32 - 3.0) / sigma).powi(2) / 2.0).exp());
    let sum: f32 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    let pass = |source: &Plane, dx: usize, dy: usize| {
        let mut result = Plane::new(source.width, source.height);
        result.values.par_chunks_mut(source.width).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                *value = (0..7)
                    .map(|tap| {
                        let x = (x + tap * dx).saturating_sub(3 * dx).min(source.width - 1);
                        let y = (y + tap * dy).saturating_sub(3 * dy).min(source.height - 1);
                        weights[tap] * source.row(y)[x]
                    })
                    .sum();
            }
        });
        result
    };
    pass(&pass(plane, 1, 0), 0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_version_is_the_picture() {
        let mut plane = Plane::new(96, 144);
        plane.values.iter_mut().enumerate().for_each(|(index, value)| *value = (index * 7 % 251) as f32);
        let view = Sizes::of(&plane).view(Version::all().next().unwrap());
        assert_eq!(view, plane);
    }

    #[test]
    fn a_mirrored_version_is_the_picture_mirrored() {
        let mut plane = Plane::new(96, 96);
        plane.values.iter_mut().enumerate().for_each(|(index, value)| *value = (index * 7 % 251) as f32);
        let view = Sizes::of(&plane).view(Version::new(1).unwrap());
        for y in 0..96 {
            assert!((0..96).all(|x| (view.row(y)[x] - plane.row(y)[95 - x]).abs() < 1e-2), "row {y}");
        }
    }

    #[test]
    fn patches_fill_the_picture_and_no_more() {
        let upright: Vec<_> = patches(3, Version::new(0).unwrap(), 640, 360).collect();
        assert_eq!(upright.len(), 25 * 13);
        assert_eq!((upright[0].x, upright[0].y), (-288, -144));
        let small: Vec<_> = patches(3, Version::new(4).unwrap(), 96, 96).collect();
        assert_eq!(small.len(), 1, "at half its size such a video is one patch");
        for version in Version::all() {
            for patch in patches(0, version, 317, 203) {
                assert!(lies_within(&patch, 317, 203), "{patch:?}");
            }
        }
    }
}
