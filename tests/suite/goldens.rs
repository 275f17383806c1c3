//! Whole films against the hashes of `tests/goldens/frames.txt`: everything is integer, so nothing may differ.
//!
//! Every film but one has all its settings spelt out, so that a better default changes that one alone.

use crate::stage::{Staging, Still};
use std::{collections::BTreeMap, env, fmt::Write as _, fs, path::Path, process::Command};
use yurameki::{
    config::Life,
    display::sim::Buffering,
    effect::{
        autumn, kaleidoscope,
        shimmer::{self, Branch, Light, Range},
    },
    frame::{Layout, PixelFormat, Size},
    input::action::Action,
    math::{Factor, Turns},
    noise::{
        Kind,
        drive::{self, PhaseForm},
    },
    os::output::{FrameHash, FrameRate, Target, Writer},
};

/// The bless that the first line of the file explains.
const BLESS: &str = "YURAMEKI_BLESS";

const FIRST_LINE: &str = "# SHA-256 over 48 frames each, by tests/suite/goldens.rs; after a wanted change write them anew by: \
     YURAMEKI_BLESS=1 cargo test --test suite goldens";

const FRAMES: u32 = 48;

/// Not a multiple of anything, and wide enough for several runs of the kernel.
const DRAWN: Size = Size::new(163, 61);
const DEMO: Size = Size::new(160, 120);

struct Film {
    name: String,
    still: Source,
    staging: Staging<'static>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Drawn,
    DrawnWithHoles,
    Demo,
    DemoWithHoles,
}

impl Source {
    fn still(self) -> Still {
        match self {
            Self::Drawn => Still::drawn(DRAWN),
            Self::DrawnWithHoles => Still::drawn(DRAWN).with_holes(),
            Self::Demo => Still::demo(DEMO),
            Self::DemoWithHoles => Still::demo(DEMO).with_holes(),
        }
    }

    fn size(self) -> Size {
        match self {
            Self::Drawn | Self::DrawnWithHoles => DRAWN,
            Self::Demo | Self::DemoWithHoles => DEMO,
        }
    }
}

/// A life without a default in it.
fn life(range: Range) -> Life {
    Life {
        drive: drive::Settings {
            amplitude: Kind::Filter,
            frequency: Kind::White,
            period_frames: 17,
            response_frames: 9,
            glide_frames: 6,
            phase: PhaseForm::Integrated,
        },
        shimmer: shimmer::Settings {
            range,
            branch: Branch::Rising,
            light: Light { azimuth: Turns::from_degrees(300), elevation: Turns::from_degrees(40) },
            relief: Factor::ONE,
            strength: Factor::ONE,
            wind: Turns::from_degrees(75),
        },
        kaleidoscope: kaleidoscope::Settings::default(),
        autumn: autumn::Settings::default(),
    }
}

fn film(name: impl Into<String>, still: Source, life: Life) -> Film {
    let layout = Layout::new(still.size(), PixelFormat::Xrgb8888, None).expect("a good layout");
    let staging =
        Staging { life, frames_per_second: 12, seed: 7, layout, buffering: Buffering::Double, presses: &[] };
    Film { name: name.into(), still, staging }
}

fn ranges() -> impl Iterator<Item = (&'static str, Range)> {
    Range::NAMES.iter().copied()
}

/// Range, branch and phase in every combination that makes a difference: the travelling range leaves no branch open.
fn combinations() -> Vec<Film> {
    let mut films = Vec::new();
    for (range_name, range) in ranges() {
        for &(branch_name, branch) in Branch::NAMES {
            for (phase_name, phase) in
                [("integrated", PhaseForm::Integrated), ("literal", PhaseForm::Literal)]
            {
                if range == Range::Travelling && branch != Branch::Rising {
                    continue;
                }
                let mut life = life(range);
                (life.shimmer.branch, life.drive.phase) = (branch, phase);
                let name = format!("drawn-{range_name}-{branch_name}-{phase_name}");
                films.push(film(name, Source::Drawn, life));
            }
        }
    }
    films
}

/// Every pixel format, rows an odd number of bytes apart.
fn formats() -> Vec<Film> {
    let with_format = |format: PixelFormat| {
        let mut film = film(format!("format-{format}"), Source::DrawnWithHoles, life(Range::Neighbourhood));
        let stride_bytes = film.staging.layout.size.width as usize * format.bytes_per_pixel() + 13;
        film.staging.layout = Layout::new(DRAWN, format, Some(stride_bytes)).expect("a good layout");
        film
    };
    PixelFormat::ALL.into_iter().map(with_format).collect()
}

/// Every noise, for the amplitude and for the frequency.
fn noises() -> Vec<Film> {
    let mut films = Vec::new();
    for kind in Kind::ALL {
        let mut amplitude = life(Range::Full);
        (amplitude.drive.amplitude, amplitude.drive.frequency) = (kind, Kind::Constant);
        films.push(film(format!("amplitude-{kind}"), Source::Drawn, amplitude));
        if kind == Kind::Constant {
            continue; // The same film.
        }
        let mut frequency = life(Range::Full);
        (frequency.drive.amplitude, frequency.drive.frequency) = (Kind::Constant, kind);
        films.push(film(format!("frequency-{kind}"), Source::Drawn, frequency));
    }
    films
}

/// Light, relief, strength and wind at their ends.
fn looks() -> Vec<Film> {
    let look = |name: &str, change: fn(&mut shimmer::Settings)| {
        let mut life = life(Range::Travelling);
        change(&mut life.shimmer);
        film(format!("look-{name}"), Source::DrawnWithHoles, life)
    };
    vec![
        look("light-from-above", |s| s.light.elevation = Turns::from_degrees(90)),
        look("light-from-low", |s| s.light.elevation = Turns::from_degrees(5)),
        look("light-from-below", |s| s.light.azimuth = Turns::from_degrees(180)),
        look("flat", |s| s.relief = Factor::ZERO),
        look("steep", |s| s.relief = Factor::from_num(4)),
        look("strong", |s| s.strength = Factor::from_num(4)),
        look("wind-from-below", |s| s.wind = Turns::from_degrees(0)),
    ]
}

/// The demo photo in every range mode; masked; at another rate; with buttons pressed.
fn demos() -> Vec<Film> {
    let mut films: Vec<Film> =
        ranges().map(|(name, range)| film(format!("demo-{name}"), Source::Demo, life(range))).collect();
    for (name, range) in ranges() {
        films.push(film(format!("demo-{name}-masked"), Source::DemoWithHoles, life(range)));
    }
    let mut fast = film("demo-30-fps", Source::Demo, life(Range::Travelling).at(30));
    (fast.staging.frames_per_second, fast.staging.seed) = (30, 2);
    films.push(fast);
    let mut pressed = film("demo-pressed", Source::DemoWithHoles, life(Range::Neighbourhood));
    pressed.staging.presses = &[
        (9, Action::Amplitude),
        (20, Action::Pause),
        (25, Action::Pause),
        (27, Action::Frequency),
        (40, Action::Amplitude),
    ];
    films.push(pressed);
    films
}

fn hash(film: &Film, still: &Still) -> String {
    let mut hash = FrameHash::new();
    film.staging.show(still, FRAMES, 0, |_, frame| hash.update(frame));
    hash.hex()
}

/// The product as it comes: default settings, automatic mask, photo decoded and fitted.
fn defaults_hash() -> String {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/demo.jpg");
    let output = Command::new(env!("CARGO_BIN_EXE_yurameki"))
        .arg("render")
        .arg(demo)
        .args(["--size", "160x120", "--frames", "48", "--hash"])
        .output()
        .expect("the program runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Writes the frames that came as pictures, and tells where.
fn keep(film: &Film, still: &Still) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("goldens").join(&film.name);
    fs::create_dir_all(&folder).expect("the target folder can be written");
    let rate = FrameRate::new(film.staging.frames_per_second, 1).expect("a rate");
    let target = Target::Folder(folder.clone());
    let mut writer = Writer::create(&target, still.size, rate, FRAMES).expect("the folder can be written");
    film.staging.show(still, FRAMES, 0, |_, frame| writer.write(frame).expect("the disk has room"));
    writer.finish().expect("the disk has room");
    folder.display().to_string()
}

fn file_text(hashes: &BTreeMap<String, String>) -> String {
    let mut text = format!("{FIRST_LINE}\n");
    for (name, hash) in hashes {
        writeln!(text, "{name} {hash}").expect("memory");
    }
    text
}

const DEFAULTS: &str = "defaults";

#[test]
fn goldens_are_met_to_the_bit() {
    let mut films = combinations();
    for more in [formats(), noises(), looks(), demos()] {
        films.extend(more);
    }
    let mut stills = BTreeMap::new();
    let mut got = BTreeMap::from([(DEFAULTS.to_owned(), defaults_hash())]);
    for film in &films {
        let still = stills.entry(film.still).or_insert_with(|| film.still.still());
        assert_eq!(
            got.insert(film.name.clone(), hash(film, still)),
            None,
            "two films are called {}",
            film.name
        );
    }

    let mut names = BTreeMap::new();
    for (name, hash) in &got {
        let twin = names.insert(hash, name);
        assert!(twin.is_none(), "{name} and {twin:?} are the same film, though their settings differ");
    }

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/frames.txt");
    if env::var_os(BLESS).is_some() {
        fs::write(&path, file_text(&got)).expect("the goldens can be written");
        return;
    }
    let file = fs::read_to_string(&path).expect("tests/goldens/frames.txt");
    if file == file_text(&got) {
        return;
    }
    let want: BTreeMap<String, String> =
        file.lines().filter_map(|line| line.split_once(' ')).map(|(n, h)| (n.into(), h.into())).collect();
    let mut report = String::new();
    for film in films.iter().filter(|film| want.get(&film.name) != got.get(&film.name)) {
        let kept = keep(film, &stills[&film.still]);
        writeln!(report, "{}: other frames, kept in {kept}", film.name).expect("memory");
    }
    if want.get(DEFAULTS) != got.get(DEFAULTS) {
        writeln!(report, "{DEFAULTS}: `yurameki render` makes other frames").expect("memory");
    }
    for name in want.keys().filter(|name| *name != "#" && !got.contains_key(*name)) {
        writeln!(report, "{name}: no film is called that any more").expect("memory");
    }
    panic!("tests/goldens/frames.txt is not met; its first line tells how to write it anew\n{report}");
}
