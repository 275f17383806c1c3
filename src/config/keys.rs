//! Which keys of a board are which buttons.

use crate::input::Button;
use core::{fmt, str::FromStr};
use heapless::{String, Vec};

/// A key as the kernel calls it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Key {
    /// The name of its code in the kernel's input-event-codes.h, like `KEY_RIGHT` or `BTN_0`. Whether there is such a code shows
    /// when the keys are opened.
    Name(String<32>),
    /// Its code, up to [`Key::MAX_CODE`].
    Code(u16),
}

impl Key {
    /// The kernel's KEY_MAX.
    pub const MAX_CODE: u16 = 0x2ff;
}

/// A text that is no [`Key`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAKey;

impl fmt::Display for NotAKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the name of a key is needed, like KEY_RIGHT or BTN_0, or its code, 1 to {}", Key::MAX_CODE)
    }
}

impl core::error::Error for NotAKey {}

impl FromStr for Key {
    type Err = NotAKey;

    fn from_str(text: &str) -> Result<Self, NotAKey> {
        let word = |name: &str| {
            !name.is_empty()
                && name.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit() || byte == b'_')
        };
        if text.strip_prefix("KEY_").or(text.strip_prefix("BTN_")).is_some_and(word) {
            return String::try_from(text).map(Self::Name).map_err(|_| NotAKey);
        }
        let code = text.parse().ok().filter(|code| (1..=Self::MAX_CODE).contains(code));
        code.filter(|_| !text.starts_with('+')).map(Self::Code).ok_or(NotAKey)
    }
}

/// The most keys that can be buttons.
pub const MAX_KEYS: usize = 32;

/// What a board or a person has said of keys. Those that are not said are left to the defaults of whoever reads them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Keys(Vec<(Key, Button), MAX_KEYS>);

/// There are [`MAX_KEYS`] keys already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyKeys;

impl fmt::Display for TooManyKeys {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at most {MAX_KEYS} keys can be buttons")
    }
}

impl core::error::Error for TooManyKeys {}

impl Keys {
    /// Makes `key` a button, in place of the one it was.
    pub fn set(&mut self, key: Key, button: Button) -> Result<(), TooManyKeys> {
        match self.0.iter_mut().find(|(known, _)| *known == key) {
            Some((_, old)) => *old = button,
            None => self.0.push((key, button)).map_err(|_| TooManyKeys)?,
        }
        Ok(())
    }

    /// The keys that were made buttons, in the order in which they came.
    pub fn as_slice(&self) -> &[(Key, Button)] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_a_name_or_a_code_of_the_kernel() {
        let named = |name| Ok(Key::Name(String::try_from(name).unwrap()));
        assert_eq!("KEY_RIGHT".parse(), named("KEY_RIGHT"));
        assert_eq!("BTN_0".parse(), named("BTN_0"));
        assert_eq!("767".parse(), Ok(Key::Code(767)));
        for bad in ["", "0", "768", "-1", "+1", "KEY_", "KEY_right", "RIGHT", "99999999999"] {
            assert_eq!(bad.parse::<Key>(), Err(NotAKey), "{bad}");
        }
    }

    #[test]
    fn the_later_word_on_a_key_counts_and_keys_have_an_end() {
        let mut keys = Keys::default();
        for button in [Button::Left, Button::Up] {
            assert_eq!(keys.set(Key::Code(1), button), Ok(()));
        }
        assert_eq!(keys.as_slice(), [(Key::Code(1), Button::Up)]);
        for code in 2..=MAX_KEYS as u16 {
            assert_eq!(keys.set(Key::Code(code), Button::Up), Ok(()));
        }
        assert_eq!(keys.set(Key::Code(100), Button::Up), Err(TooManyKeys));
    }
}
