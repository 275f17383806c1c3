//! One device with buttons.

use super::{
    KeyCodes,
    consoles::ConsoleKeys,
    held::{Held, Told},
    now,
};
use crate::input::{Button, gesture::Edge};
use evdev::{KeyCode, raw_stream::RawDevice};
use rustix::{
    fs::OFlags,
    ioctl::{Setter, ioctl, opcode},
    time::ClockId,
};
use std::{
    ffi::c_int,
    fmt,
    fs::OpenOptions,
    io,
    os::{
        fd::{AsFd, OwnedFd},
        unix::fs::OpenOptionsExt as _,
    },
    path::{Path, PathBuf},
};

/// Reads of one device a frame. Each takes 32 events, and the kernel keeps 64 of a keyboard: more reads than this only a
/// device needs that floods the frame.
const READS: usize = 8;

/// A device that is listened to.
///
/// Not `evdev::Device`, which looks after dropped events by itself, but forgets to when nothing more is to be read.
#[derive(Debug)]
pub(super) struct Device {
    path: PathBuf,
    raw: RawDevice,
    held: Held,
    grabbing: Grabbing,
}

/// Whether nobody else sees the keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grabbing {
    Open,
    Grabbed,
    Refused,
}

impl Device {
    /// The device at `path`; none if it has no buttons.
    pub(super) fn open(path: &Path, codes: &KeyCodes) -> io::Result<Option<Self>> {
        let raw = open(path)?;
        if buttons(&raw, codes).next().is_none() {
            return Ok(None);
        }
        use_monotonic_clock(&raw)?;
        Ok(Some(Self { path: path.to_owned(), raw, held: Held::default(), grabbing: Grabbing::Open }))
    }

    /// Adds the edges since the last time to `edges`; an error means that the device is gone.
    pub(super) fn poll(
        &mut self,
        codes: &KeyCodes,
        grab: bool,
        consoles: &mut ConsoleKeys,
        edges: &mut Vec<Edge>,
    ) -> io::Result<()> {
        if grab && self.grabbing == Grabbing::Open {
            self.grab_at_rest()?;
        }
        for _ in 0..READS {
            let events = match self.raw.fetch_events() {
                Ok(events) => events,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            let told = events.filter_map(Told::of).inspect(|&told| consoles.take(told));
            if self.held.take(told, codes, edges) {
                log::debug!("buttons: {self}: events were dropped");
                let down = self.raw.get_key_state()?;
                self.held.resynchronise(|code| down.contains(code), codes, now(), edges);
            }
        }
        Ok(())
    }

    /// Adds the edges that release every key to `edges`.
    pub(super) fn release(&mut self, codes: &KeyCodes, edges: &mut Vec<Edge>) {
        self.held.resynchronise(|_| false, codes, now(), edges);
    }

    /// Takes the keys for this program alone, as soon as none is down: a console that saw a key go down (ENTER, which
    /// started the program) must see it go up.
    fn grab_at_rest(&mut self) -> io::Result<()> {
        if self.raw.get_key_state()?.iter().next().is_some() {
            return Ok(());
        }
        self.grabbing = match self.raw.grab() {
            Ok(()) => Grabbing::Grabbed,
            Err(error) => {
                log::warn!("buttons: {self}: another program has its keys: {error}");
                Grabbing::Refused
            }
        };
        Ok(())
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}", name(&self.raw), self.path.display())
    }
}

/// What the device at `path` is called, and its keys that are buttons.
pub(super) fn buttons_of(path: &Path, codes: &KeyCodes) -> io::Result<(String, Vec<(KeyCode, Button)>)> {
    let raw = open(path)?;
    Ok((name(&raw).to_owned(), buttons(&raw, codes).collect()))
}

fn open(path: &Path) -> io::Result<RawDevice> {
    let non_blocking = OFlags::NONBLOCK.bits() as i32;
    let file = OpenOptions::new().read(true).custom_flags(non_blocking).open(path)?;
    RawDevice::from_fd(OwnedFd::from(file))
}

fn buttons(raw: &RawDevice, codes: &KeyCodes) -> impl Iterator<Item = (KeyCode, Button)> {
    codes.iter().filter(|&(code, _)| raw.supported_keys().is_some_and(|keys| keys.contains(code)))
}

fn name(raw: &RawDevice) -> &str {
    raw.name().unwrap_or("a device without a name")
}

/// Has events stamped by the clock of [`now`]. Without a word the kernel takes the one on the wall, which may jump.
fn use_monotonic_clock(device: impl AsFd) -> io::Result<()> {
    /// EVIOCSCLOCKID of the kernel's input.h.
    const SET_CLOCK: rustix::ioctl::Opcode = opcode::write::<c_int>(b'E', 0xa0);
    // SAFETY: for this request the kernel reads one `int` from the address that it is given, and writes nothing.
    unsafe { ioctl(device, Setter::<SET_CLOCK, c_int>::new(ClockId::Monotonic as c_int)) }?;
    Ok(())
}
