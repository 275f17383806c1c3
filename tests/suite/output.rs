//! Frames written to files are the frames that were rendered.
#![cfg(feature = "os")]

use image::{
    AnimationDecoder, RgbImage,
    codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder},
};
use std::{
    ffi::OsStr,
    fs::{self, File},
    io::BufReader,
    path::Path,
};
use yurameki::{
    frame::{FrameRef, Layout, PixelFormat, Size},
    os::output::{FrameHash, FrameRate, OutputError, Target, Writer},
};

/// Frames in memory.
struct Film {
    layout: Layout,
    frames: Vec<Vec<u8>>,
}

impl Film {
    /// A still gradient of many colours in which a square of other colours moves; the third frame repeats the second.
    fn new(size: Size, format: PixelFormat, padding: usize) -> Self {
        let stride = size.width as usize * format.bytes_per_pixel() + padding;
        let layout = Layout::new(size, format, Some(stride)).unwrap();
        let frame = |t: u32| {
            let mut bytes = vec![0xa5; layout.len_bytes()];
            for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
                let moves = x.wrapping_sub(3 * t) < 6 && y.wrapping_sub(t) < 4;
                let word = if moves || size.pixels() == 1 {
                    0x00c0_3070 + t * 0x0005_0711
                } else {
                    x * 0x0003_0104 + y * 0x0201_0500
                };
                let start = y as usize * stride + x as usize * format.bytes_per_pixel();
                bytes[start..][..format.bytes_per_pixel()]
                    .copy_from_slice(&word.to_le_bytes()[..format.bytes_per_pixel()]);
            }
            bytes
        };
        Self { layout, frames: [0, 1, 1, 2, 3].map(frame).into() }
    }

    fn views(&self) -> impl Iterator<Item = FrameRef<'_>> {
        self.frames.iter().map(|bytes| FrameRef::new(bytes, self.layout).unwrap())
    }

    /// The frames pixel by pixel, as [`FrameRef::rgb`] tells them.
    fn pictures(&self) -> Vec<RgbImage> {
        let Size { width, height } = self.layout.size;
        let picture =
            |view: FrameRef<'_>| RgbImage::from_fn(width, height, |x, y| image::Rgb(view.rgb(x, y)));
        self.views().map(picture).collect()
    }

    fn write(&self, out: &Path, rate: FrameRate) -> Result<(), OutputError> {
        let mut writer = self.create(out, rate)?;
        self.views().try_for_each(|view| writer.write(view))?;
        writer.finish()
    }

    fn create(&self, out: &Path, rate: FrameRate) -> Result<Writer, OutputError> {
        let target = Target::parse(out.as_os_str()).unwrap();
        Writer::create(&target, self.layout.size, rate, self.frames.len() as u32)
    }
}

fn rate(frames: u32) -> FrameRate {
    FrameRate::new(frames, 1).unwrap()
}

/// Small, odd, and large enough that the encoders' blocks and the dither's mask repeat; each in every pixel format.
fn films() -> impl Iterator<Item = (String, Film)> {
    let sizes = [(1, 1), (17, 5), (90, 71)].map(|(width, height)| Size::new(width, height));
    sizes.into_iter().flat_map(|size| {
        PixelFormat::ALL.into_iter().flat_map(move |format| {
            [0, 7].map(|padding| (format!("{size} {format} +{padding}"), Film::new(size, format, padding)))
        })
    })
}

/// The frames of an animation as they are shown, and how long, in milliseconds.
fn read(path: &Path) -> (Vec<RgbImage>, Vec<f64>) {
    let file = BufReader::new(File::open(path).unwrap());
    let frames = match path.extension().and_then(OsStr::to_str).unwrap() {
        "gif" => GifDecoder::new(file).unwrap().into_frames(),
        "webp" => WebPDecoder::new(file).unwrap().into_frames(),
        _ => PngDecoder::new(file).unwrap().apng().unwrap().into_frames(),
    };
    let shown = frames.map(|frame| {
        let frame = frame.unwrap();
        let (numerator, denominator) = frame.delay().numer_denom_ms();
        let picture = image::DynamicImage::from(frame.into_buffer()).to_rgb8();
        (picture, f64::from(numerator) / f64::from(denominator))
    });
    shown.unzip()
}

fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    let sum: u64 = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn apng_and_webp_keep_every_pixel_of_every_format_and_stride() {
    let folder = tempfile::tempdir().unwrap();
    for (name, film) in films() {
        for file in ["a.apng", "a.png", "a.webp"] {
            let path = folder.path().join(file);
            film.write(&path, rate(30)).unwrap();
            assert!(read(&path).0 == film.pictures(), "{file}, {name}");
        }
    }
}

#[test]
fn a_film_of_one_frame_is_a_still_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut film = Film::new(Size::new(17, 5), PixelFormat::Xrgb8888, 3);
    film.frames.truncate(1);
    for file in ["a.png", "a.apng", "a.webp"] {
        let path = folder.path().join(file);
        film.write(&path, rate(30)).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert!(!bytes.windows(4).any(|chunk| chunk == b"acTL" || chunk == b"ANIM"), "{file} is animated");
        let picture = image::load_from_memory(&bytes).unwrap().to_rgb8();
        assert!(picture == film.pictures()[0], "{file}");
    }
    let path = folder.path().join("a.gif");
    film.write(&path, rate(30)).unwrap();
    assert_eq!(read(&path).0.len(), 1);
}

#[test]
fn a_folder_holds_a_png_for_each_frame() {
    let parent = tempfile::tempdir().unwrap();
    for (name, film) in films().step_by(3) {
        let folder = parent.path().join("frames");
        film.write(&folder, rate(30)).unwrap();
        let expected: Vec<String> = (0..film.frames.len()).map(|i| format!("frame_{i:05}.png")).collect();
        assert_eq!(names_in(&folder), expected);
        for (file, picture) in expected.iter().zip(film.pictures()) {
            assert!(image::open(folder.join(file)).unwrap().to_rgb8() == picture, "{file}, {name}");
        }
    }
    assert_eq!(names_in(parent.path()), ["frames"]);
}

/// Each square of 10 × 10 pixels as their mean: what the eye makes of a dither.
fn squares(picture: &RgbImage) -> RgbImage {
    image::imageops::thumbnail(picture, picture.width().div_ceil(10), picture.height().div_ceil(10))
}

#[test]
fn a_gif_is_near_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gif");
    let film = Film::new(Size::new(90, 71), PixelFormat::Xbgr8888, 7);
    film.write(&path, rate(25)).unwrap();
    let shown = read(&path).0;
    assert_eq!(shown.len(), film.frames.len());
    for (i, (shown, expected)) in shown.iter().zip(film.pictures()).enumerate() {
        let (pixels, means) =
            (mean_difference(shown, &expected), mean_difference(&squares(shown), &squares(&expected)));
        assert!(pixels < 8.0 && means < 2.5, "frame {i} is off by {pixels}, its squares by {means}");
    }
    // Fewer colours than a palette holds.
    let few = Film::new(Size::new(17, 5), PixelFormat::Rgb565, 0);
    few.write(&path, rate(25)).unwrap();
    let difference = mean_difference(&read(&path).0[0], &few.pictures()[0]);
    assert!(difference < 1.0, "few colours are off by {difference}");
}

#[test]
fn a_gif_is_still_where_the_film_is_still() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gif");
    for (name, film) in films() {
        film.write(&path, rate(25)).unwrap();
        let (shown, expected) = (read(&path).0, film.pictures());
        assert_eq!(shown.len(), expected.len());
        for i in 1..shown.len() {
            let still = expected[i].pixels().zip(expected[i - 1].pixels()).map(|(a, b)| a == b);
            let kept = shown[i].pixels().zip(shown[i - 1].pixels()).map(|(a, b)| a == b);
            assert!(still.zip(kept).all(|(still, kept)| kept || !still), "frame {i} of {name} crawls");
        }
        let moved = film.layout.size.pixels() > 1;
        assert!(!moved || shown[0] != shown[4], "{name} does not move");
    }
}

#[test]
fn colours_that_the_first_frame_lacks_are_still_near_in_a_gif() {
    let folder = tempfile::tempdir().unwrap();
    let mut film = Film::new(Size::new(90, 71), PixelFormat::Bgr888, 0);
    // From greens to the reds of autumn.
    let tint = |t: u8| {
        (0..90 * 71_u32).flat_map(|i| [40 * t + 30, 150 - 25 * t, (i % 60) as u8]).collect::<Vec<u8>>()
    };
    film.frames = (0..5).map(tint).collect();
    let path = folder.path().join("a.gif");
    film.write(&path, rate(25)).unwrap();
    for (i, (shown, expected)) in read(&path).0.iter().zip(film.pictures()).enumerate() {
        let difference = mean_difference(&squares(shown), &squares(&expected));

        assert!(difference < 5.0, "frame {i} is off by {difference}");
    }
}

/// Reads a YUV4MPEG2 file back to RGB in floating point, with the inverse of the equations of BT.601.
fn read_y4m(path: &Path) -> (String, Vec<RgbImage>) {
    let bytes = fs::read(path).unwrap();
    let end = bytes.iter().position(|b| *b == b'\n').unwrap();
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let number =
        |tag: char| header.split(' ').find_map(|word| word.strip_prefix(tag)?.parse::<u32>().ok()).unwrap();
    let (width, height) = (number('W'), number('H'));
    let plane = (width * height) as usize;
    let frames = bytes[end + 1..].chunks_exact(6 + 3 * plane).map(|frame| {
        let samples = frame.strip_prefix(b"FRAME\n").unwrap();
        RgbImage::from_fn(width, height, |x, y| {
            let at = (y * width + x) as usize;
            let luma = (f64::from(samples[at]) - 16.0) / 219.0;
            let [blue, red] = [1, 2].map(|c| (f64::from(samples[c * plane + at]) - 128.0) / 224.0);
            let (r, b) = (luma + 1.402 * red, luma + 1.772 * blue);
            let g = (luma - 0.299 * r - 0.114 * b) / 0.587;
            image::Rgb([r, g, b].map(|v| (v * 255.0).round().clamp(0.0, 255.0) as u8))
        })
    });
    (header.clone(), frames.collect())
}

#[test]
fn y4m_keeps_the_colours_and_says_how_to_read_them() {
    let folder = tempfile::tempdir().unwrap();
    for (name, film) in films() {
        let path = folder.path().join("a.y4m");
        film.write(&path, FrameRate::new(30_000, 1001).unwrap()).unwrap();
        let (header, shown) = read_y4m(&path);
        let Size { width, height } = film.layout.size;
        assert_eq!(
            header,
            format!("YUV4MPEG2 W{width} H{height} F30000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED")
        );
        assert_eq!(shown.len(), film.frames.len());
        for (shown, expected) in shown.iter().zip(film.pictures()) {
            let worst = shown.as_raw().iter().zip(expected.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(worst <= Some(2), "{name} is off by {worst:?}");
        }
    }
}

#[test]
fn delays_keep_the_time_of_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let mut film = Film::new(Size::new(5, 3), PixelFormat::Rgb565, 1);
    film.frames = film.frames.iter().cycle().take(60).cloned().collect();
    for frames_a_second in [7, 24, 30, 60] {
        for (file, unit_ms) in [("a.gif", 10.0), ("a.webp", 1.0), ("a.apng", 1.0)] {
            let path = folder.path().join(file);
            film.write(&path, rate(frames_a_second)).unwrap();
            let (_, delays) = read(&path);
            let exact = 1000.0 / f64::from(frames_a_second);
            assert_eq!(delays.len(), 60);
            assert!(
                delays.iter().all(|ms| (ms - exact).abs() <= unit_ms),
                "{file} at {frames_a_second}: {delays:?}"
            );
            let sum: f64 = delays.iter().sum();
            assert!((sum - 60.0 * exact).abs() <= unit_ms, "{file} at {frames_a_second}: {sum} ms");
        }
    }
}

#[test]
fn a_writer_that_is_dropped_or_cut_short_leaves_what_was_there() {
    let film = Film::new(Size::new(17, 5), PixelFormat::Xrgb2101010, 4);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("old.gif"), "old").unwrap();
    for file in ["a.apng", "old.gif", "a.webp", "a.y4m", "frames"] {
        let path = folder.path().join(file);
        let mut writer = film.create(&path, rate(30)).unwrap();
        film.views().for_each(|view| writer.write(view).unwrap());
        drop(writer);
        assert_eq!(names_in(folder.path()), ["old.gif"], "{file}, dropped");

        let mut writer = film.create(&path, rate(30)).unwrap();
        writer.write(film.views().next().unwrap()).unwrap();
        let text = writer.finish().unwrap_err().to_string();
        assert!(text.contains(file) && text.contains("ended after 1 of 5 frames"), "{text}");
        assert_eq!(names_in(folder.path()), ["old.gif"], "{file}, cut short");
    }
    assert_eq!(fs::read(folder.path().join("old.gif")).unwrap(), b"old");
}

#[test]
fn a_new_file_takes_the_place_of_the_old_one_and_has_the_usual_permissions() {
    let film = Film::new(Size::new(4, 4), PixelFormat::Rgb888, 0);
    let folder = tempfile::tempdir().unwrap();
    let (path, link) = (folder.path().join("a.gif"), folder.path().join("link.gif"));
    fs::write(&path, "old").unwrap();
    std::os::unix::fs::symlink("a.gif", &link).unwrap();
    let usual = fs::metadata(&path).unwrap().permissions();
    film.write(&link, rate(30)).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(read(&path).0.len(), film.frames.len());
    assert_eq!(fs::metadata(&path).unwrap().permissions(), usual);
}

#[test]
fn frames_of_an_earlier_run_are_replaced_and_other_files_are_kept() {
    let film = Film::new(Size::new(4, 4), PixelFormat::Rgb888, 0);
    let folder = tempfile::tempdir().unwrap();
    for name in ["frame_00000.png", "frame_00099.png", ".directory"] {
        fs::write(folder.path().join(name), "old").unwrap();
    }
    drop(film.create(folder.path(), rate(30)).unwrap());
    assert_eq!(names_in(folder.path()), [".directory", "frame_00000.png", "frame_00099.png"]);
    film.write(folder.path(), rate(30)).unwrap();
    let names = names_in(folder.path());
    assert_eq!(names.len(), 1 + film.frames.len(), "{names:?}");
    assert!(image::open(folder.path().join("frame_00000.png")).is_ok());

    fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    let text = film.write(folder.path(), rate(30)).unwrap_err().to_string();
    assert!(text.contains("other files (notes.txt)"), "{text}");
}

#[test]
fn a_place_that_cannot_be_written_is_named_with_the_cure() {
    let film = Film::new(Size::new(4, 4), PixelFormat::Rgb888, 0);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for (place, cure) in [
        ("missing/a.gif", "folder does not exist; create it"),
        ("missing/frames", "folder does not exist; create it"),
        ("file/a.gif", "is a file, not a folder"),
        ("file", "a file, not a folder; name"),
    ] {
        let path = folder.path().join(place);
        let text = film.create(&path, rate(30)).map(drop).unwrap_err().to_string();
        assert!(text.starts_with(path.to_str().unwrap()) && text.contains(cure), "{text}");
        assert!(!text.contains('\n'), "{text}");
    }
}

#[test]
fn frames_that_do_not_fit_the_film_are_refused() {
    let film = Film::new(Size::new(4, 4), PixelFormat::Rgb888, 0);
    let other = Film::new(Size::new(4, 5), PixelFormat::Rgb888, 0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.webp");
    let mut writer = film.create(&path, rate(30)).unwrap();
    let text = writer.write(other.views().next().unwrap()).unwrap_err().to_string();
    assert!(text.contains("a frame of 4×5 pixels among frames of 4×4"), "{text}");
    film.views().for_each(|view| writer.write(view).unwrap());
    let text = writer.write(film.views().next().unwrap()).unwrap_err().to_string();
    assert!(text.contains("more than the 5 frames"), "{text}");

    let target = Target::parse(path.as_os_str()).unwrap();
    for (size, frames, problem) in [(Size::new(0, 4), 1, "0×4"), (Size::new(4, 4), 0, "no frames")] {
        let text = Writer::create(&target, size, rate(30), frames).map(drop).unwrap_err().to_string();
        assert!(text.contains(problem), "{text}");
    }
}

#[test]
fn the_hash_depends_on_pixels_size_and_format_but_not_on_the_stride() {
    let hash = |film: &Film| {
        let mut hash = FrameHash::new();
        film.views().for_each(|view| hash.update(view));
        hash.hex()
    };
    let size = Size::new(6, 4);
    let film = Film::new(size, PixelFormat::Rgb565, 0);
    let expected = hash(&film);
    assert_eq!(expected.len(), 64);
    assert_eq!(hash(&Film::new(size, PixelFormat::Rgb565, 5)), expected);
    let mut reformatted = Film::new(size, PixelFormat::Rgb565, 0);
    reformatted.layout.format = PixelFormat::Bgr565;
    let mut reshaped = Film::new(size, PixelFormat::Rgb565, 0);
    reshaped.layout = Layout::new(size.transposed(), PixelFormat::Rgb565, None).unwrap();
    let mut changed = Film::new(size, PixelFormat::Rgb565, 0);
    changed.frames[4][17] ^= 1;
    for other in [reformatted, reshaped, changed] {
        assert_ne!(hash(&other), expected);
    }
    // As sha256sum tells it for one frame of 1×1, RGB565 and the bytes 1, 2: 01000000 01000000 "RGB565" 01 02.
    let layout = Layout::new(Size::new(1, 1), PixelFormat::Rgb565, None).unwrap();
    let mut one = FrameHash::new();
    one.update(FrameRef::new(&[1, 2], layout).unwrap());
    assert_eq!(one.hex(), "e9c9ce00c818aa6d246b92c7ccbc291f487fc85008c1b55c3827ade75238a1c3");
}
