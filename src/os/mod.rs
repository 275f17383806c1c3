//! # Operating system

#[cfg(feature = "window")]
pub mod window;
