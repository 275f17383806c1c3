//! How much of a picture's luminance depends on the drive: what the [guard](crate::noise::guard) must know of it.

use super::{Effect, Moment, RUN};
use crate::{
    frame::{Size, pack::Block},
    math::{Factor, Turns, lanes::LANES},
    noise::{drive::Drive, guard::Sensitivity},
};

/// The most parts across and down: of 16 pixels on a panel of 1024×640, of more on a larger one.
const COLUMNS: usize = 64;
const ROWS: usize = 40;
const PARTS: usize = COLUMNS * ROWS;

/// A part is no smaller than so many pixels a side: what two or three pixels do is a glint and no flash.
const LEAST_SIDE: usize = 16;

/// Rows of pixels that are looked at in a row of parts: texture has no preferred rows, and a fourth of the work is enough.
const LOOKED_AT: usize = 4;

/// Phases around a cycle.
const PHASES: u32 = 8;

/// The chord of an eighth of a turn, 2·sin(π/8), in 1024ths.
const CHORD: u32 = 784;

/// A part is taken for no darker than this share of full white in 2^-16, 1 %: WCAG counts no flash of what is as good as black.
const DARK: u32 = 655;

/// The mean linear luminance of every part, in 2^-16 of full white, row by row; what is beyond the last part is black.
type Parts = [u16; PARTS];

/// How many parts there are across and down.
fn shape(size: Size) -> (usize, usize) {
    let parts = |side: u32, most| (side as usize / LEAST_SIDE).clamp(1, most);
    (parts(size.width, COLUMNS), parts(size.height, ROWS))
}

const STILL: Drive =
    Drive { amplitude: Factor::ZERO, frequency: Factor::ONE, phase: Turns(0), onset: Factor::ONE };

/// Measures `effect`, whose moments must depend on nothing but amplitude and phase, at rest and at eight phases of the full swing.
///
/// The luminance of a level is taken for its square (a gamma of 2). Takes 41 instructions for each pixel of a picture of 320×96, of which it looks at a quarter
/// (x86-64 with AVX2), and 20 KB of stack and what a run of blocks takes.
pub(super) fn measure(effect: &mut impl Effect) -> Sensitivity {
    let mut at =
        |amplitude, phase, parts: &mut Parts| look(&effect.at(Drive { amplitude, phase, ..STILL }), parts);
    let (mut rest, mut before, mut now, mut steepest) = ([0; PARTS], [0; PARTS], [0; PARTS], [0_u16; PARTS]);
    let still = at(Factor::ZERO, Turns::default(), &mut rest);
    let mut last = at(Factor::ONE, Turns::default(), &mut before);
    let mut mean = last.abs_diff(still);
    for phase in 1..=PHASES {
        let whole =
            at(Factor::ONE, Turns((u64::from(phase) * (1 << 32) / u64::from(PHASES)) as u32), &mut now);
        mean = mean.max(whole.abs_diff(last) * 1024 / CHORD).max(whole.abs_diff(still));
        last = whole;
        for (((steepest, now), before), rest) in steepest.iter_mut().zip(&now).zip(&before).zip(&rest) {
            let along = u32::from(now.abs_diff(*before)) * 1024 / CHORD;
            let out = u32::from(now.abs_diff(*rest));
            *steepest = (*steepest).max(along.max(out).min(u16::MAX.into()) as u16);
        }
        core::mem::swap(&mut now, &mut before);
    }
    let share = |bits: u32| Factor::from_bits((bits.min(7 << 16) << (Factor::FRAC_NBITS - 16)) as i32);
    let (columns, rows) = shape(effect.at(STILL).size());
    let parts = columns * rows;
    Sensitivity { mean: share(mean), local: share(upper_quartile(&steepest[..parts], &rest[..parts])) }
}

/// What a quarter of the parts exceed of change by luminance, in 2^-16.
fn upper_quartile(steepest: &[u16], rest: &[u16]) -> u32 {
    /// Of 1/64: changes of up to four times the luminance.
    const BINS: usize = 256;
    let mut counts = [0_usize; BINS];
    for (steepest, rest) in steepest.iter().zip(rest) {
        let share = u32::from(*steepest) * 64 / u32::from(*rest).max(DARK);
        counts[(share as usize).min(BINS - 1)] += 1;
    }
    let mut above = 0;
    for (bin, count) in counts.iter().enumerate().rev() {
        above += count;
        if above * 4 > steepest.len() {
            // The upper edge of the bin; of the lowest, nothing but rounding.
            return (bin as u32 + u32::from(bin > 0)) << 10;
        }
    }
    0
}

/// The luminance of every part of `moment`, and the mean of all.
fn look(moment: &impl Moment, parts: &mut Parts) -> u32 {
    let size = moment.size();
    let (columns, rows) = shape(size);
    let width = size.width as usize;
    let mut blocks = [[[0; LANES]; 3]; RUN];
    let mut total = 0_u64;
    for (row, parts) in parts.chunks_exact_mut(columns).take(rows).enumerate() {
        let (mut sums, mut counts) = ([0_u64; COLUMNS], [0_u32; COLUMNS]);
        for sample in 0..LOOKED_AT {
            let place = (2 * (row * LOOKED_AT + sample) + 1) as u64 * u64::from(size.height);
            let y = (place / (2 * LOOKED_AT * rows) as u64) as u32;
            for x in (0..width).step_by(RUN * LANES) {
                let blocks = &mut blocks[..(width - x).div_ceil(LANES).min(RUN)];
                moment.colours(x, y, blocks);
                for (block, from) in blocks.iter().zip((x..).step_by(LANES)) {
                    // No part is narrower than a block, and each block is of the part in which its middle is.
                    let (count, middle) = (LANES.min(width - from), (from + LANES / 2).min(width - 1));
                    let column = middle * columns / width;
                    sums[column] += u64::from(luminance(block, count));
                    counts[column] += count as u32;
                }
            }
        }
        for ((part, sum), count) in parts.iter_mut().zip(sums).zip(counts) {
            *part = (sum / u64::from(count.max(1))) as u16;
            total += u64::from(*part);
        }
    }
    (total / (columns * rows) as u64) as u32
}

/// The sum over the first `count` pixels, in 2^-16 of full white.
fn luminance([red, green, blue]: &Block, count: usize) -> u32 {
    let pixels = red.iter().zip(green).zip(blue).take(count);
    let squares = pixels.map(|((&red, &green), &blue)| {
        let [red, green, blue] = [red, green, blue].map(|level| i32::from(level).clamp(0, 4080) as u32);
        let luma = (54 * red + 183 * green + 19 * blue) >> 8;
        luma * luma
    });
    squares.sum::<u32>() / 255
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect;
    use core::ops::Range;

    /// A picture of one grey, of which a share of the rows follows the sine.
    struct Pulse {
        rows: u32,
    }

    struct Grey {
        rows: u32,
        swing: i16,
    }

    const SIZE: Size = Size::new(128, 80);

    impl Effect for Pulse {
        type Moment<'a> = Grey;

        fn at(&mut self, drive: Drive) -> Grey {
            let share = drive.amplitude * drive.phase.sin();
            Grey { rows: self.rows, swing: ((i64::from(share.to_bits()) * 400) >> Factor::FRAC_NBITS) as i16 }
        }
    }

    impl effect::Moment for Grey {
        fn size(&self) -> Size {
            SIZE
        }

        fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
            core::iter::once(0..SIZE.width as usize)
        }

        fn colours(&self, _: usize, y: u32, blocks: &mut [Block]) {
            blocks.fill([[2000 + if y < self.rows { self.swing } else { 0 }; LANES]; 3]);
        }
    }

    #[test]
    fn a_pulse_of_half_the_picture_is_measured_as_computed() {
        let found = measure(&mut Pulse { rows: SIZE.height / 2 });
        // (2400² − 2000²)/4080² at the steepest eighth, by the chord: the two lighter levels are the steeper ones.
        let (rest, peak, eighth) = (2000_f64.powi(2), 2400_f64.powi(2), 2282_f64.powi(2));
        let steepest = (peak - rest).max((eighth - rest) / 0.765);
        let (local, mean) = (steepest / rest, steepest / 4080_f64.powi(2) / 2.);
        assert!((found.mean.to_num::<f64>() / mean - 1.).abs() < 0.02, "{found:?} for {mean}");
        // A bin of 1/64 is told by its upper edge.
        let over = found.local.to_num::<f64>() - local;
        assert!((-0.005..=0.025).contains(&over), "{found:?} for {local}");
    }

    #[test]
    fn what_only_a_fifth_of_the_picture_does_counts_in_the_mean_alone() {
        let found = measure(&mut Pulse { rows: SIZE.height / 5 });
        assert_eq!(found.local, Factor::ZERO);
        assert!(found.mean > Factor::ZERO);
        assert_eq!(measure(&mut Pulse { rows: 0 }), Sensitivity::NONE);
    }
}
