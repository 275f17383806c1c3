//! The integration tests: one binary, one module a theme.

#[cfg(feature = "os")]
mod photo;
