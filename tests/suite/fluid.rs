//! Clips as people play them.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};
use tempfile::TempDir;
use yurameki::{
    effect::fluid::{ClipError, Kind, Shape, Tint},
    frame::{Rect, Size},
    os::clip::{ClipWriter, WriteError, Written},
};

fn run(words: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_yurameki")).args(words).env_remove("RUST_LOG").output();
    let output = output.expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

const BASE: Size = Size::new(96, 64);
const GRID: Size = Size::new(32, 20);

const fn shape(kind: Kind) -> Shape {
    let rect = Rect { x: 16, y: 12, size: Size::new(64, 40) };
    Shape { kind, millihertz: 25_000, step: 2, base: BASE, grid: GRID, rect }
}

/// A base of ramps, and a matte with a soft edge and a hole.
fn still() -> (Vec<u8>, Vec<u8>) {
    let base = (0..BASE.pixels()).flat_map(|i| [(i % 96 * 2) as u8, (i / 96 * 3) as u8, (i % 7 * 30) as u8]);
    let matte = (0..GRID.pixels()).map(|i| match (i % 32, i / 32) {
        (12..16, 8..12) => 0,
        (x, _) => (x * 20).min(255) as u8,
    });
    (base.collect(), matte.collect())
}

/// Waves that run to the right, `frames` of them to a round.
fn waves(kind: Kind, frames: usize, frame: usize) -> Vec<f32> {
    let wave = |i: usize| {
        let (x, y) = (i % 32, i / 32 % 20);
        ((x * 8 + y * 3 + 256 - frame * 256 / frames) % 64) as f32 - 32.0
    };
    (0..shape(kind).values()).map(wave).collect()
}

fn write(path: &Path, kind: Kind, frames: usize) -> Result<Written, WriteError> {
    let (base, matte) = still();
    let mut writer = ClipWriter::create(path, &shape(kind), &base, &matte, &Tint::GREY)?;
    for frame in 0..frames {
        writer.frame(&waves(kind, frames, frame))?;
    }
    writer.finish()
}

/// A clip of luma in a folder of its own.
fn clip() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("brook.yfl");
    write(&path, Kind::Luma, 16).expect("a clip");
    (folder, path)
}

/// SHA-256 over 24 frames of a clip of luma and of one of colour.
const HASHES: [&str; 2] = [
    "50b22e1139ee0b0346c47a7d98cae8c89de620981358924c9e3c79195b9e0a6e",
    "e340c3f584ac8f22f40bc9c7b9e50bf8bb7b759702d48e93de2975d4d4ab6609",
];

/// The hash of 24 frames.
fn hash(path: &Path, more: &[&str]) -> String {
    let path = path.to_str().expect("the name is text");
    let words = ["render", path, "--size", "120x80", "--frames", "24", "--hash", "--quiet", "--seed", "7"];
    let (code, out, error) = run(&[&words[..], more].concat());
    assert_eq!(code, Some(0), "{error}");
    out.trim().to_owned()
}

#[test]
fn the_frames_of_a_clip_are_those_of_every_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("clip.yfl");
    let hashes = [Kind::Luma, Kind::Colour].map(|kind| {
        write(&path, kind, 16).expect("a clip");
        hash(&path, &[])
    });
    assert_eq!(hashes, HASHES);
}

#[test]
fn strength_seed_and_effect_change_the_picture() {
    let (_folder, path) = clip();
    let plain = hash(&path, &[]);
    for more in [&["--strength", "2"][..], &["--amplitude", "white"], &["--effect", "kaleidoscope"]] {
        assert_ne!(hash(&path, more), plain, "{more:?}");
    }
}

#[test]
fn what_is_written_tells_its_length_and_what_was_cut_off() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("clip.yfl");
    let (base, matte) = still();
    let mut writer =
        ClipWriter::create(&path, &shape(Kind::Luma), &base, &matte, &Tint::GREY).expect("begun");
    let mut change = vec![0.0; GRID.pixels()];
    // One beyond 127 steps of 2 levels, one not; one in the hole, which is left out.
    (change[20], change[21], change[8 * 32 + 13]) = (300.0, -254.0, 300.0);
    change[22] = f32::NAN;
    writer.frame(&change).expect("a frame");
    writer.frame(&change).expect("a frame");
    assert!(!path.exists(), "it has its name before it is whole");
    let written = writer.finish().expect("a clip");
    let bytes = fs::metadata(&path).expect("it is there").len();
    // The hole lies between moving columns, so it is coded all the same.
    assert_eq!(written, Written { frames: 2, bytes, clipped: 4 });
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("clip.yfl");
    let (base, matte) = still();
    let create =
        |shape: &Shape, base: &[u8], matte: &[u8]| ClipWriter::create(&path, shape, base, matte, &Tint::GREY);
    let good = shape(Kind::Luma);
    let refused = |result: Result<ClipWriter, WriteError>| {
        result.err().map(|error| error.to_string()).expect("refused")
    };
    assert!(refused(create(&good, &base[1..], &matte)).starts_with("the base of the clip has"));
    assert!(refused(create(&good, &base, &matte[1..])).starts_with("the matte of the clip has"));
    assert!(refused(create(&Shape { step: 0, ..good }, &base, &matte)).contains("steps of 0 levels"));
    let mut writer = create(&good, &base, &matte).expect("begun");
    assert!(writer.frame(&[0.0; 3]).is_err());
    writer.frame(&waves(Kind::Luma, 16, 0)).expect("a frame");
    assert!(matches!(writer.finish(), Err(WriteError::Clip(ClipError::Frames(1)))));
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0, "something is left behind");
}

#[test]
fn a_cut_or_damaged_clip_is_refused_by_name() {
    let (folder, path) = clip();
    let good = fs::read(&path).expect("the clip");
    let bad = folder.path().join("bad.yfl");
    let name = bad.to_str().expect("the name is text");
    let refused = |bytes: &[u8], why: &str| {
        fs::write(&bad, bytes).expect("written");
        let (code, _, error) = run(&["render", name, "--hash", "--frames", "2", "--quiet"]);
        assert_eq!(code, Some(1), "{why}: {error}");
        assert!(error.contains(name) && error.contains(why) && error.trim().lines().count() == 1, "{error}");
    };
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 4;
        bytes
    };
    refused(&good[..good.len() - 1], "cut short");
    refused(&good[..40], "cut short");
    refused(&[&good[..], b"x"].concat(), "goes on after its end");
    refused(&flipped(3), "version");
    refused(&flipped(13), "header");
    refused(&flipped(100), "tint");
    refused(&flipped(good.len() - 3), "index");
}

#[test]
fn a_folder_shows_photos_and_clips() {
    let (folder, _) = clip();
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/drawn.png"), folder.path().join("a.png"))
        .expect("a photo");
    fs::write(folder.path().join("c.yfl"), b"YFL\x01 and no more").expect("a bad clip");
    let name = folder.path().to_str().expect("the name is text");
    let script = folder.path().join("presses");
    fs::write(&script, "3 right\n6 right\n9 right\n").expect("a script");
    let script = script.to_str().expect("the name is text");
    let (code, _, error) =
        run(&["run", name, "--display", "sim:80x60", "--frames", "14", "--script", script]);
    assert_eq!(code, Some(0), "{error}");
    let skipped: Vec<&str> = error.lines().filter(|line| line.contains("skipped")).collect();
    assert!(skipped.len() == 1 && skipped[0].contains("c.yfl"), "{error}");
}
