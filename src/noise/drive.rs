//! The drive: noise turned into what every effect understands.
//!
//! The paper, eq. 4, 7 and 8: A(t) = A0·X_A(t), ω(t) = ω0·X_f(t), H(t) = A(t)·sin(ω(t)·t + α) + C.
//!
//! - X_A, from the [response](Response) S to the noise: 1/2 + S/(6·sigma_S), clamped to 0..=1, which holds three sigma to either
//!   side. For noises in 0..=1 it is S/G, their weighted mean, which never leaves that range.
//! - X_f, from a noise N of unit sigma: 1 + N/3, clamped to 0..=2. [`Kind::Chaos`] is first brought to zero mean and unit sigma, so
//!   that the mean speed is ω0 with every noise. [`Kind::ChaosLiteral`] is doubled, to fill 0..=2.
//! - θ is the sum of ω0·X_f over the frames so far. Departs from eq. 8, which multiplies the noisy frequency by the time: its phase
//!   jumps grow for ever (with white noise to 29 turns a frame within 100 s). That form stays selectable, as [`PhaseForm::Literal`].

use super::{Generator, Kind, Range, chaos::Chaos, response::Response};
use crate::math::{
    Factor, Sample, Turns,
    random::{Stream, stream},
    smoothstep,
};

/// What an effect needs to know to render a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drive {
    /// X_A: the share of the full swing, 0..=1.
    pub amplitude: Factor,
    /// X_f: the oscillation's speed relative to its base frequency, 0..=2. Shown to people; effects follow `phase`.
    pub frequency: Factor,
    /// θ: where in its cycle the oscillation is.
    pub phase: Turns,
    /// How far the picture has come alive, 0..=1: at 0 every effect shows the photo as it is.
    pub onset: Factor,
}

/// How the phase follows from the frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseForm {
    /// θ(t+1) = θ(t) + ω0·X_f(t).
    Integrated,
    /// θ(t) = ω0·X_f(t)·t, eq. 8 as printed.
    Literal,
}

/// What an oscillation is made of. The default is the cell of the paper's Table 2 that people liked best, at 12 frames a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The noise of the amplitude.
    pub amplitude: Kind,
    /// The noise of the frequency.
    pub frequency: Kind,
    /// T: how many frames an oscillation takes where X_f = 1. 0 is taken as 1.
    pub period_frames: u32,
    /// τ of the amplitude's response, in frames, at most [`Response::MAX_TIME_CONSTANT`]. The paper leaves it open; water looks
    /// right with less than trees.
    pub response_frames: u32,
    /// How many frames X_A and X_f take to follow a new noise.
    pub glide_frames: u32,
    /// How the phase follows from the frequency.
    pub phase: PhaseForm,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            amplitude: Kind::Brown,
            frequency: Kind::Brown,
            period_frames: 20,
            response_frames: 20,
            glide_frames: 6,
            phase: PhaseForm::Integrated,
        }
    }
}

/// The source of drives: two noises and a phase. A step takes 140 to 450 instructions, by the noises; a change of noise takes one
/// step for each frame that the response lasts. It fills 4.4 KB, nearly all of it the memory of the response.
#[derive(Clone, Debug)]
pub struct Oscillator {
    amplitude: Amplitude,
    frequency: Frequency,
    phase: Phase,
}

impl Oscillator {
    /// The oscillation of `settings` and `seed`, at frame 0.
    pub fn new(settings: Settings, seed: u64) -> Self {
        let generator = |kind, name| Generator::new(kind, stream(seed, name));
        let glide = Glide::new(settings.glide_frames);
        let amplitude = generator(settings.amplitude, Stream::Amplitude);
        Self {
            amplitude: Amplitude::new(amplitude, Response::new(settings.response_frames), glide),
            frequency: Frequency { noise: generator(settings.frequency, Stream::Frequency), glide },
            phase: Phase::new(settings.phase, settings.period_frames),
        }
    }

    /// The drive of the next frame; the first call gives frame 0, where θ is 0.
    pub fn step(&mut self) -> Drive {
        let amplitude = self.amplitude.step();
        let frequency = self.frequency.step();
        Drive { amplitude, frequency, phase: self.phase.step(frequency), onset: Factor::ONE }
    }

    /// The noise of the amplitude.
    pub const fn amplitude(&self) -> Kind {
        self.amplitude.noise.kind()
    }

    /// The noise of the frequency.
    pub const fn frequency(&self) -> Kind {
        self.frequency.noise.kind()
    }

    /// Changes the noise of the amplitude: from what it is, X_A glides to what the new noise makes of it. The noise that it has
    /// already goes on unchanged.
    pub fn set_amplitude(&mut self, kind: Kind) {
        if kind != self.amplitude() {
            self.amplitude.change(kind);
        }
    }

    /// Changes the noise of the frequency: from what it is, X_f glides to what the new noise makes of it; θ goes on from where it
    /// is. The noise that it has already goes on unchanged.
    pub fn set_frequency(&mut self, kind: Kind) {
        if kind != self.frequency() {
            self.frequency.noise.change(kind);
            self.frequency.glide.restart();
        }
    }
}

/// X_A.
#[derive(Clone, Debug)]
struct Amplitude {
    noise: Generator,
    response: Response,
    /// What S is multiplied by: 1/(6·sigma_S), or 1/G. In units of 2^-60.
    scale: i64,
    glide: Glide,
}

impl Amplitude {
    fn new(noise: Generator, response: Response, glide: Glide) -> Self {
        let mut amplitude = Self { noise, response, scale: 0, glide };
        amplitude.settle();
        amplitude
    }

    fn change(&mut self, kind: Kind) {
        self.noise.change(kind);
        self.settle();
        self.glide.restart();
    }

    /// Brings the response and its scale in line with a new noise: nothing of another noise may be left in it.
    fn settle(&mut self) {
        for _ in 0..self.response.lasts() {
            self.response.step(self.noise.step());
        }
        let kind = self.noise.kind();
        let whole = match kind.range() {
            Range::Centred => self.response.gain().saturating_mul(self.response.spread(kind)) * 6,
            Range::Unit => self.response.gain(),
        };
        self.scale = ((1_i128 << (60 + Sample::FRAC_NBITS)) / i128::from(whole.to_bits())) as i64;
    }

    fn step(&mut self) -> Factor {
        let sum = self.response.step(self.noise.step());
        let shift = 60 + Sample::FRAC_NBITS - Factor::FRAC_NBITS;
        let scaled = (i128::from(sum.to_bits()) * i128::from(self.scale) + (1 << (shift - 1))) >> shift;
        let middle = match self.noise.kind().range() {
            Range::Centred => Factor::ONE.to_bits() / 2,
            Range::Unit => 0,
        };
        let clamped = (scaled + i128::from(middle)).clamp(0, Factor::ONE.to_bits().into());
        self.glide.follow(Factor::from_bits(clamped as i32))
    }
}

/// X_f.
#[derive(Clone, Debug)]
struct Frequency {
    noise: Generator,
    glide: Glide,
}

impl Frequency {
    fn step(&mut self) -> Factor {
        let sample = self.noise.step();
        let third = |sigmas: Sample| Sample::ONE.saturating_add(sigmas / 3);
        let target = match self.noise.kind() {
            Kind::Constant => sample,
            Kind::Chaos => third((sample - Chaos::MEAN) * Chaos::PER_SIGMA),
            Kind::ChaosLiteral => sample * 2,
            Kind::White | Kind::Filter | Kind::Hosoda | Kind::Brown | Kind::BrownLiteral => third(sample),
        };
        self.glide.follow(Factor::from_num(target.clamp(Sample::ZERO, Sample::ONE * 2)))
    }
}

/// θ.
#[derive(Clone, Debug)]
struct Phase {
    form: PhaseForm,
    /// ω0, in units of 2^-64 turn a frame.
    base: u128,
    /// Frames so far.
    frame: u64,
    /// The sum of ω0·X_f so far, in units of 2^-64 turn: finer than [`Turns`], so that what each frame rounds off stays below a step
    /// of θ for seven years at the default period.
    turns: u64,
}

impl Phase {
    const fn new(form: PhaseForm, period_frames: u32) -> Self {
        let period_frames = if period_frames == 0 { 1 } else { period_frames };
        Self { form, base: (1 << 64) / period_frames as u128, frame: 0, turns: 0 }
    }

    /// θ of this frame, whose X_f is `frequency`.
    fn step(&mut self, frequency: Factor) -> Turns {
        let turns = match self.form {
            PhaseForm::Integrated => self.turns,
            PhaseForm::Literal => self.advance(frequency, self.frame),
        };
        self.turns = self.turns.wrapping_add(self.advance(frequency, 1));
        self.frame += 1;
        Turns((turns.wrapping_add(1 << 31) >> 32) as u32)
    }

    /// By how much `frames` frames of one frequency advance the phase, in units of 2^-64 turn. Whole turns are cut off.
    const fn advance(&self, frequency: Factor, frames: u64) -> u64 {
        let cycles = self.base.wrapping_mul(frequency.to_bits() as u128).wrapping_mul(frames as u128);
        (cycles >> Factor::FRAC_NBITS) as u64
    }
}

/// A value that follows another, and glides to it from where it is when it is to follow something new.
#[derive(Clone, Copy, Debug)]
struct Glide {
    frames: u32,
    /// Frames of gliding that are left.
    left: u32,
    /// Where the glide started.
    from: Factor,
    /// The last value; none before the first frame.
    last: Option<Factor>,
}

impl Glide {
    const fn new(frames: u32) -> Self {
        Self { frames, left: 0, from: Factor::ZERO, last: None }
    }

    fn restart(&mut self) {
        if let Some(last) = self.last {
            self.from = last;
            self.left = self.frames;
        }
    }

    fn follow(&mut self, target: Factor) -> Factor {
        let mut value = target;
        if self.left > 0 {
            self.left -= 1;
            let done = u64::from(self.frames - self.left) << Factor::FRAC_NBITS;
            let share = Factor::from_bits((done / u64::from(self.frames)) as i32);
            value = self.from + (target - self.from) * smoothstep(share);
        }
        self.last = Some(value);
        value
    }
}
