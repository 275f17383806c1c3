use super::canvas::{Canvas, at};
use crate::{math::Factor, noise::drive::Drive};
use embedded_graphics::{
    draw_target::DrawTarget,
    geometry::Size,
    pixelcolor::{Rgb888, RgbColor},
    primitives::Rectangle,
};
use heapless::HistoryBuf;

/// What is seen of a noise: eight seconds, one column for each of [`COLUMNS_PER_SECOND`].
pub(super) const COLUMNS: usize = 96;

/// Twelve, the paper's frame rate. At a higher one, frames in between are left out.
const COLUMNS_PER_SECOND: u32 = 12;

/// The height of a plot, in cells.
pub(super) const HEIGHT: u32 = 26;

/// The last seconds of X_A and X_f.
#[derive(Clone, Debug, Default)]
pub(in crate::app) struct Trace {
    amplitudes: Curve,
    frequencies: Curve,
    frames: u32,
}

/// The last seconds of one of them, as heights: 0 at the bottom, 255 at the top.
type Curve = HistoryBuf<u8, COLUMNS>;

impl Trace {
    /// Notes the drive of a frame.
    pub(in crate::app) fn note(&mut self, drive: Drive, frames_per_second: u32) {
        if self.frames.is_multiple_of(frames_per_second.div_ceil(COLUMNS_PER_SECOND)) {
            self.amplitudes.write(height(drive.amplitude));
            self.frequencies.write(height(drive.frequency / 2));
        }
        self.frames = self.frames.wrapping_add(1);
    }

    /// X_A, of 0..=1, and X_f, of 0..=2.
    pub(super) const fn curves(&self) -> [&Curve; 2] {
        [&self.amplitudes, &self.frequencies]
    }
}

/// A share of 0..=1 as a height.
fn height(share: Factor) -> u8 {
    ((i64::from(share.to_bits()) * 255) >> Factor::FRAC_NBITS).clamp(0, 255) as u8
}

/// Plots the end of `curve` from column `x`, row `y` on, the newest on the right of `columns` columns, over a line for its middle.
pub(super) fn plot(curve: &Curve, x: u32, y: u32, columns: u32, colour: Rgb888, canvas: &mut Canvas<'_, '_>) {
    let mut fill = |x, y, width, height, colour| {
        let Ok(()) = canvas.fill_solid(&Rectangle::new(at(x, y), Size::new(width, height)), colour);
    };
    let middle = Rgb888::new(colour.r() / 2, colour.g() / 2, colour.b() / 2);
    fill(x, y + HEIGHT / 2, columns, 1, middle);
    let shown = curve.len().min(columns as usize);
    let rows = curve.oldest_ordered().skip(curve.len() - shown);
    let rows = rows.map(|&height| y + HEIGHT - 2 - u32::from(height) * (HEIGHT - 2) / 255);
    let mut before = None;
    for (row, x) in rows.zip(x + columns - shown as u32..) {
        // From the row before, so that the curve is one line however steep it is.
        let from = before.replace(row).unwrap_or(row);
        fill(x, from.min(row), 1, from.abs_diff(row) + 2, colour);
    }
}
