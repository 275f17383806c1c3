//! Any text is a script that plays to its end, or an error of one line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::{
    app::State,
    input::{Buttons, key_map::KeyMap, script::Script},
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
    let (mut state, keys) = (State::default(), KeyMap::default());
    for frame in (0..200).chain([u64::MAX]) {
        while let Some(press) = script.next_press(frame) {
            if let Some(action) = keys.action(press) {
                let _ = state.take(action);
            }
        }
    }
    assert_eq!(script.next_press(u64::MAX), None, "every press has come");
});
