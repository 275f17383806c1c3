//! # Operating system

pub mod interrupt;
pub mod output;
pub mod progress;
