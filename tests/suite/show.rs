//! A running show: what is painted only where it moves, what stays still, and what a panel's mishaps leave behind.

use crate::stage::{Staging, Still};
use yurameki::{
    app::Show,
    config::Life,
    display::{
        Display, DisplayError,
        fault::{Fault, Mishap, seeded},
        sim::{Buffering, Sim, memory_len},
    },
    effect::{
        Effect, Photo,
        shimmer::{Range, Shimmer, storage_len},
    },
    frame::{FrameRef, Layout, PixelFormat, Rotation, Size},
    input::action::Action,
    noise::Kind,
};

const FRAMES_PER_SECOND: u32 = 12;

fn ranges() -> impl Iterator<Item = Range> {
    Range::NAMES.iter().map(|&(_, range)| range)
}

/// A lively show: strong, and of noises that move at once.
fn lively(range: Range) -> Life {
    let mut life = Life::default();
    (life.drive.amplitude, life.drive.frequency) = (Kind::White, Kind::Constant);
    life.shimmer.range = range;
    life.shimmer.strength = yurameki::math::Factor::from_num(2);
    life
}

/// A panel that always asks for every pixel, with a show of its own: what an aged buffer is compared with.
struct Whole {
    show: Show,
    panel: Sim<Vec<u8>>,
}

impl Whole {
    fn new(life: Life, layout: Layout, most_bytes: usize) -> Self {
        let panel = Sim::new(vec![0; most_bytes], layout, Buffering::Single, 0).expect("enough memory");
        Self { show: Show::new(life.drive, FRAMES_PER_SECOND, 5), panel }
    }

    fn turn(&mut self, effect: &mut impl Effect) -> FrameRef<'_> {
        self.panel.forget();
        self.show.turn(effect, "a photo.jpg", &mut self.panel).expect("an untroubled panel");
        self.panel.shown().expect("presented")
    }
}

fn same(a: FrameRef<'_>, b: FrameRef<'_>) -> bool {
    a.rows().eq(b.rows())
}

/// Presses that change everything that can be changed, with time between them to settle and without.
const PRESSES: [(u32, Action); 13] = [
    (15, Action::Amplitude),
    (60, Action::Pause),
    (70, Action::Information),
    (80, Action::Information),
    (90, Action::Pause),
    (91, Action::Frequency),
    (92, Action::Amplitude),
    (140, Action::Information),
    (143, Action::Pause),
    (144, Action::Pause),
    (150, Action::Information),
    (151, Action::Information),
    (152, Action::Information),
];

#[test]
fn painting_what_moves_leaves_the_same_frame_as_painting_everything() {
    let size = Size::new(321, 90);
    let still = Still::drawn(size).with_holes();
    let moving = still.mask.iter().filter(|&&mask| mask != 0).count();
    assert!((size.pixels() / 5..size.pixels() * 4 / 5).contains(&moving), "{moving} pixels move");
    let formats = [PixelFormat::Rgb565, PixelFormat::Xrgb8888, PixelFormat::Bgr888];
    for ((range, format), rotation) in ranges().zip(formats).zip(Rotation::ALL) {
        for buffering in [Buffering::Single, Buffering::Double] {
            let life = lively(range);
            let stride_bytes = size.width as usize * format.bytes_per_pixel() + 5;
            let layout = Layout::new(size, format, Some(stride_bytes)).expect("a good layout");
            let mut storage = vec![0; storage_len(size)];
            let mut shimmer =
                Shimmer::prepare(still.photo(), &life.shimmer, &mut storage).expect("enough storage");
            let most_bytes = memory_len(layout, Buffering::Double);
            let mut whole = Whole::new(life, layout, most_bytes);
            let sim = Sim::new(vec![0xA5; most_bytes], layout, buffering, 0).expect("enough memory");
            // Forgotten between a back buffer and its present, before a back buffer, and again soon after.
            let schedule = [(201, Mishap::Forgotten), (240, Mishap::Forgotten), (242, Mishap::Forgotten)];
            let mut panel = Fault::new(sim, schedule);
            let mut show = Show::new(life.drive, FRAMES_PER_SECOND, 5);
            show.set_rotation(rotation);
            whole.show.set_rotation(rotation);
            let mut before = Vec::new();
            let mut changes = 0;
            for frame in 0..200 {
                for (_, action) in PRESSES.iter().filter(|(at, _)| *at == frame) {
                    assert_eq!((show.press(*action), whole.show.press(*action)), (None, None));
                }
                if frame == 180 {
                    show.restart();
                    whole.show.restart();
                }
                show.turn(&mut shimmer, "a photo.jpg", &mut panel).expect("no loss is on the schedule");
                let want = whole.turn(&mut shimmer);
                let got = panel.sim().shown().expect("presented");
                assert!(same(got, want), "{range} {format} {buffering:?}: frame {frame} differs");
                let rows: Vec<u8> = want.rows().flatten().copied().collect();
                changes += usize::from(rows != before);
                before = rows;
            }
            assert!(changes > 100, "{range}: the picture moved in {changes} frames only");
        }
    }
}

/// The pixels of a frame that differ from those of another, as (column, row).
fn differing(a: FrameRef<'_>, b: &[[u8; 3]]) -> Vec<(u32, u32)> {
    let Size { width, height } = a.layout().size;
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    all.zip(b).filter(|&((x, y), &before)| a.rgb(x, y) != before).map(|(at, _)| at).collect()
}

fn pixels(frame: FrameRef<'_>) -> Vec<[u8; 3]> {
    let Size { width, height } = frame.layout().size;
    (0..height).flat_map(|y| (0..width).map(move |x| frame.rgb(x, y))).collect()
}

#[test]
fn information_is_in_the_lower_left_corner_of_the_upright_picture_and_readable_in_every_format() {
    for (format, rotation) in PixelFormat::ALL.into_iter().zip(Rotation::ALL.into_iter().cycle()) {
        let upright = Size::new(400, 300);
        let size = rotation.turned(upright);
        // The worst photo for white text.
        let (rgb, mask) = (vec![255; size.pixels() * 3], vec![0; size.pixels()]);
        let layout = Layout::new(size, format, None).expect("a good layout");
        let mut storage = vec![0; storage_len(size)];
        let photo = Photo { size, rgb: &rgb, mask: &mask };
        let mut shimmer =
            Shimmer::prepare(photo, &Life::default().shimmer, &mut storage).expect("enough storage");
        let mut panel =
            Sim::new(vec![0; memory_len(layout, Buffering::Double)], layout, Buffering::Double, 0)
                .expect("enough memory");
        let mut show = Show::new(Life::default().drive, FRAMES_PER_SECOND, 5);
        show.set_rotation(rotation);
        let mut frames = |show: &mut Show, count: u32| {
            for _ in 0..count {
                show.turn(&mut shimmer, "夏の山 é.jpg\n2019-07-21 14:03", &mut panel)
                    .expect("an untroubled panel");
            }
            pixels(panel.shown().expect("presented"))
        };
        let plain = frames(&mut show, 3);
        assert_eq!(show.press(Action::Information), None);
        let written = frames(&mut show, 2);
        let (mut text, mut ground) = (0, 0);
        for (i, (&before, &after)) in plain.iter().zip(&written).enumerate().filter(|(_, (a, b))| a != b) {
            assert_eq!(before, [255; 3]);
            let (x, y) = (i as u32 % size.width, i as u32 / size.width);
            let (x, y) = match rotation {
                Rotation::None => (x, y),
                Rotation::Quarter => (y, size.width - 1 - x),
                Rotation::Half => (size.width - 1 - x, size.height - 1 - y),
                Rotation::ThreeQuarter => (size.height - 1 - y, x),
            };
            assert!(
                x < upright.width - 80 && y > upright.height / 2,
                "{format} {rotation}: column {x}, row {y}"
            );
            ground += usize::from(after.iter().all(|&level| level < 100));
            text += usize::from(after.iter().any(|&level| level > 180));
        }
        assert!(ground > 5_000 && text > 500, "{format} {rotation}: {text} pixels on {ground}");
        show.press(Action::Information);
        assert_eq!(frames(&mut show, 3), plain, "{format} {rotation}: something is left behind");
    }
}

#[test]
fn the_noises_are_plotted_for_three_seconds_after_a_press() {
    let size = Size::new(400, 200);
    let (rgb, mask) = (vec![90; size.pixels() * 3], vec![0; size.pixels()]);
    let layout = Layout::new(size, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut storage = vec![0; storage_len(size)];
    let photo = Photo { size, rgb: &rgb, mask: &mask };
    let mut shimmer =
        Shimmer::prepare(photo, &Life::default().shimmer, &mut storage).expect("enough storage");
    let mut panel = Sim::new(vec![0; memory_len(layout, Buffering::Double)], layout, Buffering::Double, 0)
        .expect("enough memory");
    let mut show = Show::new(lively(Range::Full).drive, FRAMES_PER_SECOND, 5);
    let mut written = Vec::new();
    let mut before = Vec::new();
    for frame in 0..100 {
        if frame == 30 {
            assert_eq!(show.press(Action::Frequency), None);
        }
        show.turn(&mut shimmer, "a photo.jpg", &mut panel).expect("an untroubled panel");
        let shown = panel.shown().expect("presented");
        let plain = vec![[90; 3]; size.pixels()];
        if !differing(shown, &plain).is_empty() {
            written.push(frame);
            // The plot moves: white noise drives the amplitude.
            assert!(frame == 30 || !differing(shown, &before).is_empty(), "frame {frame} is that before");
        }
        before = pixels(shown);
    }
    assert_eq!(written, (30..66).collect::<Vec<_>>());
}

#[test]
fn a_message_stands_alone_and_the_next_photo_paints_it_over() {
    let still = Still::drawn(Size::new(300, 120)).with_holes();
    let life = lively(Range::Full);
    let layout = Layout::new(still.size, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut storage = vec![0; storage_len(still.size)];
    let mut shimmer = Shimmer::prepare(still.photo(), &life.shimmer, &mut storage).expect("enough storage");
    let most_bytes = memory_len(layout, Buffering::Double);
    let mut panel = Sim::new(vec![0; most_bytes], layout, Buffering::Double, 0).expect("enough memory");
    let mut show = Show::new(life.drive, FRAMES_PER_SECOND, 5);
    for _ in 0..3 {
        show.tell("no photos yet\n/a/folder/with a name that is far too long to be shown", &mut panel)
            .expect("shown");
    }
    let told = pixels(panel.shown().expect("presented"));
    let lit = told.iter().filter(|&&rgb| rgb == [255; 3]).count();
    assert!(lit > 300 && told.iter().all(|rgb| [[0; 3], [255; 3]].contains(rgb)), "{lit} pixels of text");
    let mut whole = Whole::new(life, layout, most_bytes);
    for frame in 0..4 {
        show.turn(&mut shimmer, "", &mut panel).expect("shown");
        assert!(same(panel.shown().expect("presented"), whole.turn(&mut shimmer)), "frame {frame}");
    }
    assert_eq!(show.frame(), 4, "messages do not count");
}

#[test]
fn a_show_goes_on_through_ten_thousand_troubled_turns() {
    let sizes = [Size::new(33, 17), Size::new(48, 24), Size::new(321, 90)];
    let stills = sizes.map(|size| Still::drawn(size).with_holes());
    let layouts: Vec<Layout> = sizes
        .iter()
        .zip([PixelFormat::Rgb565, PixelFormat::Xrgb2101010, PixelFormat::Rgb888])
        .flat_map(|(&size, format)| {
            let row = size.width as usize * format.bytes_per_pixel();
            [0, 7].map(|padding| Layout::new(size, format, Some(row + padding)).expect("a good layout"))
        })
        .collect();
    let most_bytes =
        layouts.iter().map(|&layout| memory_len(layout, Buffering::Double)).max().expect("some layouts");
    let most_words = sizes.map(storage_len).into_iter().max().expect("some sizes");
    let life = lively(Range::Travelling);
    let sim = Sim::new(vec![0; most_bytes], layouts[0], Buffering::Double, 12_000).expect("enough memory");
    let mut panel = Fault::new(sim, seeded(11, &layouts));
    let mut whole = Whole::new(life, layouts[0], most_bytes);
    let mut show = Show::new(life.drive, FRAMES_PER_SECOND, 5);
    let (mut storage, mut turns, mut shown, mut recovered) = (vec![0; most_words], 0, 0, 0);
    while turns < 10_000 {
        // As the program does when the mode has changed or the panel is back.
        let layout = panel.mode().layout;
        let still = stills.iter().find(|still| still.size == layout.size).expect("a known size");
        let mut shimmer =
            Shimmer::prepare(still.photo(), &life.shimmer, &mut storage).expect("enough storage");
        whole.panel.set_layout(layout).expect("enough memory");
        show.restart();
        whole.show.restart();
        let mut lost_in_a_row = 0;
        let mut failed = false;
        while turns < 10_000 {
            turns += 1;
            if turns % 97 == 0 {
                let action = [Action::Amplitude, Action::Information, Action::Frequency, Action::Pause]
                    [turns / 97 % 4];
                assert_eq!((show.press(action), whole.show.press(action)), (None, None));
            }
            match show.turn(&mut shimmer, "a photo.jpg", &mut panel) {
                Ok(()) => {
                    let want = whole.turn(&mut shimmer);
                    let got = panel.sim().shown().expect("just presented");
                    assert_eq!(got.layout(), layout, "turn {turns}");
                    assert!(same(got, want), "turn {turns}: other pixels than on an untroubled panel");
                    recovered += usize::from(failed);
                    (failed, lost_in_a_row) = (false, 0);
                    shown += 1;
                }
                Err(DisplayError::Lost) => {
                    (failed, lost_in_a_row) = (true, lost_in_a_row + 1);
                    assert!(lost_in_a_row < 200, "turn {turns}: the panel never comes back");
                }
                Err(DisplayError::ModeChanged) => break,
                Err(DisplayError::Closed) => panic!("turn {turns}: nobody has closed it"),
            }
        }
    }
    assert_eq!(show.frame(), shown, "frames are counted when they were presented");
    assert!(shown > 5_000 && recovered > 100, "{shown} shown, {recovered} times recovered");
}

#[test]
fn what_is_still_stays_the_photo_to_the_bit_and_the_first_frame_is_the_photo() {
    let still = Still::drawn(Size::new(163, 61)).with_holes();
    let layout = Layout::new(still.size, PixelFormat::Xrgb8888, None).expect("a good layout");
    for range in ranges() {
        let staging = Staging {
            life: lively(range),
            frames_per_second: FRAMES_PER_SECOND,
            seed: 3,
            layout,
            buffering: Buffering::Double,
            presses: &[],
        };
        let mut moved = 0;
        staging.show(&still, 120, 0, |number, frame| {
            for (i, &mask) in still.mask.iter().enumerate() {
                let (x, y) = (i as u32 % still.size.width, i as u32 / still.size.width);
                let (got, photo) = (frame.rgb(x, y), still.rgb_at(x, y));
                if number == 0 || mask == 0 {
                    assert_eq!(got, photo, "{range}: frame {number}, column {x}, row {y}, mask {mask}");
                }
                moved += usize::from(got != photo);
            }
        });
        assert!(moved > 100_000, "{range}: only {moved} pixels moved in 120 frames");
    }
}

#[cfg(feature = "os")]
#[test]
fn the_mean_of_fifty_seconds_is_the_photo_within_30_db() {
    let still = Still::demo(Size::new(320, 213));
    let layout = Layout::new(still.size, PixelFormat::Xrgb8888, None).expect("a good layout");
    for range in ranges() {
        let mut life = Life::default();
        life.shimmer.range = range;
        let staging = Staging {
            life,
            frames_per_second: FRAMES_PER_SECOND,
            seed: 1,
            layout,
            buffering: Buffering::Single,
            presses: &[],
        };
        let mut sums = vec![0_u32; still.rgb.len()];
        const FRAMES: u32 = 600;
        staging.show(&still, FRAMES, 0, |_, frame| {
            let pixels = frame.rows().flat_map(|row| row.as_chunks::<4>().0);
            for (sums, &[b, g, r, _]) in sums.as_chunks_mut::<3>().0.iter_mut().zip(pixels) {
                for (sum, level) in sums.iter_mut().zip([r, g, b]) {
                    *sum += u32::from(level);
                }
            }
        });
        let squares = sums.iter().zip(&still.rgb).map(|(&sum, &level)| {
            let error = f64::from(sum) / f64::from(FRAMES) - f64::from(level);
            error * error
        });
        let mean_square = squares.sum::<f64>() / still.rgb.len() as f64;
        let decibels = 10.0 * (255.0 * 255.0 / mean_square).log10();
        eprintln!("{range}: the mean of {FRAMES} frames is {decibels:.1} dB from the photo");
        assert!(decibels >= 30.0, "{range}: {decibels:.1} dB");
    }
}
