//! The integration tests: one module a theme.

mod display;
#[cfg(feature = "window")]
mod window;
