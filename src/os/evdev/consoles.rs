use super::held::Told;
use evdev::KeyCode;

/// Alt+F1 to Alt+F12, with or without Ctrl: another text console is asked for. While keyboards are grabbed the kernel does not see
/// these keys, so that they must be done for it.
#[derive(Debug, Default)]
pub(super) struct ConsoleKeys {
    alt: bool,
    asked: Option<u8>,
}

impl ConsoleKeys {
    /// Takes in what a keyboard tells.
    pub(super) fn take(&mut self, told: Told) {
        match told {
            Told::Key { code: KeyCode::KEY_LEFTALT, pressed, .. } => self.alt = pressed,
            Told::Key { code, pressed: true, .. } if self.alt => self.asked = console(code).or(self.asked),
            Told::Key { .. } => {}
            Told::Dropped => self.alt = false,
        }
    }

    /// The console that was asked for since the last time.
    pub(super) const fn asked(&mut self) -> Option<u8> {
        self.asked.take()
    }
}

/// The number of the console that a key stands for.
const fn console(code: KeyCode) -> Option<u8> {
    match code {
        KeyCode(code @ 59..=68) => Some((code - 58) as u8),
        KeyCode::KEY_F11 => Some(11),
        KeyCode::KEY_F12 => Some(12),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn asked(told: &[(KeyCode, bool)]) -> Option<u8> {
        let mut keys = ConsoleKeys::default();
        for &(code, pressed) in told {
            keys.take(Told::Key { code, pressed, at: Duration::ZERO });
        }
        let asked = keys.asked();
        assert_eq!(keys.asked(), None, "it is asked for once");
        asked
    }

    #[test]
    fn alt_and_a_function_key_ask_for_a_console() {
        let alt = (KeyCode::KEY_LEFTALT, true);
        let functions = [
            (KeyCode::KEY_F1, 1),
            (KeyCode::KEY_F2, 2),
            (KeyCode::KEY_F10, 10),
            (KeyCode::KEY_F11, 11),
            (KeyCode::KEY_F12, 12),
        ];
        for (code, number) in functions {
            assert_eq!(asked(&[alt, (code, true)]), Some(number));
            assert_eq!(
                asked(&[(KeyCode::KEY_LEFTCTRL, true), alt, (code, true), (code, false)]),
                Some(number)
            );
            assert_eq!(asked(&[(code, true), alt, (code, false)]), None, "the other way round");
            assert_eq!(asked(&[alt, (KeyCode::KEY_LEFTALT, false), (code, true)]), None);
        }
        assert_eq!(asked(&[alt, (KeyCode::KEY_ENTER, true)]), None);
    }

    #[test]
    fn after_dropped_events_alt_is_up() {
        let mut keys = ConsoleKeys::default();
        let key = |code| Told::Key { code, pressed: true, at: Duration::ZERO };
        for told in [key(KeyCode::KEY_LEFTALT), Told::Dropped, key(KeyCode::KEY_F3)] {
            keys.take(told);
        }
        assert_eq!(keys.asked(), None);
    }
}
