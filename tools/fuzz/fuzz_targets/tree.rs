//! Any text is a species of tree, or an error of one line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::effect::autumn::Species;

fuzz_target!(|text: &str| {
    if let Err(error) = Species::parse(text) {
        let line = error.to_string();
        assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
    }
});
