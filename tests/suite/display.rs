//! The simulated panel in every geometry, its mishaps, and scripts of presses.

use proptest::prelude::*;
use yurameki::{
    display::{
        Display, DisplayError,
        fault::{Fault, seeded},
        sim::{Buffering, Sim, Spec, memory_len},
    },
    frame::{FrameMut, FrameRef, Layout, PixelFormat, Size},
    input::{Buttons as _, script::Script},
};

/// What the memory holds before anything is painted: no colour of [`paint`].
const UNTOUCHED: u8 = 0xA5;

/// Fills each pixel's bytes with values that tell their place and `salt`, all of them under [`UNTOUCHED`].
fn paint(frame: &mut FrameMut<'_>, salt: usize) {
    for y in 0..frame.layout().size.height {
        for (x, byte) in frame.row(y).iter_mut().enumerate() {
            *byte = colour(x, y, salt);
        }
    }
}

fn colour(x: usize, y: u32, salt: usize) -> u8 {
    ((x * 7 + y as usize * 13 + salt * 31) % usize::from(UNTOUCHED)) as u8
}

fn is_painted(frame: FrameRef<'_>, salt: usize) -> bool {
    let row_is_painted =
        |(y, row): (usize, &[u8])| row.iter().enumerate().all(|(x, &b)| b == colour(x, y as u32, salt));
    frame.rows().enumerate().all(row_is_painted)
}

/// Every format in sizes that are even and odd, with rows packed, padded by odd numbers and by whole rows.
fn geometries() -> impl Iterator<Item = Layout> {
    let sizes = [(1, 1), (1, 7), (33, 17), (40, 6)].map(|(width, height)| Size::new(width, height));
    PixelFormat::ALL.into_iter().flat_map(move |format| {
        sizes.into_iter().flat_map(move |size| {
            let row = size.width as usize * format.bytes_per_pixel();
            [0, 1, 3, 13, row].map(|padding| Layout::new(size, format, Some(row + padding)).expect("valid"))
        })
    })
}

#[test]
fn every_geometry_shows_what_was_painted_and_leaves_padding_alone() {
    for layout in geometries() {
        for buffering in [Buffering::Single, Buffering::Double] {
            let spare = 11;
            let mut memory = vec![UNTOUCHED; memory_len(layout, buffering) + spare];
            let mut sim = Sim::new(&mut memory[..], layout, buffering, 60_000).expect("enough memory");
            for salt in 0..3 {
                paint(&mut sim.back_buffer().expect("always there").frame, salt);
                sim.present().expect("always works");
                assert!(is_painted(sim.shown().expect("presented"), salt), "{layout:?} {buffering:?} {salt}");
            }
            let painted = memory.iter().filter(|&&byte| byte != UNTOUCHED).count();
            let buffers = memory_len(layout, buffering) / layout.len_bytes();
            let pixels = layout.row_bytes() * layout.size.height as usize * buffers;
            assert_eq!(
                painted, pixels,
                "{layout:?} {buffering:?}: every pixel byte and no other was written"
            );
        }
    }
}

#[test]
fn a_buffer_of_age_n_holds_the_frame_of_n_presents_ago() {
    let layout = Layout::new(Size::new(5, 4), PixelFormat::Rgb888, Some(17)).expect("valid");
    for buffering in [Buffering::Single, Buffering::Double] {
        let memory = vec![UNTOUCHED; memory_len(layout, buffering)];
        let mut sim = Sim::new(memory, layout, buffering, 0).expect("enough memory");
        for turn in 0..9 {
            let mut back = sim.back_buffer().expect("always there");
            match back.age as usize {
                0 => assert!(turn < 2, "{buffering:?}"),
                age => assert!(is_painted(back.frame.as_ref(), turn - age), "{buffering:?} turn {turn}"),
            }
            paint(&mut back.frame, turn);
            sim.present().expect("always works");
        }
    }
}

#[test]
fn a_loop_that_goes_on_shows_its_frames_through_a_thousand_mishaps() {
    let layouts: Vec<Layout> = geometries().collect();
    let most = layouts.iter().map(|&layout| memory_len(layout, Buffering::Double)).max().expect("some");
    for seed in 0..8 {
        let memory = vec![UNTOUCHED; most];
        let sim = Sim::new(memory, layouts[0], Buffering::Double, 60_000).expect("enough memory");
        let mut panel = Fault::new(sim, seeded(seed, &layouts));
        let (mut shown, mut lost, mut changed) = (0, 0, 0);
        let mut layout = panel.mode().layout;
        for turn in 0..17_000 {
            let now_us = panel.sim().now_us() + 16_667;
            panel.sim_mut().set_now(now_us);
            let outcome = panel.back_buffer().map(|mut back| {
                assert_eq!(back.frame.layout(), layout, "a change of layout is told before it shows");
                paint(&mut back.frame, turn);
            });
            match outcome.and_then(|()| panel.present()) {
                Ok(()) => {
                    shown += 1;
                    assert!(is_painted(panel.sim().shown().expect("presented"), turn));
                }
                Err(DisplayError::Lost) => lost += 1,
                Err(DisplayError::ModeChanged) => {
                    changed += 1;
                    layout = panel.mode().layout;
                }
                Err(DisplayError::Closed) => panic!("a panel is never closed"),
            }
        }
        assert_eq!(panel.sim().log().presents(), shown);
        assert!(panel.sim().log().dropped() > 1000, "late presents are seen as dropped frames");
        assert!(
            shown > 8_000 && lost > 1_000 && changed > 100,
            "{shown} shown, {lost} lost, {changed} changed"
        );
    }
}

#[test]
fn a_bad_script_is_refused_by_line_and_word() {
    let message = |text: &str| Script::parse(text).expect_err(text).to_string();
    assert_eq!(
        message("# fine\n3 right\n4 banana"),
        "line 3 of the script: unknown button \"banana\"; \
         the known ones are left, right, up, down, enter, space, i, esc"
    );
    assert!(message("3").starts_with("line 1 of the script: a button is missing"));
    assert!(message("right 3").starts_with("line 1 of the script: \"right\" is not a frame's number"));
    assert!(message("-3 up").contains("\"-3\" is not a frame's number"));
    assert!(message("18446744073709551616 up").contains("is not a frame's number"));
    assert!(
        message("3 up triple").contains("unknown gesture \"triple\"; the known ones are short, double, long")
    );
    assert!(message("3 up long 4").contains("\"4\" is one word too many"));
    assert!(message("\n9 up\n8 up").starts_with("line 3 of the script: frame 8 comes after frame 9"));
}

#[test]
fn a_hostile_script_is_an_error_of_one_short_line() {
    let long_line = "7".repeat(10_000_000);
    let long_word = "é".repeat(500);
    let texts = [&long_line[..], &long_word, "\0\0\0", "0 \u{202e}\u{7}", "1\u{a0}up\u{0}", "#\n🦀 up"];
    for text in texts {
        let message = Script::parse(text).expect_err("hostile").to_string();
        assert!(message.len() < 200 && !message.contains(char::is_control), "{message}");
    }
}

proptest! {
    #[test]
    fn any_text_is_a_script_or_an_error_of_one_short_line(text in "([0-9]{0,3} ?(up|I|left|\\PC{0,3})[ \n#]{0,2}|\\PC){0,6}") {
        match Script::parse(&text) {
            Ok(mut script) => {
                let presses = std::iter::from_fn(|| script.next_press(u64::MAX)).count();
                let lines = text.lines().filter(|line| line.split('#').next().is_some_and(|code| !code.trim().is_empty()));
                prop_assert_eq!(presses, lines.count(), "each line with a word is a press");
            }
            Err(error) => {
                let message = error.to_string();
                prop_assert!(message.len() < 250 && !message.contains(char::is_control), "{}", message);
            }
        }
    }

    #[test]
    fn any_text_is_a_spec_that_fits_or_an_error(text in "sim:[0-9]{1,6}x[0-9]{1,6}(:(RGB565|bgr888|\\PC{0,3})(:[0-9]{0,22})?)?") {
        if let Ok(Spec(layout)) = text.parse() {
            prop_assert_eq!(Layout::new(layout.size, layout.format, Some(layout.stride_bytes)), Ok(layout));
            prop_assert!(memory_len(layout, Buffering::Double) <= 2 * 16_384 * Spec::MAX_STRIDE_BYTES);
        }
    }
}
