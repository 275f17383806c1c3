use super::{
    overlay,
    state::{Outcome, Request, State},
};
use crate::{
    display::{Display, DisplayError},
    effect::{Effect, Paint},
    input::action::Action,
    math::Factor,
    noise::{
        Kind,
        drive::{self, Drive, Oscillator},
    },
};

/// A running show: what the buttons have chosen, where the oscillation is, and what the display already holds.
#[derive(Clone, Debug)]
pub struct Show {
    state: State,
    oscillator: Oscillator,
    /// The noises of the amplitude and the frequency that the photo was last said to have.
    noises: (Kind, Kind),
    drive: Drive,
    frames_per_second: u32,
    /// Frames presented since the show began.
    frame: u64,
    /// Frames presented of this photo, up to a second's worth.
    onset_frames: u32,
    /// Frames presented since anything but the motion changed the picture.
    settled: u32,
    /// Frames for which the noises' names stay on the picture.
    notice_frames: u32,
}

/// How long the noises' names stay on the picture after a press.
const NOTICE_SECONDS: u32 = 3;

impl Show {
    /// A show at its first frame.
    pub fn new(settings: drive::Settings, frames_per_second: u32, seed: u64) -> Self {
        let mut oscillator = Oscillator::new(settings, seed);
        let drive = oscillator.step();
        let state = State::default();
        Self {
            state,
            oscillator,
            noises: (settings.amplitude, settings.frequency),
            drive,
            frames_per_second,
            frame: 0,
            onset_frames: 0,
            settled: 0,
            notice_frames: 0,
        }
    }

    /// Another photo is shown from now on, or the display has lost its frames: everything is painted, and the picture comes alive
    /// from the still photo.
    pub fn restart(&mut self) {
        (self.onset_frames, self.settled) = (0, 0);
    }

    /// The photo that is shown from now on has these noises. What the buttons have chosen stays while photos do not differ in
    /// theirs.
    pub fn choose_noises(&mut self, amplitude: Kind, frequency: Kind) {
        let before = core::mem::replace(&mut self.noises, (amplitude, frequency));
        if before.0 != amplitude {
            self.oscillator.set_amplitude(amplitude);
        }
        if before.1 != frequency {
            self.oscillator.set_frequency(frequency);
        }
    }

    /// Does what a press is for, and tells what that asks of the caller.
    pub fn press(&mut self, action: Action) -> Option<Request> {
        match self.state.take(action)? {
            Outcome::NextAmplitude => self.choose_noise(Oscillator::amplitude, Oscillator::set_amplitude),
            Outcome::NextFrequency => self.choose_noise(Oscillator::frequency, Oscillator::set_frequency),
            Outcome::Ask(request) => return Some(request),
        }
        None
    }

    /// One frame: renders and presents it, and steps the noise. `name` is what the information calls the photo.
    pub fn turn(
        &mut self,
        effect: &mut impl Effect,
        name: &str,
        display: &mut impl Display,
    ) -> Result<(), DisplayError> {
        self.present(effect, name, display)?;
        self.frame += 1;
        self.notice_frames = self.notice_frames.saturating_sub(1);
        if !self.state.paused {
            self.drive = self.oscillator.step();
            self.onset_frames = (self.onset_frames + 1).min(self.frames_per_second);
        }
        Ok(())
    }

    /// Frames presented so far.
    pub const fn frame(&self) -> u64 {
        self.frame
    }

    fn choose_noise(&mut self, current: fn(&Oscillator) -> Kind, set: fn(&mut Oscillator, Kind)) {
        let kind = current(&self.oscillator).next();
        set(&mut self.oscillator, kind);
        self.notice_frames = NOTICE_SECONDS * self.frames_per_second;
    }

    fn present(
        &mut self,
        effect: &mut impl Effect,
        name: &str,
        display: &mut impl Display,
    ) -> Result<(), DisplayError> {
        let mut back = display.back_buffer()?;
        let holds_motion = back.age != 0 && back.age <= self.settled;
        let paint = if holds_motion { Paint::Motion } else { Paint::Everything };
        effect.render(Drive { onset: self.onset(), ..self.drive }, paint, &mut back.frame);
        let noises = (self.oscillator.amplitude(), self.oscillator.frequency());
        let written = match (self.state.information, self.notice_frames) {
            (true, _) => overlay::write(&mut back.frame, Some(name), noises),
            (false, 1..) => overlay::write(&mut back.frame, None, noises),
            (false, 0) => false,
        };
        display.present()?;
        // What was written must be painted over in every buffer that it went into.
        self.settled = if written { 0 } else { self.settled.saturating_add(1) };
        Ok(())
    }

    /// The picture comes alive within its first second, smoothly: 3s² − 2s³.
    fn onset(&self) -> Factor {
        let done = u64::from(self.onset_frames) << Factor::FRAC_NBITS;
        let s = Factor::from_bits((done / u64::from(self.frames_per_second.max(1))) as i32);
        s * s * (Factor::from_num(3) - 2 * s)
    }
}
