//! Any bytes are a photo of the panel's size, or an error of one line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::{
    frame::Size,
    os::photo::{Fit, Limits, Options, from_bytes},
};

fuzz_target!(|bytes: &[u8]| {
    let size = Size::new(33, 17);
    let fit = [Fit::Blurred, Fit::Fill, Fit::Plain][bytes.len() % 3];
    let limits = Limits { pixels: 1 << 16, bytes: 8 << 20 };
    let options = Options { fit, limits, ..Options::new(size) };
    match from_bytes("a photo", bytes, &options) {
        Ok(photo) => {
            assert!(photo.size == size && photo.rgb.len() == size.pixels() * 3);
            let (rect, inside) = (photo.picture, |start: u32, length: u32, side: u32| start + length <= side);
            assert!(inside(rect.x, rect.size.width, 33) && inside(rect.y, rect.size.height, 17));
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
        }
    }
});
