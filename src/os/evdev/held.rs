//! From what devices tell of their keys to edges of buttons.

use super::KeyCodes;
use crate::input::{Button, gesture::Edge};
use evdev::{EventSummary, InputEvent, KeyCode, SynchronizationCode};
use std::time::{Duration, SystemTime};

/// What a device tells of its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// A key went down or up.
    Key {
        /// Which key.
        code: KeyCode,
        /// Down.
        pressed: bool,
        /// When, on the clock that the device was told to use.
        at: Duration,
    },
    /// There were more events than the kernel keeps; some are missing from here on.
    Dropped,
}

impl Told {
    /// What `event` tells of keys. A key that repeats itself (value 2) tells nothing.
    pub(super) fn of(event: InputEvent) -> Option<Self> {
        match event.destructure() {
            EventSummary::Synchronization(_, SynchronizationCode::SYN_DROPPED, _) => Some(Self::Dropped),
            EventSummary::Key(_, code, value @ (0 | 1)) => {
                let at = event.timestamp().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
                Some(Self::Key { code, pressed: value == 1, at })
            }
            _ => None,
        }
    }
}

/// The keys of one device that are down, of those that are buttons.
///
/// Of every key, the edges that come out of here are balanced: down, up, down, …, whatever goes in.
#[derive(Debug, Default)]
pub(super) struct Held(Vec<KeyCode>);

impl Held {
    /// Takes in what one read gave, and adds the edges of buttons to `edges`. Tells whether events are missing: then the rest
    /// was passed over, and [`Self::resynchronise`] must follow with what the keys are now.
    #[must_use]
    pub(super) fn take(
        &mut self,
        told: impl Iterator<Item = Told>,
        codes: &KeyCodes,
        edges: &mut Vec<Edge>,
    ) -> bool {
        for told in told {
            match told {
                Told::Key { code, pressed, at } => {
                    if let Some(button) = codes.button(code) {
                        self.key(code, Edge { button, pressed, at }, edges);
                    }
                }
                Told::Dropped => return true,
            }
        }
        false
    }

    /// Adds the edges that lead from what was known to the keys that are `down` now.
    pub(super) fn resynchronise(
        &mut self,
        down: impl Fn(KeyCode) -> bool,
        codes: &KeyCodes,
        at: Duration,
        edges: &mut Vec<Edge>,
    ) {
        for (code, button) in codes.iter() {
            self.key(code, Edge { button, pressed: down(code), at }, edges);
        }
    }

    fn key(&mut self, code: KeyCode, edge: Edge, edges: &mut Vec<Edge>) {
        let place = self.0.iter().position(|&held| held == code);
        match (place, edge.pressed) {
            (None, true) => self.0.push(code),
            (Some(place), false) => drop(self.0.swap_remove(place)),
            (None, false) | (Some(_), true) => return,
        }
        edges.push(edge);
    }
}

/// How many keys hold each button down, over all devices.
#[derive(Debug, Default)]
pub(super) struct Holders([u16; Button::ALL.len()]);

impl Holders {
    /// The edge of a button that the edge of one of its keys comes to: the first one down, the last one up.
    pub(super) fn take(&mut self, edge: Edge) -> Option<Edge> {
        let holders = &mut self.0[edge.button as usize];
        let before = *holders;
        *holders = if edge.pressed { before.saturating_add(1) } else { before.saturating_sub(1) };
        ((before == 0) != (*holders == 0)).then_some(edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: fn(u64) -> Duration = Duration::from_millis;
    const KEYS: [KeyCode; 4] = [KeyCode::KEY_ENTER, KeyCode::KEY_KPENTER, KeyCode::KEY_SPACE, KeyCode::KEY_A];

    fn key(code: KeyCode, pressed: bool, ms: u64) -> Told {
        Told::Key { code, pressed, at: MS(ms) }
    }

    fn edge(button: Button, pressed: bool, ms: u64) -> Edge {
        Edge { button, pressed, at: MS(ms) }
    }

    /// The edges of one read, and whether events are missing.
    fn take(held: &mut Held, told: &[Told]) -> (Vec<Edge>, bool) {
        let mut edges = Vec::new();
        let missing = held.take(told.iter().copied(), &KeyCodes::default(), &mut edges);
        (edges, missing)
    }

    #[test]
    fn a_key_that_repeats_itself_tells_nothing() {
        let told = |kind, code, value| Told::of(InputEvent::new(kind, code, value));
        let enter = KeyCode::KEY_ENTER.0;
        assert_eq!(told(1, enter, 1), Some(key(KeyCode::KEY_ENTER, true, 0)));
        assert_eq!(told(1, enter, 2), None);
        assert_eq!(told(1, enter, 0), Some(key(KeyCode::KEY_ENTER, false, 0)));
        assert_eq!([told(0, 3, 0), told(0, 0, 0), told(4, 4, 28)], [Some(Told::Dropped), None, None]);
    }

    #[test]
    fn keys_without_a_button_and_releases_of_keys_that_were_not_down_are_passed_over() {
        let told = [
            key(KeyCode::KEY_A, true, 1),
            key(KeyCode::KEY_ENTER, false, 2),
            key(KeyCode::KEY_SPACE, true, 3),
        ];
        assert_eq!(take(&mut Held::default(), &told), (vec![edge(Button::Space, true, 3)], false));
    }

    #[test]
    fn after_dropped_events_the_keys_are_as_the_kernel_has_them() {
        let mut held = Held::default();
        let told = [
            key(KeyCode::KEY_ENTER, true, 1),
            Told::Dropped,
            key(KeyCode::KEY_SPACE, false, 2),
            key(KeyCode::KEY_I, true, 2),
        ];
        assert_eq!(take(&mut held, &told), (vec![edge(Button::Enter, true, 1)], true));
        let mut edges = Vec::new();
        let down = [KeyCode::KEY_SPACE, KeyCode::KEY_A];
        held.resynchronise(|code| down.contains(&code), &KeyCodes::default(), MS(5), &mut edges);
        assert_eq!(edges, [edge(Button::Enter, false, 5), edge(Button::Space, true, 5)]);
        let told = [key(KeyCode::KEY_SPACE, true, 6), key(KeyCode::KEY_SPACE, false, 7)];
        assert_eq!(take(&mut held, &told), (vec![edge(Button::Space, false, 7)], false));
    }

    #[test]
    fn a_keyboard_that_is_pulled_out_releases_its_keys() {
        let mut held = Held::default();
        let _ = take(&mut held, &[key(KeyCode::KEY_SPACE, true, 1), key(KeyCode::KEY_UP, true, 2)]);
        let mut edges = Vec::new();
        held.resynchronise(|_| false, &KeyCodes::default(), MS(9), &mut edges);
        edges.sort_by_key(|edge| edge.button as usize);
        assert_eq!(edges, [edge(Button::Up, false, 9), edge(Button::Space, false, 9)]);
    }

    #[test]
    fn a_button_on_two_keyboards_is_down_while_it_is_down_on_any() {
        let mut holders = Holders::default();
        let turns = [true, true, false, true, false, false, true, false].into_iter().zip(0..);
        let edges: Vec<_> =
            turns.filter_map(|(pressed, ms)| holders.take(edge(Button::Right, pressed, ms))).collect();
        let expected = [(true, 0), (false, 5), (true, 6), (false, 7)];
        assert_eq!(edges, expected.map(|(pressed, ms)| edge(Button::Right, pressed, ms)));
    }

    proptest! {
        #[test]
        fn whatever_two_keyboards_tell_no_button_is_stuck_once_they_are_gone(
            told in proptest::collection::vec((any::<bool>(), 0..5usize, any::<bool>()), 0..80),
        ) {
            let codes = KeyCodes::default();
            let mut keyboards = [Held::default(), Held::default()];
            let (mut holders, mut edges) = (Holders::default(), Vec::new());
            for (ms, (second, what, pressed)) in (0..).zip(told) {
                let told = KEYS.get(what).map_or(Told::Dropped, |&code| key(code, pressed, ms));
                let held = &mut keyboards[usize::from(second)];
                if held.take([told].into_iter(), &codes, &mut edges) {
                    held.resynchronise(|code| code == KEYS[ms as usize % KEYS.len()], &codes, MS(ms), &mut edges);
                }
            }
            for held in &mut keyboards {
                held.resynchronise(|_| false, &codes, MS(100), &mut edges);
            }
            let mut down = [false; Button::ALL.len()];
            for edge in edges.into_iter().filter_map(|edge| holders.take(edge)) {
                prop_assert_ne!(down[edge.button as usize], edge.pressed, "edges come by turns");
                down[edge.button as usize] = edge.pressed;
            }
            prop_assert_eq!(down, [false; Button::ALL.len()]);
        }
    }
}
