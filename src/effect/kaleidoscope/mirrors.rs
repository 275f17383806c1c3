//! How the windows move, and the colours that they give.

use super::{
    address::{SYMBOLS, Tones},
    texture::{SIDE, TEXELS, Texel, Toning, approach},
    windows::{Place, Summary, UNIT, Windows, folded},
};
use crate::{
    frame::pack::Level,
    math::{Factor, Turns},
    noise::drive::Drive,
};

/// Frames after which windows are chosen anew. Windows that were chosen in every frame would be seen to tremble.
const CHOSEN_FOR: u32 = 12;

/// How far a frame brings the colours of the one before to those that the windows show, in sixteenths. Windows that have just been chosen come in without a
/// pop, over some 20 frames, and the rest lags by 8 frames of a turn that takes 1,200. At 2 the change from frame to frame is at the most that of a
/// smoothstep of 12 frames; it takes one look at the reference for each colour where a fade between two sets of windows takes two.
const FOLLOWING: u16 = 2;

/// Turns of the drive for one of the mirrors. An oscillation takes 1.7 s; mirrors that turned as fast would flicker.
pub(super) const GEAR: i64 = 24;

/// How far windows leave their place at X_A = 1.
pub(super) const REACH: i32 = UNIT / 14;

/// Where the mirrors are, and which windows are seen.
#[derive(Clone, Debug)]
pub(super) struct Mirrors {
    tonal: Option<(Summary, Tones)>,
    windows: Windows,
    /// Frames since the windows were chosen.
    age: u32,
    /// How far the colours have to go to those of the windows, in sixteenths.
    due: u16,
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
        Self { tonal, windows, age: 0, due: 16, turned: 0, last: None }
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
        self.due = self.due.max(FOLLOWING);
        self.age += 1;
        if self.age == CHOSEN_FOR {
            self.age = 0;
            if let Some((summary, _)) = &self.tonal {
                self.windows = Windows::tonal(summary, &self.shifts(), Some(&self.windows));
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

    /// Brings `table`, the colours of all addresses of `depth` symbols, up to this moment. It must be that of the moment before.
    pub(super) fn colours(&mut self, texels: &[Texel], depth: u32, table: &mut [Texel]) {
        let share = core::mem::take(&mut self.due);
        let Some((texels, _)) = texels.split_first_chunk::<TEXELS>() else { return };
        if share == 0 {
            return;
        }
        let (shifts, turn) = (self.shifts(), Turn::new(self.angle()));
        let middles = core::array::from_fn(|k| plus(self.windows.0[k], shifts.0[k]));
        let (mut offsets, length) = (Offsets { x: [0; WINDOW], y: [0; WINDOW] }, SYMBOLS.pow(depth - 1));
        offsets.fill(&middles, turn, depth);
        let mut fresh = [Texel::default(); WINDOW];
        let fresh = &mut fresh[..length];
        for (k, table) in table.chunks_exact_mut(length).take(SYMBOLS).enumerate() {
            offsets.sample(texels, middles[k], fresh);
            let toning = match &self.tonal {
                Some((_, tones)) => toning(fresh, Level::from(tones.levels[k]) << 4),
                None => Toning::NONE,
            };
            approach(table, fresh, toning, share);
        }
    }
}

/// The most colours that begin with one symbol.
const WINDOW: usize = SYMBOLS * SYMBOLS;

/// How far a window's mean luma is brought to the level that its symbol has in the photo, in sixteenths. At 0 a reference without darkness
/// or light of its own leaves nothing to be seen of the photo; at 16 it gives its hues, and nothing of its mood.
const TONED: i32 = 10;

/// What brings the mean luma of a window's colours nearer to `wanted`, all alike: darker colours are scaled down, lighter ones half scaled up and half
/// mixed with white. White alone would make pastels of all colours, scaling alone would clip them.
fn toning(window: &[Texel], wanted: Level) -> Toning {
    const WHITE: i32 = 255 << 4;
    let mean = i32::from(Texel::mean_of(window).luma()).max(1);
    let change = (i32::from(wanted) - mean) * TONED / 16;
    let (scaled, lighter) = if change < 0 { (change, 0) } else { (change / 2, change - change / 2) };
    // Q12. Where all is nearly black there is nothing to be scaled up.
    let scale = (((mean + scaled) << 12) / mean).min(u16::MAX.into()) as u16;
    let white = ((lighter << 12) / (WHITE - mean).max(1)).min(1 << 12) as u16;
    Toning { scale, white }
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

/// Where the colours of a window lie, seen from its middle: the places of g_s1∘g_s2∘g_s3 of the middle of the reference without c_s1, for
/// g_k(p) = c_k + R(p − 1/2)/4.
struct Offsets {
    x: [i32; WINDOW],
    y: [i32; WINDOW],
}

impl Offsets {
    fn fill(&mut self, middles: &[Place; SYMBOLS], turn: Turn, depth: u32) {
        let Self { x, y } = self;
        let mut all = x.iter_mut().zip(y);
        let mut tell = |[x, y]: Place| {
            if let Some((left, upper)) = all.next() {
                (*left, *upper) = (x, y);
            }
        };
        let inner = middles.map(|middle| turn.of(middle));
        match depth {
            1 => tell([0, 0]),
            2 => inner.into_iter().for_each(tell),
            _ => middles.iter().for_each(|&middle| {
                inner.iter().for_each(|&offset| tell(turn.of(plus(middle, offset))));
            }),
        }
    }

    /// Fills `out` with the colours around `middle`, between texels by sixteenths.
    fn sample(&self, texels: &[Texel; TEXELS], [x, y]: Place, out: &mut [Texel]) {
        // 2^16 are 256 texels. Beyond the middle of the last one there is nothing to go on to.
        const LAST: u16 = (SIDE as u16 - 1) << 8;
        let (mut upper_left, mut across, mut down) = ([0_u16; WINDOW], [0_u8; WINDOW], [0_u8; WINDOW]);
        // Lanes here, one by one below.
        for i in 0..WINDOW {
            let (u, v) = (folded(x + self.x[i]).min(LAST), folded(y + self.y[i]).min(LAST));
            upper_left[i] = (v & 0xff00) | u >> 8;
            (across[i], down[i]) = ((u >> 4 & 15) as u8, (v >> 4 & 15) as u8);
        }
        let places = upper_left.iter().zip(&across).zip(&down);
        for (out, ((&at, &across), &down)) in out.iter_mut().zip(places) {
            let at = usize::from(at);
            let row = |at: usize| texels[at].towards(texels[at + 1], across.into());
            *out = row(at).towards(row(at + SIDE), down.into());
        }
    }
}

#[inline(always)]
const fn plus([x, y]: Place, [u, v]: Place) -> Place {
    [x + u, y + v]
}
