//! The program as people run it: what it makes, what it refuses, and how it says so.

use image::{AnimationDecoder, ImageEncoder, codecs::png::PngEncoder};
use rustix::process::{Pid, Signal, kill_process};
use std::{
    fs::{self, File},
    io::{BufReader, Read},
    os::unix::{fs::PermissionsExt, process::ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
};
use tempfile::TempDir;

fn program(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_yurameki"));
    command.args(words).env_remove("RUST_LOG").env_remove("RUST_BACKTRACE").stdin(Stdio::null());
    command
}

fn outcome(output: &Output) -> (Option<i32>, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Runs the program to its end.
fn run(words: &[&str]) -> (Option<i32>, String, String) {
    outcome(&program(words).output().expect("the program starts"))
}

/// A folder for one test, and names in it.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("the name is text").to_owned()
    }

    fn write(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.path(name);
        fs::write(&path, bytes).expect("the folder can be written");
        path
    }

    /// A copy of a small photo.
    fn photo(&self, name: &str) -> String {
        self.write(name, &fs::read(data("drawn.jpg")).expect("tests/data"))
    }

    /// Every name in the folder, sorted.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder can be read");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into()).collect();
        names.sort();
        names
    }
}

pub(crate) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The program fails with one line that contains all `parts`, and leaves no file but those that were there.
#[track_caller]
fn fails(folder: &Folder, words: &[&str], parts: &[&str]) {
    let before = folder.names();
    let (code, stdout, stderr) = run(words);
    assert_eq!(code, Some(1), "{words:?}: {stderr}");
    assert_eq!(stdout, "", "{words:?}");
    check_line(&stderr, words, parts);
    assert_eq!(folder.names(), before, "{words:?} left something behind");
}

#[track_caller]
fn check_line(stderr: &str, words: &[&str], parts: &[&str]) {
    assert_eq!(stderr.lines().count(), 1, "{words:?}: {stderr}");
    assert!(stderr.starts_with("yurameki: ") && stderr.ends_with('\n'), "{words:?}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{words:?}: no \"{part}\" in: {stderr}");
    }
}

/// The program refuses `words` as wrongly used, with a message that contains all `parts`.
#[track_caller]
fn is_misused(words: &[&str], parts: &[&str]) {
    let (code, stdout, stderr) = run(words);
    assert_eq!(code, Some(2), "{words:?}: {stderr}");
    assert_eq!(stdout, "", "{words:?}");
    for part in parts {
        assert!(stderr.contains(part), "{words:?}: no \"{part}\" in: {stderr}");
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
}

/// A PNG whose header says `width` × `height`, and that has no more.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut header = b"IHDR".to_vec();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([8, 2, 0, 0, 0]);
    let crc = !header.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    });
    let mut file = b"\x89PNG\r\n\x1a\n\0\0\0\r".to_vec();
    file.extend(header);
    file.extend(crc.to_be_bytes());
    file.extend(b"\0\0\0\0IDAT");
    file
}

/// Whether files are protected from the user who runs the tests: not from root.
fn is_protected(path: &str) -> bool {
    let protected = File::open(path).is_err();
    if !protected {
        eprintln!("skipped a part: the user who runs the tests may read everything");
    }
    protected
}

/// Bad photos, by name, and what is said of each.
fn bad_photos(folder: &Folder) -> Vec<(String, &'static str)> {
    let jpeg = fs::read(data("drawn.jpg")).expect("tests/data");
    let mut bad = vec![
        (folder.write("empty.jpg", b""), "is empty"),
        (folder.write("cut.jpg", &jpeg[..jpeg.len() / 3]), "copy it again"),
        (folder.write("text.jpg", b"these are words"), "is not a picture"),
        (folder.write("huge.png", &png_header(30_000, 30_000)), "more than the limit"),
        (folder.write("flat.png", &png_header(0, 100)), "again"),
    ];
    let locked = folder.photo("locked.jpg");
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).expect("the file is ours");
    if is_protected(&locked) {
        bad.push((locked, "may not be read"));
    } else {
        fs::remove_file(locked).expect("the file is ours");
    }
    bad
}

#[test]
fn a_bad_photo_is_one_line_that_names_it_whatever_is_asked_for() {
    let folder = Folder::new();
    let mut bad = bad_photos(&folder);
    bad.push((folder.path("missing.jpg"), "there is no such file"));
    fs::create_dir(folder.path("folder.jpg")).expect("the folder can be written");
    for (photo, what) in &bad {
        let out = folder.path("out.png");
        fails(&folder, &["render", photo, "--out", &out, "--size", "64x48", "--frames", "2"], &[photo, what]);
        fails(&folder, &["mask", photo, "--out", &out], &[photo, what]);
        fails(&folder, &["run", photo, "--display", "sim:64x48", "--frames", "2"], &[photo, what]);
    }
    let photo = folder.path("folder.jpg");
    fails(&folder, &["mask", &photo, "--out", &folder.path("out.png")], &[&photo, "is a folder"]);
}

#[test]
fn photos_that_the_fuzzer_found_end_in_one_line() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/fuzz/seeds/photo");
    for seed in fs::read_dir(seeds).expect("tools/fuzz/seeds/photo") {
        let seed = seed.expect("a seed").path();
        let photo = seed.to_str().expect("the name is text");
        let (code, stdout, stderr) = run(&["render", photo, "--hash", "--size", "64x48", "--frames", "2"]);
        match code {
            Some(0) => assert_eq!(stdout.trim().len(), 64, "{photo}"),
            Some(1) => check_line(&stderr, &[photo], &[photo]),
            _ => panic!("{photo}: exit code {code:?}: {stderr}"),
        }
    }
}

#[test]
fn a_photo_is_told_by_its_content_and_not_by_its_name() {
    let folder = Folder::new();
    let mislabelled = folder.photo("a.png");
    let (code, stdout, stderr) = run(&["render", &mislabelled, "--hash", "--size", "64x48", "--frames", "2"]);
    assert_eq!((code, stdout.trim().len()), (Some(0), 64), "{stderr}");
}

#[test]
fn a_bad_mask_is_named_and_one_of_another_size_is_stretched_and_said() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let out = folder.path("out.png");
    let words = folder.write("words.png", b"these are words");
    let missing = folder.path("missing.png");
    for mask in [&words, &missing] {
        let render = ["render", &photo, "--out", &out, "--size", "64x48", "--frames", "2", "--mask", mask];
        fails(&folder, &render, &[mask, ": "]);
        fails(
            &folder,
            &["run", &photo, "--display", "sim:64x48", "--frames", "2", "--mask", mask],
            &[mask, ": "],
        );
    }
    let mut other_size = Vec::new();
    let grey: Vec<u8> = (0..20 * 31).map(|i| (i % 256) as u8).collect();
    PngEncoder::new(&mut other_size)
        .write_image(&grey, 20, 31, image::ExtendedColorType::L8)
        .expect("a picture");
    let mask = folder.write("a.jpg.mask.png", &other_size);
    for explicit in [true, false] {
        let mut words = vec!["render", &photo, "--hash", "--size", "64x48", "--frames", "2"];
        if explicit {
            words.extend(["--mask", &mask]);
        }
        let (code, _, stderr) = run(&words);
        assert_eq!(code, Some(0), "{stderr}");
        assert!(stderr.contains("20×31") || explicit || stderr.contains(&mask), "{stderr}");
    }
}

#[test]
fn what_cannot_be_is_refused_as_misuse() {
    let sizes = ["0x0", "64", "x", "-1x5", "16385x1", "16384x16384", "1e3x5", "99999999999x1"];
    for size in sizes {
        is_misused(&["render", "a.jpg", "--out", "o.png", &format!("--size={size}")], &[size, "size"]);
        is_misused(&["run", "a.jpg", "--display", &format!("sim:{size}")], &[size]);
    }
    for display in ["sim:64x48:YUV", "sim:64x48:RGB565:127", "sim:64x48:RGB565:-1", "sim", "monitor", ""] {
        is_misused(&["run", "a.jpg", "--display", display], &["--display"]);
    }
    is_misused(&["run", "a.jpg", "--display", "sim:64x48:YUV"], &["XRGB8888", "BGR565", "XRGB2101010"]);
    is_misused(&["render", "a.jpg", "--hash", "--format", "RGB999"], &["XRGB8888", "BGR565"]);
    let noises =
        ["constant", "white", "chaos", "filter", "hosoda", "brown", "chaos-literal", "brown-literal"];
    is_misused(&["noise", "--kind", "pink"], &noises);
    is_misused(&["render", "a.jpg", "--hash", "--amplitude", "pink"], &noises);
    is_misused(&["render", "a.jpg", "--hash", "--frequency", ""], &noises);
    is_misused(&["render", "a.jpg", "--hash", "--range", "wide"], &["full", "neighbourhood", "travelling"]);
    is_misused(&["render", "a.jpg", "--hash", "--phase", "new"], &["integrated", "literal"]);
    is_misused(&["render", "a.jpg", "--hash", "--branch", "up"], &["rising", "falling", "scattered"]);
    is_misused(&["render", "a.jpg", "--hash", "--preset", "oak"], &["poplar", "rowan", "river", "waterfall"]);
    is_misused(&["render", "a.jpg", "--hash", "--light", "90"], &["AZIMUTH,ELEVATION"]);
    is_misused(&["render", "a.jpg", "--hash", "--light", "90,4"], &["5 to 90"]);
    is_misused(&["render", "a.jpg", "--hash", "--strength", "5"], &["0 to 4"]);
    is_misused(&["render", "a.jpg", "--hash", "--relief", "NaN"], &["0 to 4"]);
    is_misused(&["render", "a.jpg", "--hash", "--frames", "0"], &["--frames"]);
    is_misused(&["render", "a.jpg", "--hash", "--fps", "61"], &["--fps"]);
    is_misused(&["run", "a.jpg", "--fps", "11"], &["--fps"]);
    is_misused(&["run", "a.jpg", "--rotate", "45"], &["90", "180", "270"]);
    is_misused(&["render", "a.jpg"], &["--out"]);
    is_misused(&["render", "a.jpg", "--out", "o.jpeg"], &["o.jpeg", ".apng", ".gif", ".webp", ".y4m"]);
    is_misused(&["mask", "a.jpg", "--out", "o.gif"], &["o.gif", ".png"]);
    is_misused(&["mask", "a.jpg", "--out", "-"], &[".png"]);
    is_misused(&["noise", "--kind", "brown", "--response", "0"], &["--response"]);
    is_misused(&["noise", "--kind", "brown", "--response", "9", "--raw"], &["--raw"]);
    is_misused(&["dance"], &["dance"]);
}

#[test]
fn an_output_that_cannot_be_written_is_named_and_leaves_nothing() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    fs::create_dir(folder.path("full")).expect("the folder can be written");
    folder.write("full/letter.txt", b"dear");
    folder.write("file", b"a file");
    let nowhere = [
        (folder.path("missing/o.png"), "its folder does not exist"),
        (folder.path("file/o.png"), "a part of the path is a file"),
        (folder.path("file"), "a file, not a folder"),
        (folder.path("full"), "letter.txt"),
    ];
    for (out, what) in nowhere {
        let words = ["render", &photo, "--out", &out, "--size", "64x48", "--frames", "3"];
        fails(&folder, &words, &[&out, what]);
    }
    let locked = folder.path("locked");
    fs::create_dir(&locked).expect("the folder can be written");
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o500)).expect("the folder is ours");
    let out = folder.path("locked/o.webp");
    if File::create(folder.path("locked/try")).is_err() {
        fails(&folder, &["render", &photo, "--out", &out, "--size", "64x48"], &[&out, "no permission"]);
    } else {
        eprintln!("skipped a part: the user who runs the tests may write everywhere");
    }
}

#[test]
fn a_full_disk_is_one_line_and_no_panic_wherever_it_hits() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let mask = folder.path("mask.png");
    let full = || Stdio::from(File::options().write(true).open("/dev/full").expect("/dev/full"));
    let writers: [&[&str]; 5] = [
        &["render", &photo, "--out", "-", "--size", "64x48", "--frames", "3"],
        &["render", &photo, "--hash", "--size", "64x48", "--frames", "3"],
        &["run", &photo, "--display", "sim:64x48", "--frames", "3", "--fps", "60"],
        &["noise", "--kind", "brown", "--steps", "100000"],
        &["mask", &photo, "--out", &mask],
    ];
    for words in writers {
        let output = program(words).stdout(full()).output().expect("the program starts");
        let (code, _, stderr) = outcome(&output);
        assert_eq!(code, Some(1), "{words:?}: {stderr}");
        check_line(&stderr, words, &["standard output"]);
        // Not even the line that says so can be written: the exit code still tells.
        let status = program(words).stdout(full()).stderr(full()).status().expect("the program starts");
        assert_eq!(status.code(), Some(1), "{words:?}");
    }
}

#[test]
fn a_film_that_finds_no_room_half_way_leaves_no_file() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    // The shell lets the system refuse what goes beyond 8 blocks of a file, instead of ending the program.
    let limited = |out: &str| {
        Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 8; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_yurameki")])
            .args(["render", &photo, "--out", out, "--size", "160x120", "--frames", "20", "--mask", "none"])
            .output()
            .expect("the shell starts")
    };
    for name in ["o.png", "o.gif", "o.webp", "o.y4m", "folder"] {
        let (out, before) = (folder.path(name), folder.names());
        let (code, _, stderr) = outcome(&limited(&out));
        assert_eq!(code, Some(1), "{name}: {stderr}");
        check_line(&stderr, &[name], &[&out, "cannot be written"]);
        assert_eq!(folder.names(), before, "{name}");
    }
}

/// Runs the program and closes its standard output once `bytes` have come.
fn closed_early(words: &[&str], bytes: usize) -> (Option<i32>, String) {
    let mut child =
        program(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut stdout = child.stdout.take().expect("piped");
    stdout.read_exact(&mut vec![0; bytes]).expect("the program writes that much");
    drop(stdout);
    let (code, _, stderr) = outcome(&child.wait_with_output().expect("the program ends"));
    (code, stderr)
}

#[test]
fn a_pipe_that_is_closed_early_ends_the_work_without_a_panic() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let film = ["render", &photo, "--out", "-", "--size", "320x240", "--frames", "1000"];
    let (code, stderr) = closed_early(&film, 10);
    assert_eq!(code, Some(1));
    check_line(&stderr, &film, &["standard output", "closed the pipe"]);
    // Whoever reads numbers by `head` has got them all.
    assert_eq!(
        closed_early(&["noise", "--kind", "white", "--steps", "1000000"], 50),
        (Some(0), String::new())
    );
}

#[test]
fn a_folder_with_bad_photos_is_shown_all_the_same_and_each_is_named_once() {
    let folder = Folder::new();
    let bad = bad_photos(&folder);
    folder.photo("first.jpg");
    folder.photo("zebra.jpg");
    // Twice round the folder, in both directions.
    let script: String =
        (0..30).map(|i| format!("{} {}\n", i + 1, if i < 15 { "right" } else { "left" })).collect();
    let script = folder.write("script.txt", script.as_bytes());
    let shown = folder.0.path().to_str().expect("the name is text");
    let words =
        ["run", shown, "--display", "sim:64x48", "--frames", "40", "--fps", "60", "--script", &script];
    let (code, stdout, stderr) = run(&words);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.starts_with("40 frames, ") && stdout.lines().count() == 1, "{stdout}");
    for (photo, what) in &bad {
        let lines: Vec<&str> = stderr.lines().filter(|line| line.contains(photo.as_str())).collect();
        assert!(
            lines.len() == 1 && lines[0].contains(what) && lines[0].contains("skipped"),
            "{photo}: {stderr}"
        );
    }
    assert_eq!(stderr.lines().count(), bad.len(), "{stderr}");
}

#[test]
fn a_folder_without_a_photo_that_can_be_shown_ends_the_show() {
    let folder = Folder::new();
    let path = folder.0.path().to_str().expect("the name is text");
    fails(&folder, &["run", path, "--display", "sim:64x48"], &["there is no photo"]);
    let bad = bad_photos(&folder);
    let (code, _, stderr) = run(&["run", path, "--display", "sim:64x48"]);
    assert_eq!((code, stderr.lines().count()), (Some(1), bad.len() + 1), "{stderr}");
    assert!(stderr.ends_with("none of the photos can be shown\n"), "{stderr}");
}

#[test]
fn a_simulated_panel_reports_what_it_has_seen() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    for display in ["sim:64x48", "sim:33x17:RGB565:71", "sim:1x1:bgr888", "sim:48x64:XRGB2101010"] {
        for rotation in ["0", "90", "180", "270"] {
            let words = [
                "run",
                &photo,
                "--display",
                display,
                "--frames",
                "6",
                "--fps",
                "60",
                "--mask",
                "none",
                "--rotate",
                rotation,
            ];
            let (code, stdout, stderr) = run(&words);
            assert_eq!((code, &*stderr), (Some(0), ""), "{words:?}");
            for part in ["6 frames, ", " fps, ", " dropped, ", " % of a processor, ", "peak memory "] {
                assert!(stdout.contains(part), "{stdout}");
            }
        }
    }
}

#[test]
fn without_a_photo_the_demo_is_shown() {
    let (code, stdout, stderr) = run(&["run", "--display", "sim:64x48", "--frames", "3", "--fps", "60"]);
    assert_eq!((code, &*stderr), (Some(0), ""));
    assert!(stdout.starts_with("3 frames, "), "{stdout}");
}

#[test]
fn a_script_presses_the_buttons_and_a_bad_one_is_named() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let with_script = |text: &[u8]| {
        let script = folder.write("script.txt", text);
        let words = ["run", &photo, "--display", "sim:64x48", "--fps", "60", "--script", &script];
        run(&words)
    };
    let (code, stdout, stderr) = with_script(b"1 up\n2 i\n3 space\n4 down\n5 left\n9 esc\n");
    assert_eq!((code, &*stderr), (Some(0), ""));
    assert!(stdout.starts_with("9 frames, "), "{stdout}");
    for (text, what) in [
        (&b"3 up\nnine esc\n"[..], "line 2"),
        (b"3 jump\n", "unknown button \"jump\""),
        (b"\xff\xfe", "is no text"),
    ] {
        let (code, _, stderr) = with_script(text);
        assert_eq!(code, Some(1), "{stderr}");
        check_line(&stderr, &["--script"], &["script.txt", what]);
    }
    let missing = folder.path("missing.txt");
    fails(&folder, &["run", &photo, "--display", "sim:64x48", "--script", &missing], &[&missing]);
    let endless = ["run", &photo, "--display", "sim:64x48", "--script", "/dev/zero"];
    fails(&folder, &endless, &["/dev/zero", "over 16 MiB"]);
}

#[test]
fn noise_prints_as_many_numbers_as_asked_for() {
    let numbers = |words: &[&str]| -> Vec<f64> {
        let (code, stdout, stderr) = run(words);
        assert_eq!((code, &*stderr), (Some(0), ""), "{words:?}");
        stdout.lines().map(|line| line.parse().expect("a number")).collect()
    };
    for kind in ["constant", "white", "chaos", "filter", "hosoda", "brown", "chaos-literal", "brown-literal"]
    {
        let noise = |more: &[&str]| numbers(&[&["noise", "--kind", kind, "--steps", "97"], more].concat());
        let (frequency, amplitude) = (noise(&[]), noise(&["--response", "20"]));
        assert_eq!([frequency.len(), amplitude.len(), noise(&["--raw"]).len()], [97; 3]);
        assert!(frequency.iter().all(|number| (0.0..=2.0).contains(number)), "{kind}: {frequency:?}");
        assert!(amplitude.iter().all(|number| (0.0..=1.0).contains(number)), "{kind}: {amplitude:?}");
        assert_eq!(noise(&["--seed", "1"]), frequency);
        assert!(kind == "constant" || noise(&["--seed", "2"]) != frequency, "{kind}");
    }
    assert_eq!(numbers(&["noise", "--kind", "brown", "--steps", "0"]), Vec::<f64>::new());
}

#[test]
fn the_mask_is_a_picture_that_can_be_used_as_one() {
    let folder = Folder::new();
    let photo = folder.write("a.jpg", &fs::read(data("demo.jpg")).expect("tests/data"));
    let mask = folder.path("a.jpg.mask.png");
    let (code, stdout, stderr) = run(&["mask", &photo, "--out", &mask]);
    assert_eq!((code, &*stderr), (Some(0), ""));
    assert!(stdout.contains("% of the photo moves"), "{stdout}");
    let picture = image::open(&mask).expect("a picture");
    assert_eq!((picture.width(), picture.height()), (1280, 854));
    let (code, _, stderr) = run(&["render", &photo, "--hash", "--size", "64x48", "--frames", "2"]);
    assert!(
        code == Some(0) && stderr.contains(&mask),
        "the mask beside the photo is used and said: {stderr}"
    );
}

#[test]
fn a_film_is_written_in_every_format_and_hashes_the_same_each_time() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let film = |out: &str| {
        let out = folder.path(out);
        let words = [
            "render", &photo, "--out", &out, "--size", "65x49", "--frames", "5", "--fps", "10", "--hash",
            "--seed", "3",
        ];
        let (code, stdout, stderr) = run(&words);
        assert_eq!((code, &*stderr), (Some(0), ""), "{words:?}");
        (out, stdout)
    };
    let open = |path: &str| BufReader::new(File::open(path).expect("the film"));
    let frames = |count: usize, size: (u32, u32)| assert_eq!((count, size), (5, (65, 49)));

    let (out, hash) = film("o.gif");
    let gif = image::codecs::gif::GifDecoder::new(open(&out)).expect("a GIF");
    let pictures = gif.into_frames().collect_frames().expect("whole");
    frames(pictures.len(), pictures[0].buffer().dimensions());
    let (out, same) = film("o.webp");
    assert_eq!(same, hash);
    let webp = image::codecs::webp::WebPDecoder::new(open(&out)).expect("a WebP");
    let pictures = webp.into_frames().collect_frames().expect("whole");
    frames(pictures.len(), pictures[0].buffer().dimensions());
    for name in ["o.png", "o.apng"] {
        let (out, same) = film(name);
        assert_eq!(same, hash);
        let png = image::codecs::png::PngDecoder::new(open(&out)).expect("a PNG");
        let pictures = png.apng().expect("animated").into_frames().collect_frames().expect("whole");
        frames(pictures.len(), pictures[0].buffer().dimensions());
    }
    let (out, same) = film("folder");
    assert_eq!(same, hash);
    let pictures: Vec<_> =
        fs::read_dir(out).expect("a folder").map(|entry| entry.expect("a file").path()).collect();
    frames(pictures.len(), image::image_dimensions(&pictures[0]).expect("a picture"));
    let (out, same) = film("o.y4m");
    assert_eq!(same, hash);
    let y4m = fs::read(out).expect("the film");
    assert!(y4m.starts_with(b"YUV4MPEG2 W65 H49 F10:1 "));

    let words =
        ["render", &photo, "--out", "-", "--size", "65x49", "--frames", "5", "--fps", "10", "--seed", "3"];
    let piped = program(&words).output().expect("the program starts");
    assert!(piped.status.success() && piped.stdout == y4m, "a pipe gets what the file got");

    let words =
        ["render", &photo, "--hash", "--size", "65x49", "--frames", "5", "--fps", "10", "--seed", "4"];
    let other = run(&words).1;
    assert!(other.trim().len() == 64 && other != hash, "another seed, another film");
}

/// Waits for what the program does of itself, and ends it where that does not come.
fn until(child: &mut Child, what: &str, mut done: impl FnMut() -> bool) {
    while !done() {
        if let Some(status) = child.try_wait().expect("the program is ours") {
            panic!("ended by {status} before {what}");
        }
        std::thread::yield_now();
    }
}

#[test]
fn ctrl_c_in_the_middle_of_a_film_leaves_no_file() {
    for (signal, out) in [(Signal::INT, "o.webp"), (Signal::TERM, "o.gif"), (Signal::HUP, "folder")] {
        if is_ignored(signal) {
            eprintln!("skipped: the tests were started with {signal:?} ignored (nohup, a background job)");
            continue;
        }
        let folder = Folder::new();
        let photo = folder.photo("a.jpg");
        let before = folder.names();
        let words =
            ["render", &photo, "--out", &folder.path(out), "--size", "160x120", "--frames", "1000000"];
        let mut command = program(&words);
        let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
        until(&mut child, "the film is begun", || folder.names() != before);
        let id = Pid::from_child(&child);
        kill_process(id, signal).expect("the program is ours");
        let (code, _, stderr) = outcome(&child.wait_with_output().expect("the program ends"));
        assert_eq!(code, Some(1), "{stderr}");
        check_line(&stderr, &words, &["stopped"]);
        assert_eq!(folder.names(), before, "{out}: something was left behind");
    }
}

/// Whether this program, and so those that it starts, ignore `signal`: bit `signal` − 1 of SigIgn, proc(5).
fn is_ignored(signal: Signal) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    u64::from_str_radix(mask.trim(), 16).unwrap_or_default() >> (signal.as_raw() - 1) & 1 == 1
}

#[test]
fn a_show_that_is_asked_to_end_ends_well() {
    let folder = Folder::new();
    let photo = folder.photo("a.jpg");
    let bad = folder.write("bad.jpg", b"no photo");
    // The line about the second photo tells that the show runs.
    let script = folder.write("script.txt", b"1 right\n");
    let words = ["run", &photo, &bad, "--display", "sim:64x48", "--script", &script];
    let mut child =
        program(&words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut line = [0; 9];
    child.stderr.take().expect("piped").read_exact(&mut line).expect("a line");
    kill_process(Pid::from_child(&child), Signal::TERM).expect("the program is ours");
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!((output.status.code(), output.status.signal()), (Some(0), None));
    assert!(String::from_utf8_lossy(&output.stdout).contains(" fps, "));
}
