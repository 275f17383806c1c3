//! The decoder in floating point, as Fisher writes it, and what must hold for coder, decoder and file.

use super::{
    block::{Block, Fit, brightness_q10},
    file::{Checked, FileError, most_bytes, write},
    *,
};
use proptest::prelude::*;

/// W(z) of all ranges at once: z'(x) = s·D(iso(x)) + o, D the mean of four pixels.
fn contracted_once(code: &Code<'_>, z: &[f64]) -> Vec<f64> {
    let width = code.plane.width as usize;
    let mut drawn = z.to_vec();
    for &leaf in code.leaves {
        let (x, y, side) = leaf.range();
        let strides = leaf.strides(width / 2);
        let s = f64::from(leaf.contrast) / 16.0;
        let span = 255.0 * (1.0 + s.abs());
        let o = f64::from(leaf.brightness) / 127.0 * span - if s > 0.0 { 255.0 * s } else { 0.0 };
        for (u, v) in (0..side).flat_map(|v| (0..side).map(move |u| (u, v))) {
            let at = (strides.start + u as isize * strides.right + v as isize * strides.down) as usize;
            let first = at / (width / 2) * 2 * width + at % (width / 2) * 2;
            let mean = (z[first] + z[first + 1] + z[first + width] + z[first + width + 1]) / 4.0;
            drawn[(y + v) * width + x + u] = (s * mean + o).clamp(0.0, 255.0);
        }
    }
    drawn
}

/// A picture with slopes, edges and texture.
fn scene(size: Size) -> Vec<u8> {
    let plane = plane_size(size, (0, 0));
    let mut levels = vec![0; plane.pixels()];
    fill_plane(size, (0, 0), &mut levels, |i| {
        let (x, y) = (i as u32 % size.width, i as u32 / size.width);
        let disc = (i64::from(x) - 40).pow(2) + (i64::from(y) - 30).pow(2) < 500;
        let texture = if y > size.height / 2 { (((x * 7919) ^ (y * 104_729)) >> 3) & 31 } else { 0 };
        (x / 2 + y + texture + if disc { 90 } else { 0 }).min(255) as u8
    });
    levels
}

struct Coded {
    size: Size,
    levels: Vec<u8>,
    leaves: Vec<Leaf>,
}

impl Coded {
    fn new(size: Size, search: Search) -> Self {
        let (plane, levels) = (plane_size(size, (0, 0)), scene(size));
        let options = Options { search, ..Options::default() };
        let mut leaves = vec![Leaf::default(); most_leaves(plane)];
        let mut scratch = vec![0; scratch_len(plane, search)];
        let code = encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ()).unwrap();
        let count = code.leaves.len();
        leaves.truncate(count);
        Self { size, levels, leaves }
    }

    fn code(&self) -> Code<'_> {
        Code { plane: plane_size(self.size, (0, 0)), leaves: &self.leaves }
    }

    fn file(&self) -> Vec<u8> {
        let mut file = vec![0; most_bytes(self.size)];
        let length = write(&self.code(), self.size, &mut file);
        file.truncate(length);
        file
    }

    fn decoded(&self, iterations: u32, start: u8) -> Vec<u8> {
        let mut levels = vec![start; self.levels.len()];
        decode(&self.code(), iterations, &mut levels, &mut vec![0; self.levels.len() / 4]);
        levels
    }
}

fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}

const SIZE: Size = Size::new(120, 77);

#[test]
fn the_decoder_is_that_of_floating_point() {
    for &(name, search) in Search::NAMES {
        let coded = Coded::new(SIZE, search);
        let mut exact = vec![128.0; coded.levels.len()];
        for _ in 0..80 {
            exact = contracted_once(&coded.code(), &exact);
        }
        let got = coded.decoded(30, 128);
        let errors = got.iter().zip(&exact).map(|(&got, exact)| (f64::from(got) - exact).abs());
        let (sum, worst) = errors.fold((0.0, 0_f64), |(sum, worst), e| (sum + e, worst.max(e)));
        let mean = sum / got.len() as f64;
        // Every sweep rounds twice, by half a level; a contrast of 15/16 makes up to 16 times as much of it.
        assert!(mean < 0.75 && worst < 15.5, "{name}: {mean} in the mean, {worst} at the most");
    }
}

#[test]
fn the_decoder_ends_at_one_picture_from_black_from_white_and_from_grey() {
    let coded = Coded::new(SIZE, Search::Filter8);
    let settled = coded.decoded(40, 128);
    for start in [0, 255] {
        let off = mean_difference(&coded.decoded(40, start), &settled);
        assert!(off < 0.6, "from {start}: {off} levels");
    }
    assert!(mean_difference(&coded.decoded(6, 128), &settled) < 1.0);
}

#[test]
fn every_search_describes_the_picture_and_a_wider_one_describes_it_better() {
    let error = |search| {
        let coded = Coded::new(SIZE, search);
        mean_difference(&coded.decoded(12, 128), &coded.levels)
    };
    let [none, local, filter, canonical, classes] =
        [Search::None, Search::Local, Search::Filter8, Search::FilterC, Search::Classes72].map(error);
    assert!(none < 9.0 && local < none && filter < local, "none {none}, local {local}, filter8 {filter}");
    assert!(canonical < none && classes < none, "filterC {canonical}, classes72 {classes}, none {none}");
}

#[test]
fn pictures_of_any_size_are_tiled_by_their_ranges() {
    for (width, height) in [(1, 1), (1, 5_000), (5_000, 1), (16, 16), (17, 33), (250, 31)] {
        for search in [Search::None, Search::FilterC] {
            let coded = Coded::new(Size::new(width, height), search);
            let plane = coded.code().plane;
            let mut covered = vec![0; plane.pixels()];
            for leaf in &coded.leaves {
                let (x, y, side) = leaf.range();
                for row in y..y + side {
                    covered[row * plane.width as usize + x..][..side]
                        .iter_mut()
                        .for_each(|count| *count += 1);
                }
            }
            assert!(covered.iter().all(|&count| count == 1), "{width}×{height}");
            assert_eq!(coded.decoded(8, 128).len(), plane.pixels());
            let file = coded.file();
            let mut leaves = vec![Leaf::default(); coded.leaves.len()];
            assert_eq!(Checked::new(&file).unwrap().read(&mut leaves), coded.code(), "{width}×{height}");
        }
    }
}

#[test]
fn a_picture_of_one_colour_is_coded_exactly_enough() {
    for level in [0, 1, 100, 254, 255] {
        let size = Size::new(40, 40);
        let plane = plane_size(size, (0, 0));
        let levels = vec![level; plane.pixels()];
        let mut leaves = vec![Leaf::default(); most_leaves(plane)];
        let mut scratch = vec![0; scratch_len(plane, Search::Filter8)];
        let options = Options { search: Search::Filter8, ..Options::default() };
        let code = encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ()).unwrap();
        assert_eq!(code.leaves().len(), plane.pixels() / 256);
        let (mut decoded, mut contracted) = (vec![128; plane.pixels()], vec![0; plane.pixels() / 4]);
        decode(&code, 8, &mut decoded, &mut contracted);
        assert!(decoded.iter().all(|&z| z.abs_diff(level) <= 1), "{level}: {}", decoded[0]);
    }
}

#[test]
fn too_little_memory_is_refused_with_what_is_needed() {
    let plane = plane_size(SIZE, (0, 0));
    let mut leaves = vec![Leaf::default(); most_leaves(plane)];
    let needed = scratch_len(plane, Search::Classes72);
    let options = Options { search: Search::Classes72, ..Options::default() };
    let error =
        encode(&scene(SIZE), plane, &options, &mut vec![0; needed - 1], &mut leaves, |_| ()).unwrap_err();
    assert_eq!((error.needed, error.got), (needed, needed - 1));
}

#[test]
fn a_cut_file_is_refused() {
    let file = Coded::new(SIZE, Search::Local).file();
    for part in 0..50 {
        let cut = &file[..file.len() * part / 50];
        let error = Checked::new(cut).unwrap_err();
        assert!(matches!(error, FileError::Cut | FileError::NotCoded), "{part}/50: {error}");
    }
    let longer = [&file[..], &[0]].concat();
    assert_eq!(Checked::new(&longer).unwrap_err(), FileError::Longer);
}

#[test]
fn a_file_with_any_bit_flipped_is_refused() {
    let file = Coded::new(SIZE, Search::Local).file();
    for i in 0..1_000 {
        let bit = i * 7919 % (file.len() * 8);
        let mut flipped = file.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Checked::new(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn a_file_of_another_version_is_refused_by_its_number() {
    let mut file = Coded::new(SIZE, Search::None).file();
    file[3] = 2;
    assert_eq!(Checked::new(&file).unwrap_err(), FileError::Version(2));
}

/// A file whose checksum is right, whatever it claims.
fn sealed(mut file: Vec<u8>) -> Vec<u8> {
    file::seal(&mut file);
    file
}

#[test]
fn a_file_that_claims_more_than_it_holds_is_refused_before_memory_is_taken() {
    let file = Coded::new(SIZE, Search::None).file();
    for (width, height) in [(16_384_u16, 16_384_u16), (65_535, 1), (0, 5), (136, 77)] {
        let mut hostile = file.clone();
        hostile[4..6].copy_from_slice(&width.to_le_bytes());
        hostile[6..8].copy_from_slice(&height.to_le_bytes());
        // Leaves that such a picture may have.
        for leaves in [u32::MAX, 0, 40, 1_048_576 * 4] {
            hostile[8..12].copy_from_slice(&leaves.to_le_bytes());
            assert!(Checked::new(&sealed(hostile.clone())).is_err(), "{width}×{height}, {leaves}");
        }
    }
}

proptest! {
    /// Bodies of chance with a right checksum: refused, or every leaf lies within the plane, and decodes.
    #[test]
    fn a_hostile_body_is_refused_or_harmless(body in proptest::collection::vec(any::<u8>(), 4..60), leaves in 4_u32..40) {
        let mut file = b"YFC\x01".to_vec();
        file.extend([32, 0, 32, 0]);
        file.extend(leaves.to_le_bytes());
        file.extend([0; 8]);
        file.extend(body);
        if let Ok(checked) = Checked::new(&sealed(file)) {
            let mut leaves = vec![Leaf::default(); checked.leaves()];
            let code = checked.read(&mut leaves);
            let pixels = code.plane_size().pixels();
            decode(&code, 3, &mut vec![128; pixels], &mut vec![0; pixels / 4]);
        }
    }

    /// As the fuzz target `yfc`: true files, changed here and there, cut or made longer, with a right checksum.
    #[test]
    fn a_file_that_was_tampered_with_is_refused_or_harmless(
        changes in proptest::collection::vec((any::<u16>(), any::<u8>()), 0..6), header in any::<bool>(), length in 0_usize..400
    ) {
        static FILE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
        let mut file = FILE.get_or_init(|| Coded::new(Size::new(40, 36), Search::Filter8).file()).clone();
        let whole = file.len();
        for (place, byte) in changes {
            let within = if header { 20 } else { whole };
            file[usize::from(place) % within] ^= byte;
        }
        if length < whole {
            file.truncate(length.max(whole - length));
        }
        let file = sealed(file);
        if let Ok(checked) = Checked::new(&file) {
            let mut leaves = vec![Leaf::default(); checked.leaves()];
            let code = checked.read(&mut leaves);
            let pixels = code.plane_size().pixels();
            prop_assert!(pixels / 256 * 13 <= file.len() * 8);
            decode(&code, 2, &mut vec![128; pixels], &mut vec![0; pixels / 4]);
        }
    }

    #[test]
    fn a_fit_has_the_error_that_it_tells_and_no_other_brightness_has_less(
        range in proptest::collection::vec(any::<u8>(), 64), domain in proptest::collection::vec(any::<u8>(), 64)
    ) {
        let (r, d) = (Block::at(&range, 8, 0, 0, 8), Block::at(&domain, 8, 0, 0, 8));
        let fit = Fit::new(&r, &d);
        let error = |step: u8| -> f64 {
            let (s, o) = (f64::from(fit.contrast) / 16.0, f64::from(brightness_q10(fit.contrast, step)) / 1024.0);
            range.iter().zip(&domain).map(|(&r, &d)| (s * f64::from(d) + o - f64::from(r)).powi(2)).sum()
        };
        let told = fit.error as f64 / f64::from(1 << 20);
        prop_assert!((told - error(fit.brightness)).abs() < 1e-6 * told.max(1.0));
        for step in 0..=127 {
            prop_assert!(error(step) > told - 0.02 * 64.0, "{step} is better than {}", fit.brightness);
        }
    }
}
