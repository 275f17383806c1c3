use crate::input::Button;

/// What a press asks for beyond the state itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
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
    /// Takes a press in.
    pub fn press(&mut self, button: Button) -> Option<Action> {
        match button {
            Button::Right => Some(Action::Ask(Request::NextPhoto)),
            Button::Left => Some(Action::Ask(Request::PreviousPhoto)),
            Button::Up => Some(Action::NextAmplitude),
            Button::Down => Some(Action::NextFrequency),
            Button::Escape => Some(Action::Ask(Request::Quit)),
            Button::Space => {
                self.paused = !self.paused;
                None
            }
            Button::Info => {
                self.information = !self.information;
                None
            }
            Button::Enter => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn space_and_information_are_switches() {
        let mut state = State::default();
        assert_eq!([Button::Space, Button::Info].map(|b| state.press(b)), [None; 2]);
        assert_eq!(state, State { paused: true, information: true });
        assert_eq!([Button::Space, Button::Info].map(|b| state.press(b)), [None; 2]);
        assert_eq!(state, State::default());
    }
}
