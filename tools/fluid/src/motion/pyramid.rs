//! Smaller and smaller copies of a frame.

use crate::plane::Plane;

/// Pixels that each level goes on beyond its border, so that what moves out of the picture can be followed without questions.
pub(super) const MARGIN: usize = 24;

/// Levels stop before a side would be under this many pixels: three patches of the flow.
const SMALLEST: usize = 24;

/// A level with its border continued.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Without the margin.
    pub(super) width: usize,
    pub(super) height: usize,
    stride: usize,
    values: Vec<f32>,
}

impl Level {
    fn of(plane: &Plane) -> Self {
        let stride = plane.width + 2 * MARGIN;
        let mut values = Vec::with_capacity(stride * (plane.height + 2 * MARGIN));
        for y in 0..plane.height + 2 * MARGIN {
            let row = plane.row(y.saturating_sub(MARGIN).min(plane.height - 1));
            values.extend(core::iter::repeat_n(row[0], MARGIN));
            values.extend_from_slice(row);
            values.extend(core::iter::repeat_n(row[plane.width - 1], MARGIN));
        }
        Self { width: plane.width, height: plane.height, stride, values }
    }

    /// The row from `x` on, which may lie up to [`MARGIN`] before the picture.
    pub(super) fn from(&self, x: isize, y: isize) -> &[f32] {
        let margin = MARGIN as isize;
        &self.values[(y + margin) as usize * self.stride + (x + margin) as usize..]
    }
}

/// The levels of a frame, from half its size on down.
pub(super) fn levels(luma: &[u8], width: usize, height: usize) -> Vec<Level> {
    let mut plane = Plane { width, height, values: luma.iter().map(|level| f32::from(*level)).collect() };
    let mut levels = Vec::new();
    loop {
        plane = halved(&plane);
        levels.push(Level::of(&plane));
        if plane.width / 2 < SMALLEST || plane.height / 2 < SMALLEST {
            return levels;
        }
    }
}

/// Half the size: means of two by two, a last odd row or column left out.
pub(crate) fn halved(plane: &Plane) -> Plane {
    let mut half = Plane::new(plane.width / 2, plane.height / 2);
    let width = half.width;
    for (y, row) in half.values.chunks_exact_mut(width).enumerate() {
        let (above, below) = (plane.row(2 * y), plane.row(2 * y + 1));
        for ((value, above), below) in
            row.iter_mut().zip(above.as_chunks::<2>().0).zip(below.as_chunks::<2>().0)
        {
            *value = (above[0] + above[1] + below[0] + below[1]) / 4.0;
        }
    }
    half
}
