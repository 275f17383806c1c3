//! The display that was chosen, and the presses that come with it. This is the one place that chooses.
//!
//! `auto` takes a window within a desktop: the desktop holds the panel, and nothing else could draw to it. Without a desktop it
//! takes the panel itself, by KMS, else by a frame buffer device; a machine that has neither gets a simulated panel. A panel
//! that is not there yet, with a card or a device that could show on it, is waited for. A service is there for a panel that
//! people see: it waits for a card or a device too, whose driver may be loaded after it, and never simulates.

#[cfg(any(feature = "kms", feature = "linuxfb"))]
use super::console::OnConsole;
#[cfg(feature = "linuxfb")]
use super::fbdev::Fbdev;
#[cfg(feature = "kms")]
use super::kms::Kms;
use super::{
    Failure,
    args::{DisplayChoice, KmsChoice},
    service::{Idle, Service},
    usage,
};
use crate::{
    display::{
        BackBuffer, Display, DisplayError, Mode,
        sim::{self, Buffering, Sim},
    },
    frame::{Layout, PixelFormat, Size},
    input::{Buttons, Press, key_map::KeyMap},
};
use std::{
    path::Path,
    thread::sleep,
    time::{Duration, Instant},
};

/// Somewhere to show frames.
pub(super) enum Panel {
    #[cfg(feature = "window")]
    Window(Box<super::window::Window>),
    #[cfg(feature = "kms")]
    Kms(Box<OnConsole<Kms>>),
    #[cfg(feature = "linuxfb")]
    Fbdev(Box<OnConsole<Fbdev>>),
    Sim(Box<Simulated>),
}

/// A simulated panel in real time.
pub(super) struct Simulated {
    sim: Sim<Vec<u8>>,
    start: Instant,
    cpu_at_start: Duration,
    lateness: Lateness,
}

/// How late frames were, counted by milliseconds.
#[derive(Debug)]
struct Lateness {
    /// Frames that were late by less than 1, 2, … ms; the last count holds all that were later.
    counts: [u64; 1001],
    worst: Duration,
}

impl Lateness {
    const fn new() -> Self {
        Self { counts: [0; 1001], worst: Duration::ZERO }
    }

    fn note(&mut self, late: Duration) {
        self.counts[(late.as_millis() as usize).min(1000)] += 1;
        self.worst = self.worst.max(late);
    }

    /// The milliseconds below which so many per cent of the frames were late.
    fn percentile(&self, per_cent: u64) -> usize {
        let all: u64 = self.counts.iter().sum();
        let mut left = (all * per_cent).div_ceil(100);
        let below = self.counts.iter().position(|&count| {
            left = left.saturating_sub(count);
            left == 0
        });
        below.unwrap_or(1000) + 1
    }
}

/// What may become of a panel that cannot be shown on now.
#[cfg_attr(not(feature = "kms"), expect(dead_code, reason = "only KMS knows panels and holders"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prospect {
    /// There is no device for it, or its driver is not loaded yet.
    NoDevice,
    /// There is a device, and no panel plugged in.
    NoPanel,
    /// There is a device that this user may not open. At the start of the machine it may be another one in a moment, when udev
    /// gives it to its group.
    Denied,
    /// Another program holds it.
    Held,
    /// It stays as it is.
    None,
}

/// Why a panel cannot be shown on now.
struct Unavailable {
    why: Failure,
    prospect: Prospect,
}

/// How often a panel that is waited for is looked for.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// How long a service waits for a graphics card, and the right to open it, before it takes a frame buffer device. Firmware leaves
/// one of those that the card's driver will take away, and a Raspberry Pi loads that driver within its first ten seconds.
const CARD_PATIENCE: Duration = Duration::from_secs(15);

impl Panel {
    /// Opens the display that was chosen, waiting for a panel that is not there yet, and says which it is and why.
    pub(super) fn open(
        choice: &DisplayChoice,
        frames_per_second: u32,
        service: &mut Service,
    ) -> Result<Self, Failure> {
        match choice {
            DisplayChoice::Sim(sim::Spec(layout)) => Self::simulate(*layout, frames_per_second),
            DisplayChoice::Window => Self::open_window(),
            DisplayChoice::Kms(choice) => {
                let passes = |prospect, _| matches!(prospect, Prospect::NoDevice | Prospect::NoPanel);
                wait(|| Self::open_kms(choice), passes, service).map_err(|unavailable| unavailable.why)
            }
            DisplayChoice::Fbdev(device) => {
                let passes = |prospect, _| prospect == Prospect::NoDevice;
                wait(|| Self::open_fbdev(device.as_deref()), passes, service)
                    .map_err(|unavailable| unavailable.why)
            }
            DisplayChoice::Auto => Self::open_any(frames_per_second, service),
        }
    }

    fn open_any(frames_per_second: u32, service: &mut Service) -> Result<Self, Failure> {
        let no_window = match Self::open_window() {
            Ok(panel) => return Ok(panel),
            Err(why) => why,
        };
        log::info!("no window: {no_window}");
        let managed = service.is_managed();
        let passes = |prospect, waited| match prospect {
            Prospect::NoPanel => true,
            Prospect::NoDevice => managed && waited < CARD_PATIENCE,
            Prospect::Denied | Prospect::Held | Prospect::None => false,
        };
        let no_kms = match wait(|| Self::open_kms(&KmsChoice::default()), passes, service) {
            Ok(panel) => return Ok(panel),
            // What somebody else shows would be painted over at once, by whatever way.
            Err(Unavailable { why, prospect: Prospect::Held }) => return Err(why),
            Err(Unavailable { why, .. }) => why,
        };
        log::info!("no kms: {no_kms}");
        let passes = |prospect, _| managed && prospect == Prospect::NoDevice;
        let no_fbdev = match wait(|| Self::open_fbdev(None), passes, service) {
            Ok(panel) => return Ok(panel),
            Err(Unavailable { why, .. }) => why,
        };
        log::info!("no fbdev: {no_fbdev}");
        if managed {
            return Err(Failure::new("there is no panel to show on; `yurameki probe` lists what there is"));
        }
        let layout = Layout::new(Size::new(1024, 600), PixelFormat::Xrgb8888, None)?;
        log::warn!("nobody can see it: showing on a simulated panel of {}", layout.size);
        Self::simulate(layout, frames_per_second)
    }

    #[cfg(feature = "kms")]
    fn open_kms(choice: &KmsChoice) -> Result<Self, Unavailable> {
        let kms = Kms::open(choice);
        let kms = kms.map_err(|error| Unavailable { prospect: error.prospect(), why: error.into() })?;
        Ok(Self::Kms(Box::new(OnConsole::new(kms))))
    }

    #[cfg(not(feature = "kms"))]
    fn open_kms(_: &KmsChoice) -> Result<Self, Unavailable> {
        let why = Failure::new("this program was built without KMS; build it with the feature `kms`");
        Err(Unavailable { why, prospect: Prospect::None })
    }

    #[cfg(feature = "linuxfb")]
    fn open_fbdev(device: Option<&Path>) -> Result<Self, Unavailable> {
        let fbdev = Fbdev::open(device);
        let fbdev = fbdev.map_err(|error| Unavailable { prospect: error.prospect(), why: error.into() })?;
        Ok(Self::Fbdev(Box::new(OnConsole::new(fbdev))))
    }

    #[cfg(not(feature = "linuxfb"))]
    fn open_fbdev(_: Option<&Path>) -> Result<Self, Unavailable> {
        let why = Failure::new(
            "this program was built without frame buffer devices; build it with the feature `linuxfb`",
        );
        Err(Unavailable { why, prospect: Prospect::None })
    }

    #[cfg(feature = "window")]
    fn open_window() -> Result<Self, Failure> {
        let window = super::window::Window::open("Yurameki", None)?;
        log::info!("showing in a window of {}", window.mode().layout.size);
        Ok(Self::Window(Box::new(window)))
    }

    #[cfg(not(feature = "window"))]
    fn open_window() -> Result<Self, Failure> {
        Err(Failure::new("this program was built without windows; build it with the feature `window`"))
    }

    fn simulate(layout: Layout, frames_per_second: u32) -> Result<Self, Failure> {
        let memory = vec![0; sim::memory_len(layout, Buffering::Double)];
        let sim = Sim::new(memory, layout, Buffering::Double, frames_per_second * 1_000)?;
        Ok(Self::Sim(Box::new(Simulated {
            sim,
            start: Instant::now(),
            cpu_at_start: usage::cpu_time(),
            lateness: Lateness::new(),
        })))
    }

    /// Whether it is a panel without a desktop, which the program has for itself: with its keyboards and its light.
    pub(super) const fn is_bare(&self) -> bool {
        match self {
            #[cfg(feature = "window")]
            Self::Window(_) => false,
            Self::Sim(_) => false,
            #[cfg(any(feature = "kms", feature = "linuxfb"))]
            _ => true,
        }
    }

    /// Switches to the text console of that number, where the panel shares itself with consoles.
    pub(super) fn show_console(&self, number: u8) {
        match self {
            #[cfg(feature = "kms")]
            Self::Kms(kms) => kms.show_console(number),
            #[cfg(feature = "linuxfb")]
            Self::Fbdev(fbdev) => fbdev.show_console(number),
            _ => log::debug!("there is no console {number} here"),
        }
    }

    /// Notes how late the frame was that was presented last.
    pub(super) fn note_lateness(&mut self, late: Duration) {
        match self {
            Self::Sim(simulated) => simulated.lateness.note(late),
            #[cfg(any(feature = "window", feature = "kms", feature = "linuxfb"))]
            _ => {}
        }
    }

    /// What a simulated panel has seen, as a line for people.
    pub(super) fn report(&self) -> Option<String> {
        #[cfg_attr(
            not(any(feature = "window", feature = "kms", feature = "linuxfb")),
            expect(irrefutable_let_patterns, reason = "the only display")
        )]
        let Self::Sim(simulated) = self else { return None };
        let log = simulated.sim.log();
        let millihertz = log.mean_millihertz();
        let worked = usage::cpu_time().saturating_sub(simulated.cpu_at_start).as_secs_f64();
        let share = 100.0 * worked / simulated.start.elapsed().as_secs_f64().max(1e-9);
        let memory =
            usage::peak_memory_kib().map_or("unknown".into(), |kib| format!("{:.1} MB", kib as f64 / 1024.0));
        Some(format!(
            "{} frames, {}.{:02} fps, {} dropped, late by less than {} ms (half), {} ms (99 %), {:.1} ms (all), \
             {share:.1} % of a processor, peak memory {memory}",
            log.presents(),
            millihertz / 1000,
            millihertz % 1000 / 10,
            log.dropped(),
            simulated.lateness.percentile(50),
            simulated.lateness.percentile(99),
            simulated.lateness.worst.as_secs_f64() * 1e3,
        ))
    }
}

impl Display for Panel {
    fn mode(&self) -> Mode {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.mode(),
            #[cfg(feature = "kms")]
            Self::Kms(kms) => kms.mode(),
            #[cfg(feature = "linuxfb")]
            Self::Fbdev(fbdev) => fbdev.mode(),
            Self::Sim(simulated) => simulated.sim.mode(),
        }
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.back_buffer(),
            #[cfg(feature = "kms")]
            Self::Kms(kms) => kms.back_buffer(),
            #[cfg(feature = "linuxfb")]
            Self::Fbdev(fbdev) => fbdev.back_buffer(),
            Self::Sim(simulated) => simulated.sim.back_buffer(),
        }
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.present(),
            #[cfg(feature = "kms")]
            Self::Kms(kms) => kms.present(),
            #[cfg(feature = "linuxfb")]
            Self::Fbdev(fbdev) => fbdev.present(),
            Self::Sim(simulated) => {
                simulated.sim.set_now(simulated.start.elapsed().as_micros() as u64);
                simulated.sim.present()
            }
        }
    }

    fn set_power(&mut self, on: bool) -> Result<bool, DisplayError> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.set_power(on),
            #[cfg(feature = "kms")]
            Self::Kms(kms) => kms.set_power(on),
            #[cfg(feature = "linuxfb")]
            Self::Fbdev(fbdev) => fbdev.set_power(on),
            Self::Sim(simulated) => simulated.sim.set_power(on),
        }
    }
}

/// Opens a panel, waiting as long as what keeps it away `passes`, by itself and how long it was waited for; a service waits a little
/// for the right to open it, too.
fn wait(
    open: impl Fn() -> Result<Panel, Unavailable>,
    passes: impl Fn(Prospect, Duration) -> bool,
    service: &mut Service,
) -> Result<Panel, Unavailable> {
    let (start, managed) = (Instant::now(), service.is_managed());
    let may_be_given = |prospect| prospect == Prospect::Denied && managed && start.elapsed() < CARD_PATIENCE;
    let mut told = false;
    loop {
        match open() {
            Err(Unavailable { why, prospect })
                if passes(prospect, start.elapsed()) || may_be_given(prospect) =>
            {
                service.idle(Instant::now(), Idle::NoPanel);
                if !told {
                    log::warn!("{why}; waiting for it");
                }
                told = true;
                sleep(LOOK_EVERY);
            }
            outcome => return outcome,
        }
    }
}

impl Buttons for Panel {
    #[cfg_attr(not(feature = "window"), expect(unused_variables, reason = "only a window has buttons"))]
    fn next_press(&mut self, frame: u64) -> Option<Press> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.next_press(frame),
            _ => None,
        }
    }

    #[cfg_attr(not(feature = "window"), expect(unused_variables, reason = "only a window has buttons"))]
    fn set_keys(&mut self, keys: KeyMap) {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.set_keys(keys),
            _ => {}
        }
    }
}
