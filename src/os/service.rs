//! What the service manager is told (systemd, sd_notify(3)): when the show has begun, that it lives, and how it goes.
//!
//! A frame that has gone black while its program still runs is the failure that people complain about most. So there is no
//! thread and no timer here: only a turn of the loop that has come to its end says anything. A turn that hangs, in a flip that
//! never ends, in the painting, on a disk, keeps silent, and the manager starts the program anew.
//!
//! A turn without a frame is a sign of life only for a reason that a restart would not mend ([`Idle`]): the panel is off, gone or
//! not there yet (it is opened afresh once a second), there is no photo, or the first is being loaded. The manager then sees the reason in place of
//! the picture. Before the first frame such turns prolong the start instead, since a watchdog runs only from
//! then on.

use super::loader::Encoding;
use crate::noise::Kind;
use sd_notify::NotifyState;
use std::{
    env,
    fmt::Write as _,
    io,
    time::{Duration, Instant},
};

/// A status line is written so often, and the start is prolonged.
const STATUS_EVERY: Duration = Duration::from_secs(1);

/// A start that waits may take so much longer from each time on that it says so. A Raspberry Pi Zero decodes the largest photos within.
const MORE_TIME: Duration = Duration::from_secs(90);

/// The watchdog is fed so many times within its time, so that a late frame does not matter.
const FEEDS: u32 = 4;

/// Why a turn of the loop has shown no frame, though all is well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Idle {
    /// The panel is off, by the time of the day or by hand.
    Off,
    /// The panel is not plugged in, is gone, or shows another console.
    NoPanel,
    /// No photo is there; the panel says so.
    NoPhoto,
    /// No photo is loaded yet.
    Loading,
}

impl Idle {
    const fn status(self) -> &'static str {
        match self {
            Self::Off => "the panel is off",
            Self::NoPanel => "waiting for the panel",
            Self::NoPhoto => "waiting for a photo",
            Self::Loading => "loading a photo",
        }
    }
}

type Send = fn(&[NotifyState<'_>]) -> io::Result<()>;

/// The service manager that has started the program, if one has. It is told at the end, too.
#[derive(Debug)]
pub(super) struct Service {
    /// `None` where nobody listens.
    send: Option<Send>,
    feed_every: Option<Duration>,
    feed_due: Option<Instant>,
    status_due: Option<Instant>,
    /// A frame was shown.
    ready: bool,
    /// Frames shown since `counting_since`.
    frames: u32,
    counting_since: Option<Instant>,
    status: String,
    /// What is being coded while all this is shown.
    encoding: Option<Encoding>,
}

impl Service {
    /// The manager that the environment names (`NOTIFY_SOCKET`, `WATCHDOG_USEC`).
    pub(super) fn from_env() -> Self {
        let listens = env::var_os("NOTIFY_SOCKET").is_some();
        Self::new(listens.then_some(sd_notify::notify as Send), sd_notify::watchdog_enabled())
    }

    fn new(send: Option<Send>, watchdog: Option<Duration>) -> Self {
        Self {
            send,
            feed_every: watchdog.map(|time| time / FEEDS),
            feed_due: None,
            status_due: None,
            ready: false,
            frames: 0,
            counting_since: None,
            status: String::new(),
            encoding: None,
        }
    }

    /// Whether a manager has started the program: it is meant to run for ever, perhaps from before its panel is there.
    pub(super) const fn is_managed(&self) -> bool {
        self.send.is_some()
    }

    /// What is being coded from now on.
    pub(super) fn set_encoding(&mut self, encoding: Option<Encoding>) {
        self.encoding = encoding;
    }

    /// A frame of `photo` was presented. Costs a comparison, and once a second a message.
    pub(super) fn shown(&mut self, now: Instant, photo: &str, noises: (Kind, Kind), paused: bool) {
        self.frames = self.frames.saturating_add(1);
        let first = self.becomes_ready();
        self.tell(now, first, |status, rate| {
            let paused = if paused { ", paused" } else { "" };
            if let Some(rate) = rate {
                let _ = write!(status, "{rate:.1} fps, ");
            }
            let _ = write!(status, "{photo}, amplitude {}, frequency {}{paused}", noises.0, noises.1);
        });
    }

    /// Notes a frame; whether it is the first, of which everything is told at once.
    fn becomes_ready(&mut self) -> bool {
        let first = !std::mem::replace(&mut self.ready, true);
        if first {
            (self.status_due, self.feed_due) = (None, None);
        }
        first
    }

    /// A turn has shown no photo.
    pub(super) fn idle(&mut self, now: Instant, why: Idle) {
        // What the panel says in the place of a photo is a frame too.
        let first = why == Idle::NoPhoto && self.becomes_ready();
        self.tell(now, first, |status, _| status.push_str(why.status()));
        // The rate is that of a stretch of frames without a gap.
        (self.frames, self.counting_since) = (0, None);
    }

    /// Says what is due. `write` is given the frames a second since it was asked last.
    fn tell(&mut self, now: Instant, first: bool, write: impl FnOnce(&mut String, Option<f64>)) {
        let Some(send) = self.send else { return };
        let passed = |due: Option<Instant>| due.is_none_or(|due| now >= due);
        let feeds = self.ready && self.feed_every.is_some() && passed(self.feed_due);
        let says = passed(self.status_due);
        if !feeds && !says {
            return;
        }
        let mut states = Vec::with_capacity(3);
        if first {
            states.push(NotifyState::Ready);
        }
        if feeds {
            self.feed_due = self.feed_every.map(|every| now + every);
            states.push(NotifyState::Watchdog);
        }
        if says {
            self.status_due = Some(now + STATUS_EVERY);
            let rate = self.rate(now);
            self.status.clear();
            write(&mut self.status, rate);
            if let Some(encoding) = &self.encoding {
                let _ = write!(self.status, ", {encoding}");
            }
            one_line(&mut self.status);
            states.push(NotifyState::Status(&self.status));
            if !self.ready {
                states.push(NotifyState::ExtendTimeoutUsec(MORE_TIME.as_micros() as u32));
            }
        }
        // A manager that cannot be reached restarts the program by itself.
        if let Err(error) = send(&states) {
            log::debug!("the service manager is not reached: {error}");
        }
    }

    /// Frames a second since it was asked last.
    fn rate(&mut self, now: Instant) -> Option<f64> {
        let frames = std::mem::take(&mut self.frames);
        let since = self.counting_since.replace(now)?;
        Some(f64::from(frames) / now.duration_since(since).as_secs_f64().max(1e-3))
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        if let Some(send) = self.send {
            let _ = send(&[NotifyState::Stopping]);
        }
    }
}

/// A line break in the name of a photo would begin another message.
fn one_line(text: &mut String) {
    if text.contains(char::is_control) {
        *text = text.replace(char::is_control, " ");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    thread_local! {
        static HEARD: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    }

    fn hear(states: &[NotifyState<'_>]) -> io::Result<()> {
        let lines: Vec<String> = states.iter().map(|state| format!("{state}\n")).collect();
        HEARD.with_borrow_mut(|heard| heard.push(lines.concat()));
        Ok(())
    }

    fn service(watchdog: Option<Duration>) -> Service {
        Service::new(Some(hear), watchdog)
    }

    fn heard() -> Vec<String> {
        HEARD.take()
    }

    const NOISES: (Kind, Kind) = (Kind::Brown, Kind::White);
    const MINUTE: Duration = Duration::from_secs(60);

    #[test]
    fn the_first_frame_is_what_makes_it_ready() {
        let (mut service, now) = (service(Some(MINUTE)), Instant::now());
        service.idle(now, Idle::NoPanel);
        service.idle(now + STATUS_EVERY, Idle::Loading);
        let waiting = heard();
        assert_eq!(waiting[0], "STATUS=waiting for the panel\nEXTEND_TIMEOUT_USEC=90000000\n");
        assert_eq!(waiting[1], "STATUS=loading a photo\nEXTEND_TIMEOUT_USEC=90000000\n");
        service.shown(now + STATUS_EVERY, "lake.jpg", NOISES, false);
        service.shown(now + STATUS_EVERY, "lake.jpg", NOISES, false);
        assert_eq!(
            heard(),
            ["READY=1\nWATCHDOG=1\nSTATUS=lake.jpg, amplitude brown, frequency white\n"],
            "once, and at once"
        );
    }

    #[test]
    fn the_status_tells_the_rate_once_a_second() {
        let (mut service, start) = (service(None), Instant::now());
        for frame in 0..=24 {
            service.shown(start + frame * Duration::from_secs(1) / 12, "lake.jpg", NOISES, frame > 12);
        }
        let heard = heard();
        assert_eq!(heard.len(), 3);
        assert_eq!(heard[1], "STATUS=12.0 fps, lake.jpg, amplitude brown, frequency white\n");
        assert_eq!(heard[2], "STATUS=12.0 fps, lake.jpg, amplitude brown, frequency white, paused\n");
    }

    /// The seconds from the start at which the watchdog is fed in ten minutes of turns, each of which takes a twelfth of a second or
    /// what `stalls` says.
    fn fed(idle: Option<Idle>, stall: impl Fn(u32) -> Option<Duration>) -> Vec<u64> {
        let (mut service, start) = (service(Some(MINUTE)), Instant::now());
        let (mut now, mut fed) = (start, Vec::new());
        service.shown(now, "lake.jpg", NOISES, false);
        heard();
        for turn in 0..12 * 600 {
            now += stall(turn).unwrap_or(Duration::from_secs(1) / 12);
            match idle {
                Some(why) => service.idle(now, why),
                None => service.shown(now, "lake.jpg", NOISES, false),
            }
            if heard().iter().any(|message| message.contains("WATCHDOG=1")) {
                fed.push((now - start).as_secs());
            }
        }
        fed
    }

    fn longest_silence(fed: &[u64]) -> u64 {
        fed.windows(2).map(|pair| pair[1] - pair[0]).max().expect("fed more than once")
    }

    #[test]
    fn frames_feed_the_watchdog_and_so_does_every_good_reason_for_none() {
        for idle in [None, Some(Idle::Off), Some(Idle::NoPanel), Some(Idle::NoPhoto)] {
            let fed = fed(idle, |_| None);
            assert!((38..=41).contains(&fed.len()), "{idle:?}: fed {} times", fed.len());
            assert!(longest_silence(&fed) <= 16, "{idle:?}");
        }
    }

    #[test]
    fn what_is_being_encoded_is_told_beside_what_is_shown_and_where_nothing_is() {
        let (mut service, now) = (service(None), Instant::now());
        service.set_encoding(Some(Encoding { name: "sea.jpg".into(), percent: 40 }));
        service.idle(now, Idle::Loading);
        service.shown(now + STATUS_EVERY, "lake.jpg", NOISES, false);
        service.set_encoding(None);
        service.shown(now + 2 * STATUS_EVERY, "lake.jpg", NOISES, false);
        let heard = heard();
        assert!(heard[0].starts_with("STATUS=loading a photo, encoding sea.jpg 40 %\n"), "{heard:?}");
        assert!(heard[1].ends_with("lake.jpg, amplitude brown, frequency white, encoding sea.jpg 40 %\n"));
        assert!(heard[2].ends_with("lake.jpg, amplitude brown, frequency white\n"), "{heard:?}");
    }

    #[test]
    fn a_turn_that_hangs_does_not_feed_the_watchdog() {
        let fed = fed(None, |turn| (turn == 1000).then_some(3 * MINUTE));
        assert!(longest_silence(&fed) >= 180, "{fed:?}");
    }

    #[test]
    fn a_line_break_in_a_name_begins_no_other_message() {
        let (mut service, now) = (service(None), Instant::now());
        service.shown(now, "x\nWATCHDOG=trigger\r\u{b}.jpg", NOISES, false);
        assert_eq!(heard(), ["READY=1\nSTATUS=x WATCHDOG=trigger  .jpg, amplitude brown, frequency white\n"]);
    }

    #[test]
    fn the_end_is_told() {
        drop(service(None));
        assert_eq!(heard(), ["STOPPING=1\n"]);
    }

    #[test]
    fn nobody_is_told_where_nobody_listens() {
        let mut service = Service::new(None, Some(MINUTE));
        service.shown(Instant::now(), "lake.jpg", NOISES, false);
        drop(service);
        assert_eq!(heard(), [""; 0]);
    }
}
