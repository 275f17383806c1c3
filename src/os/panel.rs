//! The display that was chosen, and the presses that come with it.

use super::{Failure, args::DisplayChoice, usage};
use crate::{
    display::{
        BackBuffer, Display, DisplayError, Mode,
        sim::{self, Buffering, Sim},
    },
    frame::{Layout, PixelFormat, Size},
    input::{Buttons, Press, key_map::KeyMap},
};
use std::time::{Duration, Instant};

/// Somewhere to show frames.
pub(super) enum Panel {
    #[cfg(feature = "window")]
    Window(Box<super::window::Window>),
    Sim(Box<Simulated>),
}

/// A simulated panel in real time.
pub(super) struct Simulated {
    sim: Sim<Vec<u8>>,
    start: Instant,
    cpu_at_start: Duration,
}

impl Panel {
    /// Opens the display that was chosen, and says which it is and why.
    pub(super) fn open(choice: DisplayChoice, frames_per_second: u32) -> Result<Self, Failure> {
        match choice {
            DisplayChoice::Sim(sim::Spec(layout)) => Self::simulate(layout, frames_per_second),
            DisplayChoice::Window => Self::open_window(),
            DisplayChoice::Auto => Self::open_window().or_else(|why| {
                let layout = Layout::new(Size::new(1024, 600), PixelFormat::Xrgb8888, None)?;
                log::warn!("showing on a simulated panel of {}: {why}", layout.size);
                Self::simulate(layout, frames_per_second)
            }),
        }
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
        Ok(Self::Sim(Box::new(Simulated { sim, start: Instant::now(), cpu_at_start: usage::cpu_time() })))
    }

    /// What a simulated panel has seen, as a line for people.
    pub(super) fn report(&self) -> Option<String> {
        #[cfg_attr(not(feature = "window"), expect(irrefutable_let_patterns, reason = "the only display"))]
        let Self::Sim(simulated) = self else { return None };
        let log = simulated.sim.log();
        let millihertz = log.mean_millihertz();
        let worked = usage::cpu_time().saturating_sub(simulated.cpu_at_start).as_secs_f64();
        let share = 100.0 * worked / simulated.start.elapsed().as_secs_f64().max(1e-9);
        let memory =
            usage::peak_memory_kib().map_or("unknown".into(), |kib| format!("{:.1} MB", kib as f64 / 1024.0));
        Some(format!(
            "{} frames, {}.{:02} fps, {} dropped, {share:.1} % of a processor, peak memory {memory}",
            log.presents(),
            millihertz / 1000,
            millihertz % 1000 / 10,
            log.dropped(),
        ))
    }
}

impl Display for Panel {
    fn mode(&self) -> Mode {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.mode(),
            Self::Sim(simulated) => simulated.sim.mode(),
        }
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.back_buffer(),
            Self::Sim(simulated) => simulated.sim.back_buffer(),
        }
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.present(),
            Self::Sim(simulated) => {
                simulated.sim.set_now(simulated.start.elapsed().as_micros() as u64);
                simulated.sim.present()
            }
        }
    }
}

impl Buttons for Panel {
    #[cfg_attr(
        not(feature = "window"),
        expect(unused_variables, reason = "a simulated panel has no buttons")
    )]
    fn next_press(&mut self, frame: u64) -> Option<Press> {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.next_press(frame),
            Self::Sim(_) => None,
        }
    }

    fn set_keys(&mut self, keys: KeyMap) {
        match self {
            #[cfg(feature = "window")]
            Self::Window(window) => window.set_keys(keys),
            Self::Sim(_) => {}
        }
    }
}
