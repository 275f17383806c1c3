//! # Shimmer
//!
//! Light that plays over what moves in a breeze or flows.

pub mod automatic_mask;
