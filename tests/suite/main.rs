//! The integration tests: one binary, one module a theme.

mod display;
#[cfg(feature = "os")]
mod output;
#[cfg(feature = "os")]
mod photo;
#[cfg(feature = "window")]
mod window;
