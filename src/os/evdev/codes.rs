use crate::input::Button;
use evdev::KeyCode;
use std::fmt;

/// Which keys are which buttons: what a board says of the codes that its keys send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyCodes(Vec<(KeyCode, Button)>);

impl KeyCodes {
    /// No key is a button.
    pub const EMPTY: Self = Self(Vec::new());

    /// From now on `key` is `button`, whatever it was. A key is known by its name in the kernel's input-event-codes.h
    /// (`KEY_NEXTSONG`, `BTN_0`; letters may be small or capital), or by its number (`163`, `0xa3`).
    ///
    /// # Errors
    ///
    /// [`UnknownKey`], if `key` is neither.
    pub fn assign(&mut self, key: &str, button: Button) -> Result<(), UnknownKey> {
        let code = parse(key).ok_or(UnknownKey)?;
        self.0.retain(|&(known, _)| known != code);
        self.0.push((code, button));
        Ok(())
    }

    /// The button that a key is.
    pub(super) fn button(&self, code: KeyCode) -> Option<Button> {
        self.iter().find(|&(known, _)| known == code).map(|(_, button)| button)
    }

    /// Each key that is a button.
    pub(super) fn iter(&self) -> impl Iterator<Item = (KeyCode, Button)> + '_ {
        self.0.iter().copied()
    }
}

impl Default for KeyCodes {
    /// The keys of a PC's keyboard, and those of remote controls in their place.
    fn default() -> Self {
        Self(vec![
            (KeyCode::KEY_LEFT, Button::Left),
            (KeyCode::KEY_RIGHT, Button::Right),
            (KeyCode::KEY_UP, Button::Up),
            (KeyCode::KEY_DOWN, Button::Down),
            (KeyCode::KEY_ENTER, Button::Enter),
            (KeyCode::KEY_KPENTER, Button::Enter),
            (KeyCode::KEY_OK, Button::Enter),
            (KeyCode::KEY_SELECT, Button::Enter),
            (KeyCode::KEY_SPACE, Button::Space),
            (KeyCode::KEY_I, Button::Info),
            (KeyCode::KEY_INFO, Button::Info),
            (KeyCode::KEY_ESC, Button::Escape),
        ])
    }
}

fn parse(key: &str) -> Option<KeyCode> {
    /// The kernel's KEY_MAX.
    const LAST: u16 = 0x2ff;
    let number = match key.strip_prefix("0x") {
        Some(hex) => u16::from_str_radix(hex, 16).ok(),
        None => key.parse().ok(),
    };
    match number {
        Some(number) => (number <= LAST).then_some(KeyCode(number)),
        None => key.to_ascii_uppercase().parse().ok(),
    }
}

/// A word that is no key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownKey;

impl fmt::Display for UnknownKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "unknown key; a key is a name of the kernel's, like KEY_LEFT or BTN_0, or a number from 0 to 767; \
             `evtest` shows those of a device",
        )
    }
}

impl std::error::Error for UnknownKey {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_known_by_name_and_by_number() {
        let mut codes = KeyCodes::EMPTY;
        for (key, button) in [("key_nextsong", Button::Right), ("0xa5", Button::Left), ("28", Button::Enter)]
        {
            codes.assign(key, button).expect(key);
        }
        let buttons = [KeyCode::KEY_NEXTSONG, KeyCode::KEY_PREVIOUSSONG, KeyCode::KEY_ENTER, KeyCode::KEY_A]
            .map(|code| codes.button(code));
        assert_eq!(buttons, [Some(Button::Right), Some(Button::Left), Some(Button::Enter), None]);
    }

    #[test]
    fn the_last_word_on_a_key_holds() {
        let mut codes = KeyCodes::default();
        codes.assign("KEY_SPACE", Button::Right).expect("a key");
        assert_eq!(codes.button(KeyCode::KEY_SPACE), Some(Button::Right));
        assert_eq!(codes.iter().filter(|&(code, _)| code == KeyCode::KEY_SPACE).count(), 1);
    }

    #[test]
    fn what_is_no_key_is_refused() {
        for key in ["", "LEFT", "KEY_", "768", "-1", "0x", "0x300", "65536", "KEY_LEFT "] {
            let mut codes = KeyCodes::EMPTY;
            assert_eq!(codes.assign(key, Button::Left), Err(UnknownKey), "{key:?}");
        }
    }
}
