//! The frame kernel: two swings in, pixels out.
//!
//! Everything is 16-bit lanes, so that one instruction handles 8 (SSE, NEON) to 32 (AVX-512) pixels.

use super::{
    Shimmer,
    shade::{Light, slope},
    spans::{self, Span},
    storage::Planes,
};
use crate::{
    effect::Paint,
    frame::{
        FrameMut,
        pack::{Colours, Level, pack},
    },
    math::{Factor, mul_q15},
    noise::drive::Drive,
};
use core::ops::Range;

/// Pixels that are computed at a time: their levels stay in the first-level cache.
const RUN: usize = 128;

/// What a frame has in common for all pixels.
#[derive(Clone, Copy)]
struct Moment {
    /// X_A·sin θ, Q15.
    sine: i16,
    /// X_A·cos θ, Q15.
    cosine: i16,
    /// onset·m/L_z, Q13.
    strength: i16,
    light: Light,
}

pub(super) fn render(shimmer: &mut Shimmer<'_>, drive: Drive, paint: Paint, out: &mut FrameMut<'_>) {
    let q15 = |factor: Factor| (factor.to_bits() >> 13).clamp(-32_767, 32_767) as i16;
    let moment = Moment {
        sine: q15(drive.amplitude * drive.phase.sin()),
        cosine: q15(drive.amplitude * drive.phase.cos()),
        strength: mul_q15(shimmer.strength, q15(drive.onset)) + i16::from(drive.onset >= Factor::ONE),
        light: shimmer.light,
    };
    let Ok(planes) = &Planes::carve(shimmer.size, shimmer.storage) else {
        unreachable!("the storage was long enough when the photo was prepared")
    };
    let whole = [Span { start: 0, end: planes.size.width as u16 }];
    for y in 0..planes.size.height {
        let most = spans::most(planes.size.width);
        let spans = match paint {
            Paint::Everything => &whole[..],
            Paint::Motion => &planes.spans[y as usize * most..][..most],
        };
        for span in spans.iter().take_while(|span| span.start < span.end) {
            match shimmer.centred {
                false => render_span::<false>(planes, moment, y, *span, out),
                true => render_span::<true>(planes, moment, y, *span, out),
            }
        }
    }
}

fn render_span<const CENTRED: bool>(
    planes: &Planes<'_>,
    moment: Moment,
    y: u32,
    span: Span,
    out: &mut FrameMut<'_>,
) {
    let layout = out.layout();
    let bytes_per_pixel = layout.format.bytes_per_pixel();
    let row = y as usize * planes.size.width as usize;
    let (start, end) = (usize::from(span.start), usize::from(span.end));
    let pixels = out.row(y)[start * bytes_per_pixel..end * bytes_per_pixel].chunks_mut(RUN * bytes_per_pixel);
    for (run, pixels) in pixels.enumerate() {
        let x = start + run * RUN;
        let length = RUN.min(end - x);
        let (mut gain, mut levels) = ([0; RUN], [[0; RUN]; 3]);
        let place = row + x..row + x + length;
        gains::<CENTRED>(planes, moment, place.clone(), &mut gain[..length]);
        for (levels, channel) in levels.iter_mut().zip([&*planes.red, planes.green, planes.blue]) {
            amplify(&channel[place.clone()], &gain[..length], &mut levels[..length]);
        }
        let [red, green, blue] = levels.each_ref().map(|levels| &levels[..length]);
        pack(layout.format, Colours { red, green, blue }, x as u32, y, pixels);
    }
}

/// The gains of the pixels at `place`, Q12.
#[inline(always)]
fn gains<const CENTRED: bool>(planes: &Planes<'_>, moment: Moment, place: Range<usize>, gains: &mut [i16]) {
    let slopes = [&planes.sine, &planes.cosine, &planes.centre];
    let [pu, qu, cu] = slopes.map(|s| &s.u[place.clone()]);
    let [pv, qv, cv] = slopes.map(|s| &s.v[place.clone()]);
    let (mean, mask) = (&planes.mean_shade[place.clone()], &planes.mask[place]);
    for (i, gain) in gains.iter_mut().enumerate() {
        let centre = |plane: &[i16]| if CENTRED { plane[i] } else { 0 };
        let u = slope(moment.sine, pu[i], moment.cosine, qu[i], centre(cu));
        let v = slope(moment.sine, pv[i], moment.cosine, qv[i], centre(cv));
        let shade = moment.light.shade(u, v) - mean[i];
        // 0..=255 to 0..=1 in Q15, both ends exact to a step.
        let mask = i16::from(mask[i]) << 7 | i16::from(mask[i]) >> 1;
        *gain = (ONE + mul_q15(mul_q15(shade, mask), moment.strength)).max(0);
    }
}

/// A gain of 1.
const ONE: i16 = 1 << 12;

/// A channel times the gains, saturated, with 4 fractional bits. A gain of 1 changes nothing.
#[inline(always)]
fn amplify(channel: &[u8], gains: &[i16], levels: &mut [Level]) {
    for ((level, &channel), &gain) in levels.iter_mut().zip(channel).zip(gains) {
        *level = mul_q15(i16::from(channel) << 7, gain).min(255 << 4) as Level;
    }
}
