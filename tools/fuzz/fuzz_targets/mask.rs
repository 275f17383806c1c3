//! Any bytes are a mask for a photo, or an error of one line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::OnceLock;
use yurameki::{
    frame::Size,
    os::photo::{Limits, Options, Photo, from_bytes, mask_from_bytes},
};

static PHOTO: OnceLock<Photo> = OnceLock::new();

fuzz_target!(|bytes: &[u8]| {
    let photo = PHOTO.get_or_init(|| {
        let file = include_bytes!("../../../tests/data/drawn.png");
        from_bytes("drawn.png", file, &Options::new(Size::new(41, 40))).expect("a photo")
    });
    let limits = Limits { pixels: 1 << 16, bytes: 8 << 20 };
    match mask_from_bytes("a mask", bytes, photo, &limits) {
        Ok(mask) => assert_eq!(mask.len(), photo.size.pixels()),
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
        }
    }
});
