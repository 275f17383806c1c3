//! The time of the day where the frame hangs.
//!
//! Small boards have no clock of their own: after a power cut they wake up in 1970 or at the moment they were switched off, until the
//! network has told the time. So the time is taken as unknown until the kernel says that it is synchronised (adjtimex(2),
//! `STA_UNSYNC`), or systemd-timesyncd that it has been since the start (`/run/systemd/timesync/synchronized`). Once is enough:
//! without a network the kernel takes its word back after some hours, and the clock goes on well enough. A board
//! with a battery clock and no network says so by [`Trust::AsItIs`].

use crate::config::night::Zone;
use jiff::{Timestamp, civil::DateTime, tz::TimeZone};
use rustix::fs::Access;
use std::fmt;

/// No clock is right before this year, in which the program was not yet thought of.
const FIRST_YEAR: i16 = 2024;

/// When the system's clock is believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Once it was synchronised over the network.
    #[default]
    Synchronised,
    /// From the start: a battery keeps it.
    AsItIs,
}

named!(Trust, "clock", Synchronised = "synchronised", AsItIs = "as-it-is");

/// The system's clock in a time zone.
#[derive(Clone, Debug)]
pub struct LocalTime {
    zone: TimeZone,
    /// The clock is known to have been set.
    set: bool,
}

/// A time zone that the system does not know.
#[derive(Debug)]
pub struct UnknownZone {
    name: String,
    source: jiff::Error,
}

impl fmt::Display for UnknownZone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = &self.name;
        write!(
            f,
            "{name:?} is no time zone that is known here: use a name as Europe/Berlin, and install tzdata"
        )
    }
}

impl std::error::Error for UnknownZone {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

impl LocalTime {
    /// The time in `zone`, by name ("Europe/Berlin") or by rule ("CET-1CEST,M3.5.0,M10.5.0/3", POSIX.1-2017, 8.3). The
    /// system's is that of `$TZ` or `/etc/localtime`; where there is none, it is UTC, which is told once.
    ///
    /// # Errors
    /// If there is no such zone.
    pub fn new(zone: &Zone, trust: Trust) -> Result<Self, UnknownZone> {
        let zone = match zone {
            Zone::Named(name) => TimeZone::get(name)
                .or_else(|error| TimeZone::posix(name).map_err(|_| error))
                .map_err(|source| UnknownZone { name: name.as_str().to_owned(), source })?,
            Zone::Local => TimeZone::try_system().unwrap_or_else(|error| {
                log::warn!("the time zone of this system is unknown ({error}): using UTC; name the zone in the configuration");
                TimeZone::UTC
            }),
        };
        Ok(Self { zone, set: trust == Trust::AsItIs })
    }

    /// The same clock in another zone: what `before` knew of it stays known.
    #[must_use]
    pub(super) fn after(mut self, before: &Self) -> Self {
        self.set |= before.set;
        self
    }

    /// The minute of the local day now, 0..1440; `None` while the clock is not known to be set. Costs three system calls at the most.
    pub fn now(&mut self) -> Option<u16> {
        self.set = self.set || is_synchronised();
        self.minute_at(Timestamp::now()).filter(|_| self.set)
    }

    /// The month and the day of the local date, both from 1, and the minute of the day; `None` while the clock is not known to be set.
    pub fn date(&mut self) -> Option<(u8, u8, u16)> {
        let minute = self.now()?;
        let local: DateTime = self.zone.to_datetime(Timestamp::now());
        Some((local.month() as u8, local.day() as u8, minute))
    }

    /// The minute of the day at `time`; `None` before 2024.
    pub fn minute_at(&self, time: Timestamp) -> Option<u16> {
        let local: DateTime = self.zone.to_datetime(time);
        let minute = u16::try_from(i32::from(local.hour()) * 60 + i32::from(local.minute())).ok();
        minute.filter(|_| local.year() >= FIRST_YEAR)
    }
}

/// Whether the clock is, or was since the system's start, set by the network.
fn is_synchronised() -> bool {
    kernel_is_synchronised()
        || rustix::fs::access("/run/systemd/timesync/synchronized", Access::EXISTS).is_ok()
}

/// What the kernel says; no where it may not be asked (a seccomp filter).
fn kernel_is_synchronised() -> bool {
    // SAFETY: timex is a plain C structure of integers, for which all zeroes is a value: `modes` 0 changes nothing.
    let mut status: libc::timex = unsafe { std::mem::zeroed() };
    // SAFETY: the pointer is to a timex that lives and is ours alone during the call.
    let state = unsafe { libc::adjtimex(&raw mut status) };
    state >= 0 && state != libc::TIME_ERROR && status.status & libc::STA_UNSYNC == 0
}
