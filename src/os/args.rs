//! The command line, as typed.

use super::{
    autumn::{PlatesChoice, TreeChoice},
    output::{FileFormat, FrameRate, Target},
    photo::Fit,
};
use crate::{
    config::{self, EffectChoice, Preset},
    display::sim,
    effect::{
        autumn::Stage,
        kaleidoscope::{self, fractal::Search},
        shimmer::{Branch, Light, Range},
    },
    frame::{PixelFormat, Rotation, Size},
    math::{Factor, Turns},
    noise::{Kind, drive::PhaseForm},
};
use clap::{
    Parser, Subcommand,
    builder::{OsStringValueParser, TypedValueParser},
};
use std::{path::PathBuf, str::FromStr};

/// A photo frame that brings still photos to life.
///
/// Without a command it shows a built-in photo: in a window where there is a screen, else rendered to a file.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show photos, alive, on a display.
    Run(Run),
    /// Render a photo's first seconds to a file.
    Render(Render),
    /// Print a noise, one number a line.
    Noise(Noise),
    /// Write the automatic mask of a photo, to look at and edit in any paint program.
    Mask(Mask),
    /// Code a photo's luma as a fractal: a .yfc file.
    Encode(Encode),
    /// Draw the picture that a .yfc file describes.
    Decode(Decode),
    /// Print, check and explain what can be configured.
    Config(ConfigFile),
    /// List the displays with the memory that they need, the buttons, the backlights, and the state of the console.
    Probe,
    #[cfg(any(feature = "kms", feature = "linuxfb"))]
    /// Give the text console back after the program was killed.
    RestoreConsole,
}

/// Arguments of `run`.
#[derive(Clone, Debug, clap::Args)]
pub struct Run {
    /// Photos, clips, and folders of them; without any, those that the configuration names, else the built-in demo photo.
    pub photos: Vec<PathBuf>,
    /// The configuration; /etc/yurameki/config.toml where nothing is said and that is there. What is said here goes before it.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// The board, by the name or the file of its facts; `yurameki config --boards` lists them.
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub board: Option<String>,
    /// Where to show them: auto, window, kms:CARD:CONNECTOR:WxH@HZ, fbdev:DEVICE or sim:WIDTHxHEIGHT:FORMAT:STRIDE_BYTES, of
    /// which the last parts can be left out.
    ///
    /// auto is a window within a desktop, which holds the panel; without one it is kms, else fbdev, else simulated.
    /// kms:1:HDMI-A-1:1280x720@60 is a mode of a connector of /dev/dri/card1, kms:::1280x720 a mode of the first panel;
    /// fbdev:1 is /dev/fb1. `yurameki probe` lists what there is.
    #[arg(long)]
    pub display: Option<DisplayChoice>,
    /// Frames a second, 12 to 60.
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(12..=60))]
    pub fps: Option<u32>,
    /// End after so many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
    /// Presses of buttons, one `FRAME BUTTON [double|long]` a line.
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// How the panel is mounted: the picture is turned clockwise by so many degrees.
    #[arg(long, value_name = "DEGREES")]
    pub rotate: Option<Rotation>,
    /// How photos live.
    #[command(flatten)]
    pub look: Look,
}

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct Render {
    /// The photo, or a clip; an autumn may do without one.
    #[arg(required_unless_present = "effect", required_if_eq_any([("effect", "shimmer"), ("effect", "kaleidoscope")]))]
    pub photo: Option<PathBuf>,
    /// FILE.apng, .png, .gif, .webp or .y4m, a folder, or - for Y4M on standard output.
    #[arg(long, value_name = "FILE", required_unless_present = "hash", value_parser = target())]
    pub out: Option<Target>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "1024x600", value_parser = size)]
    pub size: Size,
    /// How many frames.
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Frames a second, 1 to 60.
    #[arg(long, value_name = "F", default_value_t = config::DEFAULT_FRAMES_PER_SECOND, value_parser = clap::value_parser!(u32).range(1..=60))]
    pub fps: u32,
    /// The panel's pixel format, whose depth and dithering the file shows.
    #[arg(long, default_value = "XRGB8888")]
    pub format: PixelFormat,
    /// A kaleidoscope of what moves, in the mode tonal: shimmer, of the photo itself, or frames, where PHOTO is a folder with the frames of a film.
    #[arg(long, value_name = "shimmer|frames", requires = "effect", conflicts_with_all = ["mode", "search"])]
    pub source: Option<Motion>,
    /// Print the SHA-256 over all frames: the same on every machine.
    #[arg(long)]
    pub hash: bool,
    /// Show no progress.
    #[arg(long)]
    pub quiet: bool,
    /// How the photo lives.
    #[command(flatten)]
    pub look: Look,
}

/// What moves in a kaleidoscope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The photo shimmers.
    Shimmer,
    /// One picture follows the other.
    Frames,
}

named!(Motion, "source", Shimmer = "shimmer", Frames = "frames");

impl Render {
    /// The rate of the frames in the file.
    pub fn rate(&self) -> FrameRate {
        // clap has checked 1..=60.
        FrameRate::new(self.fps, 1).unwrap_or_else(|| unreachable!("1 to 60 frames a second are a rate"))
    }
}

/// Arguments of `noise`.
#[derive(Debug, clap::Args)]
pub struct Noise {
    /// constant, white, chaos, filter, hosoda, brown, chaos-literal or brown-literal.
    #[arg(long, value_name = "K")]
    pub kind: Kind,
    /// How many numbers.
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    pub steps: u64,
    /// The seed.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// The time constant of the response filter in frames; without it the noise drives a frequency, with it an amplitude.
    #[arg(long, value_name = "TAU", value_parser = clap::value_parser!(u32).range(1..=200))]
    pub response: Option<u32>,
    /// The generator's own numbers, before they are scaled and clamped to drive anything.
    #[arg(long, conflicts_with = "response")]
    pub raw: bool,
}

/// Arguments of `mask`.
#[derive(Debug, clap::Args)]
pub struct Mask {
    /// The photo.
    pub photo: PathBuf,
    /// The picture to write: white moves, black is still.
    #[arg(long, value_name = "FILE.png", value_parser = png_target())]
    pub out: Target,
}

/// Arguments of `encode`.
#[derive(Debug, clap::Args)]
pub struct Encode {
    /// The photo.
    pub photo: PathBuf,
    /// The file to write.
    #[arg(long, value_name = "FILE.yfc", value_parser = yfc_path())]
    pub out: PathBuf,
    /// Where domains are looked for: none, local, filter8, filterC or classes72.
    #[arg(long, default_value = "filter8")]
    pub search: Search,
    /// Ranges that are further off than so many levels are cut in four while they can be: 0 to 255; the root of the mean square.
    #[arg(long, value_name = "LEVELS", default_value = "8")]
    pub tolerance: Tolerance,
    /// Shrink the photo to lie within WIDTHxHEIGHT; without it, within 4096x4096.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,
    /// Show no progress.
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `decode`.
#[derive(Debug, clap::Args)]
pub struct Decode {
    /// The file.
    #[arg(value_name = "FILE.yfc")]
    pub file: PathBuf,
    /// The picture to write.
    #[arg(long, value_name = "FILE.png", value_parser = png_target())]
    pub out: Target,
    /// How often every range is drawn, starting from grey.
    #[arg(long, value_name = "K", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub iterations: u32,
}

/// An error in levels, 0 to 255, in steps of 1/16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance(u16);

impl Tolerance {
    /// In 1/16 levels.
    pub const fn to_q4(self) -> u16 {
        self.0
    }
}

impl FromStr for Tolerance {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let number = word.parse::<f64>().ok().filter(|levels| (0.0..=255.0).contains(levels));
        number
            .map(|levels| Self((levels * 16.0).round() as u16))
            .ok_or("a tolerance is 0 to 255 levels, like 8")
    }
}

/// Arguments of `config`.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
pub struct ConfigFile {
    /// Print the default configuration, in which every key is explained.
    #[arg(long)]
    pub default: bool,
    /// Check a configuration or the file of a board.
    #[arg(long, value_name = "FILE")]
    pub check: Option<PathBuf>,
    /// List the known boards.
    #[arg(long)]
    pub boards: bool,
    /// Print the facts of a known board, as a start for another.
    #[arg(long, value_name = "NAME")]
    pub board: Option<String>,
}

/// How photos live.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Look {
    /// The seed of the noises: the same seed, the same motion.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// The effect: shimmer, kaleidoscope or autumn.
    #[arg(long)]
    pub effect: Option<EffectChoice>,
    /// The paper's set-up for poplar, rowan, river or waterfall; single options go before it.
    #[arg(long)]
    pub preset: Option<Preset>,
    /// The amplitude's noise: constant, white, chaos, filter, hosoda, brown, chaos-literal or brown-literal.
    #[arg(long, value_name = "K")]
    pub amplitude: Option<Kind>,
    /// The frequency's noise, as above.
    #[arg(long, value_name = "K")]
    pub frequency: Option<Kind>,
    /// The range of the swing: full, neighbourhood or travelling.
    #[arg(long, value_name = "MODE")]
    pub range: Option<Range>,
    /// The phase: integrated, or literal as the paper prints it.
    #[arg(long, value_name = "FORM", value_parser = phase)]
    pub phase: Option<PhaseForm>,
    /// How heights start in the ranges full and neighbourhood: rising, falling or scattered.
    #[arg(long)]
    pub branch: Option<Branch>,
    /// What moves: a picture (white moves), auto, or none for everything. By default PHOTO.mask.png beside the photo, else auto.
    #[arg(long, value_name = "FILE|auto|none")]
    pub mask: Option<MaskChoice>,
    /// Where the light comes from: degrees clockwise from the top, and degrees above the picture, 5 to 90.
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = light, allow_hyphen_values = true)]
    pub light: Option<Light>,
    /// How steep the relief is, 0 to 4; 1 is usual.
    #[arg(long, value_name = "K", value_parser = factor, allow_hyphen_values = true)]
    pub relief: Option<Factor>,
    /// How far the light changes the photo, 0 to 4; with a light at 45° up to 2.8, with a lower one less.
    #[arg(long, value_name = "M", value_parser = factor, allow_hyphen_values = true)]
    pub strength: Option<Factor>,
    /// Where the wind blows to, degrees clockwise from the top, -360 to 360, for the travelling range.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = clap::value_parser!(i16).range(-360..=360))]
    pub wind: Option<i16>,
    /// The photo whose colours a kaleidoscope takes; in a show, by default, that of another photo.
    #[arg(long, value_name = "PHOTO")]
    pub reference: Option<PathBuf>,
    /// What a kaleidoscope makes of the photo: watercolour, tonal (crisper), or literal as its paper has it.
    #[arg(long)]
    pub mode: Option<kaleidoscope::Mode>,
    /// Where a kaleidoscope's coder looks for domains: none, local, filter8, filterC or classes72.
    #[arg(long)]
    pub search: Option<Search>,
    /// How many symbols the addresses of a kaleidoscope have, 1 to 3: with fewer, colours are means over larger parts.
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u8).range(1..=3))]
    pub depth: Option<u8>,
    /// An autumn's tree: maple, ginkgo, birch, pine, paper, or a file that describes one.
    #[arg(long, value_name = "NAME|FILE")]
    pub tree: Option<TreeChoice>,
    /// An autumn's colours: synthetic, or a folder of seven photos of leaves, from green to the last colour.
    #[arg(long, value_name = "DIR|synthetic")]
    pub plates: Option<PlatesChoice>,
    /// An autumn that stands still, at a stage from 0 (green) to 6 (all colours) and 7 (bare).
    #[arg(long, value_name = "S", conflicts_with_all = ["season", "season_minutes"])]
    pub stage: Option<Stage>,
    /// The stages that an autumn goes through; a film from its first frame to its last, a show within --season-minutes.
    #[arg(long, value_name = "START..END", value_parser = stages)]
    pub season: Option<(Stage, Stage)>,
    /// In how many minutes a show goes through them, to begin again; without --season and this it follows the calendar.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_440))]
    pub season_minutes: Option<u32>,
    /// In how many minutes a show goes once around an autumn's own tree, in small steps; without it, it is seen from one side.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(5..=1_440))]
    pub around_minutes: Option<u32>,
    /// How likely a twig turns with its bough, 0 to 1; else it goes its own way.
    #[arg(long, value_name = "P", value_parser = share)]
    pub patchiness: Option<Factor>,
    /// An autumn's sun, in whose shade leaves turn later: degrees clockwise from the top and above the picture, or none.
    #[arg(long, value_name = "AZIMUTH,ELEVATION|none", value_parser = sun, allow_hyphen_values = true)]
    pub sun: Option<Sun>,
    /// Whether leaves fall: on or off.
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub leaf_fall: Option<bool>,
    /// How a photo of another shape fills the panel: blurred, fill or plain.
    #[arg(long)]
    pub fit: Option<Fit>,
}

/// Where to show photos.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DisplayChoice {
    /// A window within a desktop, else a panel, else a simulated one.
    Auto,
    /// A window.
    Window,
    /// A panel on a graphics card, by the kernel's mode setting.
    Kms(KmsChoice),
    /// A panel on a frame buffer device: this one, or the first.
    Fbdev(Option<PathBuf>),
    /// A simulated panel.
    Sim(sim::Spec),
}

/// Which panel of a graphics card, `kms[:CARD[:CONNECTOR[:WxH[@HZ]]]]`. What is left out or empty is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KmsChoice {
    /// The card, like `/dev/dri/card0`, card0 or 0; without it, the first with a panel.
    pub card: Option<PathBuf>,
    /// The connector, like HDMI-A-1; without it, the first with a panel.
    pub connector: Option<String>,
    /// The mode's size; without it, the mode that the panel prefers.
    pub size: Option<Size>,
    /// The mode's whole frames a second; without it, the first of the size.
    pub hertz: Option<u32>,
}

impl FromStr for DisplayChoice {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let (kind, rest) = word.split_once(':').map_or((word, None), |(kind, rest)| (kind, Some(rest)));
        match (kind, rest) {
            ("auto", None) => Ok(Self::Auto),
            ("window", None) => Ok(Self::Window),
            ("kms", rest) => rest.unwrap_or_default().parse().map(Self::Kms),
            ("fbdev", None) => Ok(Self::Fbdev(None)),
            ("fbdev", Some(device)) => Ok(Self::Fbdev(Some(device_path(device, "/dev/", "fb")))),
            ("sim", _) => {
                let spec: sim::Spec = word.parse().map_err(|e: sim::SpecError| e.to_string())?;
                if spec.0.size.pixels() > MOST_PIXELS {
                    return Err(TOO_MANY_PIXELS.into());
                }
                Ok(Self::Sim(spec))
            }
            _ => Err("unknown display; the known ones are auto, window, kms[:CARD[:CONNECTOR[:WxH[@HZ]]]], \
                      fbdev[:DEVICE], sim:WIDTHxHEIGHT[:FORMAT[:STRIDE_BYTES]]"
                .into()),
        }
    }
}

impl FromStr for KmsChoice {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let mut parts = words.splitn(3, ':').map(|part| Some(part).filter(|part| !part.is_empty()));
        let mut part = || parts.next().flatten();
        let (card, connector, mode) = (part(), part(), part());
        let (size_word, hertz) = match mode.and_then(|mode| mode.split_once('@')) {
            Some((size, hertz)) => {
                (Some(size), Some(hertz.parse().map_err(|_| "a mode is WxH or WxH@HZ, like 1280x720@60")?))
            }
            None => (mode, None),
        };
        Ok(Self {
            card: card.map(|card| device_path(card, "/dev/dri/", "card")),
            connector: connector.map(str::to_owned),
            size: size_word.map(size).transpose()?,
            hertz,
        })
    }
}

/// The path of a device given as a path, a name (fb1) or a number (1).
fn device_path(word: &str, folder: &str, name: &str) -> PathBuf {
    match word {
        path if path.contains('/') => path.into(),
        number if number.bytes().all(|byte| byte.is_ascii_digit()) => {
            format!("{folder}{name}{number}").into()
        }
        name => format!("{folder}{name}").into(),
    }
}

/// What of a photo moves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MaskChoice {
    /// What plausibly moves.
    Automatic,
    /// Everything.
    Everything,
    /// What is white in this picture.
    File(PathBuf),
}

impl FromStr for MaskChoice {
    type Err = std::convert::Infallible;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        Ok(match word {
            "auto" => Self::Automatic,
            "none" => Self::Everything,
            file => Self::File(file.into()),
        })
    }
}

/// The most pixels of a frame: those of 8K UHD, the largest panel that is sold. A frame takes about 26 bytes a pixel of memory, 0.9 GB then.
const MOST_PIXELS: usize = 7_680 * 4_320;
const TOO_MANY_PIXELS: &str = "the largest frame is one of 7680x4320 pixels, or as many in another shape";

/// Reads a size as people type it: WIDTHxHEIGHT.
///
/// # Errors
/// Anything else; one line that says what a size is.
pub fn size(word: &str) -> Result<Size, &'static str> {
    let form = "a size is WIDTHxHEIGHT in pixels, each 1 to 16384, like 1024x600";
    let (width, height) = word.split_once(['x', 'X', '×']).ok_or(form)?;
    let side =
        |text: &str| text.parse().ok().filter(|side| (1..=crate::frame::Layout::MAX_SIDE).contains(side));
    let size = Size::new(side(width).ok_or(form)?, side(height).ok_or(form)?);
    if size.pixels() > MOST_PIXELS { Err(TOO_MANY_PIXELS) } else { Ok(size) }
}

fn target() -> impl TypedValueParser<Value = Target> {
    OsStringValueParser::new().try_map(|word| Target::parse(&word))
}

fn yfc_path() -> impl TypedValueParser<Value = PathBuf> {
    let is_yfc =
        |path: &PathBuf| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("yfc"));
    clap::builder::PathBufValueParser::new()
        .try_map(move |path| Some(path).filter(is_yfc).ok_or("name a file that ends in .yfc"))
}

fn png_target() -> impl TypedValueParser<Value = Target> {
    target().try_map(|target| match target {
        Target::File { format: FileFormat::Png, .. } => Ok(target),
        other => Err(format!("{other}: one picture is written; name a file that ends in .png")),
    })
}

pub(super) fn phase(word: &str) -> Result<PhaseForm, &'static str> {
    match word {
        "integrated" => Ok(PhaseForm::Integrated),
        "literal" => Ok(PhaseForm::Literal),
        _ => Err("unknown phase; the known ones are integrated, literal"),
    }
}

pub(super) fn light(word: &str) -> Result<Light, &'static str> {
    let form = "a light is AZIMUTH,ELEVATION in whole degrees, the elevation 5 to 90, like 315,45";
    let (azimuth, elevation) = word.split_once(',').ok_or(form)?;
    let azimuth: i16 = azimuth.trim().parse().map_err(|_| form)?;
    let elevation = elevation.trim().parse().ok().filter(|degrees| (5..=90).contains(degrees)).ok_or(form)?;
    Ok(Light { azimuth: Turns::from_degrees(azimuth.into()), elevation: Turns::from_degrees(elevation) })
}

fn stages(word: &str) -> Result<(Stage, Stage), &'static str> {
    let (from, to) = word.split_once("..").ok_or("a season is START..END, like 0..6")?;
    Ok((from.parse()?, to.parse()?))
}

/// A sun, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sun(pub Option<Light>);

pub(super) fn sun(word: &str) -> Result<Sun, &'static str> {
    if word == "none" { Ok(Sun(None)) } else { light(word).map(|light| Sun(Some(light))) }
}

pub(super) fn share(word: &str) -> Result<Factor, &'static str> {
    let share = word.parse::<Factor>().ok().filter(|share| (Factor::ZERO..=Factor::ONE).contains(share));
    share.ok_or("a number from 0 to 1 is needed")
}

pub(super) fn on_off(word: &str) -> Result<bool, &'static str> {
    match word {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("on or off is needed"),
    }
}

pub(super) fn factor(word: &str) -> Result<Factor, &'static str> {
    let number =
        word.parse::<Factor>().ok().filter(|factor| (Factor::ZERO..=Factor::from_num(4)).contains(factor));
    number.ok_or("a number from 0 to 4 is needed")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manual_page_has_every_command() {
        use clap::CommandFactory;
        let page = include_str!("../../tools/package/debian/yurameki.1").replace("\\-", "-");
        let (_, commands) = page.split_once(".SH COMMANDS").expect("a section");
        let (commands, _) = commands.split_once(".SH").expect("another section");
        for command in Args::command().get_subcommands() {
            let name = command.get_name();
            let is_its_line =
                |line: &str| line.split(['"', ' ']).any(|word| word == name) && line.starts_with(".B");
            assert!(commands.lines().any(is_its_line), "{name}");
        }
    }

    fn kms(
        card: Option<&str>,
        connector: Option<&str>,
        size: Option<Size>,
        hertz: Option<u32>,
    ) -> DisplayChoice {
        let (card, connector) = (card.map(PathBuf::from), connector.map(str::to_owned));
        DisplayChoice::Kms(KmsChoice { card, connector, size, hertz })
    }

    #[test]
    fn a_panel_is_asked_for_by_card_connector_and_mode_or_parts_of_them() {
        let hd = Some(Size::new(1280, 720));
        for (word, choice) in [
            ("kms", kms(None, None, None, None)),
            ("kms:1", kms(Some("/dev/dri/card1"), None, None, None)),
            ("kms:card1:HDMI-A-1", kms(Some("/dev/dri/card1"), Some("HDMI-A-1"), None, None)),
            ("kms:/dev/dri/x::1280x720", kms(Some("/dev/dri/x"), None, hd, None)),
            ("kms:::1280x720@60", kms(None, None, hd, Some(60))),
            ("fbdev", DisplayChoice::Fbdev(None)),
            ("fbdev:1", DisplayChoice::Fbdev(Some("/dev/fb1".into()))),
            ("fbdev:/tmp/fb", DisplayChoice::Fbdev(Some("/tmp/fb".into()))),
        ] {
            assert_eq!(word.parse(), Ok(choice), "{word}");
        }
    }

    #[test]
    fn a_panel_of_no_such_form_is_refused() {
        for word in ["kms:::1280", "kms:::1280x720@fast", "kms:::1280x720@60:4", "auto:1", "panel", ""] {
            assert!(word.parse::<DisplayChoice>().is_err(), "{word}");
        }
    }
}
