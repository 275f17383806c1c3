//! The integration tests: one binary, one module a theme.

mod display;
#[cfg(feature = "os")]
mod library;
mod logbook;
mod mask;
#[cfg(feature = "os")]
mod night;
mod noise;
#[cfg(feature = "os")]
mod output;
#[cfg(feature = "os")]
mod photo;
mod playlist;
mod spectrum;
#[cfg(feature = "os")]
mod state;
#[cfg(feature = "window")]
mod window;
