//! Configuration files, boards, sidecars: what they say is done, and what is wrong with them is told.

use clap::Parser;
use proptest::prelude::*;
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    time::Duration,
};
use tempfile::TempDir;
use yurameki::{
    config::{
        Order, Preset,
        night::{Level, Zone},
    },
    effect::{
        kaleidoscope::{Mode, Settings, fractal::Search},
        shimmer::{Branch, Range},
    },
    frame::Rotation,
    input::{Button, action::Action},
    math::{Factor, Turns},
    noise::{Kind, drive::PhaseForm},
    os::{
        ConfigError, Place,
        args::{self, Args, DisplayChoice, MaskChoice},
        board::{self, BOARDS},
        config::{Config, Look},
        config_file::{self, DEFAULT},
        evdev::KeyCodes,
        local_time::Trust,
        photo::Fit,
        sidecar,
    },
};

/// A text that says something else than the default of every key but `preset`.
const OTHER: &str = r##"
[display]
output = "sim:480x320:RGB565"
rotation = 270
fps = 30
backlight = "10-0045"
[photos]
folders = ["holiday", "/srv/photos"]
order = "date"
seconds = 5
fade = 0.5
fit = "plain"
background = "#10fF20"
[life]
effect = "shimmer"
mode = "literal"
search = "filterC"
depth = 2
reference = "sunset.jpg"
amplitude = "white"
frequency = "chaos"
phase = "literal"
range = "full"
branch = "scattered"
light = "-45,90"
relief = 2
strength = 0.25
wind = -90
mask = "leaves.png"
tree = "birch"
plates = "leaves"
patchiness = 0.5
sun = "none"
leaf-fall = "off"
around-minutes = 45
seed = 18446744073709551615
[buttons]
right = "previous"
"space:long" = "none"
[keys]
KEY_PLAYPAUSE = "space"
115 = "up"
[night]
times = ["23:00 off", "07:00 100%", "21:30 40%"]
zone = "Asia/Tokyo"
clock = "as-it-is"
[season]
hemisphere = "south"
green = "05-01"
turns = "09-20"
full = "10-30"
bare = "11-30"
minutes = 7
[memory]
ceiling = 64
[log]
level = "debug"
"##;

/// What can be compared of a configuration.
fn shown(config: &Config) -> String {
    format!("{config:#?}")
}

fn parse(text: &str) -> Result<Config, ConfigError> {
    config_file::parse("test.toml", text)
}

fn good(text: &str) -> Config {
    parse(text).unwrap_or_else(|error| panic!("{error}"))
}

/// The only mistake in a text: its place and the message.
fn fault(text: &str) -> ((usize, usize), String) {
    let error = parse(text).expect_err(text);
    let [fault] = &error.faults[..] else { panic!("one mistake in {text:?}: {error}") };
    let Place { line, column } = fault.place.expect("a place");
    assert!(error.to_string().starts_with(&format!("test.toml:{line}:{column}: ")), "{error}");
    ((line, column), fault.message.clone())
}

/// The default keys and these.
fn codes(keys: &[(&str, Button)]) -> KeyCodes {
    let mut codes = KeyCodes::default();
    for (key, button) in keys {
        codes.assign(key, *button).unwrap();
    }
    codes
}

fn run_args(words: &[&str]) -> args::Run {
    let words = ["yurameki", "run"].into_iter().chain(words.iter().copied());
    match Args::try_parse_from(words).expect("good words").command {
        Some(args::Command::Run(args)) => args,
        other => panic!("{other:?}"),
    }
}

/// The keys of a text in which every comment that is a key counts, each as `section.key`.
fn keys_of(text: &str) -> BTreeSet<String> {
    let mut section = String::new();
    let mut keys = BTreeSet::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']').to_owned();
        } else if let Some((key, _)) = line.trim_start_matches('#').split_once(" = ")
            && !key.contains(' ')
        {
            keys.insert(format!("{section}.{key}"));
        }
    }
    keys
}

/// The default text with every key that is commented out in force.
fn uncommented() -> String {
    let line = |line: &str| match line.strip_prefix('#') {
        Some(key) if !key.starts_with(' ') && !key.is_empty() => format!("{key}\n"),
        _ => format!("{line}\n"),
    };
    DEFAULT.lines().map(line).collect()
}

#[test]
fn the_default_text_gives_the_defaults() {
    assert_eq!(shown(&good(DEFAULT)), shown(&Config::default()));
    assert_eq!(shown(&good("")), shown(&Config::default()));
}

/// Every value in the default text is the default: said after another, it gives the default back.
#[test]
fn each_value_of_the_default_text_is_the_default() {
    let (folder, other) = (TempDir::new().unwrap(), OTHER.replace("\"leaves.png\"", "\"none\""));
    let (board, file) = (folder.path().join("board.toml"), folder.path().join("config.toml"));
    // Those without a default have an example in the text instead.
    let without_default =
        ["board = ", "compatible = ", "backlight = ", "mask = ", "preset = ", "reference = ", "minutes = "];
    let text: String = uncommented()
        .lines()
        .filter(|line| !without_default.iter().any(|key| line.starts_with(key)))
        .filter(|line| !line.contains("KEY_PLAYPAUSE") && !line.starts_with("115"))
        .map(|line| format!("{line}\n"))
        .collect();
    fs::write(&board, other).unwrap();
    fs::write(&file, text).unwrap();
    let got =
        Config::resolve(&run_args(&["--board", board.to_str().unwrap(), "--config", file.to_str().unwrap()]))
            .unwrap_or_else(|error| panic!("{error}"));
    let default = Config::default();
    let want = Config {
        // What the other text said and the default text has no word to take back.
        backlight: got.backlight.clone(),
        keys: got.keys.clone(),
        look: Look {
            mask: got.look.mask.clone(),
            reference: got.look.reference.clone(),
            season: got.look.season,
            around_minutes: got.look.around_minutes,
            ..default.look.clone()
        },
        ..default
    };
    assert_eq!(shown(&got), shown(&want));
}

#[test]
fn every_key_is_explained_in_the_default_text_and_taken() {
    let (explained, other) = (keys_of(DEFAULT), keys_of(OTHER));
    let free = |key: &&String| !key.starts_with("buttons.") && !key.starts_with("keys.");
    let missing: Vec<_> = explained
        .difference(&other)
        .filter(free)
        .filter(|key| ![".board", ".compatible", "life.preset"].contains(&key.as_str()))
        .collect();
    assert_eq!(missing, Vec::<&String>::new(), "not tried here");
    // What is known is listed by the message on what is not.
    for section in ["display", "photos", "life", "night", "memory", "log"] {
        let (_, message) = fault(&format!("[{section}]\nzebra = 1"));
        let (_, known) = message.split_once("the known ones are ").expect("a list");
        let known: BTreeSet<String> = known.split(", ").map(|key| format!("{section}.{key}")).collect();
        let here = |key: &&String| key.starts_with(&format!("{section}."));
        assert_eq!(known, explained.iter().filter(here).cloned().collect(), "{section}");
    }
    good(&uncommented());
}

#[test]
fn every_key_does_what_it_says() {
    let config =
        config_file::parse("/etc/frame/config.toml", OTHER).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(config.display, "sim:480x320:RGB565".parse().unwrap());
    assert_eq!((config.rotation, config.frames_per_second), (Rotation::ThreeQuarter, 30));
    assert_eq!(config.backlight.as_deref(), Some(Path::new("/sys/class/backlight/10-0045")));
    assert_eq!(config.photos, ["/etc/frame/holiday", "/srv/photos"].map(PathBuf::from));
    assert_eq!((config.order, config.fade), (Order::Date, Duration::from_millis(500)));
    let Look { life, mask, fit, background, seconds, reference, .. } = config.look;
    assert_eq!(reference.as_deref(), Some(Path::new("/etc/frame/sunset.jpg")));
    let Settings { mode, search, depth, rotation: _ } = life.kaleidoscope;
    assert_eq!((mode, search, depth), (Mode::Literal, Search::FilterC, 2));
    assert_eq!((fit, background, seconds), (Fit::Plain, [0x10, 0xff, 0x20], 5));
    assert_eq!(mask, Some(MaskChoice::File("/etc/frame/leaves.png".into())));
    let (drive, shimmer) = (life.drive, life.shimmer);
    assert_eq!(
        (drive.amplitude, drive.frequency, drive.phase),
        (Kind::White, Kind::Chaos, PhaseForm::Literal)
    );
    assert_eq!((shimmer.range, shimmer.branch), (Range::Full, Branch::Scattered));
    assert_eq!(shimmer.light.azimuth, Turns::from_degrees(315));
    assert_eq!(shimmer.light.elevation, Turns::from_degrees(90));
    assert_eq!((shimmer.relief, shimmer.strength), (Factor::from_num(2), Factor::from_num(0.25)));
    assert_eq!(shimmer.wind, Turns::from_degrees(270));
    assert_eq!(config.seed, u64::MAX);
    let action = |press: &str| config.actions.action(press.parse().unwrap());
    let presses = ["right", "space:long", "space"].map(action);
    assert_eq!(presses, [Some(Action::Previous), None, Some(Action::Pause)]);
    assert_eq!(config.keys, codes(&[("115", Button::Up), ("KEY_PLAYPAUSE", Button::Space)]));
    let edges: Vec<_> = config.night.edges().iter().map(|edge| (edge.minute, edge.level)).collect();
    assert_eq!(edges, [(420, Level::Percent(100)), (1290, Level::Percent(40)), (1380, Level::Off)]);
    assert!(matches!(config.night.zone, Zone::Named(name) if name == "Asia/Tokyo"));
    assert_eq!(config.clock, Trust::AsItIs);
    assert_eq!((config.memory_ceiling_bytes, config.log), (64 << 20, log::LevelFilter::Debug));
}

#[test]
fn an_unknown_key_is_told_with_its_place_and_what_may_be_meant() {
    let (place, message) = fault("# frame\n[display]\n  fsp = 12\n");
    assert_eq!(place, (3, 3));
    assert_eq!(
        message,
        "unknown key fsp; did you mean fps?; the known ones are output, rotation, fps, backlight"
    );
    let (place, message) = fault("[disply]\nfps = 12\n");
    assert_eq!(place, (1, 2));
    assert!(message.contains("unknown section disply; did you mean display?"), "{message}");
    assert_eq!(fault("[photos]\nfps = 12"), ((2, 1), "fps belongs in [display]".into()));
    assert_eq!(fault("fps = 12"), ((1, 1), "fps belongs in [display]".into()));
    assert_eq!(fault("[log]\nboard = \"qemu\"").1, "board belongs before the first [section]");
    assert!(fault("display = 5").1.contains("write [display] on a line of its own"));
    assert!(fault("[keys]\nRIGHT = \"right\"").1.contains("like KEY_LEFT"));
    assert!(fault("[keys]\n\"KEY\\n\" = \"right\"").1.starts_with("KEY\\n: unknown key"));
}

#[test]
fn a_wrong_value_is_told_with_its_place_and_what_is_needed() {
    for (text, at, needed) in [
        ("[display]\nfps = \"12\"", (2, 7), "fps: a number is needed; this is a text"),
        ("[display]\nfps = 12.5", (2, 7), "fps: a whole number from 12 to 60 is needed"),
        ("[display]\nfps = 11", (2, 7), "fps: a whole number from 12 to 60 is needed"),
        ("[display]\nfps = 0x18", (2, 7), "fps: a decimal number is needed"),
        (
            "[display]\nfps = 99999999999999999999999999",
            (2, 7),
            "fps: a whole number from 12 to 60 is needed",
        ),
        (
            "[display]\nrotation = 45",
            (2, 12),
            "rotation: unknown rotation; the known ones are 0, 90, 180 and 270",
        ),
        ("[display]\noutput = true", (2, 10), "output: a text in quotes is needed; this is true or false"),
        ("[photos]\nfit = 3", (2, 7), "fit: a text in quotes is needed; this is a number"),
        ("[photos]\nfit = \"fil\"", (2, 7), "fit: unknown fit; the known ones are blurred, fill, plain"),
        ("[photos]\nfade = nan", (2, 8), "fade: a number of seconds from 0 to 5 is needed"),
        ("[photos]\nfade = -0.1", (2, 8), "fade: a number of seconds from 0 to 5 is needed"),
        ("[photos]\nseconds = 1e300", (2, 11), "seconds: a whole number from 5 to 86400 is needed"),
        ("[photos]\nfolders = \"x\"", (2, 11), "folders: a list in brackets is needed; this is a text"),
        (
            "[photos]\nfolders = [\"a\",\n  7]",
            (3, 3),
            "folders: a text in quotes is needed; this is a number",
        ),
        ("[photos]\nfolders = [\"~/x\"]", (2, 12), "folders: ~ is not known here"),
        ("[photos]\nbackground = \"black\"", (2, 14), "background: a colour is #RRGGBB"),
        ("[life]\nrelief = nan", (2, 10), "relief: a number from 0 to 4 is needed"),
        ("[life]\nrelief = inf", (2, 10), "relief: a number from 0 to 4 is needed"),
        ("[life]\nstrength = 1e999999999", (2, 12), "strength: a number from 0 to 4 is needed"),
        ("[life]\nstrength = -1", (2, 12), "strength: a number from 0 to 4 is needed"),
        ("[life]\nwind = 100000", (2, 8), "wind: whole degrees are needed"),
        ("[life]\nlight = \"1\"", (2, 9), "light: a light is AZIMUTH,ELEVATION"),
        ("[life]\npreset = \"tree\"", (2, 10), "preset: unknown preset; the known ones are poplar, rowan"),
        ("[life]\namplitude = \"pink\"", (2, 13), "amplitude: unknown noise; the known ones are"),
        ("[life]\nseed = -1", (2, 8), "seed: a whole number from 0 to 18446744073709551615"),
        ("[life]\neffect = \"fire\"", (2, 10), "effect: unknown effect"),
        ("[buttons]\nspace = \"nap\"", (2, 9), "space: unknown action; the known ones are next"),
        ("[buttons]\nspade = \"next\"", (2, 9), "spade: unknown button; the known ones are left"),
        ("[buttons]\nspace = 1", (2, 9), "space: a text in quotes is needed"),
        ("[keys]\nKEY_A = \"a\"", (2, 9), "KEY_A: unknown button; the known ones are left"),
        ("[night]\ntimes = [\"7:00 1%\", \"07:00 2%\"]", (2, 21), "times: this time is in the list already"),
        ("[night]\ntimes = [\"25:00 1%\"]", (2, 10), "times: a time of day"),
        ("[night]\ntimes = [07:00:00]", (2, 10), "times: a text in quotes is needed; this is a date or time"),
        (
            "[night]\nclock = \"now\"",
            (2, 9),
            "clock: unknown clock; the known ones are synchronised, as-it-is",
        ),
        ("[night]\nzone = \"../../etc/passwd\"", (2, 8), "zone: local or the name of a time zone"),
        ("[memory]\nceiling = 1", (2, 11), "ceiling: a whole number from 16 to 65536 is needed"),
        ("[log]\nlevel = \"loud\"", (2, 9), "level: unknown level; the known ones are off, error"),
    ] {
        let (place, message) = fault(text);
        assert_eq!(place, at, "{text}: {message}");
        assert!(message.starts_with(needed), "{text}: {message}");
    }
}

#[test]
fn what_is_no_toml_is_told_with_its_place() {
    for (text, line) in
        [("[display]\nfps = \n", 2), ("[display\n", 1), ("a = 1\na = 2", 2), ("x", 1), ("a = '\u{0}'", 1)]
    {
        let error = parse(text).expect_err(text);
        assert_eq!(error.faults[0].place.map(|place| place.line), Some(line), "{error}");
        assert_eq!(error.to_string().lines().count(), error.faults.len(), "{error}");
    }
}

#[test]
fn all_mistakes_are_told_in_the_order_of_the_text() {
    let error = parse("[photos]\nfit = 1\nzebra = 2\n[display]\nfps = 1\n").unwrap_err();
    let lines: Vec<_> = error.faults.iter().map(|fault| fault.place.unwrap().line).collect();
    assert_eq!(lines, [2, 3, 5]);
}

#[test]
fn a_preset_is_taken_for_its_range_and_noises_and_single_keys_go_before_it() {
    let look = good("[life]\nwind = 0\nfrequency = \"white\"\npreset = \"river\"").look;
    let (drive, shimmer) = (look.life.drive, look.life.shimmer);
    assert_eq!(
        (shimmer.range, drive.amplitude, drive.frequency),
        (Range::Neighbourhood, Kind::Filter, Kind::White)
    );
    assert_eq!(shimmer.wind, Turns::default());
    assert_eq!("river".parse(), Ok(Preset::River));
}

/// Files in a folder that goes with the value.
struct Files(TempDir);

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let files_in = Self(TempDir::new().unwrap());
        for (name, text) in files {
            fs::write(files_in.path(name), text).unwrap();
        }
        files_in
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn word(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }
}

#[test]
fn the_board_the_file_and_the_arguments_go_before_each_other_in_this_order() {
    let files = Files::new(&[
        (
            "board.toml",
            "[display]\nfps = 24\nrotation = 90\n[life]\nwind = 1\nseed = 5\n[keys]\n1 = \"up\"\n2 = \"up\"",
        ),
        (
            "config.toml",
            "board = \"qemu\"\n[display]\nrotation = 180\n[photos]\nfolders = [\"here\"]\n[life]\nwind = 2\nseed = 6\n[keys]\n2 = \"down\"",
        ),
    ]);
    let (board, file) = (files.word("board.toml"), files.word("config.toml"));
    let words = ["--board", &board, "--config", &file, "--wind", "3", "--seed", "7"];
    let config = Config::resolve(&run_args(&words)).unwrap();
    assert_eq!((config.frames_per_second, config.rotation, config.seed), (24, Rotation::Half, 7));
    assert_eq!(config.plain_look().life.shimmer.wind, Turns::from_degrees(3));
    assert_eq!(config.photos, [files.path("here")]);
    assert_eq!(config.keys, codes(&[("1", Button::Up), ("2", Button::Down)]));

    let words = ["shown", "--config", &file, "--display", "window", "--fps", "15", "--rotate", "270"];
    let config = Config::resolve(&run_args(&words)).unwrap();
    assert_eq!(config.photos, [PathBuf::from("shown")]);
    assert_eq!((config.display, config.frames_per_second), (DisplayChoice::Window, 15));
    assert_eq!((config.rotation, config.seed), (Rotation::ThreeQuarter, 6));
    assert_eq!(config.memory_ceiling_bytes, 128 << 20, "the file names a board with this ceiling");
}

#[test]
fn a_board_that_is_not_known_or_names_another_is_refused() {
    let files =
        Files::new(&[("board.toml", "board = \"qemu\""), ("config.toml", "board = \"raspberry-pi4\"")]);
    let refused = |words: &[&str]| Config::resolve(&run_args(words)).unwrap_err().to_string();
    let (board, file) = (files.word("board.toml"), files.word("config.toml"));
    assert!(refused(&["--config", &file]).contains("did you mean raspberry-pi-4?"));
    assert!(refused(&["--config", &files.word("none.toml")]).starts_with(&files.word("none.toml")));
    fs::write(&file, "").unwrap();
    assert!(refused(&["--config", &file, "--board", &board]).contains("names no board"));
    fs::write(&file, "compatible = [\"linux,dummy-virt\"]").unwrap();
    assert!(refused(&["--config", &file]).contains("only in the file of a board"));
}

#[test]
fn a_board_is_told_by_the_most_specific_name_in_its_device_tree() {
    let files = Files::new(&[
        ("pi", "raspberrypi,4-model-b\0brcm,bcm2711\0"),
        ("virt", "linux,dummy-virt\0"),
        ("later", "some,carrier\0raspberrypi,5-model-b\0linux,dummy-virt\0"),
        ("unknown", "some,board\0"),
        ("longer", "raspberrypi,4-model-bc\0"),
        ("empty", ""),
    ]);
    fs::write(files.path("binary"), b"\xff\xfe\0linux,dummy-virt\0").unwrap();
    let told = |name| board::detect(&files.path(name));
    assert_eq!(told("pi"), Some("raspberry-pi-4"));
    assert_eq!(told("virt"), Some("qemu"));
    assert_eq!(told("later"), Some("raspberry-pi-5"));
    assert_eq!(told("binary"), Some("qemu"), "what is no text is passed over");
    for name in ["unknown", "longer", "empty", "not-there"] {
        assert_eq!(told(name), None, "{name}");
    }
}

#[test]
fn no_device_tree_is_that_of_two_boards() {
    let mut all = BTreeSet::new();
    for (name, text) in BOARDS {
        let line = text.lines().find(|line| line.starts_with("compatible = "));
        for tree in line.unwrap_or_default().split('"').filter(|part| part.contains(',') && *part != ", ") {
            assert!(all.insert(tree), "{name}: {tree}");
        }
    }
    assert!(all.len() >= 12, "{all:?}");
}

#[test]
fn every_board_file_is_good_and_known_by_its_name() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("board");
    let mut files: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    let mut known: Vec<_> = BOARDS.iter().map(|(name, _)| name.to_string()).collect();
    files.sort();
    known.sort();
    assert_eq!(known, files);
    for (name, text) in BOARDS {
        assert!(board::title(text).len() > 20, "{name}: a line that says what it is");
        let files = Files::new(&[("config.toml", "")]);
        let words = ["--config", &files.word("config.toml"), "--board", name];
        Config::resolve(&run_args(&words)).unwrap_or_else(|error| panic!("{error}"));
    }
}

fn look(text: &str) -> Result<Look, ConfigError> {
    sidecar::parse(Path::new("/photos/lake.jpg.toml"), text, &Look::default())
}

#[test]
fn a_sidecar_changes_what_it_names_of_one_photo() {
    let text = "effect = \"shimmer\"\npreset = \"river\"\namplitude = \"white\"\nbranch = \"falling\"\nlight = \"0,30\"\n\
                relief = 2\nstrength = 3\nwind = 180\nmask = \"leaves.png\"\nfit = \"fill\"\nseconds = 600\nphase = \"literal\"";
    let got = look(text).unwrap();
    let mut want = Look { fit: Fit::Fill, seconds: 600, ..Look::default() };
    want.mask = Some(MaskChoice::File("/photos/leaves.png".into()));
    (want.life.drive.amplitude, want.life.drive.frequency) = (Kind::White, Kind::Constant);
    want.life.drive.phase = PhaseForm::Literal;
    let shimmer = &mut want.life.shimmer;
    (shimmer.range, shimmer.branch) = (Range::Neighbourhood, Branch::Falling);
    (shimmer.relief, shimmer.strength) = (Factor::from_num(2), Factor::from_num(3));
    (shimmer.light.azimuth, shimmer.light.elevation) = (Turns::default(), Turns::from_degrees(30));
    shimmer.wind = Turns::from_degrees(180);
    assert_eq!(got, want);
    assert_eq!(look("").unwrap(), Look::default());
}

#[test]
fn a_sidecar_has_no_sections_and_says_nothing_of_the_frame() {
    let message = |text: &str| look(text).unwrap_err().to_string();
    assert!(message("[life]\nwind = 1").contains("unknown section life"), "{}", message("[life]\nwind = 1"));
    assert!(message("seed = 1").contains("unknown key seed"));
    assert!(message("secnds = 9").contains("did you mean seconds?"));
    assert!(message("\nwind = \"w\"").starts_with("/photos/lake.jpg.toml:2:8: wind: "));
}

#[test]
fn the_command_line_goes_before_a_sidecar_and_a_sidecar_before_the_configuration() {
    let files = Files::new(&[
        ("lake.jpg.toml", "wind = 20\nrelief = 2"),
        ("lake.toml", "wind = 30"),
        ("config.toml", "[life]\nwind = 10\nrelief = 1\nstrength = 3"),
    ]);
    let config = files.word("config.toml");
    let shimmer = |photo: &str, words: &[&str]| {
        let words = [&["--config", &config], words].concat();
        Config::resolve(&run_args(&words)).unwrap().look(&files.path(photo)).life.shimmer
    };
    let numbers = |wind, relief| (Turns::from_degrees(wind), Factor::from_num(relief));
    for (photo, words, want) in [
        ("sea.jpg", &[][..], numbers(10, 1)),
        ("lake.png", &[], numbers(30, 1)),
        ("lake.jpg", &[], numbers(20, 2)),
        ("lake.jpg", &["--relief", "4"], numbers(20, 4)),
    ] {
        let got = shimmer(photo, words);
        assert_eq!((got.wind, got.relief, got.strength), (want.0, want.1, Factor::from_num(3)), "{photo}");
    }
}

#[test]
fn a_bad_sidecar_is_one_line_and_the_photo_is_shown_without_it() {
    let files = Files::new(&[("lake.toml", "wind = true\nzebra = 1")]);
    fs::create_dir(files.path("sea.jpg.toml")).unwrap();
    crate::logbook::lines();
    let config = Config::default();
    assert_eq!(config.look(&files.path("lake.jpg")), Look::default());
    assert_eq!(config.look(&files.path("sea.jpg")), Look::default());
    let lines = crate::logbook::lines();
    let [lake, sea] = &lines[..] else { panic!("{lines:?}") };
    assert!(lake.starts_with("WARN") && lake.contains("lake.toml:1:8: wind: a number is needed"), "{lake}");
    assert!(lake.ends_with("(and 1 more); the photo is shown without it"), "{lake}");
    assert!(sea.contains("sea.jpg.toml: this is no file"), "{sea}");
}

fn yurameki(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_yurameki")).args(words).env_remove("RUST_LOG").output().unwrap()
}

fn stdout(output: &Output) -> &str {
    str::from_utf8(&output.stdout).unwrap()
}

fn stderr(output: &Output) -> &str {
    str::from_utf8(&output.stderr).unwrap()
}

#[test]
fn a_sidecar_is_seen_in_the_frames() {
    let files = Files::new(&[]);
    let photo = files.word("drawn.png");
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/drawn.png"), &photo).unwrap();
    let hash = |words: &[&str]| {
        let base =
            ["render", &photo, "--hash", "--frames", "16", "--size", "96x64", "--quiet", "--mask", "none"];
        let output = yurameki(&[&base, words].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stdout(&output).to_owned()
    };
    let without = hash(&[]);
    fs::write(files.path("drawn.png.toml"), "range = \"full\"\namplitude = \"white\"\nstrength = 4").unwrap();
    let with = hash(&[]);
    assert_ne!(with, without);
    assert_eq!(hash(&["--range", "travelling", "--amplitude", "brown", "--strength", "1"]), without);
    fs::remove_file(files.path("drawn.png.toml")).unwrap();
    assert_eq!(hash(&["--range", "full", "--amplitude", "white", "--strength", "4"]), with);
}

#[test]
fn a_show_takes_its_display_and_photos_from_the_configuration() {
    let photo = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/drawn.png");
    let text = format!(
        "[display]\noutput = \"sim:64x48\"\nfps = 60\n[photos]\nfolders = [{photo:?}]\n[log]\nlevel = \"error\""
    );
    let files = Files::new(&[("config.toml", &text)]);
    let output = yurameki(&["run", "--config", &files.word("config.toml"), "--frames", "3"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).starts_with("3 frames"), "{}", stdout(&output));
    assert_eq!(stderr(&output), "");
}

#[test]
fn the_command_config_prints_checks_and_lists() {
    let printed = yurameki(&["config", "--default"]);
    assert_eq!((printed.status.code(), stdout(&printed)), (Some(0), DEFAULT));
    let files = Files::new(&[("good.toml", DEFAULT), ("bad.toml", "[display]\nfps = 1\nfsp = 2\n")]);
    let good = yurameki(&["config", "--check", &files.word("good.toml")]);
    assert_eq!(
        (good.status.code(), stdout(&good)),
        (Some(0), &*format!("{}: good\n", files.word("good.toml")))
    );
    let bad = yurameki(&["config", "--check", &files.word("bad.toml")]);
    let lines: Vec<&str> = stderr(&bad).lines().collect();
    assert_eq!((bad.status.code(), lines.len()), (Some(2), 2));
    for (line, place) in lines.iter().zip(["2:7: fps: ", "3:1: unknown key fsp"]) {
        assert!(line.starts_with(&format!("yurameki: {}:{place}", files.word("bad.toml"))), "{line}");
    }
    let boards = yurameki(&["config", "--boards"]);
    assert_eq!(stdout(&boards).lines().count(), BOARDS.len());
    let board = yurameki(&["config", "--board", "qemu"]);
    assert_eq!(Ok(stdout(&board)), board::find("qemu"));
    assert_eq!(yurameki(&["config", "--board", "qem"]).status.code(), Some(2));
    assert_eq!(yurameki(&["config"]).status.code(), Some(2));
}

#[test]
fn a_bad_configuration_ends_a_show_before_it_begins() {
    let files = Files::new(&[("bad.toml", "[display]\nfps = 1\n")]);
    let bad = yurameki(&["run", "--config", &files.word("bad.toml"), "x.jpg"]);
    assert_eq!(bad.status.code(), Some(2));
    assert!(stderr(&bad).contains("bad.toml:2:7: fps"), "{}", stderr(&bad));
}

#[test]
fn encodings_of_other_editors_are_taken_or_refused_by_name() {
    let files = Files::new(&[]);
    let file = files.word("config.toml");
    let resolve = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        Config::resolve(&run_args(&["--config", &file]))
    };
    let text = "\u{feff}[display]\r\nfps = 24\r\n";
    assert_eq!(resolve(text.as_bytes()).unwrap().frames_per_second, 24);
    let refused = |bytes: &[u8]| resolve(bytes).unwrap_err().to_string();
    let place = |at: &str| format!("{file}:{at}: ");
    assert!(refused(b"\xef\xbb\xbf[display]\r\nfps = x\r\n").starts_with(&place("2:7")));
    assert!(refused(b"\xef\xbb\xbfzebra = 1").starts_with(&place("1:1")));
    let latin = refused(b"[photos]\nfolders = [\"Stra\xdfe\"]\n");
    assert!(latin.starts_with(&place("2:17")) && latin.contains("Latin-1"), "{latin}");
    let utf16: Vec<u8> = "\u{feff}fps = 24".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(refused(&utf16).contains("UTF-16"));
    assert!(refused(&[b'#'; (1 << 20) + 1]).contains("1 MiB"));
    let folder = files.0.path().to_str().unwrap();
    assert!(Config::resolve(&run_args(&["--config", folder])).unwrap_err().to_string().contains("no file"));
}

#[test]
fn nests_without_end_and_endless_words_are_refused_quickly() {
    for text in [
        "a = ".to_owned() + &"[".repeat(500_000),
        "a.".repeat(100_000) + "b = 1",
        "z".repeat(900_000) + " = 1",
    ] {
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.len() < 1_000, "{}", error.len());
    }
}

/// Pieces of which hostile texts are made.
const PIECES: [&str; 24] = [
    "[", "]", "[[", "]]", "\n", " = ", "\"", "'''", "{", "}", ",", ".", "display", "fps", "night", "times",
    "keys", "nan", "-1", "1e9", "0x", "07:00", "\u{feff}", "ö",
];

proptest! {
    #[test]
    fn no_text_makes_the_parsers_panic(pieces in prop::collection::vec(prop::sample::select(&PIECES[..]), 0..40), any in ".{0,40}") {
        let text = pieces.concat() + &any;
        for error in [parse(&text).err(), look(&text).err()].into_iter().flatten() {
            prop_assert!(!error.faults.is_empty());
            prop_assert_eq!(error.to_string().lines().count(), error.faults.len());
        }
    }

    #[test]
    fn a_good_text_with_one_byte_changed_does_not_panic(at in 0..DEFAULT.len(), byte in 0_u8..128) {
        let mut bytes = DEFAULT.as_bytes().to_vec();
        bytes[at] = byte;
        if let Ok(text) = String::from_utf8(bytes) {
            let _ = parse(&text);
        }
    }
}
