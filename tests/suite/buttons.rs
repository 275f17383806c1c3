//! Gestures under every kind of finger: any edges at any times, stuck keys, floods, and whatever the key map listens to.

use proptest::prelude::*;
use std::{iter, time::Duration};
use yurameki::{
    app::{Request, Show},
    input::{
        Button, Press,
        action::Action,
        gesture::{Edge, Gesture, Gestures},
        key_map::KeyMap,
    },
    noise::drive::Settings,
};

const MS: fn(u64) -> Duration = Duration::from_millis;

/// Longer than any gesture takes, with the debounce.
const SETTLED: Duration = Duration::from_millis(1000);

fn taken(gestures: &mut Gestures) -> Vec<Press> {
    iter::from_fn(|| gestures.next_press()).collect()
}

fn some_keys() -> impl Strategy<Value = KeyMap> {
    proptest::collection::vec(any::<[bool; 3]>(), Button::ALL.len()).prop_map(|listens| {
        let mut keys = KeyMap::EMPTY;
        for (button, listens) in Button::ALL.into_iter().zip(listens) {
            for (gesture, listens) in Gesture::ALL.into_iter().zip(listens) {
                keys.set(button, gesture, listens.then_some(Action::Pause));
            }
        }
        keys
    })
}

/// Edges of a few buttons, sensible and not, in time that mostly goes on.
fn some_edges() -> impl Strategy<Value = Vec<Edge>> {
    let gap = prop_oneof![-5i64..40, 0i64..500, 700i64..900, Just(3_600_000)];
    let step = (0..3usize, any::<bool>(), gap);
    proptest::collection::vec(step, 0..60).prop_map(|steps| {
        let mut at = 10_000;
        let mut edges = Vec::new();
        for (button, pressed, gap) in steps {
            at += gap;
            edges.push(Edge { button: Button::ALL[button], pressed, at: MS(at.max(0) as u64) });
        }
        edges
    })
}

/// How often each button goes down.
fn downs(edges: &[Edge], button: Button) -> usize {
    let levels: Vec<bool> =
        edges.iter().filter(|edge| edge.button == button).map(|edge| edge.pressed).collect();
    iter::once(&false).chain(&levels).zip(&levels).filter(|&(before, now)| !before && *now).count()
}

proptest! {
    #[test]
    fn whatever_fingers_do_each_press_is_at_most_one_gesture(
        keys in some_keys(), edges in some_edges(), debounce in prop_oneof![Just(0u64), Just(20)],
    ) {
        let mut gestures = Gestures::new(keys, MS(debounce));
        let mut made = Vec::new();
        for edge in &edges {
            gestures.edge(*edge);
            made.extend(taken(&mut gestures));
        }
        let end = edges.iter().map(|edge| edge.at).max().unwrap_or_default();
        gestures.advance(end + SETTLED);
        made.extend(taken(&mut gestures));
        prop_assert_eq!(gestures.dropped(), 0);

        for button in Button::ALL {
            let of = |gesture| made.iter().filter(|&&press| press == Press { button, gesture }).count();
            let [short, double, long] = Gesture::ALL.map(of);
            let presses = short + 2 * double + long;
            let downs = downs(&edges, button);
            prop_assert!(presses <= downs, "{button}: {presses} presses were made of {downs}");
            prop_assert!(debounce > 0 || presses == downs, "{button}: {presses} presses were made of {downs}");
            let listens = |gesture| keys.action(Press { button, gesture }).is_some();
            prop_assert!(double == 0 || listens(Gesture::Double));
            prop_assert!(long == 0 || listens(Gesture::Long));
        }
    }

    #[test]
    fn after_any_history_every_button_works_as_if_new(
        keys in some_keys(), edges in some_edges(), gesture in 0..3usize,
    ) {
        let mut used = Gestures::new(keys, Gestures::DEBOUNCE);
        for edge in &edges {
            used.edge(*edge);
        }
        let end = edges.iter().map(|edge| edge.at).max().unwrap_or_default();
        used.release_all(end);
        used.advance(end + SETTLED);
        taken(&mut used);
        let mut new = Gestures::new(keys, Gestures::DEBOUNCE);

        let times: &[u64] = [&[0, 50][..], &[0, 50, 120, 200], &[0, 900]][gesture];
        for button in Button::ALL {
            for (i, &ms) in times.iter().enumerate() {
                let edge = Edge { button, pressed: i % 2 == 0, at: end + 2 * SETTLED + MS(ms) };
                used.edge(edge);
                new.edge(edge);
            }
        }
        for gestures in [&mut used, &mut new] {
            gestures.advance(end + 4 * SETTLED);
        }
        prop_assert_eq!(taken(&mut used), taken(&mut new));
    }

    #[test]
    fn when_somebody_looks_changes_no_gesture(
        keys in some_keys(), edges in some_edges(), looks in 1u64..100,
    ) {
        let mut edges = edges;
        edges.sort_by_key(|edge| edge.at);
        let end = edges.last().map(|edge| edge.at).unwrap_or_default() + SETTLED;
        let mut seldom = Gestures::new(keys, Gestures::DEBOUNCE);
        let mut often = seldom.clone();
        let (mut few, mut many) = (Vec::new(), Vec::new());
        let mut from = edges.first().map(|edge| edge.at).unwrap_or_default();
        for edge in &edges {
            // Hours in which nothing happens are looked at in their first seconds.
            let until = edge.at.min(from + 5 * SETTLED);
            while from < until {
                often.advance(from);
                from += MS(looks);
            }
            from = edge.at;
            for (gestures, made) in [(&mut seldom, &mut few), (&mut often, &mut many)] {
                gestures.edge(*edge);
                made.extend(taken(gestures));
            }
        }
        for (gestures, made) in [(&mut seldom, &mut few), (&mut often, &mut many)] {
            gestures.advance(end);
            made.extend(taken(gestures));
        }
        // Of presses that end at different times on different buttons the order may differ.
        for button in Button::ALL {
            let of = |made: &[Press]| made.iter().filter(|press| press.button == button).copied().collect::<Vec<_>>();
            prop_assert_eq!(of(&few), of(&many));
        }
    }
}

#[test]
fn a_button_held_for_an_hour_is_one_long_press_and_works_again() {
    let mut gestures = Gestures::new(KeyMap::default(), Gestures::DEBOUNCE);
    let edge = |pressed, at| Edge { button: Button::Space, pressed, at };
    gestures.edge(edge(true, MS(0)));
    for second in 0..3600 {
        gestures.advance(MS(second * 1000));
    }
    gestures.edge(edge(false, MS(3_600_000)));
    gestures.edge(edge(true, MS(3_601_000)));
    gestures.edge(edge(false, MS(3_601_100)));
    let made: Vec<String> = taken(&mut gestures).iter().map(ToString::to_string).collect();
    assert_eq!(made, ["space:long", "space"]);
}

#[test]
fn of_a_thousand_presses_a_second_the_oldest_are_dropped_and_counted() {
    let mut gestures = Gestures::new(KeyMap::default(), Duration::ZERO);
    let mut press = |button, us| {
        let at = Duration::from_micros(us);
        gestures.edge(Edge { button, pressed: true, at });
        gestures.edge(Edge { button, pressed: false, at: at + Duration::from_micros(500) });
    };
    for ms in 0..999 {
        press(Button::Right, ms * 1000);
    }
    press(Button::Left, 999_000);
    assert_eq!(gestures.dropped(), 1000 - Gestures::WAITING_PRESSES as u64);
    let made = taken(&mut gestures);
    assert_eq!(
        (made.len(), made.last().map(|press| press.button)),
        (Gestures::WAITING_PRESSES, Some(Button::Left))
    );
}

#[test]
fn a_contact_that_chatters_a_thousand_times_a_second_presses_fifty_times_at_the_most() {
    let mut gestures = Gestures::new(KeyMap::default(), Gestures::DEBOUNCE);
    let mut made = 0;
    for half_ms in 0..2000 {
        let at = Duration::from_micros(half_ms * 500);
        gestures.edge(Edge { button: Button::Right, pressed: half_ms % 2 == 0, at });
        made += taken(&mut gestures).len();
    }
    assert!((20..=50).contains(&made), "{made} presses");
    assert_eq!(gestures.dropped(), 0);
}

#[test]
fn each_key_of_the_default_map_does_what_it_is_for() {
    let keys = KeyMap::default();
    let mut show = Show::new(Settings::default(), 12, 7);
    let mut ask = |press: &str| {
        let action = keys.action(press.parse().expect("a press")).expect("an action");
        show.press(action)
    };
    let asked = ["right", "right:long", "left", "enter", "space:long", "enter:long", "esc"].map(&mut ask);
    let expected = [
        Request::NextPhoto,
        Request::NextReference,
        Request::PreviousPhoto,
        Request::NextEffect,
        Request::Sleep,
        Request::Hide,
        Request::Quit,
    ];
    assert_eq!(asked, expected.map(Some));
    assert_eq!(["up", "down", "space", "i"].map(&mut ask), [None; 4]);
}

/// On a real kernel. Uses keys that no keyboard at hand is likely to be pressed on, and leaves all others alone.
#[cfg(all(feature = "os", target_os = "linux"))]
mod kernel {
    use evdev::{AttributeSet, EventType, InputEvent, KeyCode, uinput::VirtualDevice};
    use std::{thread::sleep, time::Duration};
    use yurameki::{
        input::{Button, Buttons as _, Press},
        os::evdev::{KeyCodes, Keyboards},
    };

    const RIGHT: KeyCode = KeyCode::KEY_F20;
    const SPACE: KeyCode = KeyCode::KEY_F21;

    /// A keyboard with two keys; none, with a message, where this machine has no uinput.
    fn plug_in() -> Option<VirtualDevice> {
        let build = || {
            let keys: AttributeSet<KeyCode> = [RIGHT, SPACE].into_iter().collect();
            VirtualDevice::builder()?.name("Yurameki's test keyboard").with_keys(&keys)?.build()
        };
        build().inspect_err(|error| eprintln!("skipped: no virtual keyboard by /dev/uinput: {error}")).ok()
    }

    fn keyboards() -> Keyboards {
        let mut codes = KeyCodes::EMPTY;
        codes.assign("KEY_F20", Button::Right).expect("a key");
        codes.assign("KEY_F21", Button::Space).expect("a key");
        Keyboards::new(codes, true)
    }

    fn key(keyboard: &mut VirtualDevice, code: KeyCode, pressed: bool) {
        keyboard.emit(&[InputEvent::new(EventType::KEY.0, code.0, pressed.into())]).expect("emitted");
    }

    fn tap(keyboard: &mut VirtualDevice, code: KeyCode) {
        key(keyboard, code, true);
        key(keyboard, code, false);
    }

    /// Turns of a loop at 50 frames a second, `each` time after something, until `wanted` is pressed.
    #[track_caller]
    fn until(keyboards: &mut Keyboards, wanted: &str, mut each: impl FnMut()) {
        let wanted: Press = wanted.parse().expect("a press");
        for frame in 0..500 {
            each();
            while let Some(press) = keyboards.next_press(frame) {
                if press == wanted {
                    return;
                }
            }
            sleep(Duration::from_millis(20));
        }
        panic!("{wanted} was not pressed within 500 frames");
    }

    /// Turns of a loop until contacts have settled, whatever is pressed.
    fn settle(keyboards: &mut Keyboards) {
        for frame in 0..3 {
            while keyboards.next_press(frame).is_some() {}
            sleep(Duration::from_millis(20));
        }
    }

    #[test]
    fn keyboards_come_and_go_and_are_flooded_and_no_button_is_stuck() {
        let mut keyboards = keyboards();
        assert_eq!(keyboards.next_press(0), None);
        let Some(mut first) = plug_in() else { return };
        until(&mut keyboards, "right", || tap(&mut first, RIGHT));
        let node =
            first.enumerate_dev_nodes_blocking().expect("sysfs").next().expect("a node").expect("a path");
        settle(&mut keyboards);
        assert!(evdev::Device::open(node).expect("the keyboard").grab().is_err(), "its keys are ours");
        key(&mut first, SPACE, true);
        until(&mut keyboards, "space:long", || {});
        key(&mut first, SPACE, false);
        settle(&mut keyboards);

        // Many more events than the kernel keeps; the release of SPACE is among those that are dropped.
        key(&mut first, SPACE, true);
        settle(&mut keyboards);
        key(&mut first, SPACE, false);
        for _ in 0..500 {
            tap(&mut first, RIGHT);
        }
        until(&mut keyboards, "space", || {});
        until(&mut keyboards, "right", || tap(&mut first, RIGHT));

        let Some(mut second) = plug_in() else { return };
        until(&mut keyboards, "space", || tap(&mut second, SPACE));
        settle(&mut keyboards);
        key(&mut second, SPACE, true);
        settle(&mut keyboards);
        drop(second);
        until(&mut keyboards, "space", || {});
        until(&mut keyboards, "right", || tap(&mut first, RIGHT));
    }
}
