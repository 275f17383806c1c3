//! # The program's decisions
//!
//! What an action means ([`State`]), which photo comes next ([`playlist`]), how bright the panel is ([`night`]), when a frame
//! is due ([`pace`]), and one turn of the loop ([`Show::turn`]): render, present, step. Decides; whoever calls it opens photos
//! and waits for time to pass.

pub mod night;
mod overlay;
pub mod pace;
mod picture;
pub mod playlist;
mod show;
mod state;

pub use picture::{Picture, PictureMoment, Subject};
pub use show::Show;
pub use state::{Outcome, Request, State};
