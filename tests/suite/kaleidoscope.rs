//! The kaleidoscope and the fractal coder as people run them.

use std::{fs, process::Command};
use tempfile::TempDir;

fn run(words: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_yurameki")).args(words).env_remove("RUST_LOG").output();
    let output = output.expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn data(name: &str) -> String {
    format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().expect("the name is text").to_owned()
}

/// The hash of 24 frames of the demo photo.
fn hash(more: &[&str]) -> String {
    let demo = data("demo.jpg");
    let words = [
        "render",
        &demo,
        "--effect",
        "kaleidoscope",
        "--size",
        "160x100",
        "--frames",
        "24",
        "--hash",
        "--quiet",
    ];
    let (code, out, error) = run(&[&words[..], more].concat());
    assert_eq!(code, Some(0), "{error}");
    out.trim().to_owned()
}

/// SHA-256 over the frames, the same on every machine.
const HASHES: [(&str, &str); 3] = [
    ("literal", "fd424e2899aaf0239f100e39dcb916edd21f3c48b6ea097dfc8decead77a9e4c"),
    ("tonal", "8826198b04539adb44b9d0cd31ead9c6955c2537f7ff783752fc2db62b6c8441"),
    ("watercolour", "21e1bd5b0b1768940c6af4619c2285668a99c634c854d8f956f365af4e610b8a"),
];

#[test]
fn the_frames_of_every_mode_are_those_of_every_machine() {
    let reference = data("drawn.png");
    for (mode, want) in HASHES {
        let got = hash(&["--reference", &reference, "--mode", mode, "--seed", "7"]);
        assert_eq!(got, want, "{mode}");
    }
}

#[test]
fn search_depth_and_reference_change_the_picture() {
    let reference = data("drawn.png");
    let plain = hash(&["--reference", &reference]);
    for more in [&["--search", "none"][..], &["--depth", "1"], &["--depth", "2"], &["--mode", "tonal"]] {
        assert_ne!(hash(&[&["--reference", &reference], more].concat()), plain, "{more:?}");
    }
    assert_ne!(hash(&[]), plain, "without a reference the photo gives its own colours");
}

#[test]
fn a_photo_is_encoded_and_decoded_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let (coded, picture) = (path(&folder, "a.yfc"), path(&folder, "a.png"));
    for search in ["none", "local", "filter8", "filterC", "classes72"] {
        let words = ["encode", &data("demo.jpg"), "--size", "200x200", "--search", search, "--out", &coded];
        let (code, out, error) = run(&words);
        assert_eq!(code, Some(0), "{error}");
        let psnr = out.split(", ").find_map(|part| part.strip_suffix(" dB")).expect("the PSNR is told");
        assert!(psnr.parse::<f64>().is_ok_and(|psnr| psnr > 18.0), "{search}: {out}");
        assert!(out.contains(&format!("{} bytes", fs::metadata(&coded).expect("a file").len())), "{out}");
        assert_eq!(run(&["decode", &coded, "--out", &picture]).0, Some(0));
        let decoded = image::open(&picture).expect("a picture");
        assert_eq!(decoded.width().max(decoded.height()), 200);
    }
}

#[test]
fn the_same_photo_gives_the_same_file_on_every_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    let coded = path(&folder, "a.yfc");
    let words = ["encode", &data("drawn.png"), "--out", &coded];
    assert_eq!(run(&words).0, Some(0));
    let bytes = fs::read(&coded).expect("a file");
    assert_eq!((bytes.len(), &bytes[16..20]), FILE, "the length and the checksum");
}

const FILE: (usize, &[u8]) = (199, &[220, 240, 233, 209]);

#[test]
fn a_damaged_file_is_refused_with_one_line_that_names_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (coded, picture) = (path(&folder, "a.yfc"), path(&folder, "a.png"));
    assert_eq!(run(&["encode", &data("drawn.png"), "--out", &coded]).0, Some(0));
    let bytes = fs::read(&coded).expect("a file");
    let mut flipped = bytes.clone();
    flipped[30] ^= 4;
    for (damaged, why) in [(&bytes[..40], "cut short"), (&flipped[..], "damaged"), (b"hello", "no .yfc file")]
    {
        fs::write(&coded, damaged).expect("the folder can be written");
        let (code, _, error) = run(&["decode", &coded, "--out", &picture]);
        assert_eq!((code, error.lines().count()), (Some(1), 1), "{error}");
        assert!(error.contains(why) && error.contains("a.yfc"), "{error}");
        assert!(!fs::exists(&picture).expect("the folder can be read"));
    }
}

#[test]
fn a_sidecar_chooses_the_effect_and_its_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let photo = path(&folder, "a.jpg");
    fs::copy(data("demo.jpg"), &photo).expect("a copy");
    fs::copy(data("drawn.png"), path(&folder, "b.png")).expect("a copy");
    let words = ["render", &photo, "--size", "160x100", "--frames", "24", "--hash", "--quiet"];
    let shimmer = run(&words).1;
    fs::write(path(&folder, "a.toml"), "effect = \"kaleidoscope\"\nreference = \"b.png\"\n")
        .expect("a sidecar");
    let (code, kaleidoscope, error) = run(&words);
    assert_eq!(code, Some(0), "{error}");
    assert_ne!(kaleidoscope, shimmer);
    assert_eq!(kaleidoscope.trim(), hash(&["--reference", &data("drawn.png")]));
}

#[test]
fn two_photos_of_a_folder_are_shown_and_the_effect_button_changes_the_way() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::copy(data("demo.jpg"), path(&folder, "a.jpg")).expect("a copy");
    fs::copy(data("drawn.png"), path(&folder, "b.png")).expect("a copy");
    let script = path(&folder, "script");
    fs::write(&script, "3 enter\n8 enter\n13 enter\n18 enter\n20 right\n").expect("a script");
    let photos = folder.path().to_str().expect("text");
    let words = [
        "run",
        photos,
        "--effect",
        "kaleidoscope",
        "--display",
        "sim:96x64",
        "--frames",
        "40",
        "--script",
        &script,
        "--fps",
        "60",
    ];
    let (code, _, error) = run(&words);
    assert_eq!(code, Some(0), "{error}");
}

#[test]
fn the_reference_button_goes_through_the_other_photos_of_the_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to) in [("demo.jpg", "a.jpg"), ("drawn.png", "b.png"), ("grey.png", "c.png")] {
        fs::copy(data(from), path(&folder, to)).expect("a copy");
    }
    let script = path(&folder, "script");
    fs::write(&script, "3 right long\n9 right long\n15 right long\n").expect("a script");
    let photos = folder.path().to_str().expect("text");
    let run = |effect| {
        let words = ["run", photos, "--effect", effect, "--display", "sim:96x64", "--fps", "60"];
        let (code, _, error) = run(&[&words[..], &["--frames", "40", "--script", &script]].concat());
        assert_eq!(code, Some(0), "{error}");
        let lines = error.lines().filter(|line| line.contains("a.jpg: from now on in the colours of"));
        lines.map(|line| line.rsplit('/').next().expect("a name").to_owned()).collect::<Vec<_>>()
    };
    // It begins with those of the photo that comes next.
    assert_eq!(run("kaleidoscope"), ["c.png", "b.png", "c.png"]);
    assert_eq!(run("shimmer"), [""; 0], "there is nothing to give them to");
}

#[test]
fn a_film_of_one_frame_shows_the_kaleidoscope_and_a_longer_one_begins_with_the_photo() {
    let folder = tempfile::tempdir().expect("a folder");
    let frame = |effect: &str, frames: &str| {
        let out = path(&folder, &format!("{effect}{frames}"));
        let words = ["render", &data("demo.jpg"), "--effect", effect, "--size", "96x64", "--frames", frames];
        let (code, _, error) = run(&[&words[..], &["--out", &out, "--quiet"]].concat());
        assert_eq!(code, Some(0), "{error}");
        let mut files: Vec<_> =
            fs::read_dir(&out).expect("a folder").map(|file| file.expect("a file").path()).collect();
        files.sort();
        image::open(&files[0]).expect("a picture").into_rgb8().into_raw()
    };
    let photo = frame("shimmer", "1");
    assert_eq!(frame("kaleidoscope", "2"), photo);
    assert_ne!(frame("kaleidoscope", "1"), photo);
}

#[test]
fn a_source_that_moves_is_shown_in_the_colours_of_the_reference_where_it_does() {
    let (folder, film) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    for (from, to) in [("demo.jpg", "1.jpg"), ("demo.jpg", "2.jpg"), ("demo.jpg", "3.jpg")] {
        fs::copy(data(from), path(&film, to)).expect("a copy");
    }
    let frames = |photo: &str, source: &str| {
        let out = path(&folder, source);
        let words = ["render", photo, "--effect", "kaleidoscope", "--source", source, "--size", "160x100"];
        let more = ["--frames", "24", "--out", &out, "--quiet", "--reference", &data("drawn.png")];
        let (code, _, error) = run(&[&words[..], &more[..]].concat());
        assert_eq!(code, Some(0), "{error}");
        let files = fs::read_dir(&out).expect("a folder").map(|file| file.expect("a file").path());
        let mut files: Vec<_> = files.collect();
        files.sort();
        [0, 23].map(|i| image::open(&files[i]).expect("a picture").into_rgb8().into_raw())
    };
    let [photo, shimmering] = frames(&data("demo.jpg"), "shimmer");
    let changed = photo.iter().zip(&shimmering).filter(|(a, b)| a.abs_diff(**b) > 20).count();
    assert!(changed > photo.len() / 20, "{changed} of {}", photo.len());
    let [first, last] = frames(film.path().to_str().expect("text"), "frames");
    assert!(first == photo && last == photo, "a film in which nothing moves");
}

#[test]
fn a_source_without_a_kaleidoscope_or_without_frames_is_refused_with_the_cure() {
    let folder = tempfile::tempdir().expect("a folder");
    let empty = folder.path().to_str().expect("text");
    for (words, cure) in [
        (&["--source", "frames", "--effect", "shimmer"][..], "--effect kaleidoscope"),
        (&["--source", "frames", "--effect", "kaleidoscope"], "name a folder of pictures"),
    ] {
        let (code, _, error) = run(&[&["render", empty, "--hash", "--quiet"], words].concat());
        assert_eq!((code, error.lines().count()), (Some(1), 1), "{error}");
        assert!(error.contains(cure), "{error}");
    }
}
