//! From luma to the three heights of every pixel: centre C, in-phase P = A·cos α and quadrature Q = A·sin α.
//!
//! Heights are luma levels in Q7. They are left in the words of the v slopes that [`super::relief`] makes of them.

use super::{
    super::Photo,
    Branch, Range, Settings, bands, sliding,
    storage::{Block, Planes, Words},
};
use crate::math::{lanes::LANES, whole_roots};
use bytemuck::Zeroable as _;

/// The window of [`Range::Neighbourhood`] on a picture of up to 480 rows, in pixels to each side: 9 × 9. It grows with
/// the picture ([`super::relief::scale`]).
const RADIUS: i32 = 4;

/// Fills the heights for the chosen range mode. The words [`Words::Luma`] hold the luma afterwards.
#[inline(always)]
pub(super) fn fill(planes: &mut Planes<'_>, photo: Photo<'_>, settings: &Settings) {
    for (y, rgb) in photo.rgb.chunks_exact(3 * photo.size.width as usize).enumerate() {
        for (block, rgb) in planes.blocks.row_mut(y).iter_mut().zip(rgb.chunks(3 * LANES)) {
            *block = Block::zeroed();
            for (luma, &[r, g, b]) in block.words[Words::Luma as usize].iter_mut().zip(rgb.as_chunks().0) {
                *luma = luma_q7(r, g, b);
            }
        }
    }
    match settings.range {
        Range::Full => {}
        Range::Neighbourhood => find_extremes(planes),
        Range::Travelling => return bands::fill(planes, settings.wind),
    }
    swing(planes, settings);
}

/// Luma of BT.709 on the coded channels, 0..=255 in Q7. The weights sum to 1024.
const fn luma_q7(r: u8, g: u8, b: u8) -> i16 {
    ((r as u32 * 218 + g as u32 * 732 + b as u32 * 74) >> 3) as i16
}

/// Largest luma around each pixel into [`Words::CentreV`], least luma, negative, into [`Words::CosineV`].
#[inline(always)]
fn find_extremes(planes: &mut Planes<'_>) {
    let radius = ((RADIUS * super::relief::scale(planes.blocks.size)) >> super::relief::SCALE_BITS) as usize;
    let Planes { blocks, scratch, .. } = planes;
    for y in 0..blocks.size.height as usize {
        for Block { words } in blocks.row_mut(y) {
            let luma = words[Words::Luma as usize];
            words[Words::CentreV as usize] = luma;
            words[Words::CosineV as usize] = luma.map(|luma| -luma);
        }
    }
    for extreme in [Words::CentreV, Words::CosineV] {
        sliding::maximum(radius, blocks, extreme, Words::SineU, scratch);
    }
}

/// From luma, and its extremes, to C, and to P and Q (eq. 3): Q = H(0) − C and P = ±sqrt(A² − Q²).
#[inline(always)]
fn swing(planes: &mut Planes<'_>, settings: &Settings) {
    for y in 0..planes.blocks.size.height as usize {
        for (x, Block { words }) in (0..).step_by(LANES).zip(planes.blocks.row_mut(y)) {
            let luma = words[Words::Luma as usize];
            let (max, least) = match settings.range {
                Range::Full => ([255 << 7; LANES], [0; LANES]),
                _ => (words[Words::CentreV as usize], words[Words::CosineV as usize]),
            };
            let (mut centre, mut quadrature, mut squares) = ([0; LANES], [0; LANES], [0; LANES]);
            for i in 0..LANES {
                let (max, min) = (i32::from(max[i]), -i32::from(least[i]));
                let (middle, amplitude) = ((max + min) >> 1, (max - min) >> 1);
                let offset = i32::from(luma[i]) - middle;
                squares[i] = (amplitude * amplitude - offset * offset).max(0) as u32;
                (centre[i], quadrature[i]) = (middle as i16, offset as i16);
            }
            let mut in_phase = [0; LANES];
            in_phase.iter_mut().zip(whole_roots(squares)).for_each(|(height, root)| *height = root as i16);
            match settings.branch {
                Branch::Rising => {}
                Branch::Falling => in_phase.iter_mut().for_each(|height| *height = -*height),
                Branch::Scattered => {
                    let falling = (x..).zip(&mut in_phase).filter(|(x, _)| !scatter(*x, y as u32));
                    falling.for_each(|(_, height)| *height = -*height);
                }
            }
            words[Words::SineV as usize] = in_phase;
            words[Words::CosineV as usize] = quadrature;
            words[Words::CentreV as usize] = centre;
        }
    }
}

/// A bit that depends on the pixel's place alone and has no pattern: the finaliser of MurmurHash3 (Appleby, public domain).
const fn scatter(x: u32, y: u32) -> bool {
    let mut hash = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    (hash ^ (hash >> 16)) & 1 == 1
}
