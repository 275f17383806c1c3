//! Addresses and colours in floating point, as the formulas have them, and what must hold for every kaleidoscope.

use super::{
    address::{self, DEPTH, Literal, SYMBOLS, Symbols, Tones},
    fractal::{Leaf, Options, encode, fill_plane, most_leaves, plane_size, scratch_len},
    mirrors::Mirrors,
    texture::{self, SIDE, TEXELS, Texel},
    windows::Windows,
    *,
};
use crate::{
    effect::Paint,
    effect::storage::words,
    frame::{FrameMut, Layout, PixelFormat},
    math::{Factor, Turns},
};

fn drive(frame: u32, onset: Factor) -> Drive {
    let phase = Turns(frame.wrapping_mul(u32::MAX / 20));
    Drive { amplitude: Factor::ONE / 2, frequency: Factor::ONE, phase, onset }
}

/// A picture of waves.
fn waves(size: Size, speed: u32) -> Vec<u8> {
    let pixel = |i: u32| {
        let (x, y) = (i % size.width, i / size.width);
        let wave =
            |a: u32, b: u32| 128 + (Turns(((x * a + y * b) * speed) << 22).sin() * 7).to_num::<i32>() * 18;
        [wave(3, 1) as u8, wave(1, 4) as u8, wave(2, 2) as u8]
    };
    (0..size.pixels() as u32).flat_map(pixel).collect()
}

#[test]
fn an_address_is_the_itinerary_of_its_pixel() {
    let size = Size::new(90, 50);
    let plane = plane_size(size, (0, 0));
    let rgb = waves(size, 5);
    let mut levels = vec![0; plane.pixels()];
    fill_plane(size, (0, 0), &mut levels, |i| luma([rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]]));
    let options = Options { search: Search::Filter8, ..Options::default() };
    let mut leaves = vec![Leaf::default(); most_leaves(plane)];
    let mut scratch = vec![0; scratch_len(plane, options.search)];
    let code = encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ()).unwrap();
    let width = plane.width as usize;
    // δ and the leaf of every pixel.
    let mut next = vec![(0, Leaf::default()); plane.pixels()];
    for &leaf in code.leaves() {
        let (x, y, side) = leaf.range();
        let strides = leaf.strides(width / 2);
        for (u, v) in (0..side).flat_map(|v| (0..side).map(move |u| (u, v))) {
            let at = (strides.start + u as isize * strides.right + v as isize * strides.down) as usize;
            let (column, row) = (at % (width / 2), at / (width / 2));
            next[(y + v) * width + x + u] = (2 * row * width + 2 * column, leaf);
        }
    }
    let (tones, literal) = (Tones::new(&levels), Literal::new(&code));
    let tonal = |i: usize| tones.symbols[usize::from(levels[i])];
    let of_range = |i: usize| literal.symbol(next[i].1.contrast(), next[i].1.brightness());
    let symbols: [(Symbols<'_>, &dyn Fn(usize) -> u8); 2] =
        [(Symbols::Tonal(&tones), &tonal), (Symbols::Literal(&literal), &of_range)];
    for (symbols, symbol) in symbols {
        let mut addresses = vec![0; plane.pixels()];
        address::fill(&code, &symbols, &levels, &mut addresses);
        for (i, &got) in addresses.iter().enumerate() {
            let (mut at, mut want) = (i, 0);
            for _ in 0..DEPTH {
                want = want << 4 | u16::from(symbol(at));
                at = next[at].0;
            }
            assert_eq!(got, want, "pixel {i}");
        }
    }
}

#[test]
fn darker_levels_have_no_higher_symbols_and_all_symbols_are_used_where_all_levels_are() {
    let levels: Vec<u8> = (0..=255).collect();
    let tones = Tones::new(&levels);
    assert!(tones.symbols.is_sorted() && tones.levels.is_sorted());
    assert_eq!((tones.symbols[0], tones.symbols[255]), (0, 15));
    let one = Tones::new(&[77; 300]);
    assert!(one.symbols[77] < SYMBOLS as u8);
}

fn texels(reference: Reference<'_>, depth: u32) -> Vec<Texel> {
    let mut texels = vec![Texel::default(); TEXELS];
    texture::fill(reference, depth, &mut texels, &mut vec![0; texture::scratch_len()]).unwrap();
    texels
}

#[test]
fn a_texel_is_the_mean_light_around_it() {
    let size = Size::new(SIDE as u32, SIDE as u32);
    let rgb = waves(size, 31);
    let light = |code: u8| {
        let v = f64::from(code) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let coded = |v: f64| if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    for depth in 1..=DEPTH {
        let got = texels(Reference { size, rgb: &rgb }, depth);
        let reach = SIDE as isize >> (2 * depth + 1);
        let mirrored = |at: isize| match at {
            ..0 => (-1 - at) as usize,
            256.. => (511 - at) as usize,
            _ => at as usize,
        };
        for i in (0..SIDE * SIDE).step_by(4_799) {
            let (x, y) = ((i % SIDE) as isize, (i / SIDE) as isize);
            let mut sums = [0.0; 3];
            for (u, v) in (-reach..=reach).flat_map(|v| (-reach..=reach).map(move |u| (u, v))) {
                let at = 3 * (mirrored(y + v) * SIDE + mirrored(x + u));
                (0..3).for_each(|channel| sums[channel] += light(rgb[at + channel]));
            }
            let count = ((2 * reach + 1) * (2 * reach + 1)) as f64;
            for (sum, got) in sums.into_iter().zip(got[i].channels()) {
                let exact = coded(sum / count) * 255.0 * 16.0;
                assert!((exact - f64::from(got)).abs() < 4.0, "depth {depth}, texel {i}: {got} for {exact}");
            }
        }
    }
}

#[test]
fn a_colour_is_that_of_the_reference_where_the_windows_lead() {
    // A slope, of which every place is known by its colour.
    let size = Size::new(SIDE as u32, SIDE as u32);
    let rgb: Vec<u8> = (0..SIDE * SIDE).flat_map(|i| [(i % SIDE) as u8, (i / SIDE) as u8, 0]).collect();
    let texels = texels(Reference { size, rgb: &rgb }, DEPTH);
    let mut table = vec![Texel::default(); SYMBOLS.pow(DEPTH)];
    for frame in [0, 1, 30, 75, 200] {
        let mut mirrors = Mirrors::new(None);
        (0..=frame).for_each(|step| mirrors.follow(drive(step, Factor::ONE)));
        mirrors.colours(&texels, DEPTH, &mut table);
        let turns = f64::from(frame) * f64::from(u32::MAX / 20) / 2_f64.powi(32);
        let angle = turns / super::mirrors::GEAR as f64 * core::f64::consts::TAU;
        let middle = |k: usize| {
            let own = angle
                + (k as u32).wrapping_mul(2_654_435_769) as f64 / 2_f64.powi(32) * core::f64::consts::TAU;
            let reach = 0.5 * f64::from(super::mirrors::REACH) / 65_536.0;
            let [x, y] = Windows::tiles().0[k].map(|at| f64::from(at) / 65_536.0);
            [x + reach * own.cos(), y + reach * own.sin()]
        };
        let map = |k: usize, [x, y]: [f64; 2]| {
            let (x, y, [mx, my]) = (x - 0.5, y - 0.5, middle(k));
            [mx + (x * angle.cos() - y * angle.sin()) / 4.0, my + (x * angle.sin() + y * angle.cos()) / 4.0]
        };
        for (address, texel) in table.iter().enumerate() {
            let place = map(address >> 8, map(address >> 4 & 15, map(address & 15, [0.5, 0.5])));
            for (at, got) in place.into_iter().zip(texel.channels()) {
                let folded = {
                    let at = at.rem_euclid(2.0);
                    if at < 1.0 { at } else { 2.0 - at }
                };
                let want = (folded * 256.0).min(255.0) * 16.0;
                // Darks are curved, and within three texels of an edge the mean is of mirror images too.
                if (64.0..4_032.0).contains(&want) {
                    let off = (want - f64::from(got)).abs();
                    assert!(off < 24.0, "frame {frame}, address {address:03x}: {got} for {want}");
                }
            }
        }
    }
}

struct Shown {
    size: Size,
    rgb: Vec<u8>,
    kaleidoscope: Kaleidoscope<Vec<u64>>,
}

impl Shown {
    fn new(size: Size, rgb: Vec<u8>, reference: Reference<'_>, mode: Mode) -> Self {
        let settings = Settings { mode, ..Settings::default() };
        let mask = vec![0; size.pixels()];
        let photo = Photo { size, rgb: &rgb, mask: &mask };
        let storage = vec![0; storage_len(size, &settings)];
        let kaleidoscope = Kaleidoscope::prepare(photo, reference, &settings, storage, |_| ()).unwrap();
        Self { size, rgb, kaleidoscope }
    }

    fn frame(&mut self, drive: Drive) -> Vec<u8> {
        let layout = Layout::new(self.size, PixelFormat::Bgr888, None).unwrap();
        let mut bytes = vec![0; layout.len_bytes()];
        self.kaleidoscope.render(drive, Paint::Everything, &mut FrameMut::new(&mut bytes, layout).unwrap());
        bytes
    }
}

const SIZE: Size = Size::new(150, 83);

#[test]
fn it_begins_with_the_photo_itself_and_comes_from_the_reference_at_last() {
    let red: Vec<u8> = [200, 30, 10].repeat(64 * 40);
    for &(name, mode) in Mode::NAMES {
        let reference = Reference { size: Size::new(64, 40), rgb: &red };
        let mut shown = Shown::new(SIZE, waves(SIZE, 3), reference, mode);
        assert_eq!(shown.frame(drive(0, Factor::ZERO)), shown.rgb, "{name}");
        let frame = shown.frame(drive(1, Factor::ONE));
        // Toned towards black or white, red stays the largest channel.
        assert!(frame.as_chunks::<3>().0.iter().all(|[r, g, b]| r >= g && g >= b), "{name}");
    }
}

#[test]
fn a_halted_drive_is_a_picture_that_stands_still() {
    let other = waves(Size::new(90, 90), 11);
    let reference = Reference { size: Size::new(90, 90), rgb: &other };
    let mut shown = Shown::new(SIZE, waves(SIZE, 3), reference, Mode::Tonal);
    (0..17).for_each(|frame| drop(shown.frame(drive(frame, Factor::ONE))));
    let halted = shown.frame(drive(17, Factor::ONE));
    assert!((0..30).all(|_| shown.frame(drive(17, Factor::ONE)) == halted));
}

#[test]
fn no_frame_pops_while_the_mirrors_turn_and_windows_are_chosen_anew() {
    let other = waves(Size::new(90, 90), 11);
    let reference = Reference { size: Size::new(90, 90), rgb: &other };
    for &(name, mode) in Mode::NAMES {
        let mut shown = Shown::new(SIZE, waves(SIZE, 3), reference, mode);
        let mut before = shown.frame(drive(0, Factor::ONE));
        let mut still = true;
        for i in 1..90 {
            let frame = shown.frame(drive(i, Factor::ONE));
            let change: u64 = frame.iter().zip(&before).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
            assert!(change <= 7 * frame.len() as u64, "{name}, frame {i}: {}", change / frame.len() as u64);
            still &= change == 0;
            before = frame;
        }
        assert!(!still, "{name} does not move");
    }
}

#[test]
fn photos_of_any_size_and_of_one_colour_and_their_own_reference_work() {
    for (width, height) in [(1, 1), (1, 5_000), (17, 3), (64, 48)] {
        let size = Size::new(width, height);
        for rgb in [waves(size, 9), [90, 90, 90].repeat(size.pixels()), [0; 3].repeat(size.pixels())] {
            for &(_, mode) in Mode::NAMES {
                let own = rgb.clone();
                let mut shown = Shown::new(size, rgb.clone(), Reference { size, rgb: &own }, mode);
                assert_eq!(shown.frame(drive(0, Factor::ONE)).len(), own.len());
                let (one, two) = (shown.frame(drive(1, Factor::ONE)), shown.frame(drive(2, Factor::ONE)));
                assert_eq!(one.len(), two.len());
            }
        }
    }
}

#[test]
fn progress_goes_from_nothing_to_all() {
    let settings = Settings::default();
    let (rgb, mut told) = (waves(SIZE, 7), vec![0]);
    let photo = Photo { size: SIZE, rgb: &rgb, mask: &[] };
    let storage = vec![0; storage_len(SIZE, &settings)];
    let reference = Reference { size: SIZE, rgb: &rgb };
    Kaleidoscope::prepare(photo, reference, &settings, storage, |percent| told.push(percent)).unwrap();
    assert!(told.is_sorted() && told.last() == Some(&100) && told.len() > 20, "{told:?}");
}

#[test]
fn too_little_storage_is_refused_with_what_is_needed() {
    let settings = Settings::default();
    let rgb = waves(SIZE, 1);
    let photo = Photo { size: SIZE, rgb: &rgb, mask: &[] };
    let needed = storage_len(SIZE, &settings);
    let mut storage = vec![0; needed - 1];
    let reference = Reference { size: SIZE, rgb: &rgb };
    let error = Kaleidoscope::prepare(photo, reference, &settings, &mut storage[..], |_| ()).unwrap_err();
    assert_eq!(error, StorageTooSmall { needed, got: needed - 1 });
    assert!(needed > words::<u16>(SIZE.pixels() * 4));
}
