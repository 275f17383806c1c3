//! The integration tests: one binary, one module a theme.

#[cfg(feature = "os")]
mod cli;
mod cross_geometry;
mod display;
#[cfg(feature = "os")]
mod goldens;
mod layering;
#[cfg(feature = "os")]
mod photo;
mod show;
mod stage;
#[cfg(feature = "window")]
mod window;
