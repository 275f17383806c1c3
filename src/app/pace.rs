//! When a frame is due.

use core::time::Duration;

/// Absolute deadlines at an even rate. A frame that comes late is shown late, and the deadlines it has missed are dropped, never
/// caught up: the motion may stand for a moment, but it does not hurry.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    frames_per_second: u32,
    /// When frame 0 was due.
    start: Duration,
    /// Deadlines since then.
    slot: u64,
    dropped: u64,
}

impl Pace {
    /// Deadlines at `frames_per_second` (at least 1), the first at once. Times are since any fixed moment.
    pub const fn new(frames_per_second: u32, now: Duration) -> Self {
        assert!(frames_per_second > 0);
        Self { frames_per_second, start: now, slot: 0, dropped: 0 }
    }

    /// When the next frame is due.
    pub fn deadline(&self) -> Duration {
        let second = self.slot / u64::from(self.frames_per_second);
        let part =
            self.slot % u64::from(self.frames_per_second) * 1_000_000_000 / u64::from(self.frames_per_second);
        self.start + Duration::from_secs(second) + Duration::from_nanos(part)
    }

    /// Notes that the frame that was due has been shown by `now`: the next is due at the first deadline that has not passed.
    pub fn shown(&mut self, now: Duration) {
        self.slot += 1;
        let late = now.saturating_sub(self.deadline()).as_nanos();
        let missed = (late * u128::from(self.frames_per_second) / 1_000_000_000) as u64;
        self.slot += missed;
        self.dropped += missed;
    }

    /// Deadlines that have passed without a frame.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn deadlines_do_not_drift() {
        let mut pace = Pace::new(12, MS(5));
        for frame in 0..12 * 86_400 {
            assert!(pace.deadline() >= MS(5 + frame * 1000 / 12));
            pace.shown(pace.deadline());
        }
        assert_eq!((pace.deadline(), pace.dropped()), (MS(5) + Duration::from_secs(86_400), 0));
    }

    #[test]
    fn a_late_frame_drops_what_it_missed_and_hurries_nothing() {
        let mut pace = Pace::new(10, MS(0));
        pace.shown(MS(20));
        assert_eq!(pace.deadline(), MS(100));
        pace.shown(MS(730));
        assert_eq!((pace.deadline(), pace.dropped()), (MS(700), 5));
        pace.shown(MS(735));
        assert_eq!((pace.deadline(), pace.dropped()), (MS(800), 5));
    }
}
