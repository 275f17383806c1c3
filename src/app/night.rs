//! How bright the panel is at what time of the day.
//!
//! The schedule ([`config::night::Night`]) knows no date: whatever the clock does (daylight saving, a leap day, a wrong year), the
//! level is that of the time it shows ([`level_at`]). In the hour that a day has twice in autumn, edges happen twice; in the
//! hour that is missing in spring, they happen at its end.
//!
//! [`Night`] follows a schedule: it does nothing while nobody knows what time it is, and lets the person overrule the schedule
//! until its next edge.

use crate::config::{
    self,
    night::{Edge, Level},
};

/// The minutes of a day.
const DAY: u16 = 24 * 60;

/// As bright as the panel can be.
pub const FULL: Level = Level::Percent(100);

/// The share of the panel's light that looks like `level`, of 65,536 for all of it.
///
/// CIE 1976 lightness, solved for the luminance: Y = ((L* + 16) / 116)³ for L* > 8, else L* / 903.3. A panel at 50 % is half as
/// bright to the eye and gives 18 % of its light.
pub const fn light(level: Level) -> u32 {
    const CUBE: u64 = 116 * 116 * 116;
    match level {
        Level::Off => 0,
        Level::Percent(percent @ 0..=8) => ((percent as u64 * 655_360 + 4_516) / 9_033) as u32,
        Level::Percent(percent) => {
            let sum = if percent > 100 { 116 } else { percent as u64 + 16 };
            ((sum * sum * sum * 65_536 + CUBE / 2) / CUBE) as u32
        }
    }
}

/// What holds at the minute `now` of the local day, by `edges` in the order of the day. Without an edge it is [`FULL`].
pub fn level_at(edges: &[Edge], now: u16) -> Level {
    let begun = edges.partition_point(|edge| edge.minute <= now);
    // Before the first edge of the day holds what began last yesterday.
    let edge = if begun == 0 { edges.last() } else { edges.get(begun - 1) };
    edge.map_or(FULL, |edge| edge.level)
}

/// The edge that comes after the minute `now` of the local day; an edge at `now` has begun.
pub fn next_edge(edges: &[Edge], now: u16) -> Option<Edge> {
    let later = edges.iter().find(|edge| edge.minute > now);
    later.or(edges.first()).copied()
}

/// Minutes from one minute of the day forwards to another, over midnight if need be.
const fn minutes_between(from: u16, to: u16) -> u16 {
    (to + DAY - from) % DAY
}

/// Whether an edge begins on the way from `before` to `now`. A clock that was put back, by half a day at the most, has passed none.
fn passed(edges: &[Edge], before: u16, now: u16) -> bool {
    let way = minutes_between(before, now);
    way <= DAY / 2 && edges.iter().any(|edge| (1..=way).contains(&minutes_between(before, edge.minute)))
}

/// A schedule that is followed, and what the person wants instead.
#[derive(Clone, Debug)]
pub struct Night {
    schedule: config::night::Night,
    /// What the schedule said last.
    scheduled: Level,
    overruled: Option<Level>,
    /// The last time that was known.
    before: Option<u16>,
}

impl Night {
    /// Follows `schedule` from now on; until the time is known, the panel is at [`FULL`].
    pub const fn new(schedule: config::night::Night) -> Self {
        Self { schedule, scheduled: FULL, overruled: None, before: None }
    }

    /// Follows another schedule from the next turn on. What overrules it goes on until that one's next edge.
    pub fn follow(&mut self, schedule: config::night::Night) {
        self.schedule = schedule;
    }

    /// The level now, at the minute `now` (0..1440) of the local day; `None` if nobody knows what time it is: then everything stays as it is.
    pub fn turn(&mut self, now: Option<u16>) -> Level {
        if let Some(now) = now {
            let edges = self.schedule.edges();
            self.scheduled = level_at(edges, now);
            if self.before.is_some_and(|before| passed(edges, before, now)) {
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
            self.overruled = (self.scheduled == Level::Off).then_some(FULL);
        }
        asleep
    }

    /// The person wants `level` until the next edge; with [`Level::Off`] the frame sleeps.
    pub const fn overrule(&mut self, level: Level) {
        self.overruled = Some(level);
    }
}
