//! # Fluid
//!
//! Water, fire and smoke of a still picture come to life with detail taken from a database of videos, after "Creating fluid animation
//! from a single picture using a video database" (Okabe and others). Videos are cut into small [patches](patch); the picture is cut the
//! same way; each of its patches is [given](label) the best patch of a video, so that neighbours agree in motion and texture; what the
//! patches change from frame to frame is [laid](render) over the picture and written as a clip that the frame plays.
//!
//! ```text
//! video ──> motion, appearance ──> database ──> label ──> render ──> clip
//! ```

pub mod appearance;
pub mod args;
pub mod commands;
pub mod database;
pub mod features;
pub mod footage;
pub mod guidance;
pub mod label;
pub mod motion;
pub mod patch;
pub mod plane;
pub mod render;
pub mod video;
