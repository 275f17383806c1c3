//! Any text is a configuration, or mistakes of a line each; and so is a sidecar.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use yurameki::os::{config::Config, config_file, sidecar};

fuzz_target!(|text: &str| {
    let config = config_file::parse("config.toml", text).map(drop);
    let look = Config::default().plain_look();
    let sidecar = sidecar::parse(Path::new("photo.toml"), text, &look).map(drop);
    for error in [config, sidecar].into_iter().filter_map(Result::err) {
        assert!(!error.to_string().trim().is_empty());
    }
});
