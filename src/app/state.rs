use crate::input::action::Action;

/// What an action comes to beyond the state itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Drive the amplitude by the next noise.
    NextAmplitude,
    /// Drive the frequency by the next noise.
    NextFrequency,
    /// What only the owner of photos and devices can do.
    Ask(Request),
}

/// What the loop asks of whoever runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Show the next photo.
    NextPhoto,
    /// Show the photo before.
    PreviousPhoto,
    /// Bring the photo to life by the next effect.
    NextEffect,
    /// Give the kaleidoscope that is shown the colours of the next photo.
    NextReference,
    /// Switch the panel off, or on again.
    Sleep,
    /// Never show this photo again.
    Hide,
    /// Read the configuration anew, and try again what could not be shown.
    Reload,
    /// End the program.
    Quit,
}

/// What the person has chosen with the buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// The picture stands still.
    pub paused: bool,
    /// The photo's name and the noises are written on the picture.
    pub information: bool,
}

impl State {
    /// Takes an action in.
    pub fn take(&mut self, action: Action) -> Option<Outcome> {
        match action {
            Action::Pause => {
                self.paused = !self.paused;
                None
            }
            Action::Information => {
                self.information = !self.information;
                None
            }
            Action::Amplitude => Some(Outcome::NextAmplitude),
            Action::Frequency => Some(Outcome::NextFrequency),
            Action::Next => Some(Outcome::Ask(Request::NextPhoto)),
            Action::Previous => Some(Outcome::Ask(Request::PreviousPhoto)),
            Action::Effect => Some(Outcome::Ask(Request::NextEffect)),
            Action::Reference => Some(Outcome::Ask(Request::NextReference)),
            Action::Sleep => Some(Outcome::Ask(Request::Sleep)),
            Action::Hide => Some(Outcome::Ask(Request::Hide)),
            Action::Reload => Some(Outcome::Ask(Request::Reload)),
            Action::Quit => Some(Outcome::Ask(Request::Quit)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_and_information_are_switches() {
        let mut state = State::default();
        assert_eq!([Action::Pause, Action::Information].map(|action| state.take(action)), [None; 2]);
        assert_eq!(state, State { paused: true, information: true });
        assert_eq!([Action::Pause, Action::Information].map(|action| state.take(action)), [None; 2]);
        assert_eq!(state, State::default());
    }

    #[test]
    fn what_is_asked_of_others_leaves_the_state_alone() {
        let mut state = State::default();
        let switches = [Action::Pause, Action::Information];
        for action in Action::ALL.into_iter().filter(|action| !switches.contains(action)) {
            assert!(state.take(action).is_some() && state == State::default(), "{action}");
        }
    }
}
