//! Any text is a script that plays to its end, or an error of one line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::{
    app::State,
    input::{Buttons, script::Script},
};

fuzz_target!(|text: &str| {
    let mut script = match Script::parse(text) {
        Ok(script) => script,
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
            return;
        }
    };
    let mut state = State::default();
    for frame in (0..200).chain([u64::MAX]) {
        while let Some(button) = script.next_press(frame) {
            let _ = state.press(button);
        }
    }
    assert_eq!(script.next_press(u64::MAX), None, "every press has come");
});
