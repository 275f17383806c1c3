//! Dense optical flow by inverse search.
//!
//! Kroeger, Timofte, Dai and Van Gool 2016 ("DIS"): on every level of a pyramid, patches of 8 by 8 pixels, 4 apart, are moved by the
//! inverse compositional Lucas–Kanade step from where the coarser level leaves them; pixels take the mean of the patches above them,
//! weighted by how well these fit. Departs: 1) it ends at half the size of the frame; 2) in place of the variational refinement a small
//! smoothing on each level: the paper too wants a flow that is not sensitive to fine motion; 3) the steps are held back where a patch
//! shows little, so that flow in flat places is none and not chance.

use super::{
    GRID,
    pyramid::{Level, MARGIN, levels},
};

/// Side of a patch of the search, in pixels of the level.
const PATCH: usize = 8;

/// From a patch to the next.
const STRIDE: usize = 4;

/// Steps at most; most patches stop after three or four.
const STEPS: usize = 8;

/// A step that is smaller than this, in pixels of the level, is the last one.
const SMALL_STEP: f32 = 0.02;

/// Added to the squared gradients of a patch: those of a noise of half a level.
const HOLD: f32 = (PATCH * PATCH) as f32 * 0.25;

/// Farther than this from its start a patch is lost and goes back to it.
const LOST: f32 = PATCH as f32;

/// Reach of the smoothing, in pixels of the level: 5 by 5.
const SMOOTH: usize = 2;

/// The flow between two frames, on every [`GRID`]th pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Points of a row.
    pub columns: usize,
    /// Rows of points.
    pub rows: usize,
    /// u and v of each point, in 1/[`Flow::UNIT`] pixels of the video a frame.
    pub values: Vec<[i16; 2]>,
}

impl Flow {
    /// Fractions of a pixel that flow is kept in.
    pub const UNIT: f32 = 256.0;

    /// The flow from one frame to the next: both luminances, row by row, of `width` pixels a row.
    ///
    /// About 0.015 s for 640 × 360 pixels.
    pub fn between(from: &[u8], to: &[u8], width: usize, height: usize) -> Self {
        let (from, to) = (levels(from, width, height), levels(to, width, height));
        let mut field: Option<Field> = None;
        for (from, to) in from.iter().zip(&to).rev() {
            let mut next = match &field {
                Some(coarse) => coarse.doubled(from.width, from.height),
                None => Field::still(from.width, from.height),
            };
            search(from, to, &mut next);
            field = Some(next);
        }
        let (columns, rows) = (width / GRID, height / GRID);
        let values = field.map_or_else(Vec::new, |field| field.on_grid(columns, rows));
        Self { columns, rows, values }
    }
}

/// u and v at every pixel of a level, in its pixels.
#[derive(Clone)]
struct Field {
    width: usize,
    height: usize,
    values: Vec<[f32; 2]>,
}

impl Field {
    fn still(width: usize, height: usize) -> Self {
        Self { width, height, values: vec![[0.0; 2]; width * height] }
    }

    /// The start of the next finer level.
    fn doubled(&self, width: usize, height: usize) -> Self {
        let mut fine = Self::still(width, height);
        for (y, row) in fine.values.chunks_exact_mut(width).enumerate() {
            let coarse = &self.values[(y / 2).min(self.height - 1) * self.width..][..self.width];
            for (x, value) in row.iter_mut().enumerate() {
                *value = coarse[(x / 2).min(self.width - 1)].map(|part| 2.0 * part);
            }
        }
        fine
    }

    /// Means of two by two pixels of half the frame's size.
    fn on_grid(&self, columns: usize, rows: usize) -> Vec<[i16; 2]> {
        let points = (0..rows).flat_map(|row| (0..columns).map(move |column| (2 * column, 2 * row)));
        points
            .map(|(x, y)| {
                let at = |dx: usize, dy: usize| self.values[(y + dy) * self.width + x + dx];
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                // The mean of four, doubled for the whole frame's pixels; the cast saturates.
                [0, 1]
                    .map(|part| (four.iter().map(|value| value[part]).sum::<f32>() / 2.0 * Flow::UNIT) as i16)
            })
            .collect()
    }

    /// A box, along the rows and then down.
    fn smooth(&mut self) {
        let (width, height) = (self.width, self.height);
        let mut rows = vec![[0.0; 2]; width * height];
        for (y, row) in rows.chunks_exact_mut(width).enumerate() {
            let source = &self.values[y * width..][..width];
            for (x, value) in row.iter_mut().enumerate() {
                *value = mean(&source[x.saturating_sub(SMOOTH)..(x + SMOOTH + 1).min(width)]);
            }
        }
        for y in 0..height {
            let (top, bottom) = (y.saturating_sub(SMOOTH), (y + SMOOTH + 1).min(height));
            let line = &mut self.values[y * width..][..width];
            line.fill([0.0; 2]);
            for source in rows[top * width..bottom * width].chunks_exact(width) {
                for (value, source) in line.iter_mut().zip(source) {
                    value[0] += source[0];
                    value[1] += source[1];
                }
            }
            let share = 1.0 / (bottom - top) as f32;
            line.iter_mut().for_each(|value| *value = value.map(|part| part * share));
        }
    }
}

fn mean(values: &[[f32; 2]]) -> [f32; 2] {
    let share = 1.0 / values.len() as f32;
    [0, 1].map(|part| values.iter().map(|value| value[part]).sum::<f32>() * share)
}

/// A part of a frame, and what it changes by when it moves.
struct Template {
    values: [[f32; PATCH]; PATCH],
    right: [[f32; PATCH]; PATCH],
    down: [[f32; PATCH]; PATCH],
    /// The inverse of the matrix of the squared gradients: xx, xy, yy.
    inverse: [f32; 3],
}

impl Template {
    fn at(level: &Level, x: usize, y: usize) -> Self {
        let (mut values, mut right, mut down) =
            ([[0.0; PATCH]; PATCH], [[0.0; PATCH]; PATCH], [[0.0; PATCH]; PATCH]);
        for row in 0..PATCH {
            let (left_of, line) = (x as isize - 1, (y + row) as isize);
            let (above, here, below) =
                (level.from(left_of, line - 1), level.from(left_of, line), level.from(left_of, line + 1));
            for column in 0..PATCH {
                values[row][column] = here[column + 1];
                right[row][column] = (here[column + 2] - here[column]) / 2.0;
                down[row][column] = (below[column + 1] - above[column + 1]) / 2.0;
            }
        }
        // Brightness that rises or falls as a whole is no motion: only what differs from the mean counts.
        centre(&mut right);
        centre(&mut down);
        let (xx, xy, yy) = (sum(&right, &right) + HOLD, sum(&right, &down), sum(&down, &down) + HOLD);
        let determinant = xx * yy - xy * xy;
        Self { values, right, down, inverse: [yy / determinant, -xy / determinant, xx / determinant] }
    }

    /// What the other frame shows here when moved by `motion`, less what this one does; none outside.
    fn residual(&self, other: &Level, x: usize, y: usize, motion: [f32; 2]) -> Option<[[f32; PATCH]; PATCH]> {
        let margin = MARGIN as f32;
        let (left, top) = (x as f32 + motion[0], y as f32 + motion[1]);
        let inside =
            |place: f32, side: usize| place >= -margin && place + PATCH as f32 + 1.0 < side as f32 + margin;
        if !inside(left, other.width) || !inside(top, other.height) {
            return None;
        }
        let (u, v) = (left - left.floor(), top - top.floor());
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let mut residual = [[0.0; PATCH]; PATCH];
        for (row, (line, own)) in residual.iter_mut().zip(&self.values).enumerate() {
            let above = other.from(left.floor() as isize, top.floor() as isize + row as isize);
            let below = other.from(left.floor() as isize, top.floor() as isize + row as isize + 1);
            let (above, below) = (&above[..=PATCH], &below[..=PATCH]);
            for column in 0..PATCH {
                line[column] = weights[0] * above[column]
                    + weights[1] * above[column + 1]
                    + weights[2] * below[column]
                    + weights[3] * below[column + 1]
                    - own[column];
            }
        }
        centre(&mut residual);
        Some(residual)
    }

    fn step(&self, residual: &[[f32; PATCH]; PATCH]) -> [f32; 2] {
        let (x, y) = (sum(&self.right, residual), sum(&self.down, residual));
        let [xx, xy, yy] = self.inverse;
        [xx * x + xy * y, xy * x + yy * y]
    }
}

fn centre(values: &mut [[f32; PATCH]; PATCH]) {
    let mean = values.as_flattened().iter().sum::<f32>() / (PATCH * PATCH) as f32;
    values.as_flattened_mut().iter_mut().for_each(|value| *value -= mean);
}

fn sum(a: &[[f32; PATCH]; PATCH], b: &[[f32; PATCH]; PATCH]) -> f32 {
    let mut lanes = [0.0; PATCH];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..PATCH {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    lanes.iter().sum()
}

/// Improves a field by one level.
fn search(from: &Level, to: &Level, field: &mut Field) {
    let (width, height) = (field.width, field.height);
    let mut sums = vec![[0.0f32; 2]; width * height];
    let mut weights = vec![0.0f32; width * height];
    let starts = |side: usize| {
        let last = side - PATCH;
        // The last patch ends where the picture does.
        (0..last).step_by(STRIDE).chain(core::iter::once(last))
    };
    for y in starts(height) {
        for x in starts(width) {
            let start = field.values[(y + PATCH / 2) * width + x + PATCH / 2];
            let template = Template::at(from, x, y);
            let Some((motion, residual)) = follow(&template, to, x, y, start) else { continue };
            for (row, line) in residual.iter().enumerate() {
                let first = (y + row) * width + x;
                let pixels = sums[first..first + PATCH].iter_mut().zip(&mut weights[first..first + PATCH]);
                for ((sum, total), residual) in pixels.zip(line) {
                    let weight = 1.0 / residual.abs().max(1.0);
                    sum[0] += weight * motion[0];
                    sum[1] += weight * motion[1];
                    *total += weight;
                }
            }
        }
    }
    for ((value, sum), total) in field.values.iter_mut().zip(&sums).zip(&weights) {
        if *total > 0.0 {
            *value = sum.map(|part| part / total);
        }
    }
    field.smooth();
}

/// Where a patch went, and how badly it fits there; none if its start is outside.
fn follow(
    template: &Template,
    to: &Level,
    x: usize,
    y: usize,
    start: [f32; 2],
) -> Option<([f32; 2], [[f32; PATCH]; PATCH])> {
    let at_start = template.residual(to, x, y, start)?;
    let (mut motion, mut residual) = (start, at_start);
    for _ in 0..STEPS {
        let step = template.step(&residual);
        let next = [motion[0] - step[0], motion[1] - step[1]];
        if (next[0] - start[0]).hypot(next[1] - start[1]) > LOST {
            return Some((start, at_start));
        }
        let Some(there) = template.residual(to, x, y, next) else { return Some((start, at_start)) };
        (motion, residual) = (next, there);
        if step[0].hypot(step[1]) < SMALL_STEP {
            break;
        }
    }
    let badness = |residual| sum(residual, residual);
    Some(if badness(&residual) < badness(&at_start) { (motion, residual) } else { (start, at_start) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A smooth texture moved by (u, v).
    fn frame(width: usize, height: usize, u: f32, v: f32) -> Vec<u8> {
        let texture = |x: f32, y: f32| {
            (0.31 * x + 0.12 * y).sin()
                + (0.23 * y - 0.17 * x).cos()
                + (0.07 * x + 0.4 * y).sin()
                + (0.05 * x * 0.9).cos()
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x as f32 - u, y as f32 - v)));
        pixels.map(|(x, y)| (128.0 + 25.0 * texture(x, y)) as u8).collect()
    }

    fn error(flow: &Flow, u: f32, v: f32) -> f32 {
        let inner = (4..flow.rows - 4)
            .flat_map(|row| (4..flow.columns - 4).map(move |column| row * flow.columns + column));
        let errors: Vec<f32> = inner
            .map(|point| {
                let [x, y] = flow.values[point].map(|part| f32::from(part) / Flow::UNIT);
                (x - u).hypot(y - v)
            })
            .collect();
        errors.iter().sum::<f32>() / errors.len() as f32
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn a_known_shift_is_found(u in -5.0f32..5.0, v in -5.0f32..5.0) {
            // Up to 7 pixels: from 8 on, half the finest wave of the texture, there are other ways to see it.
            let flow = Flow::between(&frame(160, 120, 0.0, 0.0), &frame(160, 120, u, v), 160, 120);
            prop_assert!(error(&flow, u, v) < 0.15, "{}", error(&flow, u, v));
        }
    }

    #[test]
    fn small_motion_is_told_from_none() {
        let still = Flow::between(&frame(160, 120, 0.0, 0.0), &frame(160, 120, 0.0, 0.0), 160, 120);
        assert!(still.values.iter().all(|value| *value == [0, 0]));
        let slow = Flow::between(&frame(160, 120, 0.0, 0.0), &frame(160, 120, 0.15, 0.0), 160, 120);
        assert!(error(&slow, 0.15, 0.0) < 0.06, "{}", error(&slow, 0.15, 0.0));
    }

    #[test]
    fn light_that_goes_up_and_down_does_not_move() {
        let frame = frame(160, 120, 0.0, 0.0);
        let brighter: Vec<u8> = frame.iter().map(|level| level.saturating_add(20)).collect();
        let flow = Flow::between(&frame, &brighter, 160, 120);
        assert!(error(&flow, 0.0, 0.0) < 0.02, "{}", error(&flow, 0.0, 0.0));
    }

    #[test]
    fn a_flat_picture_does_not_move() {
        let noisy: Vec<u8> = (0..96 * 96).map(|index: usize| 100 + (index * index / 7 % 2) as u8).collect();
        let flow = Flow::between(&[100; 96 * 96], &noisy, 96, 96);
        let fast = flow.values.iter().filter(|value| value[0].abs().max(value[1].abs()) > 128).count();
        assert!(fast * 20 < flow.values.len(), "{fast}");
    }

    #[test]
    fn two_halves_move_their_own_way() {
        let (left, right) = (frame(160, 120, 3.0, 0.0), frame(160, 120, -2.0, 1.0));
        let both: Vec<u8> =
            (0..160 * 120).map(|index| if index % 160 < 80 { left[index] } else { right[index] }).collect();
        let flow = Flow::between(&frame(160, 120, 0.0, 0.0), &both, 160, 120);
        let at = |column: usize| flow.values[15 * 40 + column].map(|part| f32::from(part) / Flow::UNIT);
        assert!((at(8)[0] - 3.0).abs() < 0.3 && (at(32)[0] + 2.0).abs() < 0.3, "{:?} {:?}", at(8), at(32));
    }
}
