//! How the windows move, and the colours that they give.

use super::{
    address::{SYMBOLS, Tones},
    texture::{SIDE, Texel},
    windows::{Place, Summary, UNIT, Windows, folded},
};
use crate::{
    frame::pack::Level,
    math::{Factor, Turns, smoothstep},
    noise::drive::Drive,
};

/// Frames after which windows are chosen anew. The colours of the old ones fade into those of the new ones all that time: windows that changed
/// at once, or in every frame, would be seen to pop.
const CHOSEN_FOR: u32 = 12;

/// Turns of the drive for one of the mirrors. An oscillation takes 1.7 s; mirrors that turned as fast would flicker.
pub(super) const GEAR: i64 = 24;

/// How far windows leave their place at X_A = 1.
pub(super) const REACH: i32 = UNIT / 14;

/// Where the mirrors are, and which windows are seen.
#[derive(Clone, Debug)]
pub(super) struct Mirrors {
    tonal: Option<(Summary, Tones)>,
    before: Windows,
    now: Windows,
    /// Frames since `now` was chosen.
    age: u32,
    /// The sum of all steps of θ, in 2^-32 turns.
    turned: i64,
    last: Option<Drive>,
}

impl Mirrors {
    /// With a summary of the reference and the tones of the photo, windows are chosen by their tones; without them they are tiles.
    pub(super) fn new(tonal: Option<(Summary, Tones)>) -> Self {
        let still = Windows([[0; 2]; SYMBOLS]);
        let windows = match &tonal {
            Some((summary, _)) => Windows::tonal(summary, &still, None),
            None => Windows::tiles(),
        };
        Self { tonal, before: windows, now: windows, age: 0, turned: 0, last: None }
    }

    /// Moves on to the frame of `drive`. One that is as the one before changes nothing: a picture that is halted stands still.
    pub(super) fn follow(&mut self, drive: Drive) {
        let last = self.last.replace(drive);
        let still = |last: &Drive| (last.phase, last.amplitude) == (drive.phase, drive.amplitude);
        if last.as_ref().is_some_and(still) {
            return;
        }
        let from = last.map_or(Turns::default(), |last| last.phase);
        self.turned += i64::from(drive.phase.0.wrapping_sub(from.0) as i32);
        self.age += 1;
        if self.age == CHOSEN_FOR {
            self.age = 0;
            self.before = self.now;
            if let Some((summary, _)) = &self.tonal {
                self.now = Windows::tonal(summary, &self.shifts(), Some(&self.before));
            }
        }
    }

    fn angle(&self) -> Turns {
        Turns((self.turned / GEAR) as u32)
    }

    /// How far every window is from its place: each goes round it on a circle, at its own hour.
    fn shifts(&self) -> Windows {
        let amplitude = self.last.map_or(Factor::ZERO, |drive| drive.amplitude);
        let along = |part: Factor| {
            ((i64::from((part * amplitude).to_bits()) * i64::from(REACH)) >> Factor::FRAC_NBITS) as i32
        };
        Windows(core::array::from_fn(|k| {
            // The golden angle: neighbours in tone are not neighbours in direction.
            let angle = self.angle().plus(Turns((k as u32).wrapping_mul(2_654_435_769)));
            [along(angle.cos()), along(angle.sin())]
        }))
    }

    /// Fills `table` with the colours of all addresses of `depth` symbols.
    pub(super) fn colours(&self, texels: &[Texel], depth: u32, table: &mut [Texel]) {
        self.mixed(texels, depth, table);
        if let Some((_, tones)) = &self.tonal {
            for (window, &level) in table.chunks_exact_mut(SYMBOLS.pow(depth - 1)).zip(&tones.levels) {
                tone(window, Level::from(level) << 4);
            }
        }
    }

    /// Fills `table` with the colours of the reference: those of the windows before and of those now, as the age demands.
    fn mixed(&self, texels: &[Texel], depth: u32, table: &mut [Texel]) {
        let (shifts, turn) = (self.shifts(), Turn::new(self.angle()));
        let before = Addresses::new(&self.before, &shifts, turn);
        if self.before == self.now {
            before.each(depth, |address, place| table[address] = sample(texels, place));
            return;
        }
        let now = Addresses::new(&self.now, &shifts, turn);
        let age =
            Factor::from_bits(((u64::from(self.age) << Factor::FRAC_NBITS) / u64::from(CHOSEN_FOR)) as i32);
        let share =
            (smoothstep(age).to_bits() as u64 * 16 + (1 << (Factor::FRAC_NBITS - 1))) >> Factor::FRAC_NBITS;
        before.each(depth, |address, place| table[address] = sample(texels, place));
        now.each(depth, |address, place| {
            table[address] = table[address].towards(sample(texels, place), share);
        });
    }
}

/// How far a window's mean luma is brought to the level that its symbol has in the photo, in sixteenths. At 0 a reference without darkness
/// or light of its own leaves nothing to be seen of the photo; at 16 it gives its hues, and nothing of its mood.
const TONED: i32 = 10;

/// Brings the mean luma of a window's colours nearer to `wanted`, all alike: darker colours are scaled down, lighter ones half scaled up and half
/// mixed with white. White alone would make pastels of all colours, scaling alone would clip them.
fn tone(window: &mut [Texel], wanted: Level) {
    const WHITE: i32 = 255 << 4;
    let sum: u32 = window.iter().map(|texel| u32::from(texel.luma())).sum();
    let mean = ((sum / window.len() as u32) as i32).max(1);
    let change = (i32::from(wanted) - mean) * TONED / 16;
    let (scaled, lighter) = if change < 0 { (change, 0) } else { (change / 2, change - change / 2) };
    let scale = ((mean + scaled) << 12) / mean;
    let white = (lighter << 12) / (WHITE - mean).max(1);
    for texel in window {
        let toned = |channel: Level| {
            let scaled = ((i32::from(channel) * scale) >> 12).min(WHITE);
            (scaled + (((WHITE - scaled) * white) >> 12)) as Level
        };
        *texel = Texel::new(texel.channels().map(toned));
    }
}

/// A turn by an angle that shrinks to a quarter, Q16.
#[derive(Clone, Copy)]
struct Turn {
    cosine: i32,
    sine: i32,
}

impl Turn {
    fn new(angle: Turns) -> Self {
        let quarter = |part: Factor| part.to_bits() >> (Factor::FRAC_NBITS - 14);
        Self { cosine: quarter(angle.cos()), sine: quarter(angle.sin()) }
    }

    /// Where a place lies in a window around the origin.
    const fn of(self, [x, y]: Place) -> Place {
        let (x, y) = ((x - UNIT / 2) as i64, (y - UNIT / 2) as i64);
        let (c, s) = (self.cosine as i64, self.sine as i64);
        [((x * c - y * s) >> 16) as i32, ((x * s + y * c) >> 16) as i32]
    }
}

/// The places of all addresses: g_s1∘g_s2∘g_s3 of the middle of the reference, g_k(p) = c_k + R(p − 1/2)/4.
struct Addresses {
    middles: [Place; SYMBOLS],
    /// R(g_k(1/2) − 1/2)/4.
    inner: [Place; SYMBOLS],
    turn: Turn,
}

impl Addresses {
    fn new(windows: &Windows, shifts: &Windows, turn: Turn) -> Self {
        let middles = core::array::from_fn(|k| plus(windows.0[k], shifts.0[k]));
        Self { middles, inner: middles.map(|middle| turn.of(middle)), turn }
    }

    #[inline(always)]
    fn each(&self, depth: u32, mut tell: impl FnMut(usize, Place)) {
        match depth {
            1 => self.middles.iter().enumerate().for_each(|(k, &middle)| tell(k, middle)),
            2 => self.two(|address, offset, middle| tell(address, plus(middle, offset))),
            _ => {
                let mut inner = [[0; 2]; SYMBOLS * SYMBOLS];
                self.two(|address, offset, middle| inner[address] = self.turn.of(plus(middle, offset)));
                for (k, &middle) in self.middles.iter().enumerate() {
                    for (j, &offset) in inner.iter().enumerate() {
                        tell(k * SYMBOLS * SYMBOLS + j, plus(middle, offset));
                    }
                }
            }
        }
    }

    fn two(&self, mut tell: impl FnMut(usize, Place, Place)) {
        for (k, &middle) in self.middles.iter().enumerate() {
            for (j, &offset) in self.inner.iter().enumerate() {
                tell(k * SYMBOLS + j, offset, middle);
            }
        }
    }
}

#[inline(always)]
const fn plus([x, y]: Place, [u, v]: Place) -> Place {
    [x + u, y + v]
}

/// The colour at a place, between texels by sixteenths.
#[inline(always)]
fn sample(texels: &[Texel], [x, y]: Place) -> Texel {
    let (x, y) = (folded(x) as usize, folded(y) as usize);
    // 2^16 are 256 texels.
    let (u, v) = (x >> 8, y >> 8);
    let (right, below) = ((u + 1).min(SIDE - 1), (v + 1).min(SIDE - 1));
    let (across, down) = ((x >> 4 & 15) as u64, (y >> 4 & 15) as u64);
    let row = |v: usize| texels[v * SIDE + u].towards(texels[v * SIDE + right], across);
    row(v).towards(row(below), down)
}
