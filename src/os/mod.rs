//! # Operating system

pub mod photo;
pub mod interrupt;
pub mod output;
pub mod progress;
