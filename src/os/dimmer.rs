//! How bright the panel is: by the schedule of the night, by hand, and by whichever means the board has.

use super::{Failure, backlight::Backlight, config::Config, local_time::LocalTime};
use crate::{
    app::night::{FULL, Night},
    config::night::Level,
    display::Display,
    math::Factor,
};
use std::{path::Path, time::Duration};

/// How often the clock is looked at.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// The level of the panel, and how it is brought about.
pub(super) struct Dimmer {
    night: Night,
    clock: LocalTime,
    look_due: Duration,
    backlight: Option<Backlight>,
    level: Level,
    /// A frame was shown at this level.
    shown: bool,
}

/// The class of backlights, where a configuration names one by its folder.
const CLASS: &str = "/sys/class/backlight";

impl Dimmer {
    /// Follows the schedule of `config`. A panel that the program has for itself (`bare`) is dimmed by its backlight, if it has one
    /// with levels.
    ///
    /// # Errors
    /// A time zone that the system does not know.
    pub(super) fn new(config: &Config, bare: bool) -> Result<Self, Failure> {
        let named = |light: &Backlight| {
            config.backlight.as_ref().is_none_or(|path| path.ends_with(light.name()) && light.is_writable())
        };
        let lights = Backlight::list(Path::new(CLASS)).into_iter();
        let backlight = lights.filter(|light| light.has_levels() && light.is_writable()).find(named);
        Ok(Self {
            night: Night::new(config.night.clone()),
            clock: LocalTime::new(&config.night.zone, config.clock)?,
            look_due: Duration::ZERO,
            backlight: backlight.filter(|_| bare),
            level: FULL,
            shown: false,
        })
    }

    /// Follows the schedule and the clock of another `config`; the backlight stays the one that was found at the start.
    ///
    /// # Errors
    /// A time zone that the system does not know: nothing has changed then.
    pub(super) fn change(&mut self, config: &Config) -> Result<(), Failure> {
        self.clock = LocalTime::new(&config.night.zone, config.clock)?.after(&self.clock);
        self.night.follow(config.night.clone());
        self.look_due = Duration::ZERO;
        Ok(())
    }

    /// Looks at the clock, when it is time to, and brings the panel to the level that holds: by its backlight, its power, or by the
    /// brightness that it gives for the pictures. `now` is since any fixed moment.
    pub(super) fn turn(&mut self, now: Duration, panel: &mut impl Display) -> Factor {
        if now >= self.look_due {
            self.look_due = now + LOOK_EVERY;
            self.night.turn(self.clock.now());
        }
        let level = self.night.level();
        if level != self.level {
            log::info!("the panel goes to {level}");
            // A panel that cannot be switched off shows black.
            let switched = panel.set_power(level != Level::Off);
            let set = self.backlight.as_mut().map(|light| light.set(level));
            if let Some(Err(error)) = set {
                log::warn!("{error}; dimming the pictures instead");
                self.backlight = None;
            }
            (self.level, self.shown) = (level, switched == Ok(true));
        }
        match (level, &self.backlight) {
            (Level::Off, _) => Factor::ZERO,
            (Level::Percent(_), Some(_)) => Factor::ONE,
            (Level::Percent(percent), None) => share(percent),
        }
    }

    /// Whether the panel is off and has been given a black frame: nothing need be computed.
    pub(super) fn is_dark(&self) -> bool {
        self.level == Level::Off && self.shown
    }

    /// A frame was shown.
    pub(super) const fn shown(&mut self) {
        self.shown = true;
    }

    /// Somebody has pressed something. Tells whether that has woken the panel, and was for nothing else.
    pub(super) fn wake(&mut self) -> bool {
        self.night.wake()
    }

    /// Somebody wants the panel off until the schedule says something else.
    pub(super) const fn sleep(&mut self) {
        self.night.overrule(Level::Off);
    }
}

/// A percentage of the coded levels: they are about even to the eye, as percents of lightness are.
fn share(percent: u8) -> Factor {
    Factor::from_bits(((i64::from(percent.min(100)) << Factor::FRAC_NBITS) / 100) as i32)
}
