//! The integration tests: one binary, one module a theme.

mod buttons;
#[cfg(feature = "os")]
mod cli;
mod config;
mod cross_geometry;
mod display;
#[cfg(feature = "os")]
mod goldens;
mod layering;
mod logbook;
mod mask;
mod noise;
#[cfg(feature = "os")]
mod output;
#[cfg(feature = "os")]
mod photo;
mod show;
mod spectrum;
mod stage;
#[cfg(feature = "window")]
mod window;
