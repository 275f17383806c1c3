//! The frame kernel: two swings in, pixels out.
//!
//! Everything is 16-bit lanes, so that one instruction handles 8 (SSE, NEON) to 32 (AVX-512) pixels.

use super::{
    Shimmer,
    shade::{Light, slope},
    spans,
    storage::Planes,
};
use crate::{
    effect::{self, RUN},
    frame::{
        Size,
        pack::{Level, Levels},
    },
    math::{Factor, mul_q15, q15},
    noise::drive::Drive,
};
use core::ops::Range;

/// A shimmering photo at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    planes: Planes<'a>,
    centred: bool,
    swing: Swing,
}

/// What a moment has in common for all pixels.
#[derive(Clone, Copy, Debug)]
struct Swing {
    /// X_A·sin θ, Q15.
    sine: i16,
    /// X_A·cos θ, Q15.
    cosine: i16,
    /// onset·m/L_z, Q13.
    strength: i16,
    light: Light,
}

impl<'a> Moment<'a> {
    pub(super) fn new<S: AsMut<[u64]>>(shimmer: &'a mut Shimmer<S>, drive: Drive) -> Self {
        let swing = Swing {
            sine: q15(drive.amplitude * drive.phase.sin()),
            cosine: q15(drive.amplitude * drive.phase.cos()),
            strength: mul_q15(shimmer.strength, q15(drive.onset)) + i16::from(drive.onset >= Factor::ONE),
            light: shimmer.light,
        };
        let Ok(planes) = Planes::carve(shimmer.size, shimmer.storage.as_mut()) else {
            unreachable!("the storage was long enough when the photo was prepared")
        };
        Self { planes, centred: shimmer.centred, swing }
    }
}

impl effect::Moment for Moment<'_> {
    fn size(&self) -> Size {
        self.planes.size
    }

    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let most = spans::most(self.planes.size.width);
        let spans = self.planes.spans[y as usize * most..][..most].iter();
        spans.take_while(|span| span.start < span.end).map(|span| span.start.into()..span.end.into())
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        let planes = &self.planes;
        let start = y as usize * planes.size.width as usize + x;
        let place = start..start + levels.red.len();
        let mut gain = [0; RUN];
        let gain = &mut gain[..place.len()];
        match self.centred {
            false => gains::<false>(planes, self.swing, place.clone(), gain),
            true => gains::<true>(planes, self.swing, place.clone(), gain),
        }
        for (levels, channel) in levels.planes().into_iter().zip([&*planes.red, planes.green, planes.blue]) {
            amplify(&channel[place.clone()], gain, levels);
        }
    }
}

/// The gains of the pixels at `place`, Q12.
#[inline(always)]
fn gains<const CENTRED: bool>(planes: &Planes<'_>, swing: Swing, place: Range<usize>, gains: &mut [i16]) {
    let slopes = [&planes.sine, &planes.cosine, &planes.centre];
    let [pu, qu, cu] = slopes.map(|s| &s.u[place.clone()]);
    let [pv, qv, cv] = slopes.map(|s| &s.v[place.clone()]);
    let (mean, mask) = (&planes.mean_shade[place.clone()], &planes.mask[place]);
    for (i, gain) in gains.iter_mut().enumerate() {
        let centre = |plane: &[i16]| if CENTRED { plane[i] } else { 0 };
        let u = slope(swing.sine, pu[i], swing.cosine, qu[i], centre(cu));
        let v = slope(swing.sine, pv[i], swing.cosine, qv[i], centre(cv));
        let shade = swing.light.shade(u, v) - mean[i];
        // 0..=255 to 0..=1 in Q15, both ends exact to a step.
        let mask = i16::from(mask[i]) << 7 | i16::from(mask[i]) >> 1;
        *gain = (ONE + mul_q15(mul_q15(shade, mask), swing.strength)).max(0);
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
