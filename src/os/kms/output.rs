//! One panel on one card, while it is there: its mode, two buffers in turn, page flips.

use super::{Card, KmsError, holders};
use crate::{
    display::{BackBuffer, DisplayError, Mode},
    frame::{FrameMut, Layout, PixelFormat, Size},
    os::args::KmsChoice,
};
use drm::{
    Device as _,
    buffer::{Buffer as _, DrmFourcc},
    control::{
        self, Device as _, Event, ModeTypeFlags, PageFlipFlags, connector, crtc,
        dumbbuffer::{DumbBuffer, DumbMapping},
        framebuffer, property,
    },
};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
};
use std::{fmt, io, mem};

/// A page flip that takes longer has been lost by the driver: four refreshes of the slowest panel, 12 Hz, are over then.
const FLIP_MILLISECONDS: i64 = 350;

/// The values of the connector property "DPMS".
const DPMS_ON: property::RawValue = 0;
const DPMS_OFF: property::RawValue = 3;

/// A panel that frames can be shown on.
pub(super) struct Output {
    card: Card,
    connector: connector::Handle,
    name: String,
    crtc: crtc::Handle,
    /// What the CRTC did before, to be put back.
    before: crtc::Info,
    timing: control::Mode,
    mode: Mode,
    buffers: [Scanout; 2],
    /// The number of the back buffer.
    back: usize,
    /// Frames shown since the buffers' pixels were unknown.
    shown: u64,
    /// The CRTC scans out one of the buffers: the next frame is a page flip and no mode set.
    lit: bool,
    /// A page flip is under way.
    flipping: bool,
    /// The driver can flip pages.
    flips: bool,
}

/// A buffer that the card scans out, and its memory.
struct Scanout {
    memory: DumbMapping<'static>,
    dumb: DumbBuffer,
    framebuffer: framebuffer::Handle,
}

impl Output {
    /// Opens the panel that was asked for. What the panel shows changes with the first frame only.
    pub(super) fn open(choice: &KmsChoice) -> Result<Self, KmsError> {
        let (card, connector) = Card::with_panel(choice.card.as_deref(), choice.connector.as_deref())?;
        // The first to open a card is its master already; this asks whether somebody else is.
        if card.acquire_master_lock().is_err() {
            return Err(KmsError::Held { holders: holders(&card.path), path: card.path });
        }
        let refused = |what| {
            let path = card.path.clone();
            move |error| KmsError::Refused { path, what, error }
        };
        let crtc = choose_crtc(&card, &connector).map_err(refused("display controller"))?;
        let before = card.get_crtc(crtc).map_err(refused("display controller"))?;
        let timing = choose_timing(connector.modes(), choice, &connector.to_string());
        let (buffers, layout) = Scanout::pair(&card, timing.size()).map_err(refused("frame buffer"))?;
        let mode = Mode { layout, refresh_millihertz: refresh_millihertz(&timing) };
        Ok(Self {
            connector: connector.handle(),
            name: connector.to_string(),
            card,
            crtc,
            before,
            timing,
            mode,
            buffers,
            back: 0,
            shown: 0,
            lit: false,
            flipping: false,
            flips: true,
        })
    }

    pub(super) const fn mode(&self) -> Mode {
        self.mode
    }

    /// Whether the panel is still plugged in, as the kernel has noticed by itself: a look that costs microseconds.
    pub(super) fn is_connected(&self) -> bool {
        let info = self.card.get_connector(self.connector, false);
        info.is_ok_and(|info| info.state() != connector::State::Disconnected)
    }

    /// The buffer that is not shown, once the last flip is done.
    pub(super) fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        let age = if self.shown < 2 { 0 } else { 2 };
        let memory = self.buffers[self.back].memory.as_mut();
        let frame = FrameMut::new(memory, self.mode.layout).map_err(|_| DisplayError::Lost)?;
        Ok(BackBuffer { frame, age })
    }

    /// Shows the back buffer at the panel's next refresh.
    pub(super) fn present(&mut self) -> io::Result<()> {
        self.finish_flip()?;
        if !(self.lit && self.flips && self.flip()?) {
            let framebuffer = self.buffers[self.back].framebuffer;
            let connectors = [self.connector];
            self.card.set_crtc(self.crtc, Some(framebuffer), (0, 0), &connectors, Some(self.timing))?;
            self.lit = true;
        }
        self.back ^= 1;
        self.shown += 1;
        Ok(())
    }

    /// Starts a page flip; `false` where the driver has none.
    fn flip(&mut self) -> io::Result<bool> {
        let framebuffer = self.buffers[self.back].framebuffer;
        match self.card.page_flip(self.crtc, framebuffer, PageFlipFlags::EVENT, None) {
            Ok(()) => self.flipping = true,
            Err(error) if is(&error, Errno::INVAL) || is(&error, Errno::NOSYS) => {
                log::debug!("{}: no page flips ({error}), setting the mode for each frame", self.name);
                self.flips = false;
            }
            Err(error) => return Err(error),
        }
        Ok(self.flipping)
    }

    /// Waits until the last flip is done.
    pub(super) fn finish_flip(&mut self) -> io::Result<()> {
        while self.flipping {
            let timeout = Timespec { tv_sec: 0, tv_nsec: FLIP_MILLISECONDS * 1_000_000 };
            match poll(&mut [PollFd::new(&self.card, PollFlags::IN)], Some(&timeout)) {
                Ok(0) => return Err(io::Error::new(io::ErrorKind::TimedOut, "a page flip was lost")),
                Ok(_) => {
                    let mut events = self.card.receive_events()?;
                    self.flipping = !events.any(|event| matches!(event, Event::PageFlip(_)));
                }
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Lets the card go to somebody else for a while.
    pub(super) fn pause(&mut self) {
        if let Err(error) = self.finish_flip().and_then(|()| self.card.release_master_lock()) {
            log::debug!("{}: {error}", self.card.path.display());
        }
        (self.lit, self.flipping) = (false, false);
    }

    /// Takes the card back.
    pub(super) fn resume(&mut self) -> io::Result<()> {
        self.shown = 0;
        self.card.acquire_master_lock()
    }

    /// Switches the panel's power; `false` where the driver knows no power.
    pub(super) fn set_power(&mut self, on: bool) -> io::Result<bool> {
        self.finish_flip()?;
        let properties = self.card.get_properties(self.connector)?;
        for (&property, _) in properties.iter() {
            if self.card.get_property(property)?.name().to_bytes() == b"DPMS" {
                let value = if on { DPMS_ON } else { DPMS_OFF };
                self.card.set_property(self.connector, property, value)?;
                // What was presented while the power was off is in one buffer only.
                (self.lit, self.shown) = (false, 0);
                return Ok(true);
            }
        }
        Ok(false)
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Layout { size, format, stride_bytes } = self.mode.layout;
        let hertz = f64::from(self.mode.refresh_millihertz) / 1000.0;
        let (path, name) = (self.card.path.display(), &self.name);
        write!(f, "{name} of {path}: {size} at {hertz:.2} Hz, {format}, stride {stride_bytes}, page flips")
    }
}

impl Drop for Output {
    /// Puts back what was shown before. Closing the card frees the rest.
    fn drop(&mut self) {
        let _ = self.finish_flip();
        if let (Some(framebuffer), Some(timing)) = (self.before.framebuffer(), self.before.mode()) {
            let at = self.before.position();
            if let Err(error) =
                self.card.set_crtc(self.crtc, Some(framebuffer), at, &[self.connector], Some(timing))
            {
                log::debug!("{}: what was shown before cannot be put back: {error}", self.name);
            }
        }
        for buffer in &self.buffers {
            buffer.free(&self.card);
        }
    }
}

impl Scanout {
    /// Two buffers of the first format that the card takes.
    fn pair(card: &Card, (width, height): (u16, u16)) -> io::Result<([Self; 2], Layout)> {
        let size = (u32::from(width), u32::from(height));
        let pair = |format| Ok(([Self::new(card, size, format)?, Self::new(card, size, format)?], format));
        let (buffers, format) = pair(PixelFormat::Xrgb8888).or_else(|error: io::Error| {
            log::debug!("{} refuses XRGB8888: {error}", card.path.display());
            pair(PixelFormat::Rgb565)
        })?;
        let stride_bytes = buffers[0].dumb.pitch() as usize;
        let layout = Layout::new(Size::new(size.0, size.1), format, Some(stride_bytes));
        Ok((buffers, layout.map_err(io::Error::other)?))
    }

    fn new(card: &Card, size: (u32, u32), format: PixelFormat) -> io::Result<Self> {
        let (fourcc, depth, bits) = match format {
            PixelFormat::Rgb565 => (DrmFourcc::Rgb565, 16, 16),
            _ => (DrmFourcc::Xrgb8888, 24, 32),
        };
        let mut dumb = card.create_dumb_buffer(size, fourcc, bits)?;
        let framebuffer = card.add_framebuffer(&dumb, depth, bits).inspect_err(|_| {
            let _ = card.destroy_dumb_buffer(dumb);
        })?;
        let memory = card.map_dumb_buffer(&mut dumb)?;
        // SAFETY: the mapping borrows the buffer's description for form only: it holds its own address and length, stays
        // valid when the buffer is destroyed or the card closed, and unmaps itself.
        let memory = unsafe { mem::transmute::<DumbMapping<'_>, DumbMapping<'static>>(memory) };
        Ok(Self { memory, dumb, framebuffer })
    }

    fn free(&self, card: &Card) {
        let freed = card.destroy_framebuffer(self.framebuffer);
        if let Err(error) = freed.and(card.destroy_dumb_buffer(self.dumb)) {
            log::debug!("{}: a buffer stays until the card is closed: {error}", card.path.display());
        }
    }
}

/// The controller that feeds the connector already, else the first that can.
fn choose_crtc(card: &Card, connector: &connector::Info) -> io::Result<crtc::Handle> {
    let current = connector.current_encoder().and_then(|encoder| card.get_encoder(encoder).ok());
    if let Some(crtc) = current.and_then(|encoder| encoder.crtc()) {
        return Ok(crtc);
    }
    let resources = card.resource_handles()?;
    for &encoder in connector.encoders() {
        let possible = resources.filter_crtcs(card.get_encoder(encoder)?.possible_crtcs());
        if let Some(&crtc) = possible.first() {
            return Ok(crtc);
        }
    }
    Err(io::Error::new(io::ErrorKind::NotFound, format!("none can feed {connector}")))
}

/// The mode that was asked for, where the panel has it, else that of the kernel's command line (`video=`), else the one that
/// the panel prefers.
fn choose_timing(modes: &[control::Mode], choice: &KmsChoice, name: &str) -> control::Mode {
    let of_type = |wanted| modes.iter().find(|mode| mode.mode_type().contains(wanted));
    let preferred = of_type(ModeTypeFlags::USERDEF).or_else(|| of_type(ModeTypeFlags::PREFERRED));
    let preferred = *preferred.unwrap_or(&modes[0]);
    let Some(size) = choice.size else { return preferred };
    let fits = |mode: &&control::Mode| {
        let (width, height) = mode.size();
        Size::new(width.into(), height.into()) == size
            && choice.hertz.is_none_or(|hertz| (refresh_millihertz(mode) + 500) / 1000 == hertz)
    };
    modes.iter().find(fits).copied().unwrap_or_else(|| {
        let known: Vec<_> = modes.iter().map(mode_name).collect();
        log::warn!("{name} has no mode {size} as asked for; it has {}", known.join(", "));
        preferred
    })
}

/// The buffers that the card gives for a connector's preferred mode, in words.
pub(in crate::os) fn buffers_for(card: &Card, connector: &connector::Info) -> String {
    if connector.modes().is_empty() {
        return "it tells no mode".into();
    }
    let timing = choose_timing(connector.modes(), &KmsChoice::default(), &connector.to_string());
    match Scanout::pair(card, timing.size()) {
        Ok((buffers, layout)) => {
            for buffer in buffers {
                buffer.free(card);
            }
            format!("frames of {}, {}, stride {}", layout.size, layout.format, layout.stride_bytes)
        }
        Err(error) => format!("no frame buffers: {error}"),
    }
}

/// A mode as people ask for it: WIDTHxHEIGHT@HERTZ.
pub(in crate::os) fn mode_name(mode: &control::Mode) -> String {
    let (width, height) = mode.size();
    format!("{width}x{height}@{}", (refresh_millihertz(mode) + 500) / 1000)
}

/// Pixels a second by pixels a refresh, those of the blanking included; 0 where the driver does not tell.
fn refresh_millihertz(mode: &control::Mode) -> u32 {
    let pixels = u64::from(mode.hsync().2) * u64::from(mode.vsync().2);
    (u64::from(mode.clock()) * 1_000_000).checked_div(pixels).unwrap_or(0) as u32
}

fn is(error: &io::Error, errno: Errno) -> bool {
    Errno::from_io_error(error) == Some(errno)
}

/// A failure at a panel that was there means that it is gone.
pub(super) fn lost(error: &io::Error) -> DisplayError {
    log::warn!("the panel cannot be drawn to: {error}; waiting for it");
    DisplayError::Lost
}
