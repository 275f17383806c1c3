//! Any bytes are a clip, or an error of one line; what is one takes no more memory than its measures say, and plays.
#![no_main]

use libfuzzer_sys::fuzz_target;
use yurameki::{
    effect::{
        Effect, Moment,
        fluid::{
            Base, Clip, Fluid, View,
            clip::seal,
            code::{Extent, Planes, decode},
            storage_len,
        },
    },
    frame::{Rotation, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
};

/// Larger grids take longer than a fuzzer likes.
const MOST_PIXELS: usize = 1 << 16;
const PANEL: Size = Size::new(33, 17);

fuzz_target!(|bytes: &[u8]| {
    // Behind the checksums of the frames.
    let extents = [Extent { start: 1, end: 9 }, Extent { start: 0, end: 16 }, Extent { start: 4, end: 4 }];
    let planes = Planes { width: 16, extents: &extents, count: 2 };
    let _ = decode(&planes, bytes, &mut [0; 64], &mut [0; 96]);
    // A right checksum lets the fuzzer get behind the header's.
    let mut sealed = bytes.to_vec();
    seal(&mut sealed);
    for bytes in [bytes, &sealed] {
        let clip = match Clip::open(bytes) {
            Ok(clip) => clip,
            Err(error) => {
                let line = error.to_string();
                assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
                continue;
            }
        };
        if clip.header().shape.grid.pixels() > MOST_PIXELS {
            continue;
        }
        let storage = vec![0; storage_len(clip.header(), PANEL, Rotation::None)];
        let rgb = vec![90; PANEL.pixels() * 3];
        let base = Base { size: PANEL, rgb: &rgb, view: View::whole(PANEL) };
        let Ok(mut fluid) = Fluid::prepare(clip, base, Factor::ONE, storage) else { continue };
        for frame in 0..4 {
            let phase = Turns(frame * 99_999_999);
            let drive = Drive { amplitude: Factor::ONE, frequency: Factor::ONE, phase, onset: Factor::ONE };
            assert_eq!(fluid.at(drive).size(), PANEL);
        }
    }
});
