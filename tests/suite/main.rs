//! The integration tests: one binary, one module a theme.

mod display;
mod logbook;
mod mask;
mod noise;
#[cfg(feature = "os")]
mod output;
#[cfg(feature = "os")]
mod photo;
mod playlist;
mod spectrum;
#[cfg(feature = "window")]
mod window;
