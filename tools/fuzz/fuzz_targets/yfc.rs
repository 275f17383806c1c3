//! Any bytes are a coded picture, or an error of one line; what is one takes no more memory than its file says, and decodes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::effect::kaleidoscope::fractal::{
    Leaf, decode,
    file::{Checked, seal},
};

/// More pixels take longer than a fuzzer likes.
const MOST_PIXELS: usize = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    // A right checksum lets the fuzzer get behind it.
    let mut sealed = bytes.to_vec();
    seal(&mut sealed);
    for bytes in [bytes, &sealed] {
        match Checked::new(bytes) {
            Ok(checked) => {
                let mut leaves = vec![Leaf::default(); checked.leaves()];
                let code = checked.read(&mut leaves);
                let pixels = code.plane_size().pixels();
                // Every block of 16 x 16 takes 13 bits of the file at least.
                assert!(pixels / 256 * 13 <= bytes.len() * 8);
                if pixels <= MOST_PIXELS {
                    decode(&code, 2, &mut vec![128; pixels], &mut vec![0; pixels / 4]);
                }
            }
            Err(error) => {
                let line = error.to_string();
                assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
            }
        }
    }
});
