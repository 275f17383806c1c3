//! # Yurameki: a photo frame that brings still photos to life
//!
//! One idea carries the program:
//!
//! ```text
//! noise ──> drive ──> effect ──> frame ──> display
//! (1/f^β)  (X_A, θ)   (a picture  (pixels)  (panel, window,
//!                      that moves)           file, simulator)
//! ```
//!
//! A **noise** generator steps once per frame. The **drive** turns it into two numbers that every effect
//! understands: the amplitude X_A in 0..=1 and the phase θ in turns. An **effect** is prepared once per photo
//! (it may fail; it fills memory that was lent to it) and then renders any frame from a [`noise::drive::Drive`]
//! (it cannot fail, it allocates nothing). A **display** shows a frame. Buttons change noise, effect and photo.
//!
//! Everything here but `os` is `no_std` and never allocates: time, chance and memory come in by
//! the door, as a frame count, a seed and a lent slice, so that frame 144 of seed 7 is the same picture on every machine.
//!
//! ## `math`
//! Fixed-point formats, [`math::Turns`], sine, reciprocal square root, seeded random streams. Knows no pixel.
//!
//! ## `noise`
//! White, chaos, pink (digital filter) and brown generators, the response filter, and the drive that joins them.
//!
//! ## `frame`
//! Pixel formats, views of pixel memory with any stride, resampling, dithering. Knows no photo file and no device.
//!
//! ## `effect`
//! Turns a photo into frames. Knows sizes, strides and the drive; knows no device, file or clock.
//!
//! ## `display`
//! The trait a panel implements, and the simulated panel. Knows frames; knows no effect.
//!
//! ## `input`
//! Buttons, gestures and scripts of timed presses. Knows times; knows nothing else of the program.
//!
//! ## `config`
//! What can be chosen, checked and within its limits.
//!
//! ## `app`
//! The state machine and one turn of the loop. Decides; asks others to act.
//!
//! ## `os` (feature `os`)
//! The only part that knows std, files, clocks and devices.
#![cfg_attr(not(any(feature = "os", test)), no_std)]

#[macro_use]
mod named;

pub mod app;
pub mod config;
pub mod display;
pub mod effect;
pub mod frame;
pub mod input;
pub mod math;
pub mod noise;
#[cfg(feature = "os")]
pub mod os;
