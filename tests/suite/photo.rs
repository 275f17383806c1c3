//! From a file to the pixels of the panel.

use image::{
    ExtendedColorType, ImageEncoder,
    codecs::{jpeg::JpegEncoder, png::PngEncoder},
};
use moxcms::{ColorProfile, Layout, TransformOptions};
use std::{
    error::Error,
    fs,
    os::unix::fs::{PermissionsExt, symlink},
    path::{Path, PathBuf},
};
use yurameki::{
    frame::{Rect, Size},
    os::photo::{
        Fault, Fit, Limits, Options, Photo, PhotoError, from_bytes, list, load, load_mask, mask_from_bytes,
        mask_path,
    },
};

/// The size of the drawn pictures.
const DRAWN: Size = Size::new(48, 32);

const JPEGS: [&str; 3] = ["drawn.jpg", "progressive.jpg", "grey.jpg"];
const OTHERS: [&str; 7] =
    ["drawn.png", "sixteen.png", "alpha.png", "drawn.bmp", "drawn.tif", "lossless.webp", "lossy.webp"];
const ANIMATED: [&str; 2] = ["animated.gif", "animated.webp"];

fn at(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    fs::read(at(name)).unwrap()
}

/// The drawn picture as another reader gives it.
fn drawn() -> image::RgbImage {
    image::open(at("drawn.png")).unwrap().to_rgb8()
}

fn fault(name: &str, bytes: &[u8], options: &Options) -> Fault {
    let error = from_bytes(name, bytes, options).unwrap_err();
    check_line(&error, name);
    error.fault
}

/// A message is one line, names the file first and ends with a cure.
fn check_line(error: &PhotoError, name: &str) {
    let line = error.to_string();
    assert!(line.starts_with(&format!("{name}: ")), "{line}");
    assert!(!line.contains('\n') && line.matches(": ").count() >= 2, "{line}");
}

/// Limits under which even a wild header costs little.
fn tight(size: Size) -> Options {
    Options { limits: Limits { pixels: 1_000_000, bytes: 16 << 20 }, ..Options::new(size) }
}

fn worst(a: &[u8], b: &[u8]) -> u8 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

fn mean_error(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}

fn png(rgb: &[u8], size: Size, colour: ExtendedColorType, icc: Option<Vec<u8>>) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = PngEncoder::new(&mut file);
    if let Some(icc) = icc {
        encoder.set_icc_profile(icc).unwrap();
    }
    encoder.write_image(rgb, size.width, size.height, colour).unwrap();
    file
}

/// The CRC of PNG chunks.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}

/// A PNG whose header claims another size.
fn claim(mut png: Vec<u8>, size: Size) -> Vec<u8> {
    png[16..20].copy_from_slice(&size.width.to_be_bytes());
    png[20..24].copy_from_slice(&size.height.to_be_bytes());
    let sum = crc(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    png
}

#[test]
fn an_unscaled_lossless_photo_comes_through_to_the_last_bit() {
    for name in ["drawn.png", "sixteen.png", "drawn.bmp", "drawn.tif", "lossless.webp", "animated.webp"] {
        let photo = load(&at(name), &Options::new(DRAWN)).unwrap();
        assert_eq!(photo.picture, Rect { x: 0, y: 0, size: DRAWN });
        assert!(photo.rgb == drawn().into_raw(), "{name}");
    }
}

#[test]
fn every_format_shows_the_picture_and_of_animations_the_first_frame() {
    let colour = drawn();
    let grey: Vec<u8> = image::open(at("grey.png")).unwrap().to_rgb8().into_raw();
    let formats = [("drawn.jpg", 3.0), ("progressive.jpg", 9.0), ("lossy.webp", 12.0), ("animated.gif", 6.0)];
    for (name, most) in formats {
        let error = mean_error(&load(&at(name), &Options::new(DRAWN)).unwrap().rgb, &colour);
        assert!(error < most, "{name}: {error}");
    }
    for (name, most) in [("grey.png", 0.0), ("grey.jpg", 4.0)] {
        let error = mean_error(&load(&at(name), &Options::new(DRAWN)).unwrap().rgb, &grey);
        assert!(error <= most, "{name}: {error}");
    }
}

#[test]
fn all_eight_exif_orientations_are_applied() {
    let mut file = bytes("drawn.jpg");
    for value in 1..=8 {
        file[49] = value;
        let mut want = image::load_from_memory(&file).unwrap();
        want.apply_orientation(image::metadata::Orientation::from_exif(value).unwrap());
        let size = Size::new(want.width(), want.height());
        let photo = from_bytes("turned", &file, &Options::new(size)).unwrap();
        assert_eq!(photo.source_size, size);
        assert!(photo.rgb == want.to_rgb8().into_raw(), "orientation {value}");
    }
}

/// A JPEG of smooth waves, of which a shrinking while it is decoded loses nothing.
fn waves(size: Size) -> Vec<u8> {
    let wave = |x: u32, y: u32, step: u32| {
        let turns = f64::from(x) / f64::from(size.width) * 3.0 + f64::from(y * step) / f64::from(size.height);
        (127.5 + 100.0 * (turns * std::f64::consts::TAU).sin()) as u8
    };
    let picture = image::RgbImage::from_fn(size.width, size.height, |x, y| {
        image::Rgb([1, 2, 3].map(|c| wave(x, y, c)))
    });
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, 95).encode_image(&picture).unwrap();
    file
}

#[test]
fn a_jpeg_that_is_shrunk_while_it_is_decoded_shows_the_same_picture() {
    let source = Size::new(1000, 680);
    let jpeg = waves(source);
    let png = png(&image::load_from_memory(&jpeg).unwrap().to_rgb8(), source, ExtendedColorType::Rgb8, None);
    for fit in Fit::ALL {
        for size in [Size::new(500, 340), Size::new(240, 160), Size::new(100, 60), Size::new(60, 200)] {
            let options = Options { fit, ..Options::new(size) };
            let [shrunk, whole] = [&jpeg, &png].map(|file| from_bytes("waves", file, &options).unwrap());
            assert_eq!((shrunk.source_size, shrunk.picture), (source, whole.picture));
            let error = mean_error(&shrunk.rgb, &whole.rgb);
            assert!(error < 1.0, "{fit} {size}: {error}");
        }
    }
}

#[test]
fn a_jpeg_that_is_shrunk_while_it_is_decoded_takes_little_memory() {
    let size = Size::new(4000, 3000);
    let jpeg = waves(size);
    let limits = Limits { bytes: 12 << 20, ..Limits::default() };
    assert!(matches!(
        fault("whole", &jpeg, &Options { limits, ..Options::new(size) }),
        Fault::TooMuchMemory { .. }
    ));
    let photo =
        from_bytes("shrunk", &jpeg, &Options { limits, ..Options::new(Size::new(800, 600)) }).unwrap();
    assert_eq!(photo.source_size, size);
}

#[test]
fn a_name_that_lies_about_the_format_does_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("really_a_png.jpg");
    fs::copy(at("drawn.png"), &path).unwrap();
    assert!(load(&path, &Options::new(DRAWN)).unwrap().rgb == drawn().into_raw());
}

/// The drawn picture with its codes meant in `profile`, and what moxcms itself makes of it.
fn with_profile(profile: &ColorProfile) -> (Photo, Vec<u8>) {
    let codes = drawn().into_raw();
    let mut want = vec![0; codes.len()];
    let srgb = ColorProfile::new_srgb();
    let transform =
        profile.create_transform_8bit(Layout::Rgb, &srgb, Layout::Rgb, TransformOptions::default()).unwrap();
    transform.transform(&codes, &mut want).unwrap();
    let file = png(&codes, DRAWN, ExtendedColorType::Rgb8, Some(profile.encode().unwrap()));
    (from_bytes("profiled", &file, &Options::new(DRAWN)).unwrap(), want)
}

#[test]
fn rgb_profiles_are_converted_to_srgb() {
    let profiles = [
        ColorProfile::new_display_p3(),
        ColorProfile::new_adobe_rgb(),
        ColorProfile::new_pro_photo_rgb(),
        ColorProfile::new_bt2020(),
    ];
    for profile in profiles {
        let (photo, want) = with_profile(&profile);
        let name = format!("{:?}", profile.description);
        assert!(mean_error(&photo.rgb, &want) < 0.5, "{name}: {}", mean_error(&photo.rgb, &want));
        assert!(worst(&photo.rgb, &want) <= 2, "{name}: {}", worst(&photo.rgb, &want));
        assert!(mean_error(&photo.rgb, &drawn()) > 3.0, "{name} changes nothing");
    }
}

#[test]
fn greys_stay_grey_under_a_profile() {
    let codes: Vec<u8> = (0..=255).flat_map(|code| [code; 3]).collect();
    let size = Size::new(256, 1);
    for profile in [ColorProfile::new_display_p3(), ColorProfile::new_adobe_rgb()] {
        let file = png(&codes, size, ExtendedColorType::Rgb8, Some(profile.encode().unwrap()));
        let rgb = from_bytes("greys", &file, &Options::new(size)).unwrap().rgb;
        assert!(rgb.chunks_exact(3).all(|p| p[0] == p[1] && p[1] == p[2]));
        assert_eq!((rgb[0], rgb[767]), (0, 255));
    }
}

#[test]
fn an_srgb_profile_changes_nothing() {
    let (photo, _) = with_profile(&ColorProfile::new_srgb());
    assert!(photo.rgb == drawn().into_raw());
}

#[test]
fn a_grey_profile_is_converted() {
    let codes: Vec<u8> = (0..=255).collect();
    let profile = ColorProfile::new_gray_with_gamma(1.0);
    let size = Size::new(256, 1);
    let file = png(&codes, size, ExtendedColorType::L8, Some(profile.encode().unwrap()));
    let rgb = from_bytes("linear", &file, &Options::new(size)).unwrap().rgb;
    // Half of the light is code 188 of sRGB.
    assert_eq!((rgb[0], rgb[3 * 128], rgb[3 * 255]), (0, 188, 255));
}

#[test]
fn a_broken_or_misfitting_profile_is_ignored() {
    let codes = drawn().into_raw();
    let mut cut = ColorProfile::new_display_p3().encode().unwrap();
    cut.truncate(200);
    for icc in [vec![7; 300], cut, ColorProfile::new_gray_with_gamma(2.2).encode().unwrap()] {
        let file = png(&codes, DRAWN, ExtendedColorType::Rgb8, Some(icc));
        assert!(from_bytes("broken profile", &file, &Options::new(DRAWN)).unwrap().rgb == codes);
    }
}

#[test]
fn transparency_shows_the_background_in_linear_light() {
    let options = Options { background: [255, 255, 255], ..Options::new(DRAWN) };
    let rgb = load(&at("alpha.png"), &options).unwrap().rgb;
    let opaque = drawn().into_raw();
    let row = |y: usize| y * 3 * 48;
    for y in 0..32 {
        assert_eq!(rgb[row(y)..][..3], [255; 3]);
        assert_eq!(rgb[row(y) + 3 * 47..][..3], opaque[row(y) + 3 * 47..][..3]);
    }
    // Half black over white is half of the light.
    let file = png(&[0, 0, 0, 128], Size::new(1, 1), ExtendedColorType::Rgba8, None);
    let one = Options { size: Size::new(1, 1), ..options };
    assert_eq!(from_bytes("half", &file, &one).unwrap().rgb, [187; 3]);
}

#[test]
fn a_fine_checkerboard_keeps_its_light_when_shrunk() {
    let size = Size::new(64, 64);
    let codes: Vec<u8> = (0..64 * 64).map(|i| if (i / 64 + i) % 2 == 0 { 0 } else { 255 }).collect();
    let file = png(&codes, size, ExtendedColorType::L8, None);
    let rgb = from_bytes("board", &file, &Options::new(Size::new(8, 8))).unwrap().rgb;
    // The middle: at the edges the repeated edge pixels weigh in.
    assert_eq!(rgb[3 * (8 * 4 + 4)], 188);
}

#[test]
fn each_fit_puts_the_photo_where_it_says() {
    let size = Size::new(96, 40);
    let load =
        |fit| load(&at("drawn.png"), &Options { fit, background: [9, 8, 7], ..Options::new(size) }).unwrap();
    let (plain, blurred, fill) = (load(Fit::Plain), load(Fit::Blurred), load(Fit::Fill));
    let picture = Rect { x: 18, y: 0, size: Size::new(60, 40) };
    assert_eq!((plain.picture, blurred.picture), (picture, picture));
    assert_eq!(fill.picture, Rect { x: 0, y: 0, size });
    for y in 0..40 {
        let row = 3 * 96 * y;
        let photo = row + 3 * 18..row + 3 * 78;
        assert_eq!(plain.rgb[photo.clone()], blurred.rgb[photo]);
        assert_eq!(plain.rgb[row..row + 3], [9, 8, 7]);
        assert_eq!(plain.rgb[row + 3 * 78..][..3], [9, 8, 7]);
    }
    let light = |rgb: &[u8]| rgb.iter().map(|&v| u64::from(v)).sum::<u64>() / rgb.len() as u64;
    let border: Vec<u8> = blurred.rgb.chunks(3 * 96).flat_map(|row| row[..3 * 18].to_vec()).collect();
    assert!(border.iter().any(|&v| v > 20), "the border is not black");
    assert!(light(&border) < light(&fill.rgb), "the border is darker than the photo");
}

#[test]
fn a_flat_photo_stays_flat_at_every_size() {
    let codes = [200, 100, 50].repeat(35 * 21);
    let file = png(&codes, Size::new(35, 21), ExtendedColorType::Rgb8, None);
    for size in [Size::new(7, 3), Size::new(100, 60), Size::new(1, 1), Size::new(640, 7)] {
        let options = Options { fit: Fit::Fill, ..Options::new(size) };
        let photo = from_bytes("flat", &file, &options).unwrap();
        assert!(photo.rgb.chunks_exact(3).all(|p| p == [200, 100, 50]), "{size}");
    }
}

#[test]
fn a_cut_photo_is_refused_by_name() {
    for name in JPEGS.into_iter().chain(OTHERS) {
        let whole = bytes(name);
        for part in 0..50 {
            let cut = &whole[..whole.len() * part / 50];
            let fault = fault(name, cut, &tight(DRAWN));
            assert_eq!(matches!(fault, Fault::Empty), part == 0, "{name} at {part}/50: {fault}");
        }
    }
    for name in ANIMATED {
        let whole = bytes(name);
        for part in 0..50 {
            // What is cut off may be the second frame only.
            if let Err(error) = from_bytes(name, &whole[..whole.len() * part / 50], &tight(DRAWN)) {
                check_line(&error, name);
            }
        }
    }
}

#[test]
fn a_photo_with_a_flipped_bit_is_a_picture_or_a_clear_error() {
    for name in JPEGS.into_iter().chain(OTHERS).chain(ANIMATED) {
        let whole = bytes(name);
        for i in 0..1_000_usize {
            // 7,919 is prime: the flips are spread over the whole file.
            let bit = i * 7_919 % (8 * whole.len());
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            match from_bytes(name, &flipped, &tight(DRAWN)) {
                Ok(photo) => assert_eq!(photo.rgb.len(), 3 * DRAWN.pixels()),
                Err(error) => check_line(&error, name),
            }
        }
    }
}

#[test]
fn a_huge_header_is_refused_before_memory_is_taken() {
    let options = Options::new(DRAWN);
    let huge = claim(bytes("drawn.png"), Size::new(30_000, 30_000));
    assert!(matches!(fault("huge", &huge, &options), Fault::TooManyPixels { .. }));
    let long = claim(bytes("drawn.png"), Size::new(70_000, 10));
    assert!(matches!(fault("long", &long, &options), Fault::SideTooLong(_)));
    let empty = claim(bytes("drawn.png"), Size::new(0, 10));
    fault("no pixels", &empty, &options);
    let large = claim(bytes("drawn.png"), Size::new(9_000, 9_000));
    let little = Options { limits: Limits { bytes: 16 << 20, ..Limits::default() }, ..options };
    assert!(matches!(fault("large", &large, &little), Fault::TooMuchMemory { .. }));
}

#[test]
fn a_zip_bomb_is_refused_or_cut_off() {
    let size = Size::new(2_000, 2_000);
    let bomb = png(&vec![0; size.pixels()], size, ExtendedColorType::L8, None);
    let options = tight(DRAWN);
    assert!(matches!(fault("bomb", &bomb, &options), Fault::TooManyPixels { .. }));
    if let Ok(photo) = from_bytes("small bomb", &claim(bomb, Size::new(8, 8)), &options) {
        assert_eq!(photo.source_size, Size::new(8, 8));
    }
}

#[test]
fn what_is_no_supported_picture_is_named() {
    let named = |bytes: &[u8]| fault("x", bytes, &Options::new(DRAWN)).to_string();
    for (magic, name) in [
        (&b"\0\0\0\x18ftypheic\0\0\0\0"[..], "HEIC"),
        (b"\0\0\0\x18ftypheix\0\0\0\0mif1heix", "HEIC"),
        (b"\0\0\0\x18ftypmif1\0\0\0\0mif1heic", "HEIC"),
        (b"\0\0\0\x18ftypmif1\0\0\0\0mif1avif", "AVIF"),
        (b"\0\0\0\x14ftypmif1\0\0\0\0mif1avif", "HEIF"),
        (b"\0\0\0\x18ftypavif\0\0\0\0", "AVIF"),
        (b"\0\0\0\x18ftypisom\0\0\0\0mp41avc1", "video"),
        (b"\0\0\0\x18ftypcrx \0\0\0\0", "camera RAW"),
        #[cfg(not(feature = "jxl"))]
        (b"\xff\x0a\0\0", "JPEG XL"),
        #[cfg(not(feature = "jxl"))]
        (b"\0\0\0\x0cJXL \r\n\x87\n", "JPEG XL"),
        (b"II*\0\x10\0\0\0CR\x02\0", "camera RAW"),
        (b"II*\0\x08\0\0\0\x01\0\xfe\0\x04\0\x01\0\0\0\x01\0\0\0", "camera RAW"),
        (b"FUJIFILMCCD-RAW 0201", "camera RAW"),
    ] {
        assert_eq!(named(magic), format!("{name} is not supported: convert it to JPEG"));
    }
    assert!(named(b"Dear diary, no picture here").starts_with("is not a picture"));
    assert!(named(b"").starts_with("is empty"));
}

#[cfg(feature = "jxl")]
#[test]
fn a_jpeg_xl_shows_the_picture_and_a_cut_or_too_large_one_is_refused() {
    let bytes = bytes("drawn.jxl");
    let options = tight(DRAWN);
    let photo = from_bytes("x", &bytes, &options).expect("a good file");
    assert_eq!(photo.source_size, DRAWN);
    assert!(mean_error(&photo.rgb, drawn().as_raw()) < 6.0);
    assert!(matches!(fault("cut", &bytes[..bytes.len() * 2 / 3], &options), Fault::Cut | Fault::Broken));
    let tiny = Options { limits: Limits { bytes: 1000, ..options.limits }, ..options };
    assert!(matches!(fault("large", &bytes, &tiny), Fault::TooMuchMemory { .. }));
}

#[test]
fn only_regular_files_are_opened_and_nothing_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let refused = |name: &str| {
        let error = load(&path(name), &Options::new(DRAWN)).unwrap_err();
        check_line(&error, &path(name).to_string_lossy());
        error
    };
    fs::create_dir(path("x.jpg")).unwrap();
    assert!(matches!(refused("x.jpg").fault, Fault::NotAFile("a folder")));
    let mode = rustix::fs::Mode::from_raw_mode(0o644);
    rustix::fs::mknodat(rustix::fs::CWD, path("fifo.jpg"), rustix::fs::FileType::Fifo, mode, 0).unwrap();
    assert!(matches!(refused("fifo.jpg").fault, Fault::NotAFile("a FIFO")));
    symlink(path("b.jpg"), path("a.jpg")).unwrap();
    symlink(path("a.jpg"), path("b.jpg")).unwrap();
    let looped = refused("a.jpg");
    assert!(matches!(looped.fault, Fault::LinkLoop(_)) && looped.source().is_some());
    assert!(matches!(refused("missing.jpg").fault, Fault::Missing));
    fs::write(path("._drawn.jpg"), b"\0\x05\x16\x07\0\x02\0\0Mac OS X").unwrap();
    assert!(matches!(refused("._drawn.jpg").fault, Fault::NotAPicture));
    let device = load(Path::new("/dev/zero"), &Options::new(DRAWN)).unwrap_err();
    assert!(matches!(device.fault, Fault::NotAFile("a device")));
}

#[test]
fn a_photo_that_may_not_be_read_is_refused_by_name() {
    if rustix::process::geteuid().is_root() {
        eprintln!("skipped: root may read everything");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("secret.jpg");
    fs::copy(at("drawn.jpg"), &path).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o0)).unwrap();
    let error = load(&path, &Options::new(DRAWN)).unwrap_err();
    assert!(matches!(error.fault, Fault::Forbidden(_)));
}

#[test]
fn a_file_over_the_limit_is_not_read() {
    let options = Options { limits: Limits { bytes: 100, ..Limits::default() }, ..Options::new(DRAWN) };
    let error = load(&at("drawn.bmp"), &options).unwrap_err();
    assert!(matches!(error.fault, Fault::TooMuchMemory { needed: 4662, limit: 100 }));
}

#[test]
fn an_impossible_panel_is_refused() {
    for size in [Size::new(0, 5), Size::new(5, 0), Size::new(16_385, 5)] {
        assert!(matches!(fault("x", &bytes("drawn.png"), &Options::new(size)), Fault::PanelSize(_)));
    }
}

#[test]
fn a_name_with_a_line_break_stays_one_line() {
    let error = from_bytes("a\nb.jpg", b"", &Options::new(DRAWN)).unwrap_err();
    assert!(!error.to_string().contains('\n'));
}

#[test]
fn a_mask_of_the_photos_size_is_taken_as_it_is_and_the_border_is_still() {
    let photo = load(&at("drawn.png"), &Options::new(Size::new(96, 32))).unwrap();
    let grey = image::open(at("grey.png")).unwrap().to_luma8().into_raw();
    let mask = load_mask(&at("grey.png"), &photo, &Limits::default()).unwrap();
    assert_eq!(mask.len(), 96 * 32);
    for (row, want) in mask.chunks(96).zip(grey.chunks(48)) {
        assert_eq!(row[24..72], *want);
        assert!(row[..24].iter().chain(&row[72..]).all(|&v| v == 0));
    }
}

#[test]
fn a_mask_of_another_size_is_stretched_over_the_photo() {
    let photo = load(&at("drawn.png"), &Options::new(DRAWN)).unwrap();
    let file = png(&[0, 255], Size::new(2, 1), ExtendedColorType::L8, None);
    let mask = mask_from_bytes("two", &file, &photo, &Limits::default()).unwrap();
    for row in mask.chunks(48) {
        assert_eq!((row[0], row[47]), (0, 255));
        assert!(row.is_sorted(), "soft from still to moving");
    }
}

#[test]
fn a_mask_is_cut_as_its_photo_is() {
    let options = Options { fit: Fit::Fill, ..Options::new(Size::new(16, 32)) };
    let photo = load(&at("drawn.png"), &options).unwrap();
    // The shown middle third is white.
    let codes: Vec<u8> = (0..48 * 32).map(|i| if (16..32).contains(&(i % 48)) { 255 } else { 0 }).collect();
    let file = png(&codes, DRAWN, ExtendedColorType::L8, None);
    assert!(mask_from_bytes("thirds", &file, &photo, &Limits::default()).unwrap().iter().all(|&v| v == 255));
}

#[test]
fn transparent_parts_of_a_mask_are_still() {
    let photo = load(&at("drawn.png"), &Options::new(DRAWN)).unwrap();
    let white = |alpha| png(&[255, 255, 255, alpha], Size::new(1, 1), ExtendedColorType::Rgba8, None);
    for alpha in [0, 100, 255] {
        let mask = mask_from_bytes("white", &white(alpha), &photo, &Limits::default()).unwrap();
        assert!(mask.iter().all(|&v| v == alpha));
    }
}

#[test]
fn a_mask_that_is_no_picture_is_refused_by_name() {
    let photo = load(&at("drawn.png"), &Options::new(DRAWN)).unwrap();
    let error = mask_from_bytes("a.mask.png", b"no mask", &photo, &Limits::default()).unwrap_err();
    check_line(&error, "a.mask.png");
}

#[test]
fn the_longer_name_of_a_mask_wins() {
    let folder = tempfile::tempdir().unwrap();
    let (photo, short, long) =
        (folder.path().join("a.jpg"), folder.path().join("a.mask.png"), folder.path().join("a.jpg.mask.png"));
    assert_eq!(mask_path(&photo), short);
    fs::write(&long, "").unwrap();
    fs::write(&short, "").unwrap();
    assert_eq!(mask_path(&photo), long);
}

#[test]
fn folders_are_listed_in_natural_order_without_hidden_files_and_masks() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    for inner in ["b", ".hidden", "b/c"] {
        fs::create_dir(root.join(inner)).unwrap();
    }
    let files = [
        "p10.jpg",
        "p2.JPG",
        "p2.mask.png",
        "._p2.jpg",
        "notes.txt",
        ".hidden/x.jpg",
        "b/c/z.png",
        "b/a.heic",
        "Q.webp",
    ];
    for file in files {
        fs::write(root.join(file), "").unwrap();
    }
    symlink(root, root.join("b/loop")).unwrap();
    symlink(root.join("nowhere"), root.join("gone.jpg")).unwrap();
    let found = list([root]).unwrap();
    let names: Vec<_> = found.iter().map(|p| p.strip_prefix(root).unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["b/a.heic", "b/c/z.png", "p2.JPG", "p10.jpg", "Q.webp"]);
    let file = root.join("notes.txt");
    assert_eq!(list([&file]).unwrap(), [file], "a file that is named is taken as it is");
}

#[test]
fn a_path_that_does_not_exist_is_an_error_that_names_it() {
    let error = list(["no/such/folder"]).unwrap_err();
    assert_eq!(error.to_string(), "no/such/folder: there is no such file or folder: check the name");
}
