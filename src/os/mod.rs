//! # Operating system
