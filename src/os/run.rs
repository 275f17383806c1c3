//! `yurameki run`: photos on a display, until somebody ends it.

use super::{
    Failure, args,
    interrupt::Interrupt,
    panel::Panel,
    photo, render,
    scene::{self, Scene, Source},
};
use crate::{
    app::{Request, Show, pace::Pace, playlist::Playlist},
    display::{Display, DisplayError},
    effect::shimmer::{Shimmer, storage_len},
    input::{Buttons, script::Script},
};
use clap::Parser;
use std::{
    collections::HashSet,
    fs,
    path::Path,
    thread::sleep,
    time::{Duration, Instant},
};

/// Without any argument: the demo photo in a window, or, where no window opens, in a file.
pub(super) fn demo() -> Result<(), Failure> {
    let args = args::Args::parse_from(["yurameki", "run", "demo", "--display", "window"]);
    let Some(args::Command::Run(args)) = args.command else { unreachable!("`run` was asked for") };
    match Panel::open(&args.display, args.fps) {
        Ok(panel) => show(&args, &[Source::Demo], panel),
        Err(why) => {
            log::info!("{why}");
            render::demo()
        }
    }
}

pub(super) fn run(args: &args::Run) -> Result<(), Failure> {
    let files = photo::list(&args.photos)?;
    let sources: Vec<Source<'_>> = files.iter().map(|path| Source::File(path)).collect();
    show(args, &sources, Panel::open(&args.display, args.fps)?)
}

/// How long to wait before a display that is gone is asked again.
const LOST_DISPLAY_WAIT: Duration = Duration::from_millis(250);

fn show(args: &args::Run, sources: &[Source<'_>], mut panel: Panel) -> Result<(), Failure> {
    let mut playlist = Playlist::new(sources.len()).ok_or_else(|| {
        Failure::new("there is no photo in these folders; JPEG, PNG, WebP, GIF, BMP and TIFF files are shown")
    })?;
    let script = args.script.as_deref().map(read_script).transpose()?.unwrap_or_default();
    let mut script = Script::parse(&script).map_err(|e| Failure::new(format!("the script: {e}")))?;
    let life = scene::turned(args.look.life().at(args.fps), args.rotate);
    let mut run = Running {
        show: Show::new(life.drive, args.fps, args.look.seed),
        clock: Instant::now(),
        interrupt: Interrupt::install()?,
        frames: args.frames,
        frames_per_second: args.fps,
    };
    let (mut storage, mut skipped, mut failed_in_a_row) = (Vec::new(), HashSet::new(), 0);
    while failed_in_a_row < sources.len() {
        let size = panel.mode().layout.size;
        let scene = match Scene::load(sources[playlist.current()], size, args.rotate, &args.look) {
            Ok(scene) => scene,
            Err(failure) => {
                if skipped.insert(playlist.current()) {
                    log::warn!("skipped: {failure}");
                }
                failed_in_a_row += 1;
                playlist.skip();
                continue;
            }
        };
        failed_in_a_row = 0;
        storage.resize(storage_len(size), 0);
        let mut shimmer = Shimmer::prepare(scene.photo(), &life.shimmer, &mut storage)?;
        match run.photo(&mut shimmer, scene.name(), &mut panel, &mut script) {
            Some(Request::NextPhoto) => playlist.next(),
            Some(Request::PreviousPhoto) => playlist.previous(),
            Some(Request::Quit) => {
                if let Some(report) = panel.report() {
                    println!("{report}");
                }
                return Ok(());
            }
            // The panel has another mode: the same photo again.
            None => {}
        }
    }
    Err(Failure::new("none of the photos can be shown"))
}

fn read_script(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| Failure::new(format!("the script {}: {error}", path.display())))
}

/// The loop, and what it looks at between frames.
struct Running {
    show: Show,
    clock: Instant,
    interrupt: Interrupt,
    frames: Option<u64>,
    frames_per_second: u32,
}

impl Running {
    /// Shows a photo until somebody asks for something else, or, without a request, until the panel has another mode.
    fn photo(
        &mut self,
        shimmer: &mut Shimmer<'_>,
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
            let request = next_request(&mut self.show, [script, panel]);
            if request.is_some() {
                return request;
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
fn next_request(show: &mut Show, buttons: [&mut dyn Buttons; 2]) -> Option<Request> {
    for buttons in buttons {
        while let Some(button) = buttons.next_press(show.frame()) {
            let request = show.press(button);
            if request.is_some() {
                return request;
            }
        }
    }
    None
}
