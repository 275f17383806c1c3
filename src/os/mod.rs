//! # The operating system
//!
//! The only part that knows std: arguments, photo files, clocks, devices and output files. Everything else is lent what it
//! needs from here.

mod album;
pub mod args;
pub mod autumn;
pub mod backlight;
pub mod board;
mod caption;
pub mod clip;
pub mod config;
mod config_command;
pub mod config_file;
#[cfg(any(feature = "kms", feature = "linuxfb"))]
mod console;
mod dimmer;
mod document;
#[cfg(target_os = "linux")]
pub mod evdev;
#[cfg(feature = "linuxfb")]
mod fbdev;
pub mod interrupt;
#[cfg(feature = "kms")]
mod kms;
pub mod library;
mod loader;
pub mod local_time;
mod once;
pub mod output;
mod panel;
mod panics;
pub mod photo;
mod probe;
pub mod progress;
mod run;
pub mod scene;
mod script_file;
mod service;
pub mod sidecar;
pub mod state;
mod stdout;
mod usage;
#[cfg(feature = "window")]
pub mod window;

mod encode;
mod mask;
mod memory;
mod moving;
mod noise;
mod render;

pub use document::{ConfigError, Fault, Place};

use args::{Args, Command};
use std::{error::Error, fmt};

/// Why a command ended early, as one line for people; for a configuration a line for each mistake.
#[derive(Debug)]
pub struct Failure(Box<dyn Error + Send + Sync>);

impl Failure {
    fn new(line: impl Into<String>) -> Self {
        Self(line.into().into())
    }

    /// The code to end with: 1 failed, 2 asked for what cannot be.
    pub fn exit_code(&self) -> u8 {
        if self.0.is::<ConfigError>() { 2 } else { 1 }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(Box::new(error))
    }
}

/// Logs no more than `level`, unless the environment (RUST_LOG) says otherwise.
pub fn set_log_level(level: log::LevelFilter) {
    if std::env::var_os("RUST_LOG").is_none() {
        log::set_max_level(level);
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
        Some(Command::Encode(args)) => encode::encode(&args),
        Some(Command::Decode(args)) => encode::decode(&args),
        Some(Command::Config(args)) => config_command::config(&args),
        Some(Command::Probe) => {
            print!("{}", probe::report());
            Ok(())
        }
        #[cfg(any(feature = "kms", feature = "linuxfb"))]
        Some(Command::RestoreConsole) => Ok(console::restore()?),
    }
}
