//! # Displays
//!
//! The trait that a panel, a window or the simulator implements. Knows frames; knows no effect.

pub mod fault;
pub mod sim;

use crate::frame::{FrameMut, Layout};
use core::fmt;

/// What a display shows at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Size, pixel format and stride of the frames it takes.
    pub layout: Layout,
    /// Frames a second that the panel shows, in thousandths; 0 where it does not tell.
    pub refresh_millihertz: u32,
}

/// The frame that the next [`Display::present`] shows.
#[derive(Debug)]
pub struct BackBuffer<'a> {
    /// Its pixels.
    pub frame: FrameMut<'a>,
    /// How many presents ago these pixels were shown: 1 for the last one, 2 with two buffers in turn; 0 where they are
    /// unknown (new, or shared with somebody else) and must all be painted. EGL calls this the buffer age.
    pub age: u32,
}

/// Why a display cannot be drawn to now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplayError {
    /// The panel is gone (unplugged, or another program has taken it). Try again at a later turn.
    Lost,
    /// The panel has another mode now: read [`Display::mode`] and prepare again.
    ModeChanged,
    /// The person has closed the window.
    Closed,
}

impl fmt::Display for DisplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lost => "the display is gone",
            Self::ModeChanged => "the display has changed its mode",
            Self::Closed => "the window was closed",
        })
    }
}

impl core::error::Error for DisplayError {}

/// Something that shows frames.
///
/// One turn is [`Self::back_buffer`], painting, [`Self::present`]. Either call may fail at any turn; the show goes on all
/// the same: after [`DisplayError::ModeChanged`] with frames of the new mode, after [`DisplayError::Lost`] when a later
/// turn succeeds. Only [`DisplayError::Closed`] is for ever.
pub trait Display {
    /// What it shows at the moment. It changes only in a call that fails with [`DisplayError::ModeChanged`], so that a frame
    /// always has the layout that was told before.
    fn mode(&self) -> Mode;

    /// The frame that the next present shows, to be painted. Its padding bytes belong to the display.
    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError>;

    /// Shows the back buffer. May wait for the panel's refresh, never longer. After a failure the frame may or may not have
    /// been seen, and the next back buffer tells by its age what it holds.
    fn present(&mut self) -> Result<(), DisplayError>;

    /// Switches the panel's power off or on again, and says whether it could: not every panel can. While it is off, frames
    /// may be presented as ever and are not seen; the first one after it is on again is.
    fn set_power(&mut self, on: bool) -> Result<bool, DisplayError> {
        let _ = on;
        Ok(false)
    }
}
