//! A show that runs takes no memory from the heap: counted, with every button pressed on the way.
//!
//! A binary of its own, because an allocator is counted for a whole program.

use std::{
    alloc::{GlobalAlloc, Layout as Block, System},
    cell::Cell,
    hint::black_box,
};
use yurameki::{
    app::Show,
    config::Life,
    display::sim::{Buffering, Sim, memory_len},
    effect::{
        Photo,
        autumn::{self, Autumn, Species, Stage, Tree},
        fluid::{self, Base, Clip, Fluid, Kind, Shape, Tint, View},
        kaleidoscope::{self, Kaleidoscope, Mode, Moving, Reference, Still, moving_storage_len},
        shimmer::{Range, Shimmer, storage_len},
    },
    frame::{Layout, PixelFormat, Rect, Rotation, Size},
    input::action::Action,
    math::Factor,
    os::clip::{self, ClipWriter},
};

struct Counting;

thread_local! {
    /// Calls of this thread: tests run in parallel, and the test harness allocates when it likes.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    CALLS.set(CALLS.get() + 1);
}

// SAFETY: every call goes on to the system's allocator as it came; counting allocates nothing, as the cell is initialised by a
// constant and has no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, block: Block) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(block) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, block: Block) {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(memory, block) }
    }

    unsafe fn alloc_zeroed(&self, block: Block) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc_zeroed(block) }
    }

    unsafe fn realloc(&self, memory: *mut u8, block: Block, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(memory, block, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Calls of the allocator while `work` runs.
fn calls<T>(work: impl FnOnce() -> T) -> u64 {
    let before = CALLS.get();
    black_box(work());
    CALLS.get() - before
}

#[test]
fn the_counter_counts() {
    assert_eq!(calls(|| drop(black_box(vec![1_u8; 100]))), 2);
    assert_eq!(calls(|| drop(black_box(vec![0_u8; 100]))), 2);
    assert_eq!(calls(|| black_box(1) + 1), 0);
}

/// Large enough for the information to be written on it.
const SIZE: Size = Size::new(331, 97);

#[test]
fn a_prepared_photo_shows_a_thousand_frames_without_the_heap() {
    let rgb: Vec<u8> = (0..SIZE.pixels() * 3).map(|i| (i * i / 7 % 256) as u8).collect();
    // Blocks that move and blocks that do not, so that some spans are short.
    let mask: Vec<u8> = (0..SIZE.pixels()).map(|i| if i / 50 % 3 == 0 { 0 } else { 255 }).collect();
    let photo = Photo { size: SIZE, rgb: &rgb, mask: &mask };
    let mut storage = vec![0; storage_len(SIZE)];
    for range in Range::NAMES.iter().map(|&(_, range)| range) {
        for (format, buffering) in
            [(PixelFormat::Xrgb8888, Buffering::Double), (PixelFormat::Rgb565, Buffering::Single)]
        {
            let layout = Layout::new(SIZE, format, None).expect("a good layout");
            let mut memory = vec![0; memory_len(layout, buffering)];
            let mut life = Life::default();
            life.shimmer.range = range;

            let prepared = calls(|| Shimmer::prepare(photo, &life.shimmer, &mut storage).map(drop));
            assert_eq!(prepared, 0, "{range}: preparing takes the heap");

            let mut shimmer = Shimmer::prepare(photo, &life.shimmer, &mut storage).expect("enough storage");
            let mut lent = Sim::new(&mut memory[..], layout, buffering, 0).expect("enough memory");
            let mut show = Show::new(life.drive, 12, 1);
            let shown = calls(|| {
                for frame in 0..1_000_usize {
                    if frame % 9 == 8 {
                        // Every button in turn, so that all noises, the pause and the information have been on.
                        let _ = show.press(Action::ALL[frame / 9 % Action::ALL.len()]);
                    }
                    if frame % 400 == 399 {
                        show.restart();
                    }
                    assert_eq!(show.turn(&mut shimmer, "a photo.jpg", &mut lent), Ok(()));
                }
            });
            assert_eq!(shown, 0, "{range} {format}: a running show takes the heap");
            assert!(lent.log().presents() == 1_000 && show.frame() == 1_000);
        }
    }
}

#[test]
fn a_kaleidoscope_of_what_moves_is_coded_anew_in_every_frame_without_the_heap() {
    let film: Vec<Vec<u8>> = (0..4)
        .map(|frame| (0..SIZE.pixels() * 3).map(|i| (i * (i + frame * 99) / 7 % 256) as u8).collect())
        .collect();
    let still = |frame: usize| Still { size: SIZE, rgb: &film[frame % film.len()] };
    let reference = Reference { size: SIZE, rgb: &film[0] };
    let layout = Layout::new(SIZE, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut memory = vec![0; memory_len(layout, Buffering::Double)];
    let mut storage = vec![0; moving_storage_len(SIZE)];
    let settings = kaleidoscope::Settings::default();
    let prepared = calls(|| Moving::prepare(&still(0), reference, &settings, &mut storage[..]).map(drop));
    assert_eq!(prepared, 0, "preparing takes the heap");

    let mut moving =
        Moving::prepare(&still(0), reference, &settings, &mut storage[..]).expect("enough storage");
    let mut lent = Sim::new(&mut memory[..], layout, Buffering::Double, 0).expect("enough memory");
    let mut show = Show::new(Life::default().drive, 12, 1);
    let shown = calls(|| {
        for frame in 0..100 {
            moving.see(&still(frame));
            assert_eq!(show.turn(&mut moving, "a photo.jpg", &mut lent), Ok(()));
        }
    });
    assert_eq!(shown, 0, "a running show takes the heap");
}

#[test]
fn a_kaleidoscope_is_prepared_and_shows_its_frames_without_the_heap() {
    let rgb: Vec<u8> = (0..SIZE.pixels() * 3).map(|i| (i * i / 7 % 256) as u8).collect();
    let photo = Photo { size: SIZE, rgb: &rgb, mask: &[] };
    let reference = Reference { size: SIZE, rgb: &rgb };
    let layout = Layout::new(SIZE, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut memory = vec![0; memory_len(layout, Buffering::Double)];
    for &(name, mode) in Mode::NAMES {
        let settings = kaleidoscope::Settings { mode, ..Default::default() };
        let mut storage = vec![0; kaleidoscope::storage_len(SIZE, &settings)];
        let prepared =
            calls(|| Kaleidoscope::prepare(photo, reference, &settings, &mut storage[..], |_| ()).map(drop));
        assert_eq!(prepared, 0, "{name}: preparing takes the heap");

        let mut kaleidoscope = Kaleidoscope::prepare(photo, reference, &settings, &mut storage[..], |_| ())
            .expect("enough storage");
        let mut lent = Sim::new(&mut memory[..], layout, Buffering::Double, 0).expect("enough memory");
        let mut show = Show::new(Life::default().drive, 12, 1);
        let shown = calls(|| {
            for _ in 0..200 {
                assert_eq!(show.turn(&mut kaleidoscope, "a photo.jpg", &mut lent), Ok(()));
            }
        });
        assert_eq!(shown, 0, "{name}: a running show takes the heap");
    }
}

#[test]
fn an_autumn_goes_through_its_season_without_the_heap() {
    let species = Species::known("maple").expect("a known species");
    let tree = Tree { species: &species, plates: None };
    let settings = autumn::Settings::default();
    let mut storage = vec![0; autumn::storage_len(SIZE)];
    let layout = Layout::new(SIZE, PixelFormat::Xrgb8888, None).expect("a good layout");
    let mut memory = vec![0; memory_len(layout, Buffering::Double)];
    let prepared = calls(|| Autumn::prepare(SIZE, tree, &settings, &mut storage[..]).map(drop));
    assert_eq!(prepared, 0, "preparing takes the heap");

    let mut autumn = Autumn::prepare(SIZE, tree, &settings, &mut storage[..]).expect("enough storage");
    let mut lent = Sim::new(&mut memory[..], layout, Buffering::Double, 0).expect("enough memory");
    let mut show = Show::new(Life::default().drive, 12, 1);
    let shown = calls(|| {
        for frame in 0..300 {
            autumn.set_stage(Stage::GREEN.towards(Stage::BARE, frame, 300));
            assert_eq!(show.turn(&mut autumn, "maple", &mut lent), Ok(()));
        }
    });
    assert_eq!(shown, 0, "a running autumn takes the heap");
}

#[test]
fn a_clip_plays_from_its_file_without_the_heap() {
    let folder = tempfile::tempdir().expect("a folder");
    for kind in [Kind::Luma, Kind::Colour] {
        let path = folder.path().join("clip.yfl");
        let (base, grid) = (Size::new(60, 40), Size::new(30, 20));
        let shape = Shape { kind, millihertz: 25_000, step: 1, base, grid, rect: Rect::whole(base) };
        let writer = ClipWriter::create(&path, &shape, &vec![90; 7_200], &vec![255; 600], &Tint::GREY);
        let mut writer = writer.expect("a clip begins");
        for frame in 0..9 {
            let change: Vec<f32> =
                (0..shape.values()).map(|i| (i * (frame + 3) % 61) as f32 - 30.0).collect();
            writer.frame(&change).expect("a frame");
        }
        writer.finish().expect("a clip");
        let clip = clip::open(&path).expect("it opens").expect("it is a clip");
        let mut storage = vec![0; fluid::storage_len(clip.header(), SIZE, Rotation::None)];
        let rgb = vec![90; SIZE.pixels() * 3];
        let base = Base { size: SIZE, rgb: &rgb, view: View::whole(SIZE) };
        let layout = Layout::new(SIZE, PixelFormat::Xrgb8888, None).expect("a good layout");
        let mut memory = vec![0; memory_len(layout, Buffering::Double)];
        let once: Clip<_> = clip.clone();
        let prepared = calls(|| Fluid::prepare(once, base, Factor::ONE, &mut storage[..]).map(drop));
        // What is dropped is the shared handle, which is still held.
        assert_eq!(prepared, 0, "preparing takes the heap");

        let mut fluid = Fluid::prepare(clip, base, Factor::ONE, &mut storage[..]).expect("enough storage");
        let mut lent = Sim::new(&mut memory[..], layout, Buffering::Double, 0).expect("enough memory");
        let mut show = Show::new(Life::default().drive, 12, 1);
        let shown = calls(|| {
            for _ in 0..200 {
                assert_eq!(show.turn(&mut fluid, "a clip.yfl", &mut lent), Ok(()));
            }
        });
        assert_eq!(shown, 0, "a running clip takes the heap");
    }
}
