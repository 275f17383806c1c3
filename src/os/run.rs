//! `yurameki run`: photos on a display, until somebody ends it.

use super::{
    Failure, args,
    config::Config,
    interrupt::Interrupt,
    panel::Panel,
    photo, render,
    scene::{self, Scene, Source},
    set_log_level,
    stdout::print_line,
};
use crate::{
    app::{
        Request, Show,
        pace::Pace,
        playlist::{PhotoId, Playlist, Slot},
    },
    config::Order,
    display::{Display, DisplayError},
    effect::{
        Effect,
        shimmer::{Shimmer, storage_len},
    },
    input::{Buttons, key_map::KeyMap, script::Script},
};
use clap::Parser;
use std::{
    collections::HashSet,
    fs::File,
    io::Read,
    path::Path,
    thread::sleep,
    time::{Duration, Instant},
};

/// Without any argument: the demo photo in a window, or, where no window opens, in a file.
pub(super) fn demo() -> Result<(), Failure> {
    let args = args::Args::parse_from(["yurameki", "run", "--display", "window"]);
    let Some(args::Command::Run(args)) = args.command else { unreachable!("`run` was asked for") };
    let mut config = Config::default();
    config.apply_args(&args);
    match Panel::open(&config.display, config.frames_per_second) {
        Ok(panel) => show(&config, &args, &[Source::Demo], panel),
        Err(why) => {
            log::info!("{why}");
            render::demo()
        }
    }
}

pub(super) fn run(args: &args::Run) -> Result<(), Failure> {
    let config = Config::resolve(args)?;
    set_log_level(config.log);
    let files = photo::list(&config.photos)?;
    let mut sources: Vec<Source<'_>> = files.iter().map(|path| Source::File(path)).collect();
    if config.photos.is_empty() {
        sources.push(Source::Demo);
    }
    show(&config, args, &sources, Panel::open(&config.display, config.frames_per_second)?)
}

/// How long to wait before a display that is gone is asked again.
const LOST_DISPLAY_WAIT: Duration = Duration::from_millis(250);

fn show(config: &Config, args: &args::Run, sources: &[Source<'_>], mut panel: Panel) -> Result<(), Failure> {
    let mut playlist = Playlist::new(vec![Slot::EMPTY; sources.len()], Order::Name, config.seed);
    playlist.update(&(0..sources.len() as u64).map(PhotoId).collect::<Vec<_>>());
    if playlist.is_empty() {
        return Err(Failure::new(
            "there is no photo in these folders; JPEG, PNG, WebP, GIF, BMP and TIFF files are shown",
        ));
    }
    let path = args.script.as_deref();
    let text = path.map_or(Ok(String::new()), read_script)?;
    let refused = |error| Failure::new(format!("{}: {error}", path.unwrap_or(Path::new("")).display()));
    let mut script = Script::parse(&text).map_err(refused)?;
    let frames_per_second = config.frames_per_second;
    let drive = config.plain_look().life.at(frames_per_second).drive;
    let mut run = Running {
        show: Show::new(drive, frames_per_second, config.seed),
        keys: config.actions,
        clock: Instant::now(),
        interrupt: Interrupt::install()?,
        frames: args.frames,
        frames_per_second,
    };
    panel.set_keys(config.actions);
    let (mut storage, mut skipped, mut failed_in_a_row) = (Vec::new(), HashSet::new(), 0);
    while let Some(PhotoId(photo)) = playlist.current()
        && failed_in_a_row < sources.len()
    {
        let size = panel.mode().layout.size;
        let scene = match Scene::load(sources[photo as usize], size, config) {
            Ok(scene) => scene,
            Err(failure) if sources.len() == 1 => return Err(failure),
            Err(failure) => {
                if skipped.insert(photo) {
                    log::warn!("skipped: {failure}");
                }
                failed_in_a_row += 1;
                playlist.skip();
                continue;
            }
        };
        failed_in_a_row = 0;
        let life = scene::turned(scene.look().life.at(frames_per_second), config.rotation);
        run.show.choose_noises(life.drive.amplitude, life.drive.frequency);
        storage.resize(storage_len(size), 0);
        let mut shimmer = Shimmer::prepare(scene.photo(), &life.shimmer, &mut storage)?;
        match run.photo(&mut shimmer, scene.name(), &mut panel, &mut script) {
            Some(Request::NextPhoto) => playlist.next(),
            Some(Request::PreviousPhoto) => playlist.previous(),
            Some(Request::Quit) => {
                return panel.report().map_or(Ok(()), print_line);
            }
            // The panel has another mode: the same photo again. Of the requests, `photo` gives no others.
            None | Some(Request::NextEffect | Request::Sleep | Request::Hide | Request::Reload) => {}
        }
    }
    Err(Failure::new("none of the photos can be shown"))
}

/// The most bytes of a script: a press a second for a week would fit.
const LONGEST_SCRIPT: u64 = 16 << 20;

/// The text of a script, of a file or of a pipe.
fn read_script(path: &Path) -> Result<String, Failure> {
    let refused = |why: &str| Failure::new(format!("{}: {why}", path.display()));
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LONGEST_SCRIPT + 1).read_to_end(&mut bytes));
    read.map_err(|error| refused(&format!("the script cannot be read ({error}); name another file")))?;
    if bytes.len() as u64 > LONGEST_SCRIPT {
        return Err(refused("the script is over 16 MiB; make it shorter"));
    }
    String::from_utf8(bytes).map_err(|_| refused("the script is no text; save it as UTF-8"))
}

/// The loop, and what it looks at between frames.
struct Running {
    show: Show,
    keys: KeyMap,
    clock: Instant,
    interrupt: Interrupt,
    frames: Option<u64>,
    frames_per_second: u32,
}

impl Running {
    /// Shows a photo until somebody asks for something else, or, without a request, until the panel has another mode.
    fn photo(
        &mut self,
        shimmer: &mut impl Effect,
        name: &str,
        panel: &mut Panel,
        script: &mut Script<'_>,
    ) -> Option<Request> {
        self.show.restart();
        let mut pace = Pace::new(self.frames_per_second, self.clock.elapsed());
        loop {
            if self.interrupt.requested() || self.frames.is_some_and(|frames| self.show.frame() >= frames) {
                return Some(Request::Quit);
            }
            let request = next_request(&mut self.show, &self.keys, [script, panel]);
            match request {
                Some(Request::NextPhoto | Request::PreviousPhoto | Request::Quit) => return request,
                Some(Request::NextEffect) => log::info!("there is no other effect than shimmer"),
                Some(request @ (Request::Sleep | Request::Hide | Request::Reload)) => {
                    log::info!("{request:?}: this show cannot do that");
                }
                None => {}
            }
            match self.show.turn(shimmer, name, panel) {
                Ok(()) => {}
                Err(DisplayError::Closed) => return Some(Request::Quit),
                Err(DisplayError::ModeChanged) => return None,
                Err(DisplayError::Lost) => sleep(LOST_DISPLAY_WAIT),
            }
            pace.shown(self.clock.elapsed());
            sleep(pace.deadline().saturating_sub(self.clock.elapsed()));
        }
    }
}

/// Takes all presses in; the first that asks for something ends the round.
fn next_request(show: &mut Show, keys: &KeyMap, buttons: [&mut dyn Buttons; 2]) -> Option<Request> {
    for buttons in buttons {
        while let Some(press) = buttons.next_press(show.frame()) {
            let request = keys.action(press).and_then(|action| show.press(action));
            if request.is_some() {
                return request;
            }
        }
    }
    None
}
