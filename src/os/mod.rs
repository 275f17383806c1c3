//! # Operating system

pub mod photo;
pub mod interrupt;
pub mod output;
pub mod progress;
#[cfg(feature = "window")]
pub mod window;
