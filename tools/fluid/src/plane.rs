//! Pictures in memory.

/// One channel of a picture, row by row. Luminance is that of sRGB levels, 0..=255.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` values.
    pub values: Vec<f32>,
}

impl Plane {
    /// A plane of zeros.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, values: vec![0.0; width * height] }
    }

    /// Row `y`.
    pub fn row(&self, y: usize) -> &[f32] {
        &self.values[y * self.width..][..self.width]
    }

    /// The value at a place between pixels, whose centres are at whole numbers; beyond the border the nearest pixel counts.
    pub fn sample(&self, x: f32, y: f32) -> f32 {
        let x = x.clamp(0.0, (self.width - 1) as f32);
        let y = y.clamp(0.0, (self.height - 1) as f32);
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(self.width - 1), (top + 1).min(self.height - 1));
        let (u, v) = (x - left as f32, y - top as f32);
        let mix = |row: &[f32]| row[left] + (row[right] - row[left]) * u;
        let (above, below) = (mix(self.row(top)), mix(self.row(bottom)));
        above + (below - above) * v
    }
}
