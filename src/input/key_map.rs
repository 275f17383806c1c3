//! Which press does what.

use super::{Button, Press, UnknownName, action::Action, gesture::Gesture};

/// An action, or none, for each gesture on each button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyMap {
    actions: [[Option<Action>; Gesture::ALL.len()]; Button::ALL.len()],
}

impl KeyMap {
    /// No press does anything.
    pub const EMPTY: Self = Self { actions: [[None; Gesture::ALL.len()]; Button::ALL.len()] };

    /// What `press` does.
    pub const fn action(&self, press: Press) -> Option<Action> {
        self.actions[press.button as usize][press.gesture as usize]
    }

    /// From now on `gesture` on `button` does `action`; with `None`, nothing.
    pub fn set(&mut self, button: Button, gesture: Gesture, action: impl Into<Option<Action>>) {
        self.actions[button as usize][gesture as usize] = action.into();
    }

    /// The same in words: `press` is a button, alone or with a gesture (`space`, `space:long`); `action` is the name of an
    /// action, or `none`. Letters may be small or capital.
    ///
    /// # Errors
    ///
    /// Which of the words names nothing; the message lists those that do.
    pub fn assign(&mut self, press: &str, action: &str) -> Result<(), UnknownName> {
        let Press { button, gesture } = press.parse()?;
        let nothing = action.eq_ignore_ascii_case("none");
        self.set(button, gesture, if nothing { None } else { Some(action.parse()?) });
        Ok(())
    }

    /// Whether `gesture` on `button` does anything.
    pub(super) const fn has(&self, button: Button, gesture: Gesture) -> bool {
        self.action(Press { button, gesture }).is_some()
    }
}

impl Default for KeyMap {
    /// → next photo, long → next reference, ← the photo before, ↑ next amplitude noise, ↓ next frequency noise, ENTER next effect, long ENTER hide,
    /// SPACE pause, long SPACE sleep, I information, ESC quit.
    fn default() -> Self {
        let mut keys = Self::EMPTY;
        for (button, gesture, action) in [
            (Button::Right, Gesture::Short, Action::Next),
            (Button::Right, Gesture::Long, Action::Reference),
            (Button::Left, Gesture::Short, Action::Previous),
            (Button::Up, Gesture::Short, Action::Amplitude),
            (Button::Down, Gesture::Short, Action::Frequency),
            (Button::Enter, Gesture::Short, Action::Effect),
            (Button::Enter, Gesture::Long, Action::Hide),
            (Button::Space, Gesture::Short, Action::Pause),
            (Button::Space, Gesture::Long, Action::Sleep),
            (Button::Info, Gesture::Short, Action::Information),
            (Button::Escape, Gesture::Short, Action::Quit),
        ] {
            keys.set(button, gesture, action);
        }
        keys
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_change_one_press_and_leave_the_others() {
        let mut keys = KeyMap::default();
        keys.assign("I:double", "Reload").expect("good words");
        keys.assign("esc", "none").expect("good words");
        let action = |press: &str| keys.action(press.parse().expect("a press"));
        assert_eq!(
            [action("i:double"), action("i"), action("esc")],
            [Some(Action::Reload), Some(Action::Information), None]
        );
        assert_eq!([action("space"), action("space:long")], [Some(Action::Pause), Some(Action::Sleep)]);
    }

    #[test]
    fn a_bad_word_changes_nothing_and_is_told_with_the_known_ones() {
        let mut keys = KeyMap::default();
        let mut message = |press, action| keys.assign(press, action).expect_err("a bad word").to_string();
        assert_eq!(
            message("space", "nap"),
            "unknown action; the known ones are next, previous, amplitude, frequency, effect, reference, pause, sleep, \
             hide, information, reload, quit, or none"
        );
        assert_eq!(
            message("return", "none"),
            "unknown button; the known ones are left, right, up, down, enter, space, i, esc"
        );
        assert_eq!(message("i:triple", "next"), "unknown gesture; the known ones are short, double, long");
        assert_eq!(keys, KeyMap::default());
    }

    #[test]
    fn every_action_is_known_by_its_name() {
        for action in Action::ALL {
            assert_eq!(action.name().to_uppercase().parse(), Ok(action));
        }
    }
}
