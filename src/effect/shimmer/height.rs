//! From luma to the three heights of every pixel: centre C, in-phase P = A·cos α and quadrature Q = A·sin α.
//!
//! Heights are luma levels in Q7. They are left in the `v` planes of the slopes that [`super::relief`] makes of them.

use super::{Branch, Range, Settings, bands, sliding, storage::Planes};

/// C = A = 127.5 of [`Range::Full`].
const HALF_RANGE: i16 = 255 << 6;

/// The window of [`Range::Neighbourhood`] on a picture of up to 480 rows, in pixels to each side: 9 × 9. It grows with
/// the picture ([`super::relief::scale`]).
const RADIUS: i32 = 4;

/// Fills the heights for the chosen range mode. `planes.mean_shade` holds the luma afterwards.
pub(super) fn fill(planes: &mut Planes<'_>, settings: &Settings) {
    let colours = planes.red.iter().zip(&*planes.green).zip(&*planes.blue);
    for (luma, ((&r, &g), &b)) in planes.mean_shade.iter_mut().zip(colours) {
        *luma = luma_q7(r, g, b);
    }
    match settings.range {
        Range::Full => planes.centre.v.fill(HALF_RANGE),
        Range::Neighbourhood => fill_neighbourhood(planes),
        Range::Travelling => return bands::fill(planes, settings.wind),
    }
    swing(planes, settings);
}

/// Luma of BT.709 on the coded channels, 0..=255 in Q7. The weights sum to 1024.
const fn luma_q7(r: u8, g: u8, b: u8) -> i16 {
    ((r as u32 * 218 + g as u32 * 732 + b as u32 * 74) >> 3) as i16
}

/// Largest and smallest luma around each pixel: C = (max + min)/2 into `centre.v`, A = (max − min)/2 into `cosine.v`.
fn fill_neighbourhood(planes: &mut Planes<'_>) {
    let radius = ((RADIUS * super::relief::scale(planes.size)) >> super::relief::SCALE_BITS) as usize;
    let width = planes.size.width as usize;
    let (running, suffix) = (&mut bytemuck::cast_slice_mut(planes.scratch)[..width], &mut *planes.sine.u);
    let (largest, least) = (&mut *planes.centre.v, &mut *planes.cosine.v);
    largest.copy_from_slice(planes.mean_shade);
    sliding::maximum(radius, largest, suffix, running);
    least.iter_mut().zip(&*planes.mean_shade).for_each(|(negative, &luma)| *negative = -luma);
    sliding::maximum(radius, least, suffix, running);
    for (largest, least) in largest.iter_mut().zip(least) {
        let (max, min) = (i32::from(*largest), -i32::from(*least));
        (*largest, *least) = (((max + min) >> 1) as i16, ((max - min) >> 1) as i16);
    }
}

/// From centre and amplitude to P and Q (eq. 3): Q = H(0) − C and P = ±sqrt(A² − Q²).
fn swing(planes: &mut Planes<'_>, settings: &Settings) {
    let width = planes.size.width as usize;
    for (i, &luma) in planes.mean_shade.iter().enumerate() {
        let amplitude = match settings.range {
            Range::Full => HALF_RANGE,
            _ => planes.cosine.v[i],
        };
        let (amplitude, quadrature) = (i32::from(amplitude), i32::from(luma - planes.centre.v[i]));
        let in_phase = (amplitude * amplitude - quadrature * quadrature).max(0).isqrt() as i16;
        let rises = match settings.branch {
            Branch::Rising => true,
            Branch::Falling => false,
            Branch::Scattered => scatter((i % width) as u32, (i / width) as u32),
        };
        planes.sine.v[i] = if rises { in_phase } else { -in_phase };
        planes.cosine.v[i] = quadrature as i16;
    }
}

/// A bit that depends on the pixel's place alone and has no pattern: the finaliser of MurmurHash3 (Appleby, public domain).
const fn scatter(x: u32, y: u32) -> bool {
    let mut hash = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    (hash ^ (hash >> 16)) & 1 == 1
}
