//! From heights to slopes: what the light sees.

use super::{Range, Settings, shade, storage::Planes};
use crate::{frame::Size, math::Turns};

/// Fractional bits of [`scale`].
pub(super) const SCALE_BITS: u32 = 8;

/// How many times a picture of `size` is larger than one whose shorter side has 480 pixels, at least 1, in Q8: with it the relief and
/// its waves keep their look on every panel.
pub(super) const fn scale(size: Size) -> i32 {
    let side = if size.width < size.height { size.width } else { size.height };
    let scale = (side << SCALE_BITS) as i32 / 480;
    if scale < 1 << SCALE_BITS { 1 << SCALE_BITS } else { scale }
}

/// Turns the heights (in the `v` planes) into slopes, and finds the mean shade.
pub(super) fn fill(planes: &mut Planes<'_>, settings: &Settings, light: shade::Light) {
    let axes = Axes::new(settings, planes.size);
    let width = planes.size.width as usize;
    let rows = bytemuck::cast_slice_mut::<i32, i16>(planes.scratch);
    let (above, at) = rows[..2 * width].split_at_mut(width);
    for slopes in [&mut planes.sine, &mut planes.cosine, &mut planes.centre] {
        gradient(slopes.u, slopes.v, above, at, axes);
    }
    if settings.range == Range::Full {
        planes.centre.u.fill(0);
        planes.centre.v.fill(0);
    }
    for i in 0..planes.size.pixels() {
        flatten(planes, i);
        planes.mean_shade[i] = mean_shade(planes, i, light);
    }
}

/// Slopes per height difference: a unit vector towards the light and one across, times the relief, Q15.
#[derive(Clone, Copy)]
struct Axes {
    u: [i32; 2],
    v: [i32; 2],
}

impl Axes {
    fn new(settings: &Settings, size: Size) -> Self {
        // relief · scale / luma_for_45_degrees, at most 1/2 so that products stay within 32 bits.
        let steepness =
            (settings.relief.to_bits().max(0) as i64 * i64::from(scale(size))) >> (28 + SCALE_BITS - 15);
        let steepness = (steepness / i64::from(settings.range.luma_for_45_degrees())).min(1 << 14);
        let axis = |direction: Turns| {
            [direction.sin(), -direction.cos()].map(|c| ((i64::from(c.to_bits()) * steepness) >> 28) as i32)
        };
        Self { u: axis(settings.light.azimuth), v: axis(settings.light.azimuth.plus(Turns::QUARTER)) }
    }
}

/// Fractional bits of a slope before [`flatten`]: room for ±32.
const STEEP_BITS: u32 = 10;

/// Replaces the heights in `v` (Q7) by slopes along the axes, Q10, saturated. The gradient is Sobel's, which smooths across the
/// direction that it differentiates; edges are repeated. `above` and `at` keep the heights of rows that are already replaced.
fn gradient(u: &mut [i16], v: &mut [i16], above: &mut [i16], at: &mut [i16], axes: Axes) {
    let width = at.len();
    let height = v.len() / width;
    above.copy_from_slice(&v[..width]);
    at.copy_from_slice(&v[..width]);
    for y in 0..height {
        let (done, rest) = v.split_at_mut((y + 1) * width);
        let out = &mut done[y * width..];
        let below = if rest.is_empty() { &*at } else { &rest[..width] };
        for x in 0..width {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
            let column = |x: usize| i32::from(above[x]) + 2 * i32::from(at[x]) + i32::from(below[x]);
            let row = |row: &[i16]| i32::from(row[left]) + 2 * i32::from(row[x]) + i32::from(row[right]);
            // Eight times the gradient in Q7, to Q8.
            let (dx, dy) = ((column(right) - column(left)) >> 2, (row(below) - row(above)) >> 2);
            let along = |axis: [i32; 2]| {
                let slope = (dx * axis[0] + dy * axis[1]) >> (8 + 15 - STEEP_BITS);
                slope.clamp(i16::MIN.into(), i16::MAX.into()) as i16
            };
            (u[y * width + x], out[x]) = (along(axes.u), along(axes.v));
        }
        above.copy_from_slice(at);
        if !rest.is_empty() {
            at.copy_from_slice(&rest[..width]);
        }
    }
}

/// √3 = tan 60° in Q10, less one step for rounding: the steepest that the shade's polynomial is made for.
const STEEPEST: u32 = 1773;

/// Brings the slopes of pixel i to Q14, flattened where centre and swing together could pass 60°.
///
/// |c + a·p + b·q| ≤ |c| + sqrt(|p|² + |q|²) for a² + b² ≤ 1; all three are scaled by the same factor, so that the swing keeps
/// its shape.
fn flatten(planes: &mut Planes<'_>, i: usize) {
    let [p, q, c] = [&mut planes.sine, &mut planes.cosine, &mut planes.centre];
    let mut slopes = [&mut p.u[i], &mut p.v[i], &mut q.u[i], &mut q.v[i], &mut c.u[i], &mut c.v[i]];
    let rough: u32 = slopes.iter().map(|s| u32::from(s.unsigned_abs())).sum();
    let factor = if rough <= STEEPEST {
        1 << 14
    } else {
        let square = |s: i16| (i32::from(s) * i32::from(s)) as u32 >> 3;
        let [pu, pv, qu, qv, cu, cv] = slopes.each_ref().map(|s| square(**s));
        // Squares are an eighth, so that four of them fit 32 bits; 2.83 = √8 in Q10.
        let steepest = (((pu + pv + qu + qv).isqrt() + (cu + cv).isqrt()) * 2897) >> 10;
        (STEEPEST << 14).checked_div(steepest).map_or(1 << 14, |factor| factor.min(1 << 14))
    };
    for slope in &mut slopes {
        **slope = ((i32::from(**slope) * factor as i32) >> STEEP_BITS) as i16;
    }
}

/// The swing at which the mean shade is taken: the root mean square of X_A, which has mean 1/2 and deviation 1/6
/// ([`crate::noise::drive`]): sqrt(1/4 + 1/36) = 0.527, Q15.
const TYPICAL_SWING: i16 = 17_270;

/// The mean of the shade over the phases 0°, 90°, 180°, 270°: exact to the third order of the slopes.
fn mean_shade(planes: &Planes<'_>, i: usize, light: shade::Light) -> i16 {
    let swings = [(TYPICAL_SWING, 0), (0, TYPICAL_SWING), (-TYPICAL_SWING, 0), (0, -TYPICAL_SWING)];
    let sum: i32 = swings
        .iter()
        .map(|&(a, b)| {
            let [p, q, c] = [&planes.sine, &planes.cosine, &planes.centre];
            let u = shade::slope(a, p.u[i], b, q.u[i], c.u[i]);
            let v = shade::slope(a, p.v[i], b, q.v[i], c.v[i]);
            i32::from(light.shade(u, v))
        })
        .sum();
    (sum / 4) as i16
}
