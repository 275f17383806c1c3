//! From the edges of buttons to gestures.
//!
//! A press acts as soon as it can mean nothing else, which depends on what the key map has for its button:
//!
//! | the button also has | a short press acts | a double press acts | a long press acts |
//! |---|---|---|---|
//! | nothing else | when it goes down | | |
//! | a long press | when it goes up | | 800 ms after it went down, while it is held |
//! | a double press | 400 ms after it went down | when it goes down again | |
//! | both | at the later of the two | when it goes down again | as above |
//!
//! Time comes in with every call, since any fixed moment; a time before one that was told earlier counts as that one.
//! Whatever comes in, a press is one gesture or one half of a double one, and it has become that at the latest 800 ms after
//! it began: a button that is held for an hour, or whose release is never told, holds nothing up.

use super::{Button, Press, UnknownName, key_map::KeyMap};
use core::{fmt, str::FromStr, time::Duration};
use heapless::Deque;

/// How a button was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gesture {
    /// Down and up.
    Short,
    /// Down twice within [`Gestures::DOUBLE_PRESS`].
    Double,
    /// Down for [`Gestures::LONG_PRESS`].
    Long,
}

impl Gesture {
    /// Every gesture, in the order in which they are listed to people.
    pub const ALL: [Self; 3] = [Self::Short, Self::Double, Self::Long];

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Short => "short",
            Self::Double => "double",
            Self::Long => "long",
        }
    }
}

impl fmt::Display for Gesture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Gesture {
    type Err = UnknownName;

    /// The gesture of that name, in small or capital letters.
    fn from_str(word: &str) -> Result<Self, UnknownName> {
        let mut gestures = Self::ALL.into_iter();
        gestures.find(|gesture| gesture.name().eq_ignore_ascii_case(word)).ok_or(UnknownName::Gesture)
    }
}

/// A button goes down or up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Which button.
    pub button: Button,
    /// Down.
    pub pressed: bool,
    /// When, since any fixed moment.
    pub at: Duration,
}

/// The gesture machine of a set of buttons.
#[derive(Clone, Debug)]
pub struct Gestures {
    keys: KeyMap,
    debounce: Duration,
    contacts: [Contact; Button::ALL.len()],
    now: Duration,
    presses: Deque<Press, { Self::WAITING_PRESSES }>,
    dropped: u64,
}

impl Gestures {
    /// For bare contacts: a change this soon after another is taken for the same one, its springs still swinging. Common
    /// push buttons settle within 10 ms.
    pub const DEBOUNCE: Duration = Duration::from_millis(20);
    /// From the beginning of a press to that of the next, for a double press.
    pub const DOUBLE_PRESS: Duration = Duration::from_millis(400);
    /// From the beginning of a press until it is a long one.
    pub const LONG_PRESS: Duration = Duration::from_millis(800);
    /// Presses that wait for somebody to take them. Whoever presses more often than this between two frames has no
    /// particular one in mind: the oldest go.
    pub const WAITING_PRESSES: usize = 32;

    /// Every button up. A change within `debounce` of the last one of its button takes effect at the end of that time, if
    /// it lasts: [`Self::DEBOUNCE`] for bare contacts, zero for buttons that somebody else has debounced.
    pub const fn new(keys: KeyMap, debounce: Duration) -> Self {
        Self {
            keys,
            debounce,
            contacts: [Contact::UP; Button::ALL.len()],
            now: Duration::ZERO,
            presses: Deque::new(),
            dropped: 0,
        }
    }

    /// Goes by other keys from now on.
    pub fn set_keys(&mut self, keys: KeyMap) {
        self.keys = keys;
    }

    /// Takes an edge in. An edge to where the button already is changes nothing.
    pub fn edge(&mut self, edge: Edge) {
        self.advance(edge.at);
        let contact = &mut self.contacts[edge.button as usize];
        if contact.seen != edge.pressed {
            (contact.seen, contact.seen_at) = (edge.pressed, self.now);
        }
        self.advance(edge.at);
    }

    /// Every button is up: whoever tells of edges has lost sight of them.
    pub fn release_all(&mut self, at: Duration) {
        for button in Button::ALL {
            self.edge(Edge { button, pressed: false, at });
        }
    }

    /// Forgets what was begun and what nobody has taken; every button is up.
    pub fn reset(&mut self) {
        *self = Self { now: self.now, dropped: self.dropped, ..Self::new(self.keys, self.debounce) };
    }

    /// Lets time pass until `now`.
    pub fn advance(&mut self, now: Duration) {
        self.now = self.now.max(now);
        for button in Button::ALL {
            let made = self.contacts[button as usize].advance(
                self.now,
                self.debounce,
                &Listens::to(&self.keys, button),
            );
            for gesture in made.into_iter().flatten() {
                self.queue(Press { button, gesture });
            }
        }
    }

    /// The oldest press that nobody has taken.
    pub fn next_press(&mut self) -> Option<Press> {
        self.presses.pop_front()
    }

    /// Presses that nobody took before there were too many.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    fn queue(&mut self, press: Press) {
        if self.presses.is_full() {
            self.presses.pop_front();
            self.dropped += 1;
        }
        // There is room now.
        let _ = self.presses.push_back(press);
    }
}

/// What a press of a button may become, beside a short one.
struct Listens {
    double: bool,
    long: bool,
}

impl Listens {
    const fn to(keys: &KeyMap, button: Button) -> Self {
        Self { double: keys.has(button, Gesture::Double), long: keys.has(button, Gesture::Long) }
    }
}

/// One button.
#[derive(Clone, Copy, Debug)]
struct Contact {
    /// Where the last edge left it, down or up, and when that was.
    seen: bool,
    seen_at: Duration,
    /// Where it is, the springs apart, and until when it stays there.
    pressed: bool,
    settled_at: Duration,
    phase: Phase,
}

/// How far the gesture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// None has begun.
    Rest,
    /// Down since then; what it becomes is open.
    First { since: Duration },
    /// Down and up again; it went down then, and may do so once more.
    Between { since: Duration },
    /// Down; the gesture has been made.
    Made,
}

impl Contact {
    const UP: Self = Self {
        seen: false,
        seen_at: Duration::ZERO,
        pressed: false,
        settled_at: Duration::ZERO,
        phase: Phase::Rest,
    };

    /// Up to `now`: what became of the time before a change, the change, and the time after it.
    fn advance(&mut self, now: Duration, debounce: Duration, listens: &Listens) -> [Option<Gesture>; 3] {
        let due = self.seen_at.max(self.settled_at);
        if self.seen == self.pressed || due > now {
            return [self.wait(now, listens), None, None];
        }
        let before = self.wait(due, listens);
        (self.pressed, self.settled_at) = (self.seen, due + debounce);
        let change = if self.pressed { self.go_down(due) } else { self.go_up(due, listens) };
        [before, change, self.wait(now, listens)]
    }

    fn go_down(&mut self, at: Duration) -> Option<Gesture> {
        let again = matches!(self.phase, Phase::Between { .. });
        self.phase = if again { Phase::Made } else { Phase::First { since: at } };
        again.then_some(Gesture::Double)
    }

    fn go_up(&mut self, at: Duration, listens: &Listens) -> Option<Gesture> {
        match self.phase {
            Phase::First { since } if listens.double && at.saturating_sub(since) < Gestures::DOUBLE_PRESS => {
                self.phase = Phase::Between { since };
                None
            }
            Phase::First { .. } => {
                self.phase = Phase::Rest;
                Some(Gesture::Short)
            }
            Phase::Rest | Phase::Between { .. } | Phase::Made => {
                self.phase = Phase::Rest;
                None
            }
        }
    }

    /// The gesture that is made by nothing happening until `now`.
    fn wait(&mut self, now: Duration, listens: &Listens) -> Option<Gesture> {
        let lasted = |since| now.saturating_sub(since);
        let no_second = |since| !listens.double || lasted(since) >= Gestures::DOUBLE_PRESS;
        let (phase, gesture) = match self.phase {
            Phase::First { since } if listens.long && lasted(since) >= Gestures::LONG_PRESS => {
                (Phase::Made, Gesture::Long)
            }
            Phase::First { since } if !listens.long && no_second(since) => (Phase::Made, Gesture::Short),
            Phase::Between { since } if no_second(since) => (Phase::Rest, Gesture::Short),
            _ => return None,
        };
        self.phase = phase;
        Some(gesture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::action::Action;

    const MS: fn(u64) -> Duration = Duration::from_millis;

    /// SPACE with what is in `gestures` beside a short press.
    fn space(gestures: &[Gesture]) -> Gestures {
        let mut keys = KeyMap::EMPTY;
        for &gesture in [Gesture::Short].iter().chain(gestures) {
            keys.set(Button::Space, gesture, Action::Pause);
        }
        Gestures::new(keys, Gestures::DEBOUNCE)
    }

    /// When SPACE makes which gesture, if it goes down and up by turns at `edges` and is looked at every millisecond.
    fn made(machine: &mut Gestures, edges: &[u64]) -> Vec<(u64, Gesture)> {
        let mut made = Vec::new();
        for ms in 0..3000 {
            for (i, _) in edges.iter().enumerate().filter(|&(_, &at)| at == ms) {
                machine.edge(Edge { button: Button::Space, pressed: i % 2 == 0, at: MS(ms) });
            }
            machine.advance(MS(ms));
            made.extend(std::iter::from_fn(|| machine.next_press()).map(|press| (ms, press.gesture)));
        }
        made
    }

    #[test]
    fn a_press_that_can_only_be_short_acts_when_it_goes_down() {
        assert_eq!(
            made(&mut space(&[]), &[100, 200, 300, 2900]),
            [(100, Gesture::Short), (300, Gesture::Short)]
        );
    }

    #[test]
    fn beside_a_long_press_a_short_one_acts_when_it_goes_up() {
        let mut machine = space(&[Gesture::Long]);
        assert_eq!(
            made(&mut machine, &[100, 300, 400, 1199, 1300, 2200]),
            [(300, Gesture::Short), (1199, Gesture::Short), (2100, Gesture::Long)]
        );
    }

    #[test]
    fn beside_a_double_press_a_short_one_waits_for_a_second() {
        let mut machine = space(&[Gesture::Double]);
        assert_eq!(
            made(&mut machine, &[100, 150, 499, 600, 700, 750, 1100, 1150, 2000, 2900]),
            [(499, Gesture::Double), (1100, Gesture::Short), (1500, Gesture::Short), (2400, Gesture::Short)]
        );
    }

    #[test]
    fn a_button_can_have_all_three() {
        let mut machine = space(&[Gesture::Double, Gesture::Long]);
        assert_eq!(
            made(&mut machine, &[100, 200, 300, 1300, 1400, 1900, 2000, 2900]),
            [(300, Gesture::Double), (1900, Gesture::Short), (2800, Gesture::Long)]
        );
    }

    #[test]
    fn contacts_that_bounce_make_one_press() {
        let edges = [100, 103, 104, 108, 109, 200, 202, 205, 206, 207];
        assert_eq!(made(&mut space(&[]), &edges), [(100, Gesture::Short)]);
        assert_eq!(made(&mut space(&[Gesture::Long]), &edges), [(200, Gesture::Short)]);
    }

    #[test]
    fn a_tap_shorter_than_the_debounce_is_a_press() {
        assert_eq!(made(&mut space(&[Gesture::Long]), &[100, 105]), [(120, Gesture::Short)]);
    }

    #[test]
    fn a_caller_who_comes_late_misses_nothing() {
        let mut machine = space(&[Gesture::Double, Gesture::Long]);
        let edge = |pressed, ms| Edge { button: Button::Space, pressed, at: MS(ms) };
        for edge in [edge(true, 0), edge(false, 5), edge(true, 1000), edge(false, 1900)] {
            machine.edge(edge);
        }
        let made: Vec<_> = std::iter::from_fn(|| machine.next_press()).map(|press| press.gesture).collect();
        assert_eq!(made, [Gesture::Short, Gesture::Long]);
    }

    #[test]
    fn without_debounce_presses_at_one_moment_all_count() {
        let mut machine = Gestures::new(KeyMap::default(), Duration::ZERO);
        for pressed in [true, false, true, false, true] {
            machine.edge(Edge { button: Button::Left, pressed, at: MS(7) });
        }
        assert_eq!(std::iter::from_fn(|| machine.next_press()).count(), 3);
    }
}
