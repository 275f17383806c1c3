//! # The operating system
//!
//! The only part that knows std: arguments, photo files, clocks, devices and output files. Everything else is lent what it
//! needs from here.

pub mod args;
#[cfg(any(feature = "kms", feature = "linuxfb"))]
mod console;
#[cfg(feature = "linuxfb")]
mod fbdev;
pub mod interrupt;
#[cfg(feature = "kms")]
mod kms;
pub mod output;
mod panel;
pub mod photo;
mod probe;
pub mod progress;
mod run;
mod scene;
mod usage;
#[cfg(feature = "window")]
pub mod window;

mod mask;
mod noise;
mod render;

use args::{Args, Command};
use std::{error::Error, fmt};

/// Why a command ended early, as one line for people.
#[derive(Debug)]
pub struct Failure(Box<dyn Error>);

impl Failure {
    fn new(line: impl Into<String>) -> Self {
        Self(line.into().into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(Box::new(error))
    }
}

/// Does what the arguments ask for.
pub fn execute(args: Args) -> Result<(), Failure> {
    match args.command {
        None => run::demo(),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Render(args)) => render::render(&args),
        Some(Command::Noise(args)) => noise::noise(&args),
        Some(Command::Mask(args)) => mask::mask(&args),
        Some(Command::Probe) => {
            print!("{}", probe::report());
            Ok(())
        }
        #[cfg(any(feature = "kms", feature = "linuxfb"))]
        Some(Command::RestoreConsole) => Ok(console::restore()?),
    }
}
