//! The configuration file: TOML, of which `default.toml` explains every key. A board's file has the same keys.

use super::{
    args,
    autumn::{PlatesChoice, TreeChoice},
    config::{Config, Look},
    document::{ConfigError, Document, number, text, whole, word, worded},
};
use crate::{
    config::{FRAMES_PER_SECOND, Preset, night::Zone},
    effect::kaleidoscope,
    input::Button,
    math::Turns,
};
use log::LevelFilter;
use std::{
    path::{Path, PathBuf},
    time::Duration,
};
use toml::de::DeValue;

/// The file with every key, its unit, its range and its default.
pub const DEFAULT: &str = include_str!("default.toml");

/// The configuration that `text` makes of the defaults; `name` stands for it in messages.
///
/// # Errors
/// Every mistake in it, with its line and column.
pub fn parse(name: &str, text: &str) -> Result<Config, ConfigError> {
    let mut config = Config::default();
    apply(Path::new(name), text, &mut config)?;
    Ok(config)
}

/// What a file says of boards.
#[derive(Debug, Default)]
pub(super) struct Heading {
    /// The board that it goes before.
    pub(super) board: Option<String>,
    /// What the device trees of the board that it is the file of call it.
    pub(super) compatible: Vec<String>,
}

/// Puts what the `text` of the file at `path` says in place of what `config` says, and gives what it says of boards. Paths in
/// it start from the file's folder. After a mistake `config` is of no use.
pub(super) fn apply(path: &Path, text: &str, config: &mut Config) -> Result<Heading, ConfigError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.display().to_string();
    let mut parsed = Document::parse(&name, text)?;
    let document = &mut parsed;
    let mut heading = Heading::default();
    document.read_some(("", "board"), &mut heading.board, word);
    document.read_list(("", "compatible"), |value| {
        heading.compatible.push(word(value)?);
        Ok(())
    });
    display(document, config);
    photos(document, config, folder);
    life(document, "life", &mut config.look, folder);
    document.read(("life", "seed"), &mut config.seed, whole(0..=u64::MAX));
    buttons(document, config);
    night(document, config);
    season(document, config);
    let memory = &mut config.memory_ceiling_bytes;
    document.read(("memory", "ceiling"), memory, |value| Ok(u64::from(whole(16..=65_536_u32)(value)?) << 20));
    document.read(("log", "level"), &mut config.log, worded(level));
    parsed.finish()?;
    Ok(heading)
}

fn display(document: &mut Document<'_>, config: &mut Config) {
    document.read(("display", "output"), &mut config.display, word);
    document.read(("display", "rotation"), &mut config.rotation, number(str::parse));
    document.read(("display", "fps"), &mut config.frames_per_second, whole(FRAMES_PER_SECOND));
    document.read_some(("display", "backlight"), &mut config.backlight, |value| {
        path(value, Path::new("/sys/class/backlight"))
    });
}

fn photos(document: &mut Document<'_>, config: &mut Config, folder: &Path) {
    if document.has(("photos", "folders")) {
        config.photos.clear();
    }
    document.read_list(("photos", "folders"), |value| {
        config.photos.push(path(value, folder)?);
        Ok(())
    });
    document.read(("photos", "order"), &mut config.order, word);
    document.read(("photos", "fade"), &mut config.fade, number(fade));
    shown(document, "photos", &mut config.look);
    document.read(("photos", "background"), &mut config.look.background, worded(colour));
}

/// What of the section on photos the sidecar of one photo can say too.
pub(super) fn shown(document: &mut Document<'_>, section: &'static str, look: &mut Look) {
    document.read((section, "seconds"), &mut look.seconds, whole(5..=86_400));
    document.read((section, "fit"), &mut look.fit, word);
}

/// How a photo lives: the keys of a section, or of a sidecar.
pub(super) fn life(document: &mut Document<'_>, section: &'static str, look: &mut Look, folder: &Path) {
    let mut preset: Option<Preset> = None;
    document.read_some((section, "preset"), &mut preset, word);
    if let Some(preset) = preset {
        preset.apply(&mut look.life);
    }
    let (drive, shimmer) = (&mut look.life.drive, &mut look.life.shimmer);
    document.read((section, "effect"), &mut look.effect, word);
    document.read((section, "amplitude"), &mut drive.amplitude, word);
    document.read((section, "frequency"), &mut drive.frequency, word);
    document.read((section, "phase"), &mut drive.phase, worded(args::phase));
    document.read((section, "range"), &mut shimmer.range, word);
    document.read((section, "branch"), &mut shimmer.branch, word);
    document.read((section, "light"), &mut shimmer.light, worded(args::light));
    document.read((section, "relief"), &mut shimmer.relief, number(args::factor));
    document.read((section, "strength"), &mut shimmer.strength, number(args::factor));
    document.read((section, "wind"), &mut shimmer.wind, number(wind));
    let settings = &mut look.life.kaleidoscope;
    document.read((section, "mode"), &mut settings.mode, word);
    document.read((section, "search"), &mut settings.search, word);
    document.read((section, "depth"), &mut settings.depth, whole(kaleidoscope::Settings::DEPTHS));
    document.read_some((section, "reference"), &mut look.reference, |value| path(value, folder));
    document.read((section, "tree"), &mut look.tree, |value| {
        Ok(match word(value)? {
            TreeChoice::File(_) => TreeChoice::File(path(value, folder)?),
            choice => choice,
        })
    });
    document.read((section, "plates"), &mut look.plates, |value| {
        Ok(match word(value)? {
            PlatesChoice::Folder(_) => PlatesChoice::Folder(path(value, folder)?),
            choice => choice,
        })
    });
    document.read_some((section, "around-minutes"), &mut look.around_minutes, whole(5..=1_440));
    let autumn = &mut look.life.autumn;
    document.read((section, "patchiness"), &mut autumn.patchiness, number(args::share));
    document.read((section, "sun"), &mut autumn.sun, |value| worded(args::sun)(value).map(|sun| sun.0));
    document.read((section, "leaf-fall"), &mut autumn.leaf_fall, worded(args::on_off));
    document.read_some((section, "mask"), &mut look.mask, |value| {
        Ok(match word(value)? {
            args::MaskChoice::File(_) => args::MaskChoice::File(path(value, folder)?),
            choice => choice,
        })
    });
}

fn buttons(document: &mut Document<'_>, config: &mut Config) {
    document.read_section("buttons", |press, action| {
        config.actions.assign(press, text(action)?).map_err(|error| error.to_string())
    });
    document.read_section("keys", |key, button| {
        let button: Button = word(button)?;
        // Only Linux tells of keys by these names and numbers.
        #[cfg(target_os = "linux")]
        config.keys.assign(key, button).map_err(|error| error.to_string())?;
        #[cfg(not(target_os = "linux"))]
        let _ = (key, button);
        Ok(())
    });
}

fn night(document: &mut Document<'_>, config: &mut Config) {
    let night = &mut config.night;
    if document.has(("night", "times")) {
        night.clear();
    }
    document
        .read_list(("night", "times"), |value| night.insert(word(value)?).map_err(|error| error.to_string()));
    document.read(("night", "zone"), &mut night.zone, word::<Zone>);
    document.read(("night", "clock"), &mut config.clock, word);
}

fn season(document: &mut Document<'_>, config: &mut Config) {
    let calendar = &mut config.calendar;
    document.read(("season", "hemisphere"), &mut calendar.hemisphere, word);
    document.read(("season", "green"), &mut calendar.green, word);
    document.read(("season", "turns"), &mut calendar.turns, word);
    document.read(("season", "full"), &mut calendar.full, word);
    document.read(("season", "bare"), &mut calendar.bare, word);
    document.read_some(("season", "minutes"), &mut config.look.season.minutes, whole(1..=1_440));
}

/// A path, which starts from `folder` if it is not absolute.
fn path(value: &DeValue<'_>, folder: &Path) -> Result<PathBuf, String> {
    match text(value)? {
        "" => Err("a path is needed; this is empty".into()),
        home if home.starts_with('~') => {
            Err("~ is not known here; write the whole path, like /home/me".into())
        }
        nul if nul.contains('\0') => Err("a path holds no NUL".into()),
        path => Ok(folder.join(path)),
    }
}

fn fade(word: &str) -> Result<Duration, &'static str> {
    let seconds = word.parse::<f64>().ok().filter(|seconds| (0.0..=5.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or("a number of seconds from 0 to 5 is needed")
}

fn wind(word: &str) -> Result<Turns, &'static str> {
    let degrees = word.parse::<i16>().map_err(|_| "whole degrees are needed, like 90")?;
    Ok(Turns::from_degrees(degrees.into()))
}

fn colour(word: &str) -> Result<[u8; 3], &'static str> {
    let digits =
        word.strip_prefix('#').filter(|hex| hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit()));
    let code = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let [_, colour @ ..] = code.ok_or("a colour is #RRGGBB in hexadecimal, like #101820")?.to_be_bytes();
    Ok(colour)
}

fn level(word: &str) -> Result<LevelFilter, &'static str> {
    let known = LevelFilter::iter().find(|level| level.as_str().eq_ignore_ascii_case(word));
    known.ok_or("unknown level; the known ones are off, error, warn, info, debug, trace")
}
