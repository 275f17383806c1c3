//! # Operating system

pub mod photo;
