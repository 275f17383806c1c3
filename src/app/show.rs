use super::{
    overlay::{self, Overlay, Trace},
    state::{Outcome, Request, State},
};
use crate::{
    display::{Display, DisplayError},
    effect::{Effect, Moment as _, Paint, paint},
    frame::{Rect, Rotation},
    input::action::Action,
    math::{Factor, smoothstep},
    noise::{
        Kind,
        drive::{self, Drive, Oscillator},
        guard::{Guard, Sensitivity},
    },
};

/// A running show: what the buttons have chosen, where the oscillation is, and what the display already holds.
#[derive(Clone, Debug)]
pub struct Show {
    state: State,
    oscillator: Oscillator,
    guard: Guard,
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
    fade: Option<Fade>,
    /// The share of the panel's brightness, 0..=1.
    brightness: Factor,
    /// How the panel is mounted.
    rotation: Rotation,
    trace: Trace,
    written: Option<Written>,
}

/// Where something was written on the picture that must be painted over.
#[derive(Clone, Copy, Debug)]
struct Written {
    /// All places since everything was painted.
    place: Rect,
    /// Frames presented since the last that had something written on it.
    clean: u32,
}

/// One photo fading into the next.
#[derive(Clone, Copy, Debug)]
struct Fade {
    /// Frames it takes.
    frames: u32,
    /// Frames of it that were presented.
    done: u32,
    /// How far the photo that leaves had come alive.
    onset: Factor,
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
            guard: Guard::default(),
            noises: (settings.amplitude, settings.frequency),
            drive,
            frames_per_second,
            frame: 0,
            onset_frames: 0,
            settled: 0,
            notice_frames: 0,
            fade: None,
            brightness: Factor::ONE,
            rotation: Rotation::None,
            trace: Trace::default(),
            written: None,
        }
    }

    /// Goes on with another oscillation at another rate. What the buttons have chosen stays.
    pub fn change(&mut self, settings: drive::Settings, frames_per_second: u32, seed: u64) {
        let chosen = self.noises();
        let Self { state, noises, frame, brightness, rotation, .. } = *self;
        *self = Self {
            state,
            noises,
            frame,
            brightness,
            rotation,
            ..Self::new(settings, frames_per_second, seed)
        };
        self.take_up(chosen.0, chosen.1);
    }

    /// What is written on the picture stands upright on a panel that is mounted by `rotation`.
    pub const fn set_rotation(&mut self, rotation: Rotation) {
        self.rotation = rotation;
    }

    /// Another photo is shown from now on, or the display has lost its frames: everything is painted, and the picture comes alive
    /// from the still photo.
    pub fn restart(&mut self) {
        (self.onset_frames, self.settled, self.fade, self.written) = (0, 0, None, None);
    }

    /// The photo is fully alive at once.
    pub const fn come_alive(&mut self) {
        self.onset_frames = self.frames_per_second;
    }

    /// Another photo is shown from now on: the one before fades into it within `frames`, and both move.
    pub fn fade(&mut self, frames: u32) {
        let onset = self.onset();
        self.restart();
        self.fade = (frames > 0).then_some(Fade { frames, done: 0, onset });
    }

    /// Whether one photo is fading into the next: whoever calls [`Self::turn_from`] must keep both.
    pub const fn is_fading(&self) -> bool {
        self.fade.is_some()
    }

    /// Whether the person has stopped the motion.
    pub const fn is_paused(&self) -> bool {
        self.state.paused
    }

    /// The noises of the amplitude and of the frequency.
    pub const fn noises(&self) -> (Kind, Kind) {
        (self.oscillator.amplitude(), self.oscillator.frequency())
    }

    /// Shows pictures at this share of their brightness, 0..=1, from the next frame on.
    pub fn set_brightness(&mut self, brightness: Factor) {
        if brightness != self.brightness {
            (self.brightness, self.settled) = (brightness, 0);
        }
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

    /// Goes on with the noises that were chosen before a restart.
    pub fn take_up(&mut self, amplitude: Kind, frequency: Kind) {
        self.oscillator.set_amplitude(amplitude);
        self.oscillator.set_frequency(frequency);
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

    /// One frame: renders and presents it, and steps the noise. `caption` is what the information says of the photo, a line or
    /// several.
    pub fn turn<E: Effect>(
        &mut self,
        effect: &mut E,
        caption: &str,
        display: &mut impl Display,
    ) -> Result<(), DisplayError> {
        self.turn_from(None, effect, caption, display)
    }

    /// One frame as in [`Self::turn`], in which the photo that `leaving` showed may still be seen to fade.
    pub fn turn_from<E: Effect>(
        &mut self,
        leaving: Option<&mut E>,
        effect: &mut E,
        caption: &str,
        display: &mut impl Display,
    ) -> Result<(), DisplayError> {
        let before = leaving.as_ref().filter(|_| self.is_fading()).map(|leaving| leaving.sensitivity());
        let sensitivity = effect.sensitivity().max(before.unwrap_or(Sensitivity::NONE));
        self.present(leaving, effect, caption, display)?;
        self.frame += 1;
        self.notice_frames = self.notice_frames.saturating_sub(1);
        self.fade = self.fade.and_then(|fade| fade.after());
        if !self.state.paused {
            self.trace.note(self.drive, self.frames_per_second);
            self.guard.set(sensitivity, self.frames_per_second);
            self.drive = self.guard.limit(self.oscillator.step());
            self.onset_frames = (self.onset_frames + 1).min(self.frames_per_second);
        }
        Ok(())
    }

    /// One frame without a photo, which does not count: the lines of `message`, on black.
    pub fn tell(&mut self, message: &str, display: &mut impl Display) -> Result<(), DisplayError> {
        let mut back = display.back_buffer()?;
        overlay::write_alone(message, &mut back.frame, self.rotation, self.brightness);
        display.present()?;
        self.restart();
        Ok(())
    }

    /// Frames of photos presented so far.
    pub const fn frame(&self) -> u64 {
        self.frame
    }

    fn choose_noise(&mut self, current: fn(&Oscillator) -> Kind, set: fn(&mut Oscillator, Kind)) {
        let kind = current(&self.oscillator).next();
        set(&mut self.oscillator, kind);
        self.notice_frames = NOTICE_SECONDS * self.frames_per_second;
    }

    fn present<E: Effect>(
        &mut self,
        leaving: Option<&mut E>,
        effect: &mut E,
        caption: &str,
        display: &mut impl Display,
    ) -> Result<(), DisplayError> {
        let mut back = display.back_buffer()?;
        let holds_motion = back.age != 0 && back.age <= self.settled;
        let moment = effect.at(Drive { onset: self.onset(), ..self.drive });
        let overlay = self.overlay(caption);
        let (rotation, brightness, whole) = (self.rotation, self.brightness, Rect::whole(moment.size()));
        let place = match (leaving, self.fade) {
            (Some(leaving), Some(fade)) => {
                let before = leaving.at(Drive { onset: fade.onset, ..self.drive });
                let (both, share) = ((&before, &moment), fade.share());
                paint::fade(both, share, whole, brightness, &mut back.frame);
                overlay.and_then(|overlay| {
                    overlay.write(&mut back.frame, rotation, brightness, |place, dim, frame| {
                        paint::fade(both, share, place, dim, frame);
                    })
                })
            }
            _ => {
                let paint = if holds_motion { Paint::Motion } else { Paint::Everything };
                paint::one(&moment, paint, brightness, &mut back.frame);
                if let Some(written) = self.written.filter(|written| holds_motion && back.age > written.clean)
                {
                    paint::part(&moment, written.place, brightness, &mut back.frame);
                }
                overlay.and_then(|overlay| {
                    overlay.write(&mut back.frame, rotation, brightness, |place, dim, frame| {
                        paint::part(&moment, place, dim, frame);
                    })
                })
            }
        };
        display.present()?;
        self.note_presented(place);
        Ok(())
    }

    /// What is to be written on the picture now, if anything is.
    fn overlay<'a>(&'a self, caption: &'a str) -> Option<Overlay<'a>> {
        let caption = self.state.information.then_some(caption);
        let shown = caption.is_some() || self.notice_frames > 0;
        shown.then_some(Overlay { caption, noises: self.noises(), trace: &self.trace })
    }

    /// What shone through must be painted over in every buffer that it went into, and so must what was written at `place`.
    fn note_presented(&mut self, place: Option<Rect>) {
        self.settled = if self.is_fading() { 0 } else { self.settled.saturating_add(1) };
        self.written = match (self.written, place) {
            (Some(before), Some(place)) => Some(Written { place: before.place.hull(place), clean: 0 }),
            (None, Some(place)) => Some(Written { place, clean: 0 }),
            (Some(before), None) => Some(Written { clean: before.clean.saturating_add(1), ..before }),
            (None, None) => None,
        };
    }

    /// The picture comes alive within its first second.
    fn onset(&self) -> Factor {
        smoothstep(share(self.onset_frames, self.frames_per_second))
    }
}

impl Fade {
    fn share(&self) -> Factor {
        smoothstep(share(self.done, self.frames))
    }

    /// The fade after one more frame, if there is more of it.
    fn after(mut self) -> Option<Self> {
        self.done += 1;
        (self.done < self.frames).then_some(self)
    }
}

/// `part` / `whole`, for a part of at most the whole.
fn share(part: u32, whole: u32) -> Factor {
    Factor::from_bits(((u64::from(part) << Factor::FRAC_NBITS) / u64::from(whole.max(1))) as i32)
}
