//! What the kernel knows of a frame buffer device beyond the `linuxfb` crate, and the device's memory.

use rustix::{
    ioctl::{Getter, Setter, Updater, ioctl},
    mm::{MapFlags, ProtFlags, mmap, munmap},
    param::page_size,
};
use std::{
    ffi::{c_ulong, c_void},
    fs::File,
    io, ptr,
};

const FBIOGET_VSCREENINFO: u32 = 0x4600;
const FBIOPUT_VSCREENINFO: u32 = 0x4601;
const FBIOGET_FSCREENINFO: u32 = 0x4602;
const FBIOPAN_DISPLAY: u32 = 0x4606;
/// `_IOW('F', 0x20, __u32)`.
const FBIO_WAITFORVSYNC: u32 = 0x4004_4620;

/// `FB_TYPE_PACKED_PIXELS`: neither planes nor text.
pub(super) const PACKED_PIXELS: u32 = 0;

/// `struct fb_var_screeninfo` of `<linux/fb.h>`: the mode. `rest` is only passed back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(super) struct Screen {
    pub(super) xres: u32,
    pub(super) yres: u32,
    pub(super) xres_virtual: u32,
    pub(super) yres_virtual: u32,
    pub(super) xoffset: u32,
    pub(super) yoffset: u32,
    pub(super) bits_per_pixel: u32,
    grayscale: u32,
    /// Offset, length and direction of red, green, blue and alpha.
    channels: [[u32; 3]; 4],
    rest: [u32; 20],
}

/// `struct fb_fix_screeninfo` of `<linux/fb.h>`: the memory.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Memory {
    id: [u8; 16],
    smem_start: c_ulong,
    pub(super) smem_len: u32,
    pub(super) kind: u32,
    kind_aux: u32,
    visual: u32,
    xpanstep: u16,
    pub(super) ypanstep: u16,
    ywrapstep: u16,
    pub(super) line_length: u32,
    mmio_start: c_ulong,
    mmio_len: u32,
    accel: u32,
    capabilities: u16,
    reserved: [u16; 2],
}

impl Screen {
    pub(super) fn of(device: &File) -> io::Result<Self> {
        // SAFETY: FBIOGET_VSCREENINFO fills a `struct fb_var_screeninfo`; every bit pattern is one.
        Ok(unsafe { ioctl(device, Getter::<FBIOGET_VSCREENINFO, Self>::new()) }?)
    }

    /// Sets this mode.
    pub(super) fn put(mut self, device: &File) -> io::Result<()> {
        // SAFETY: FBIOPUT_VSCREENINFO reads and writes a `struct fb_var_screeninfo`.
        Ok(unsafe { ioctl(device, Updater::<FBIOPUT_VSCREENINFO, Self>::new(&mut self)) }?)
    }

    /// Shows the page that starts at row `yoffset`.
    pub(super) fn pan(mut self, device: &File, yoffset: u32) -> io::Result<()> {
        (self.xoffset, self.yoffset) = (0, yoffset);
        // SAFETY: FBIOPAN_DISPLAY reads and writes a `struct fb_var_screeninfo`.
        Ok(unsafe { ioctl(device, Updater::<FBIOPAN_DISPLAY, Self>::new(&mut self)) }?)
    }

    /// Whether a picture has the same size, width in memory and pixels in both modes.
    pub(super) fn same_picture(&self, other: Self) -> bool {
        let picture = |screen: &Self| (screen.xres, screen.yres, screen.xres_virtual, screen.bits_per_pixel);
        picture(self) == picture(&other) && self.channels == other.channels
    }
}

/// Waits for the vertical blank, where the driver can.
pub(super) fn wait_for_vsync(device: &File) -> io::Result<()> {
    // SAFETY: FBIO_WAITFORVSYNC reads a u32, the number of the display controller.
    Ok(unsafe { ioctl(device, Setter::<FBIO_WAITFORVSYNC, u32>::new(0)) }?)
}

impl Memory {
    pub(super) fn of(device: &File) -> io::Result<Self> {
        // SAFETY: FBIOGET_FSCREENINFO fills a `struct fb_fix_screeninfo`; every bit pattern is one.
        Ok(unsafe { ioctl(device, Getter::<FBIOGET_FSCREENINFO, Self>::new()) }?)
    }

    /// The driver's name.
    pub(super) fn name(&self) -> String {
        let name = self.id.split(|&byte| byte == 0).next().unwrap_or_default();
        String::from_utf8_lossy(name).trim().to_owned()
    }
}

/// The device's memory, mapped to be written.
pub(super) struct Mapping {
    start: *mut c_void,
    /// Of the whole mapping.
    len: usize,
    /// Where in the mapping the frame buffer starts: a mapping starts with a page, a frame buffer may not.
    skip: usize,
}

impl Mapping {
    pub(super) fn new(device: &File, memory: &Memory) -> io::Result<Self> {
        let skip = memory.smem_start as usize % page_size();
        let len = skip + memory.smem_len as usize;
        let rights = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: a new shared mapping at an address that the kernel chooses; nothing else in the program points into it.
        let start = unsafe { mmap(ptr::null_mut(), len, rights, MapFlags::SHARED, device, 0) }?;
        Ok(Self { start, len, skip })
    }

    /// Copies `row` to `offset` bytes from the start of the frame buffer; what does not fit is left out.
    pub(super) fn write(&mut self, offset: usize, row: &[u8]) {
        let room = (self.len - self.skip).saturating_sub(offset);
        let len = row.len().min(room);
        if len > 0 {
            // SAFETY: skip + offset + len ≤ self.len, the length of the mapping, which lives as long as self; `row` is the
            // program's own memory and cannot overlap it.
            unsafe {
                let to = self.start.cast::<u8>().add(self.skip + offset);
                ptr::copy_nonoverlapping(row.as_ptr(), to, len);
            }
        }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: this very mapping, to which no reference is ever lent.
        if let Err(error) = unsafe { munmap(self.start, self.len) } {
            log::debug!("the frame buffer stays mapped: {error}");
        }
    }
}
