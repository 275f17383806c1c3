//! # Input
//!
//! Buttons, and scripts of timed presses. Knows times in frames; knows nothing else of the program.

pub mod script;

use core::fmt;

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
    /// Every button, in the order in which they are listed to people.
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

/// A source of presses.
pub trait Buttons {
    /// The next press since the last call, if there is one; never waits. `frame` is the number of the frame that is about to
    /// be rendered, from 0: what a script of timed presses goes by. A keyboard does not need it.
    fn next_press(&mut self, frame: u64) -> Option<Button>;
}
