//! # Input
//!
//! Buttons, the gestures that are made on them, and the actions that gestures are mapped to. A source of presses
//! ([`Buttons`]) is a keyboard, whose edges go through the gesture machine ([`gesture`]), or a script of timed presses
//! ([`script`]). Knows times; knows nothing else of the program.

pub mod action;
pub mod gesture;
pub mod key_map;
pub mod script;

use core::{fmt, str::FromStr};
use gesture::Gesture;
use key_map::KeyMap;

/// A button, by the key that stands for it on a keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Button {
    /// ←
    Left,
    /// →
    Right,
    /// ↑
    Up,
    /// ↓
    Down,
    /// ENTER
    Enter,
    /// SPACE
    Space,
    /// I
    Info,
    /// ESC
    Escape,
}

impl Button {
    /// Every button, in the order in which they are listed to people; a button `as usize` is its place here.
    pub const ALL: [Self; 8] =
        [Self::Left, Self::Right, Self::Up, Self::Down, Self::Enter, Self::Space, Self::Info, Self::Escape];

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Up => "up",
            Self::Down => "down",
            Self::Enter => "enter",
            Self::Space => "space",
            Self::Info => "i",
            Self::Escape => "esc",
        }
    }

    /// The button of that name, in small or capital letters.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|button| button.name().eq_ignore_ascii_case(name))
    }
}

impl fmt::Display for Button {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Button {
    type Err = UnknownName;

    fn from_str(word: &str) -> Result<Self, UnknownName> {
        Self::from_name(word).ok_or(UnknownName::Button)
    }
}

/// A gesture made on a button. As people write it: `space`, `space:double`, `space:long`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Press {
    /// Which button.
    pub button: Button,
    /// How it was pressed.
    pub gesture: Gesture,
}

impl fmt::Display for Press {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.gesture {
            Gesture::Short => self.button.fmt(f),
            gesture => write!(f, "{}:{gesture}", self.button),
        }
    }
}

impl FromStr for Press {
    type Err = UnknownName;

    fn from_str(word: &str) -> Result<Self, UnknownName> {
        let (button, gesture) = word.split_once(':').unwrap_or((word, Gesture::Short.name()));
        Ok(Self { button: button.trim().parse()?, gesture: gesture.trim().parse()? })
    }
}

/// A source of presses.
pub trait Buttons {
    /// The next press since the last call, if there is one; never waits. `frame` is the number of the frame that is about to
    /// be rendered, from 0: what a script of timed presses goes by. A keyboard does not need it.
    fn next_press(&mut self, frame: u64) -> Option<Press>;

    /// From now on a press has as long to become a double or a long one as `keys` has an action for it; before the first
    /// call, as the default key map has. A source that is told which gesture was made does not need it.
    fn set_keys(&mut self, _keys: KeyMap) {}
}

/// A word that names nothing, where a name of this kind belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownName {
    /// A [`Button`].
    Button,
    /// A [`Gesture`].
    Gesture,
    /// An [`Action`](action::Action).
    Action,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Button => write!(f, "unknown button; {}", Known(&Button::ALL.map(Button::name))),
            Self::Gesture => write!(f, "unknown gesture; {}", Known(&Gesture::ALL.map(Gesture::name))),
            Self::Action => {
                write!(
                    f,
                    "unknown action; {}, or none",
                    Known(&action::Action::ALL.map(action::Action::name))
                )
            }
        }
    }
}

impl core::error::Error for UnknownName {}

/// The names that would have been known.
struct Known<'a>(&'a [&'static str]);

impl fmt::Display for Known<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the known ones are ")?;
        for (i, name) in self.0.iter().enumerate() {
            write!(f, "{}{name}", if i == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_button_as_a_number_is_its_place_in_the_list() {
        for (place, button) in Button::ALL.into_iter().enumerate() {
            assert_eq!(button as usize, place);
        }
    }

    #[test]
    fn presses_are_read_as_they_are_written() {
        for press in
            Button::ALL.into_iter().flat_map(|button| Gesture::ALL.map(|gesture| Press { button, gesture }))
        {
            assert_eq!(press.to_string().parse(), Ok(press));
        }
        assert_eq!("Space:LONG".parse(), Ok(Press { button: Button::Space, gesture: Gesture::Long }));
        assert_eq!("".parse::<Press>(), Err(UnknownName::Button));
        assert_eq!("space:".parse::<Press>(), Err(UnknownName::Gesture));
    }
}
