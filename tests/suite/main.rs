//! The integration tests: one binary, one module a theme.

mod buttons;
#[cfg(feature = "os")]
mod cli;
mod config;
mod cross_geometry;
mod display;
#[cfg(feature = "os")]
mod fluid;
#[cfg(feature = "os")]
mod goldens;
#[cfg(feature = "os")]
mod kaleidoscope;
mod layering;
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
#[cfg(feature = "os")]
mod reload;
#[cfg(feature = "os")]
mod service;
mod show;
mod spectrum;
mod stage;
#[cfg(feature = "os")]
mod state;
#[cfg(feature = "os")]
mod strobe;
#[cfg(feature = "window")]
mod window;
