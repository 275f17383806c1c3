//! The outline of a flame or of smoke moves with it.
//!
//! The paper, section 6: B(i+1) = τ·W_i(B_i) + (1 − τ)·α with B_1 = α, where α is the matte and W_i moves a picture along the motion of
//! frame i of the animation; the area of B is kept. Departures: 1) it runs through the clip twice and the second round counts, so that the
//! end meets the beginning; 2) beyond the matte, where nothing moves yet, motion goes on as it is inside; 3) half the size is enough.

use super::inpaint::fill;
use super::pyramid::{halved, reduce};
use crate::motion::{GRID, flow::Flow};
use crate::plane::Plane;
use rayon::prelude::*;

/// Outlines of a clip, at half the working size.
#[derive(Default)]
pub(super) struct Outlines(Vec<Plane>);

impl Outlines {
    /// Those of a matte over a picture of this luminance with these changes. `tau` is 0 for an outline that stands still.
    pub(super) fn of(matte: &Plane, picture: &Plane, changes: &[Plane], tau: f32) -> Self {
        let small = half(matte);
        let shown: Vec<_> = changes.par_iter().map(|change| half_levels(picture, change)).collect();
        let flow = |index: usize| {
            let flow =
                Flow::between(&shown[index], &shown[(index + 1) % shown.len()], small.width, small.height);
            spread(&flow, &small)
        };
        let flows: Vec<_> = (0..shown.len()).into_par_iter().map(flow).collect();
        let area: f32 = small.values.iter().sum();
        let mut outline = small.clone();
        let mut round = || {
            let step = |flow: &[Plane; 2]| {
                let next = moved(&outline, flow, &small, tau);
                core::mem::replace(&mut outline, of_area(next, area))
            };
            flows.iter().map(step).collect::<Vec<_>>()
        };
        round();
        Self(round())
    }

    /// How much of frame `index` is fluid at a pixel of the working size.
    pub(super) fn at(&self, index: usize, x: usize, y: usize) -> f32 {
        self.0[index].sample(x as f32 / 2.0, y as f32 / 2.0)
    }

    /// The least and the most of each pixel that is fluid in any frame, at half the working size.
    pub(super) fn extremes(&self) -> [Plane; 2] {
        [f32::min, f32::max].map(|extreme| {
            let mut frames = self.0.iter();
            let mut out = frames.next().cloned().unwrap_or_else(|| Plane::new(1, 1));
            for frame in frames {
                out.values
                    .iter_mut()
                    .zip(&frame.values)
                    .for_each(|(out, value)| *out = extreme(*out, *value));
            }
            out
        })
    }
}

fn half(plane: &Plane) -> Plane {
    let mut small = Plane::new(halved(plane.width), halved(plane.height));
    reduce(plane, &mut small);
    small
}

fn half_levels(picture: &Plane, change: &Plane) -> Vec<u8> {
    let values =
        picture.values.iter().zip(&change.values).map(|(picture, change)| picture + change).collect();
    half(&Plane { values, ..*picture })
        .values
        .into_iter()
        .map(|value| value.round().clamp(0.0, 255.0) as u8)
        .collect()
}

/// The flow as two planes on its grid, continued beyond the matte.
fn spread(flow: &Flow, matte: &Plane) -> [Plane; 2] {
    let mut known = Plane::new(flow.columns, flow.rows);
    for (index, known) in known.values.iter_mut().enumerate() {
        *known = matte.sample((index % flow.columns * GRID) as f32, (index / flow.columns * GRID) as f32);
    }
    [0, 1].map(|axis| {
        let values = flow.values.iter().map(|vector| f32::from(vector[axis]) / Flow::UNIT).collect();
        fill(&Plane { width: flow.columns, height: flow.rows, values }, &known)
    })
}

/// τ·W(B) + (1 − τ)·α.
fn moved(outline: &Plane, [right, down]: &[Plane; 2], matte: &Plane, tau: f32) -> Plane {
    let mut next = Plane::new(outline.width, outline.height);
    next.values.par_chunks_mut(outline.width).enumerate().for_each(|(y, row)| {
        for (x, (value, alpha)) in row.iter_mut().zip(matte.row(y)).enumerate() {
            let (column, line) = (x as f32 / GRID as f32, y as f32 / GRID as f32);
            let from = (x as f32 - right.sample(column, line), y as f32 - down.sample(column, line));
            *value = tau * outline.sample(from.0, from.1) + (1.0 - tau) * alpha;
        }
    });
    next
}

/// The outline with its level shifted where it is neither in nor out, until it covers `area` pixels.
fn of_area(mut outline: Plane, area: f32) -> Plane {
    let covered =
        |outline: &Plane, shift: f32| outline.values.iter().map(|value| shifted(*value, shift)).sum::<f32>();
    let (mut low, mut high) = (-0.5_f32, 0.5_f32);
    for _ in 0..10 {
        let middle = (low + high) / 2.0;
        *if covered(&outline, middle) < area { &mut low } else { &mut high } = middle;
    }
    let shift = (low + high) / 2.0;
    outline.values.iter_mut().for_each(|value| *value = shifted(*value, shift));
    outline
}

/// What is wholly in or out stays so.
fn shifted(value: f32, shift: f32) -> f32 {
    (value + shift * 4.0 * value * (1.0 - value)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc() -> Plane {
        let inside = |i: usize| ((i % 64) as f32 - 32.0).hypot((i / 64) as f32 - 32.0) < 16.0;
        Plane { width: 64, height: 64, values: (0..4096).map(|i| f32::from(u8::from(inside(i)))).collect() }
    }

    #[test]
    fn an_outline_moves_with_the_fluid_and_keeps_its_area() {
        let matte = disc();
        let still = [
            Plane { values: vec![0.0; 256], width: 16, height: 16 },
            Plane { values: vec![-2.0; 256], width: 16, height: 16 },
        ];
        let area: f32 = matte.values.iter().sum();
        let next = of_area(moved(&matte, &still, &matte, 0.9), area);
        let centre = |plane: &Plane| {
            plane.values.iter().enumerate().map(|(i, value)| (i / 64) as f32 * value).sum::<f32>() / area
        };
        assert!(centre(&next) < centre(&matte) - 1.0, "{} is not above {}", centre(&next), centre(&matte));
        assert!((next.values.iter().sum::<f32>() / area - 1.0).abs() < 0.02);
    }

    #[test]
    fn without_motion_the_matte_stays() {
        let matte = disc();
        let outlines = Outlines::of(&matte, &Plane::new(64, 64), &vec![Plane::new(64, 64); 3], 0.9);
        assert!(outlines.at(2, 32, 32) > 0.99 && outlines.at(2, 4, 4) < 0.01);
    }
}
