//! # Noise

pub mod drive;
