//! # Input
//!
//! Buttons, and scripts of timed presses. Knows times in frames; knows nothing else of the program.

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

/// A source of presses.
pub trait Buttons {
    /// The next press since the last call, if there is one; never waits.
    fn next_press(&mut self) -> Option<Button>;
}
