//! `yurameki run`: photos on a display, until somebody ends it.

use super::{
    Failure,
    album::Album,
    args,
    autumn::{Orbit, SeasonClock},
    config::Config,
    dimmer::Dimmer,
    evdev::Keyboards,
    interrupt::{Interrupt, ReloadRequest},
    loader::{Living, Loader, Order},
    panel::Panel,
    render,
    scene::{Colours, Way},
    script_file,
    service::{Idle, Service},
    set_log_level,
    stdout::print_line,
};
use crate::{
    app::{
        Request, Show,
        pace::Pace,
        playlist::{Dwell, PhotoId},
    },
    display::{Display, DisplayError},
    frame::Size,
    input::{Buttons, script::Script},
    noise::{Kind, drive},
};
use clap::Parser;
use std::{
    env,
    path::PathBuf,
    sync::Arc,
    thread::sleep,
    time::{Duration, Instant},
};

/// Without any argument: the demo photo in a window, or, where no window opens, in a file.
pub(super) fn demo() -> Result<(), Failure> {
    let args = args::Args::parse_from(["yurameki", "run", "--display", "window"]);
    let Some(args::Command::Run(args)) = args.command else { unreachable!("`run` was asked for") };
    let mut config = Config::default();
    config.apply_args(&args);
    let mut service = Service::from_env();
    match Panel::open(&config.display, config.frames_per_second, &mut service) {
        Ok(panel) => Running::new(config, &args, panel, service)?.show(&mut Script::default()),
        Err(why) => {
            log::info!("{why}");
            render::demo()
        }
    }
}

pub(super) fn run(args: &args::Run) -> Result<(), Failure> {
    let config = Config::resolve(args)?;
    set_log_level(config.log);
    let path = args.script.as_deref();
    let text = path.map_or(Ok(String::new()), script_file::read)?;
    let mut script = path.map_or(Ok(Script::default()), |path| script_file::parse(path, &text))?;
    let mut service = Service::from_env();
    let panel = Panel::open(&config.display, config.frames_per_second, &mut service)?;
    let mut running = Running::new(config, args, panel, service)?;
    running.args = Some(args.clone());
    running.show(&mut script)
}

/// How long to wait where there is nothing to show: before a display that is gone is asked again, while the panel is off, and
/// before the first photo is there.
const IDLE_WAIT: Duration = Duration::from_millis(100);

/// A show: the photos, what is shown of them, and where.
struct Running {
    // Its end is told before what takes time is put away.
    service: Service,
    config: Arc<Config>,
    /// What the configuration is made of; `None` where none was asked for.
    args: Option<args::Run>,
    panel: Panel,
    keyboards: Option<Keyboards>,
    album: Album,
    loader: Loader,
    dimmer: Dimmer,
    show: Show,
    season: SeasonClock,
    orbit: Orbit,
    clock: Instant,
    interrupt: Interrupt,
    reload: ReloadRequest,
    pace: Pace,
    /// End after so many frames.
    frames: Option<u64>,
    current: Option<Living>,
    leaving: Option<Living>,
    next: Option<Living>,
    dwell: Dwell,
    /// How photos live, once a button has chosen that.
    way: Option<Way>,
    /// The photo whose colours a button has chosen last, and for which.
    colours: Option<(PhotoId, PathBuf)>,
    /// The photos were named on the command line.
    typed: bool,
}

impl Running {
    fn new(config: Config, args: &args::Run, mut panel: Panel, service: Service) -> Result<Self, Failure> {
        let typed = !args.photos.is_empty() || config.photos.is_empty();
        // A program that somebody starts by hand begins afresh; a frame goes on.
        let remembers = panel.is_bare() || env::var_os("STATE_DIRECTORY").is_some();
        let (album, state) = Album::open(&config, typed, remembers)?;
        let drive = plain_drive(&config);
        let mut show = Show::new(drive, config.frames_per_second, config.seed);
        if let Some(state) = state {
            let kind = |chosen: Option<Kind>, configured| chosen.unwrap_or(configured);
            show.take_up(kind(state.amplitude, drive.amplitude), kind(state.frequency, drive.frequency));
        }
        show.set_rotation(config.rotation);
        panel.set_keys(config.actions);
        let mut keyboards = panel.is_bare().then(|| Keyboards::new(config.keys.clone(), true));
        if let Some(keyboards) = &mut keyboards {
            keyboards.set_keys(config.actions);
        }
        let season = SeasonClock::new(config.plain_look().season, config.calendar, &config.night.zone)?;
        let orbit = Orbit::new(config.plain_look().around_minutes);
        let dimmer = Dimmer::new(&config, panel.is_bare())?;
        Ok(Self {
            loader: Loader::start()?,
            pace: Pace::new(config.frames_per_second, Duration::ZERO),
            config: Arc::new(config),
            args: None,
            service,
            panel,
            keyboards,
            album,
            dimmer,
            show,
            season,
            orbit,
            clock: Instant::now(),
            interrupt: Interrupt::install()?,
            reload: ReloadRequest::install()?,
            frames: args.frames,
            current: None,
            leaving: None,
            next: None,
            dwell: Dwell::new(None),
            way: None,
            colours: None,
            typed,
        })
    }

    /// Shows photos until somebody ends it.
    fn show(mut self, script: &mut Script<'_>) -> Result<(), Failure> {
        self.start_pace();
        while !self.interrupt.requested() && self.frames.is_none_or(|frames| self.show.frame() < frames) {
            let changed = self.album.look();
            self.renew(|id| changed.contains(&id));
            if self.reload.take() {
                self.reload();
            }
            self.supply()?;
            if self.take_presses(script) {
                break;
            }
            let brightness = self.dimmer.turn(self.clock.elapsed(), &mut self.panel);
            self.show.set_brightness(brightness);
            self.service.set_encoding(self.loader.encoding());
            match self.turn() {
                Ok(true) => {
                    self.panel.note_lateness(self.clock.elapsed().saturating_sub(self.pace.deadline()));
                    self.pace.shown(self.clock.elapsed());
                    sleep(self.pace.deadline().saturating_sub(self.clock.elapsed()));
                    continue;
                }
                Ok(false) => {
                    let why = self.idle();
                    self.service.idle(Instant::now(), why);
                    sleep(IDLE_WAIT);
                }
                Err(DisplayError::Lost) => {
                    self.service.idle(Instant::now(), Idle::NoPanel);
                    sleep(IDLE_WAIT);
                }
                Err(DisplayError::Closed) => break,
                Err(DisplayError::ModeChanged) => self.drop_photos(),
            }
            self.start_pace();
        }
        self.album.remember(self.clock.elapsed(), self.show.noises(), true);
        self.panel.report().map_or(Ok(()), print_line)
    }

    fn start_pace(&mut self) {
        self.pace = Pace::new(self.config.frames_per_second, self.clock.elapsed());
    }

    /// Presents a frame, if there is anything to be seen, and tells so.
    fn turn(&mut self) -> Result<bool, DisplayError> {
        let turned = self.present();
        if let Some(keyboards) = &mut self.keyboards {
            keyboards.set_listening(!matches!(turned, Err(DisplayError::Lost)));
        }
        turned
    }

    fn present(&mut self) -> Result<bool, DisplayError> {
        let Some(current) = self.current.as_mut().filter(|_| !self.dimmer.is_dark()) else {
            return self.say_why_nothing().map(|()| false);
        };
        current.picture.set_stage(self.season.stage(self.clock.elapsed()));
        let leaving = self.leaving.as_mut().map(|leaving| &mut leaving.picture);
        let encoding = self.loader.encoding();
        let longer = encoding.map(|encoding| format!("{}\n{encoding}", current.caption));
        let caption = longer.as_deref().unwrap_or(&current.caption);
        self.show.turn_from(leaving, &mut current.picture, caption, &mut self.panel)?;
        let name = current.caption.lines().next().unwrap_or_default();
        self.service.shown(Instant::now(), name, self.show.noises(), self.show.is_paused());
        self.dimmer.shown();
        if !self.show.is_fading()
            && let Some(leaving) = self.leaving.take()
        {
            self.loader.recycle(leaving);
        }
        let frame = Duration::from_secs(1) / self.config.frames_per_second;
        if !self.show.is_paused() && self.dwell.pass(frame) && self.album.goes_on() {
            self.album.next();
        }
        self.album.remember(self.clock.elapsed(), self.show.noises(), false);
        Ok(true)
    }

    /// Says on the panel why there is no photo. A panel that is off has been given one black frame; all that it must do is to notice
    /// that it is gone, or that somebody wants to see another console.
    fn say_why_nothing(&mut self) -> Result<(), DisplayError> {
        let nothing = if self.dimmer.is_dark() { None } else { self.album.nothing() };
        match nothing {
            Some(why) => {
                self.show.tell(&why, &mut self.panel)?;
                self.dimmer.shown();
                Ok(())
            }
            None => self.panel.back_buffer().map(drop),
        }
    }

    /// Why a turn has shown no frame on a panel that is there.
    fn idle(&mut self) -> Idle {
        match self.album.nothing() {
            _ if self.dimmer.is_dark() => Idle::Off,
            Some(_) => Idle::NoPhoto,
            None => Idle::Loading,
        }
    }

    /// Sees to it that the photo that is wanted is shown as soon as it is loaded, and that the next one is loaded by then.
    fn supply(&mut self) -> Result<(), Failure> {
        let size = self.panel.mode().layout.size;
        match self.loader.take() {
            Some((_, Ok(living))) if living.size == size && self.is_wanted(&living) => {
                self.next = Some(living)
            }
            Some((_, Ok(living))) => self.loader.recycle(living),
            // The only photo that somebody has asked for.
            Some((_, Err(failure))) if self.typed && !self.album.goes_on() && self.current.is_none() => {
                return Err(failure);
            }
            Some((id, Err(failure))) => {
                self.album.fails(id, &failure);
            }
            None => {}
        }
        let Some(wanted) = self.album.current() else { return self.give_up() };
        // The camera stands while what it sees is prepared and comes.
        if self.next.is_none() && self.leaving.is_none() && !self.loader.is_busy() {
            self.orbit.go(self.clock.elapsed());
        }
        let shown = self
            .current
            .as_ref()
            .filter(|living| !living.stale && self.is_wanted(living))
            .map(|living| living.id);
        if shown == Some(wanted) {
            if self.next.is_none() && self.leaving.is_none() && !self.loader.is_busy() {
                self.order_upcoming(size);
            }
        } else if let Some(next) = self.next.take_if(|next| next.id == wanted) {
            self.enter(next);
        } else if !self.loader.is_busy() {
            if let Some(other) = self.next.take() {
                self.loader.recycle(other);
            }
            self.order(wanted, size);
        }
        Ok(())
    }

    /// Whether a photo lives in the way, and in the colours, that buttons have chosen, and a tree is seen from where the camera is.
    fn is_wanted(&self, living: &Living) -> bool {
        let chosen = self.colours.as_ref().filter(|(id, _)| *id == living.id && living.is_kaleidoscope());
        self.way.is_none_or(|way| living.way.looks_as(way))
            && chosen.is_none_or(|(_, path)| living.colours.as_ref() == Some(path))
            && living.azimuth.is_none_or(|azimuth| azimuth == self.orbit.azimuth())
    }

    /// The photo comes again in another way, once it is prepared; that one goes on meanwhile.
    fn next_way(&mut self) {
        let Some(current) = &self.current else { return };
        self.way = Some(self.way.unwrap_or(current.way).next());
        self.forget_next();
    }

    /// The kaleidoscope comes again in the colours of the next photo; other effects take none.
    fn next_colours(&mut self) {
        let Some(current) = self.current.as_ref().filter(|living| living.is_kaleidoscope()) else { return };
        let chosen = self.colours.as_ref().filter(|(id, _)| *id == current.id);
        let before = chosen.map(|(_, path)| path).or(current.colours.as_ref());
        let Some(path) = self.album.colours_after(current.id, before.map(PathBuf::as_path)) else { return };
        let name = current.caption.lines().next().unwrap_or_default();
        log::info!("{name}: from now on in the colours of {}", path.display());
        self.colours = Some((current.id, path));
        self.forget_next();
    }

    /// What was prepared is put away.
    fn forget_next(&mut self) {
        if let Some(next) = self.next.take() {
            self.loader.recycle(next);
        }
    }

    fn order_upcoming(&mut self, size: Size) {
        if let Some(upcoming) = self.album.upcoming() {
            self.order(upcoming, size);
        }
    }

    fn order(&mut self, id: PhotoId, size: Size) {
        let colours = match &self.colours {
            Some((photo, path)) if *photo == id => Some(Colours::Chosen(path.clone())),
            _ => self.album.neighbour(id).map(Colours::Offered),
        };
        self.loader.order(Order {
            id,
            path: self.album.path(id),
            colours,
            way: self.way,
            azimuth: self.orbit.azimuth(),
            size,
            config: Arc::clone(&self.config),
        });
    }

    /// Shows a photo from now on.
    fn enter(&mut self, next: Living) {
        self.album.succeeds();
        self.show.choose_noises(next.drive.amplitude, next.drive.frequency);
        self.dwell = Dwell::new(Some(Duration::from_secs(next.seconds.into())));
        let before = self.current.replace(next);
        if let Some(left) = std::mem::replace(&mut self.leaving, before) {
            self.loader.recycle(left);
        }
        if self.leaving.is_some() {
            let frames = self.config.fade.as_millis() * u128::from(self.config.frames_per_second) / 1000;
            self.show.fade(frames as u32);
        } else {
            self.show.restart();
        }
    }

    /// Whatever of the photos `concerns` is loaded anew, while what is shown goes on.
    fn renew(&mut self, concerns: impl Fn(PhotoId) -> bool) {
        if let Some(current) = &mut self.current {
            current.stale |= concerns(current.id);
        }
        if let Some(next) = self.next.take_if(|next| concerns(next.id)) {
            self.loader.recycle(next);
        }
        self.loader.cancel(concerns);
    }

    /// Reads the configuration anew, and tries again what could not be shown. A configuration with a mistake changes nothing.
    fn reload(&mut self) {
        if let Some(args) = &self.args {
            match Config::resolve(args).map_err(Failure::from).and_then(|config| self.change(config)) {
                Ok(()) => log::info!("the configuration was read anew"),
                Err(failure) => {
                    failure.to_string().lines().for_each(|line| log::warn!("{line}"));
                    log::warn!("the configuration stays as it was");
                }
            }
        }
        self.album.retry();
        self.renew(|_| true);
    }

    /// Goes on with another configuration. If it fails, nothing has changed.
    fn change(&mut self, config: Config) -> Result<(), Failure> {
        let season = SeasonClock::new(config.plain_look().season, config.calendar, &config.night.zone)?;
        self.dimmer.change(&config)?;
        (self.season, self.orbit) = (season, Orbit::new(config.plain_look().around_minutes));
        let before = std::mem::replace(&mut self.config, Arc::new(config));
        let config = Arc::clone(&self.config);
        set_log_level(config.log);
        let fixed = [
            ("output", before.display != config.display),
            ("backlight", before.backlight != config.backlight),
        ];
        for (key, _) in fixed.iter().filter(|(_, differs)| *differs) {
            log::warn!("display.{key}: takes effect at the next start");
        }
        self.panel.set_keys(config.actions);
        if let Some(keyboards) = &mut self.keyboards {
            if before.keys != config.keys {
                *keyboards = Keyboards::new(config.keys.clone(), true);
            }
            keyboards.set_keys(config.actions);
        }
        let oscillation = |config: &Config| (plain_drive(config), config.frames_per_second, config.seed);
        if oscillation(&before) != oscillation(&config) {
            let (drive, frames_per_second, seed) = oscillation(&config);
            self.show.change(drive, frames_per_second, seed);
            self.start_pace();
        }
        if before.rotation != config.rotation {
            self.show.set_rotation(config.rotation);
            self.drop_photos();
        }
        if (&before.photos, before.order) != (&config.photos, config.order) {
            self.album.change(&config);
        }
        Ok(())
    }

    /// The panel has another size: nothing that was prepared fits.
    fn drop_photos(&mut self) {
        (self.current, self.leaving, self.next) = (None, None, None);
        self.loader.cancel(|_| true);
        self.show.restart();
    }

    /// No photo can be shown. A frame waits for better ones; a program that was told which to show says so.
    fn give_up(&self) -> Result<(), Failure> {
        let tried = self.album.is_hopeless() && !self.loader.is_busy();
        if !self.typed || !tried || self.current.is_some() {
            return Ok(());
        }
        Err(Failure::new("none of the photos can be shown"))
    }

    /// Takes all presses in, and tells whether the show is to end.
    fn take_presses(&mut self, script: &mut Script<'_>) -> bool {
        let frame = self.show.frame();
        loop {
            let keyboards = self.keyboards.as_mut().and_then(|keyboards| keyboards.next_press(frame));
            let Some(press) =
                keyboards.or_else(|| script.next_press(frame)).or_else(|| self.panel.next_press(frame))
            else {
                break;
            };
            let Some(action) = self.config.actions.action(press) else { continue };
            if self.dimmer.wake() {
                continue;
            }
            match self.show.press(action) {
                Some(Request::Quit) => return true,
                Some(request) => self.answer(request),
                None => {}
            }
        }
        if let Some(number) = self.keyboards.as_mut().and_then(Keyboards::console_asked) {
            self.panel.show_console(number);
        }
        false
    }

    fn answer(&mut self, request: Request) {
        match request {
            Request::NextPhoto => self.album.next(),
            Request::PreviousPhoto => self.album.previous(),
            Request::NextEffect => self.next_way(),
            Request::NextReference => self.next_colours(),
            Request::Sleep => self.dimmer.sleep(),
            Request::Hide => {
                if let Some(current) = &self.current {
                    self.album.hide(current.id);
                }
                // A photo that is gone from its folder may stay while there is no other; one that nobody wants to see may not.
                if self.album.current().is_none() {
                    self.drop_photos();
                }
            }
            Request::Reload => self.reload(),
            Request::Quit => {}
        }
    }
}

/// What drives a photo of which nothing else is said.
fn plain_drive(config: &Config) -> drive::Settings {
    config.plain_look().life.at(config.frames_per_second).drive
}
