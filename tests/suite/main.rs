//! The integration tests: one binary, one module a theme.

mod buttons;
#[cfg(feature = "os")]
mod config;
mod display;
mod logbook;
mod mask;
mod noise;
#[cfg(feature = "os")]
mod output;
#[cfg(feature = "os")]
mod photo;
mod spectrum;
#[cfg(feature = "window")]
mod window;
