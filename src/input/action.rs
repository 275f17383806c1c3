//! What a press can do.

use super::UnknownName;
use core::{fmt, str::FromStr};

/// Something that a person can ask of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Show the next photo.
    Next,
    /// Show the photo before.
    Previous,
    /// Drive the amplitude by the next noise.
    Amplitude,
    /// Drive the frequency by the next noise.
    Frequency,
    /// Bring the photo to life by the next effect.
    Effect,
    /// Let a kaleidoscope take the colours of the next photo.
    Reference,
    /// Let the picture stand still, or move again.
    Pause,
    /// Switch the panel off, or on again.
    Sleep,
    /// Never show this photo again.
    Hide,
    /// Write the photo's name and the noises on the picture, or no longer.
    Information,
    /// Read the configuration anew, and try again what could not be shown.
    Reload,
    /// End the program.
    Quit,
}

impl Action {
    /// Every action, in the order in which they are listed to people.
    pub const ALL: [Self; 12] = [
        Self::Next,
        Self::Previous,
        Self::Amplitude,
        Self::Frequency,
        Self::Effect,
        Self::Reference,
        Self::Pause,
        Self::Sleep,
        Self::Hide,
        Self::Information,
        Self::Reload,
        Self::Quit,
    ];

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Next => "next",
            Self::Previous => "previous",
            Self::Amplitude => "amplitude",
            Self::Frequency => "frequency",
            Self::Effect => "effect",
            Self::Reference => "reference",
            Self::Pause => "pause",
            Self::Sleep => "sleep",
            Self::Hide => "hide",
            Self::Information => "information",
            Self::Reload => "reload",
            Self::Quit => "quit",
        }
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Action {
    type Err = UnknownName;

    /// The action of that name, in small or capital letters.
    fn from_str(word: &str) -> Result<Self, UnknownName> {
        let mut actions = Self::ALL.into_iter();
        actions.find(|action| action.name().eq_ignore_ascii_case(word)).ok_or(UnknownName::Action)
    }
}
