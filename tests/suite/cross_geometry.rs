//! The same film on panels of every format, stride and shape.

use crate::stage::{Staging, Still};
use yurameki::{
    config::Life,
    display::sim::Buffering,
    effect::shimmer::Range,
    frame::{FrameRef, Layout, PixelFormat, Size},
    input::action::Action,
    noise::Kind,
};

/// What the memory holds before anything is painted.
const UNTOUCHED: u8 = 0xA5;

/// How far a colour may be from that of the XRGB8888 frame, by channel: a step of the format, and one of 8 bits for the dithering
/// of that frame.
fn tolerance(format: PixelFormat) -> [u8; 3] {
    match format {
        PixelFormat::Rgb565 | PixelFormat::Bgr565 => [9 + 1, 5 + 1, 9 + 1],
        PixelFormat::Xrgb2101010 => [1; 3],
        _ => [0; 3],
    }
}

fn life(range: Range) -> Life {
    let mut life = Life::default();
    (life.drive.amplitude, life.drive.frequency) = (Kind::White, Kind::Constant);
    life.shimmer.range = range;
    life
}

/// Information on and off, so that whole frames and moving parts are painted in turn.
const PRESSES: [(u32, Action); 2] = [(9, Action::Information), (11, Action::Information)];

const FRAMES: u32 = 20;

fn colours(frame: FrameRef<'_>) -> Vec<[u8; 3]> {
    let size = frame.layout().size;
    (0..size.height).flat_map(|y| (0..size.width).map(move |x| frame.rgb(x, y))).collect()
}

fn check(still: &Still, life: Life, frames: u32) {
    let size = still.size;
    let staging = |layout, buffering| Staging {
        life,
        frames_per_second: 12,
        seed: 9,
        layout,
        buffering,
        presses: &PRESSES,
    };
    let packed = Layout::new(size, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut want = Vec::new();
    staging(packed, Buffering::Single).show(still, frames, 0, |_, frame| want.push(colours(frame)));
    for format in PixelFormat::ALL {
        let row_bytes = size.width as usize * format.bytes_per_pixel();
        for (padding, buffering) in [
            (0, Buffering::Single),
            (1, Buffering::Double),
            (7, Buffering::Single),
            (row_bytes + 3, Buffering::Double),
        ] {
            let layout = Layout::new(size, format, Some(row_bytes + padding)).expect("a good layout");
            let memory = staging(layout, buffering).show(still, frames, UNTOUCHED, |number, frame| {
                let want = &want[number as usize];
                for (i, (got, want)) in colours(frame).iter().zip(want).enumerate() {
                    let near = |c: usize| got[c].abs_diff(want[c]) <= tolerance(format)[c];
                    assert!(
                        (0..3).all(near),
                        "{layout:?} {buffering:?}: frame {number}, pixel {i}: {got:?} for {want:?}"
                    );
                }
            });
            for buffer in memory.chunks(layout.len_bytes()) {
                for row in buffer.chunks(layout.stride_bytes) {
                    assert!(
                        row[row_bytes..].iter().all(|&byte| byte == UNTOUCHED),
                        "{layout:?}: padding painted"
                    );
                }
            }
        }
    }
}

#[test]
fn every_format_and_stride_shows_the_same_colours_and_keeps_its_padding() {
    for &(_, range) in Range::NAMES {
        check(&Still::drawn(Size::new(33, 17)).with_holes(), life(range), FRAMES);
    }
    check(&Still::drawn(Size::new(271, 101)).with_holes(), life(Range::Travelling), FRAMES);
}

#[test]
fn panels_of_a_pixel_a_column_or_a_row_show_the_same_colours() {
    for (width, height) in [(1, 1), (1, 50), (500, 1), (2, 3)] {
        for &(_, range) in Range::NAMES {
            check(&Still::drawn(Size::new(width, height)), life(range), 8);
        }
    }
}
