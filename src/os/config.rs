//! The configuration of the program: what was typed, what stands in files and what a board is, as one checked whole.
//!
//! Each goes before what comes before it here: the built-in defaults, the board's file, the configuration file, the sidecar of
//! the one photo, the command line. A key that is not said leaves what was said before; a preset is taken for its range mode and
//! its two noises, wherever it stands.

#[cfg(target_os = "linux")]
use super::evdev::KeyCodes;
use super::{
    args::{self, DisplayChoice, MaskChoice},
    autumn::{PlatesChoice, Season, TreeChoice},
    board, config_file,
    document::{ConfigError, read_text},
    local_time::Trust,
    photo::Fit,
    sidecar,
};
use crate::{
    config::{DEFAULT_FRAMES_PER_SECOND, EffectChoice, Life, Order, night::Night, season::Calendar},
    frame::Rotation,
    input::key_map::KeyMap,
    math::Turns,
};
use log::LevelFilter;
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

/// The configuration that is read where none is named, if it is there.
pub const SYSTEM_FILE: &str = "/etc/yurameki/config.toml";

/// Everything that can be chosen, checked.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where photos are shown.
    pub display: DisplayChoice,
    /// How the panel is mounted.
    pub rotation: Rotation,
    /// Frames a second, in [`crate::config::FRAMES_PER_SECOND`].
    pub frames_per_second: u32,
    /// The folder of the backlight in /sys/class/backlight; without a word, whatever the system has.
    pub backlight: Option<PathBuf>,
    /// Photos, and folders of photos.
    pub photos: Vec<PathBuf>,
    /// In which order they are shown.
    pub order: Order,
    /// How long a photo fades into the next.
    pub fade: Duration,
    /// The seed of everything that is left to chance.
    pub seed: u64,
    /// How a photo is shown of which nothing else is said.
    pub look: Look,
    /// What was typed of looks, which goes before the sidecar of a photo too.
    pub typed: args::Look,
    /// What presses do.
    pub actions: KeyMap,
    /// Which keys are which buttons.
    #[cfg(target_os = "linux")]
    pub keys: KeyCodes,
    /// When the panel is dimmed or off.
    pub night: Night,
    /// When the time of the day is known.
    pub clock: Trust,
    /// When it is autumn.
    pub calendar: Calendar,
    /// The most memory that the file of a photo and its decoding may take, in bytes.
    pub memory_ceiling_bytes: u64,
    /// What is logged.
    pub log: LevelFilter,
}

/// How one photo is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Look {
    /// What brings it to life.
    pub effect: EffectChoice,
    /// The photo whose colours a kaleidoscope takes; without a word, its neighbour in the show.
    pub reference: Option<PathBuf>,
    /// The tree of an autumn.
    pub tree: TreeChoice,
    /// The colours of its leaves.
    pub plates: PlatesChoice,
    /// The stages that an autumn goes through; without a word, those of the calendar.
    pub season: Season,
    /// In how many minutes the camera goes once around an autumn's own tree; without a word it stands.
    pub around_minutes: Option<u32>,
    /// How it lives, at [`DEFAULT_FRAMES_PER_SECOND`].
    pub life: Life,
    /// What of it moves; without a word the mask beside the photo says, else the automatic one.
    pub mask: Option<MaskChoice>,
    /// How it is fitted to the panel.
    pub fit: Fit,
    /// The sRGB colour around it, where it is plain, and behind what is transparent.
    pub background: [u8; 3],
    /// How long it is shown.
    pub seconds: u32,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            effect: EffectChoice::default(),
            reference: None,
            tree: TreeChoice::default(),
            plates: PlatesChoice::default(),
            season: Season::default(),
            around_minutes: None,
            life: Life::default(),
            mask: None,
            fit: Fit::default(),
            background: [0; 3],
            seconds: 60,
        }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self {
            display: DisplayChoice::Auto,
            rotation: Rotation::None,
            frames_per_second: DEFAULT_FRAMES_PER_SECOND,
            backlight: None,
            photos: Vec::new(),
            order: Order::default(),
            fade: Duration::from_secs(2),
            // The first seconds of this one are lively: X_A has a mean of 0.57 over five, and never falls below 0.3 in twenty.
            seed: 7,
            look: Look::default(),
            typed: args::Look::default(),
            actions: KeyMap::default(),
            #[cfg(target_os = "linux")]
            keys: KeyCodes::default(),
            night: Night::default(),
            clock: Trust::default(),
            calendar: Calendar::default(),
            memory_ceiling_bytes: super::photo::Limits::default().bytes,
            log: LevelFilter::Info,
        }
    }
}

impl Config {
    /// The configuration of `run` with these arguments: the board's file, the configuration file and the arguments, in this order.
    /// Where neither of the latter names a board, the machine does by its device tree.
    ///
    /// # Errors
    /// Whatever is wrong with the files, or that a board is not known.
    pub fn resolve(args: &args::Run) -> Result<Self, ConfigError> {
        let system = Path::new(SYSTEM_FILE);
        let file = args.config.as_deref().or_else(|| system.exists().then_some(system));
        let text = file.map(read_text).transpose()?;
        let apply_file = |config: &mut Self| match (file, &text) {
            (Some(path), Some(text)) => config_file::apply(path, text, config),
            _ => Ok(config_file::Heading::default()),
        };
        // The file may name the board that it goes before.
        let heading = apply_file(&mut Self::default())?;
        if let Some(path) = file.filter(|_| !heading.compatible.is_empty()) {
            let why = "the key `compatible` stands only in the file of a board; take it away";
            return Err(ConfigError::whole(path.display().to_string(), why));
        }
        let mut config = Self::default();
        let detected = || board::detect(Path::new(board::DEVICE_TREE)).map(str::to_owned);
        if let Some(name) = args.board.clone().or(heading.board).or_else(detected) {
            board::apply(&name, &mut config)?;
        }
        apply_file(&mut config)?;
        config.apply_args(args);
        Ok(config)
    }

    /// What was typed goes before everything else.
    pub(super) fn apply_args(&mut self, args: &args::Run) {
        if let Some(display) = &args.display {
            self.display.clone_from(display);
        }
        self.rotation = args.rotate.unwrap_or(self.rotation);
        self.frames_per_second = args.fps.unwrap_or(self.frames_per_second);
        self.seed = args.look.seed.unwrap_or(self.seed);
        self.typed = args.look.clone();
        if !args.photos.is_empty() {
            self.photos.clone_from(&args.photos);
            // Who names photos wants to see those, from the first on.
            self.order = Order::Name;
        }
    }

    /// How a photo is shown that has no sidecar.
    pub fn plain_look(&self) -> Look {
        let mut look = self.look.clone();
        self.typed.apply(&mut look);
        look
    }

    /// How the photo at `path` is shown. A sidecar with a mistake is told and passed over.
    pub fn look(&self, path: &Path) -> Look {
        let mut look = match sidecar::load(path, &self.look) {
            Ok(Some(look)) => look,
            Ok(None) => return self.plain_look(),
            Err(error) => {
                log::warn!("{}; the photo is shown without it", error.first());
                return self.plain_look();
            }
        };
        self.typed.apply(&mut look);
        look
    }
}

impl args::Look {
    /// Puts what was typed in place of what `look` says.
    fn apply(&self, look: &mut Look) {
        if let Some(preset) = self.preset {
            preset.apply(&mut look.life);
        }
        look.effect = self.effect.unwrap_or(look.effect);
        look.mask = self.mask.clone().or(look.mask.take());
        look.fit = self.fit.unwrap_or(look.fit);
        look.reference = self.reference.clone().or(look.reference.take());
        if let Some(tree) = &self.tree {
            look.tree = tree.clone();
        }
        if let Some(plates) = &self.plates {
            look.plates = plates.clone();
        }
        look.season.stages = self.stage.map(|stage| (stage, stage)).or(self.season).or(look.season.stages);
        look.season.minutes = self.season_minutes.or(look.season.minutes);
        look.around_minutes = self.around_minutes.or(look.around_minutes);
        let Life { drive, shimmer, kaleidoscope, autumn } = &mut look.life;
        autumn.patchiness = self.patchiness.unwrap_or(autumn.patchiness);
        autumn.sun = self.sun.map_or(autumn.sun, |sun| sun.0);
        autumn.leaf_fall = self.leaf_fall.unwrap_or(autumn.leaf_fall);
        drive.amplitude = self.amplitude.unwrap_or(drive.amplitude);
        drive.frequency = self.frequency.unwrap_or(drive.frequency);
        drive.phase = self.phase.unwrap_or(drive.phase);
        shimmer.range = self.range.unwrap_or(shimmer.range);
        shimmer.branch = self.branch.unwrap_or(shimmer.branch);
        shimmer.light = self.light.unwrap_or(shimmer.light);
        shimmer.relief = self.relief.unwrap_or(shimmer.relief);
        shimmer.strength = self.strength.unwrap_or(shimmer.strength);
        kaleidoscope.mode = self.mode.unwrap_or(kaleidoscope.mode);
        kaleidoscope.search = self.search.unwrap_or(kaleidoscope.search);
        kaleidoscope.depth = self.depth.unwrap_or(kaleidoscope.depth);
        shimmer.wind = self.wind.map_or(shimmer.wind, |degrees| Turns::from_degrees(degrees.into()));
    }
}
