//! How bright the panel is at what time of the day.
//!
//! A [`Schedule`] says from which minute of the local day which [`Level`] holds, until the next of its edges, over midnight
//! too. It knows no date: whatever the clock does (daylight saving, a leap day, a wrong year), the level is that of the time it
//! shows. In the hour that a day has twice in autumn, edges happen twice; in the hour that is missing in spring, they happen
//! at its end.
//!
//! [`Night`] follows a schedule: it does nothing while nobody knows what time it is, and lets the person overrule the schedule until
//! its next edge.

use core::{fmt, str::FromStr};
use heapless::Vec;

/// The minutes of a day.
const DAY: u16 = 24 * 60;

/// The most edges of a schedule: one for every hour.
pub const EDGES: usize = 24;

/// A minute of the local day, 0..1440.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Minute(u16);

impl Minute {
    /// The minute of a time of the day; `None` if there is no such time.
    pub const fn new(hour: u16, minute: u16) -> Option<Self> {
        if hour < 24 && minute < 60 { Some(Self(hour * 60 + minute)) } else { None }
    }

    /// Minutes since midnight.
    pub const fn get(self) -> u16 {
        self.0
    }

    /// Minutes from `self` forwards to `later`, over midnight if need be.
    const fn until(self, later: Self) -> u16 {
        (later.0 + DAY - self.0) % DAY
    }
}

impl fmt::Display for Minute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02}:{:02}", self.0 / 60, self.0 % 60)
    }
}

/// How bright the panel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is shown and nothing computed.
    Off,
    /// So bright as it looks: percent of CIE lightness, 1 to 100.
    Percent(u8),
}

impl Level {
    /// As bright as the panel can be.
    pub const FULL: Self = Self::Percent(100);

    /// The share of the panel's light, of 65,536 for all of it.
    ///
    /// CIE 1976 lightness, solved for the luminance: Y = ((L* + 16) / 116)³ for L* > 8, else L* / 903.3. A panel at 50 % is
    /// half as bright to the eye and gives 18 % of its light.
    pub const fn light(self) -> u32 {
        const CUBE: u64 = 116 * 116 * 116;
        match self {
            Self::Off => 0,
            Self::Percent(percent @ 0..=8) => ((percent as u64 * 655_360 + 4_516) / 9_033) as u32,
            Self::Percent(percent) => {
                let sum = if percent > 100 { 116 } else { percent as u64 + 16 };
                ((sum * sum * sum * 65_536 + CUBE / 2) / CUBE) as u32
            }
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

/// From a minute of every day on, a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// When it begins.
    pub at: Minute,
    /// What holds from then on.
    pub level: Level,
}

impl fmt::Display for Edge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.at, self.level)
    }
}

/// What is wrong with a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScheduleError {
    /// No time of the day.
    Time,
    /// No level.
    Level,
    /// Two edges at the same minute.
    Twice(Minute),
    /// More than [`EDGES`] edges.
    TooMany,
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time => f.write_str("a time of the day is 00:00 to 23:59, say \"22:30 off\""),
            Self::Level => f.write_str("a level is off or 1% to 100%, say \"22:30 off\""),
            Self::Twice(at) => write!(f, "two levels begin at {at}; keep one"),
            Self::TooMany => write!(f, "more than {EDGES} levels a day; keep {EDGES}"),
        }
    }
}

impl core::error::Error for ScheduleError {}

impl FromStr for Minute {
    type Err = ScheduleError;

    /// Reads "7:05" or "07:05".
    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let digits = |text: &str| text.len() <= 2 && text.bytes().all(|byte| byte.is_ascii_digit());
        text.split_once(':')
            .filter(|(hour, minute)| digits(hour) && digits(minute) && minute.len() == 2)
            .and_then(|(hour, minute)| Self::new(hour.parse().ok()?, minute.parse().ok()?))
            .ok_or(ScheduleError::Time)
    }
}

impl FromStr for Level {
    type Err = ScheduleError;

    /// Reads "off", "0%" or "30%".
    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let percent = match text {
            "off" => 0,
            text => text
                .strip_suffix('%')
                .filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()))
                .and_then(|digits| digits.parse().ok())
                .ok_or(ScheduleError::Level)?,
        };
        match percent {
            0 => Ok(Self::Off),
            1..=100 => Ok(Self::Percent(percent)),
            _ => Err(ScheduleError::Level),
        }
    }
}

impl FromStr for Edge {
    type Err = ScheduleError;

    /// Reads "22:30 off" or "7:00 80%".
    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let (at, level) = text.trim().split_once(' ').ok_or(ScheduleError::Level)?;
        Ok(Self { at: at.parse()?, level: level.trim_start().parse()? })
    }
}

/// The levels of a day.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// By time.
    edges: Vec<Edge, EDGES>,
}

impl Schedule {
    /// The schedule of `edges`, in any order. Without an edge the panel is always at [`Level::FULL`].
    pub fn new(edges: impl IntoIterator<Item = Edge>) -> Result<Self, ScheduleError> {
        let mut all = Vec::new();
        for edge in edges {
            all.push(edge).map_err(|_| ScheduleError::TooMany)?;
        }
        all.sort_unstable_by_key(|edge| edge.at);
        match all.windows(2).find(|pair| pair[0].at == pair[1].at) {
            Some(pair) => Err(ScheduleError::Twice(pair[0].at)),
            None => Ok(Self { edges: all }),
        }
    }

    /// What holds at `now`.
    pub fn level(&self, now: Minute) -> Level {
        let begun = self.edges.partition_point(|edge| edge.at <= now);
        // Before the first edge of the day holds what began last yesterday.
        let edge = if begun == 0 { self.edges.last() } else { self.edges.get(begun - 1) };
        edge.map_or(Level::FULL, |edge| edge.level)
    }

    /// The edge that comes after `now`; an edge at `now` has begun.
    pub fn next_edge(&self, now: Minute) -> Option<Edge> {
        let later = self.edges.iter().find(|edge| edge.at > now);
        later.or(self.edges.first()).copied()
    }

    /// Whether an edge begins on the way from `before` to `now`. A clock that was put back, by half a day at the most, has passed
    /// none.
    fn passed(&self, before: Minute, now: Minute) -> bool {
        let way = before.until(now);
        way <= DAY / 2 && self.edges.iter().any(|edge| (1..=way).contains(&before.until(edge.at)))
    }
}

/// A schedule that is followed, and what the person wants instead.
#[derive(Clone, Debug)]
pub struct Night {
    schedule: Schedule,
    /// What the schedule said last.
    scheduled: Level,
    overruled: Option<Level>,
    /// The last time that was known.
    before: Option<Minute>,
}

impl Night {
    /// Follows `schedule` from now on; until the time is known, the panel is at [`Level::FULL`].
    pub const fn new(schedule: Schedule) -> Self {
        Self { schedule, scheduled: Level::FULL, overruled: None, before: None }
    }

    /// The level now, at the time `now`; `None` if nobody knows what time it is: then everything stays as it is.
    pub fn turn(&mut self, now: Option<Minute>) -> Level {
        if let Some(now) = now {
            self.scheduled = self.schedule.level(now);
            if self.before.is_some_and(|before| self.schedule.passed(before, now)) {
                self.overruled = None;
            }
            self.before = Some(now);
        }
        self.level()
    }

    /// The level of the last turn, or what overrules it.
    pub fn level(&self) -> Level {
        self.overruled.unwrap_or(self.scheduled)
    }

    /// The person has pressed something: a frame that is off is on until the next edge. Tells whether that is what the press did.
    pub fn wake(&mut self) -> bool {
        let asleep = self.level() == Level::Off;
        if asleep {
            self.overruled = (self.scheduled == Level::Off).then_some(Level::FULL);
        }
        asleep
    }

    /// The person wants `level` until the next edge; with [`Level::Off`] the frame sleeps.
    pub const fn overrule(&mut self, level: Level) {
        self.overruled = Some(level);
    }

    /// What is followed.
    pub const fn schedule(&self) -> &Schedule {
        &self.schedule
    }
}
