//! A panel on a frame buffer device, `/dev/fb*`.
//!
//! Frames are painted in the program's own memory and copied to the device's in whole rows, in order: that memory may be
//! write-combined, and is never read. How a copy is kept from being seen half done is tried when the device is opened:
//!
//! 1. two pages and a pan from one to the other (`FBIOPAN_DISPLAY`), where the driver has room for a second page;
//! 2. else the copy follows the vertical blank (`FBIO_WAITFORVSYNC`), where the driver really waits for it;
//! 3. else it is made when the frame is due.
//!
//! The frame buffer devices that DRM drivers emulate are never panned: some of them take the call, and show nothing of it or
//! a black panel (seen with bochs and virtio-gpu of Linux 6.1 and `drm_fbdev_overalloc=200`). `kms` flips there.
//!
//! The `linuxfb` crate lists the devices, tells size and channels, sets the virtual size and switches the panel's power. It
//! does not tell `line_length` and `smem_len`, by which alone the memory can be mapped: those come from the kernel here.

mod device;
mod format;
mod kernel;

use super::console::Shared;
use crate::{
    display::{BackBuffer, Display, DisplayError, Mode},
    frame::{FrameMut, FrameRef},
};
use device::Device;
pub(super) use device::{FbdevError, describe};
use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// A device that has gone is looked for so often.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// The devices that the kernel has, in their order.
pub(super) fn list() -> Vec<PathBuf> {
    let mut devices = linuxfb::Framebuffer::list().unwrap_or_default();
    devices.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    devices
}

/// A panel on a frame buffer device.
pub(super) struct Fbdev {
    choice: Option<PathBuf>,
    /// `None` while it is gone.
    device: Option<Device>,
    mode: Mode,
    /// The back buffer.
    shadow: Vec<u8>,
    /// The shadow holds the last frame.
    known: bool,
    power: bool,
    next_look: Instant,
}

impl Fbdev {
    /// Opens the device at `choice`, or the first.
    pub(super) fn open(choice: Option<&Path>) -> Result<Self, FbdevError> {
        let device = open(choice)?;
        Ok(Self {
            choice: choice.map(Path::to_owned),
            mode: device.mode(),
            shadow: vec![0; device.mode().layout.len_bytes()],
            device: Some(device),
            known: false,
            power: true,
            next_look: Instant::now(),
        })
    }

    /// Opens a device that has gone anew.
    fn reopen(&mut self) -> Result<(), DisplayError> {
        if Instant::now() < self.next_look {
            return Err(DisplayError::Lost);
        }
        self.next_look = Instant::now() + LOOK_EVERY;
        let device = open(self.choice.as_deref()).map_err(|error| {
            log::debug!("{error}");
            DisplayError::Lost
        })?;
        let before = std::mem::replace(&mut self.mode, device.mode());
        self.shadow.resize(self.mode.layout.len_bytes(), 0);
        self.known = false;
        self.device = Some(device);
        if before == self.mode { Ok(()) } else { Err(DisplayError::ModeChanged) }
    }
}

fn open(choice: Option<&Path>) -> Result<Device, FbdevError> {
    let path = choice.map(Path::to_owned).or_else(|| list().into_iter().next());
    let device = Device::open(&path.ok_or(FbdevError::None)?)?;
    log::info!("showing on {device}");
    Ok(device)
}

impl Display for Fbdev {
    fn mode(&self) -> Mode {
        self.mode
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        if self.device.is_none() {
            self.reopen()?;
        }
        let frame = FrameMut::new(&mut self.shadow, self.mode.layout).map_err(|_| DisplayError::Lost)?;
        Ok(BackBuffer { frame, age: self.known.into() })
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        let device = self.device.as_mut().ok_or(DisplayError::Lost)?;
        self.known = true;
        if !self.power {
            return Ok(());
        }
        let frame = FrameRef::new(&self.shadow, self.mode.layout).map_err(|_| DisplayError::Lost)?;
        device.show(frame).map_err(|error| {
            log::warn!("the panel cannot be drawn to: {error}; waiting for it");
            self.device = None;
            DisplayError::Lost
        })
    }

    fn set_power(&mut self, on: bool) -> Result<bool, DisplayError> {
        let could = self.device.as_mut().ok_or(DisplayError::Lost)?.set_power(on);
        self.power = on || !could;
        Ok(could)
    }
}

impl Shared for Fbdev {
    fn pause(&mut self) {}

    fn resume(&mut self) {}
}
