//! Holes filled with what is around them: push and pull (Gortler and others 1996).
//!
//! Every level of a pyramid holds weighted means of the finer one; from the coarsest down, what is not known is taken from above.

use super::pyramid::{expand_onto, halved, reduce};
use crate::plane::Plane;

/// Fills `channel` where `known` is below 1: 0 knows nothing.
pub(super) fn fill(channel: &Plane, known: &Plane) -> Plane {
    if channel.width.max(channel.height) == 1 {
        return channel.clone();
    }
    let mut weighted = channel.clone();
    weighted.values.iter_mut().zip(&known.values).for_each(|(value, known)| *value *= known);
    let (width, height) = (halved(channel.width), halved(channel.height));
    let (mut coarse, mut weight) = (Plane::new(width, height), Plane::new(width, height));
    reduce(&weighted, &mut coarse);
    reduce(known, &mut weight);
    for (value, weight) in coarse.values.iter_mut().zip(&mut weight.values) {
        *value /= weight.max(1e-6);
        // A place that knows something is known from here on, lest far things come in.
        *weight = (*weight * 4.0).min(1.0);
    }
    let filled = fill(&coarse, &weight);
    let mut out = Plane::new(channel.width, channel.height);
    expand_onto(&filled, &mut out, 1.0);
    for (out, (value, known)) in out.values.iter_mut().zip(channel.values.iter().zip(&known.values)) {
        *out += (value - *out) * known;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_takes_what_is_around_it_and_the_rest_stays() {
        let (width, height) = (37, 23);
        let hole = |i: usize| (10..25).contains(&(i % width)) && (5..15).contains(&(i / width));
        let channel = Plane {
            width,
            height,
            values: (0..width * height).map(|i| if hole(i) { 255.0 } else { 40.0 }).collect(),
        };
        let known = Plane {
            width,
            height,
            values: (0..width * height).map(|i| if hole(i) { 0.0 } else { 1.0 }).collect(),
        };
        assert!(fill(&channel, &known).values.iter().all(|value| (value - 40.0).abs() < 0.5));
    }

    #[test]
    fn a_slope_goes_on_across_a_hole() {
        let width = 64;
        let channel = Plane { width, height: 8, values: (0..512).map(|i| (i % width) as f32).collect() };
        let known = Plane {
            width,
            height: 8,
            values: (0..512).map(|i| if (24..40).contains(&(i % width)) { 0.0 } else { 1.0 }).collect(),
        };
        let filled = fill(&channel, &known);
        assert!(
            filled.row(4).windows(2).all(|pair| pair[1] - pair[0] > -0.5 && pair[1] - pair[0] < 4.0),
            "{:?}",
            filled.row(4)
        );
    }
}
