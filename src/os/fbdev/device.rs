//! One frame buffer device, while it is there.

use super::{
    format,
    kernel::{Mapping, Memory, PACKED_PIXELS, Screen, wait_for_vsync},
};
use crate::{
    display::Mode,
    frame::{FrameRef, Layout, LayoutError, Size},
    os::panel::Prospect,
};
use linuxfb::{BlankingLevel, Framebuffer};
use std::{
    fmt,
    fs::{File, OpenOptions},
    io,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// A wait for the vertical blank that ends sooner was none: the fastest panels have one every 4 ms.
const NO_WAIT: Duration = Duration::from_millis(2);

/// Why a device cannot be shown on.
#[derive(Debug)]
pub(in crate::os) enum FbdevError {
    /// The kernel has none.
    None,
    /// It cannot be opened or asked.
    Open { path: PathBuf, error: io::Error },
    /// It has pixels that nothing here can paint.
    Pixels { path: PathBuf, numbers: String },
    /// Its numbers describe no frame.
    Layout { path: PathBuf, error: LayoutError },
}

impl FbdevError {
    pub(in crate::os) fn prospect(&self) -> Prospect {
        match self {
            Self::None => Prospect::NoDevice,
            Self::Open { error, .. } if error.kind() == io::ErrorKind::NotFound => Prospect::NoDevice,
            Self::Open { error, .. } if error.kind() == io::ErrorKind::PermissionDenied => Prospect::Denied,
            Self::Open { .. } | Self::Pixels { .. } | Self::Layout { .. } => Prospect::None,
        }
    }
}

impl fmt::Display for FbdevError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("there is no frame buffer device /dev/fb*"),
            Self::Open { path, error } if error.kind() == io::ErrorKind::PermissionDenied => {
                write!(f, "{}: {error}; the user must be in the group video", path.display())
            }
            Self::Open { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Pixels { path, numbers } => write!(
                f,
                "{} has pixels of {numbers}, which cannot be painted; choose another mode, as by `video=` of the kernel",
                path.display()
            ),
            Self::Layout { path, error } => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl std::error::Error for FbdevError {}

/// A frame buffer device that frames can be shown on.
pub(in crate::os) struct Device {
    path: PathBuf,
    name: String,
    file: File,
    framebuffer: Framebuffer,
    memory: Memory,
    mapping: Mapping,
    /// The mode as it was found, and as it is.
    before: Screen,
    screen: Screen,
    mode: Mode,
    /// Two pages are shown in turn.
    pans: bool,
    /// The driver waits for the vertical blank.
    waits: bool,
    blank: bool,
}

impl Device {
    pub(super) fn open(path: &Path) -> Result<Self, FbdevError> {
        let failed = |error| FbdevError::Open { path: path.to_owned(), error };
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
        let mut framebuffer = Framebuffer::new(path).map_err(|error| failed(io_error(error)))?;
        let before = Screen::of(&file).map_err(failed)?;
        let pans = try_second_page(&file, &mut framebuffer, before).map_err(failed)?;
        let (screen, memory) = (Screen::of(&file).map_err(failed)?, Memory::of(&file).map_err(failed)?);
        let mode = Mode { layout: layout(path, &framebuffer, &memory)?, refresh_millihertz: 0 };
        let mapping = Mapping::new(&file, &memory).map_err(failed)?;
        let waits = waits_for_vsync(&file);
        let (path, name) = (path.to_owned(), memory.name());
        Ok(Self {
            path,
            name,
            file,
            framebuffer,
            memory,
            mapping,
            before,
            screen,
            mode,
            pans,
            waits,
            blank: false,
        })
    }

    pub(super) const fn mode(&self) -> Mode {
        self.mode
    }

    /// Copies `frame` to the panel.
    pub(super) fn show(&mut self, frame: FrameRef<'_>) -> io::Result<()> {
        // Cheap, and the only call that tells of a device that has gone.
        let now = Screen::of(&self.file)?;
        if !now.same_picture(self.screen) {
            return Err(io::Error::other("it has another mode"));
        }
        if self.pans {
            let page = if now.yoffset == 0 { now.yres } else { 0 };
            self.copy(frame, page, 0);
            now.pan(&self.file, page)?;
            self.wait();
        } else {
            self.wait();
            self.copy(frame, now.yoffset, now.xoffset);
        }
        Ok(())
    }

    fn copy(&mut self, frame: FrameRef<'_>, first_row: u32, first_column: u32) {
        let stride = self.memory.line_length as usize;
        let column = first_column as usize * self.mode.layout.format.bytes_per_pixel();
        for (y, row) in (first_row as usize..).zip(frame.rows()) {
            self.mapping.write(y * stride + column, row);
        }
    }

    /// A compositor may keep the driver from waiting for a while (EBUSY): then the frame comes at once.
    fn wait(&self) {
        if self.waits
            && let Err(error) = wait_for_vsync(&self.file)
        {
            log::debug!("{}: no wait for the vertical blank: {error}", self.path.display());
        }
    }

    /// Switches the panel's power; `false` where the driver knows no power.
    pub(super) fn set_power(&mut self, on: bool) -> bool {
        let level = if on { BlankingLevel::Unblank } else { BlankingLevel::Powerdown };
        // Some drivers refuse a level that they are at already.
        let could = self.blank != on || self.framebuffer.blank(level).is_ok();
        if could {
            self.blank = !on;
        }
        could
    }

    /// How frames reach the panel.
    const fn path_of_frames(&self) -> &'static str {
        match (self.pans, self.waits) {
            (true, true) => "two pages panned at the vertical blank",
            (true, false) => "two pages panned",
            (false, true) => "copied at the vertical blank",
            (false, false) => "copied when due (no pan, no vertical blank to wait for)",
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Layout { size, format, stride_bytes } = self.mode.layout;
        let (path, name, how) = (self.path.display(), &self.name, self.path_of_frames());
        write!(f, "{path} ({name}): {size}, {format}, stride {stride_bytes}, {how}")
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if self.blank {
            self.set_power(true);
        }
        if self.pans
            && let Err(error) = self.before.put(&self.file)
        {
            log::debug!("{}: its mode is not restored: {error}", self.path.display());
        }
    }
}

/// A device as a line for people, and its size. Nothing is tried that would show.
pub(in crate::os) fn describe(path: &Path) -> io::Result<(String, Size)> {
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    let (screen, memory) = (Screen::of(&file)?, Memory::of(&file)?);
    let framebuffer = Framebuffer::new(path).map_err(io_error)?;
    let layout = layout(path, &framebuffer, &memory);
    let pixels = layout.map_or_else(|error| error.to_string(), |layout| layout.format.to_string());
    let vsync = match wait_for_vsync(&file) {
        Ok(()) if waits_for_vsync(&file) => "waits",
        Ok(()) => "returns at once",
        Err(_) => "none",
    };
    let size = Size::new(screen.xres, screen.yres);
    let line = format!(
        "{}  {}: {size}, {pixels}, stride {}, virtual {}, {} KiB, pan step {}, vertical blank {vsync}",
        path.display(),
        memory.name(),
        memory.line_length,
        Size::new(screen.xres_virtual, screen.yres_virtual),
        memory.smem_len / 1024,
        memory.ypanstep,
    );
    Ok((line, size))
}

/// Makes room for a second page and pans to it and back, where the driver can; `false` and nothing changed where not.
fn try_second_page(file: &File, framebuffer: &mut Framebuffer, before: Screen) -> io::Result<bool> {
    let memory = Memory::of(file)?;
    if memory.ypanstep == 0 || memory.name().ends_with("drmfb") {
        return Ok(false);
    }
    let (width, height) = (before.xres_virtual, before.yres);
    if before.yres_virtual < 2 * height && framebuffer.set_virtual_size(width, 2 * height).is_err() {
        return Ok(false);
    }
    // A driver may take what it does not do, and change more than it was asked to.
    let (screen, memory) = (Screen::of(file)?, Memory::of(file)?);
    let room = u64::from(memory.line_length) * 2 * u64::from(height) <= u64::from(memory.smem_len);
    let pans = room
        && screen.yres_virtual >= 2 * height
        && screen.same_picture(before)
        && screen.pan(file, height).and_then(|()| screen.pan(file, 0)).is_ok();
    if !pans {
        before.put(file)?;
    }
    Ok(pans)
}

/// Whether the driver knows the vertical blank, and really waits for it: the emulation over DRM of some drivers returns at
/// once. The first wait ends anywhere in a refresh; each one after it takes a whole refresh.
fn waits_for_vsync(file: &File) -> bool {
    let waits_long = || {
        let start = Instant::now();
        wait_for_vsync(file).is_ok() && start.elapsed() >= NO_WAIT
    };
    wait_for_vsync(file).is_ok() && (0..3).all(|_| waits_long())
}

fn layout(path: &Path, framebuffer: &Framebuffer, memory: &Memory) -> Result<Layout, FbdevError> {
    let (bytes_per_pixel, channels) = (framebuffer.get_bytes_per_pixel(), framebuffer.get_pixel_layout());
    let format = format::from_channels(bytes_per_pixel, &channels).filter(|_| memory.kind == PACKED_PIXELS);
    let format = format.ok_or_else(|| FbdevError::Pixels {
        path: path.to_owned(),
        numbers: format::numbers(bytes_per_pixel, &channels),
    })?;
    let (width, height) = framebuffer.get_size();
    let stride = Some(memory.line_length as usize);
    let layout = Layout::new(Size::new(width, height), format, stride);
    let layout = layout.and_then(|layout| match memory.smem_len as usize {
        got if got < layout.len_bytes() => Err(LayoutError::Memory { needed: layout.len_bytes(), got }),
        _ => Ok(layout),
    });
    layout.map_err(|error| FbdevError::Layout { path: path.to_owned(), error })
}

fn io_error(error: linuxfb::Error) -> io::Error {
    match (error.io, error.fb) {
        (Some(error), _) => error,
        (None, Some(error)) => io::Error::from_raw_os_error(error.errno),
        (None, None) => io::Error::other("no answer"),
    }
}
