//! The buttons of a board or a PC, as the kernel tells of them: keyboards, remote controls, and buttons on GPIO pins (which
//! a device tree overlay makes `gpio-keys` of).
//!
//! Nothing here waits and there is no thread: every device is asked once a frame. Devices come and go at any time; a device
//! that is pulled out has its keys released.

mod codes;
mod consoles;
mod device;
mod held;

pub use codes::{KeyCodes, UnknownKey};

use crate::input::{
    Button, Buttons, Press,
    gesture::{Edge, Gestures},
    key_map::KeyMap,
};
use ::evdev::KeyCode;
use consoles::ConsoleKeys;
use device::Device;
use held::Holders;
use rustix::time::{ClockId, clock_gettime};
use std::{
    collections::HashMap,
    fmt, fs, io,
    os::unix::fs::MetadataExt as _,
    path::{Path, PathBuf},
    time::Duration,
};

/// Where the kernel's devices stand.
const FOLDER: &str = "/dev/input";

/// How often new devices are looked for: nobody reaches for a button sooner after plugging it in, and a look takes some
/// tens of microseconds.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Every device with a button on it.
///
/// A button that is on several devices is down while it is down on any.
#[derive(Debug)]
pub struct Keyboards {
    folder: PathBuf,
    codes: KeyCodes,
    grab: bool,
    listening: bool,
    look_due: Duration,
    devices: Vec<(Node, Device)>,
    /// The other files in the folder.
    passed_over: HashMap<Node, Passed>,
    denial_told: bool,
    holders: Holders,
    consoles: ConsoleKeys,
    edges: Vec<Edge>,
    gestures: Gestures,
    dropped_told: u64,
}

/// A file in the folder; its inode, because names are used again.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Node {
    path: PathBuf,
    inode: u64,
}

/// Why a file is not listened to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Passed {
    /// It has none of the buttons, or does not work.
    NoButtons,
    /// It may not be read. Perhaps only not yet: udev changes the owner just after a device has come.
    Denied,
}

impl Keyboards {
    /// Every device on which `codes` has a button, those that are there and those that will come. With `grab` nobody else
    /// sees their keys, so that they do not end up on a console behind the picture.
    pub fn new(codes: KeyCodes, grab: bool) -> Self {
        Self::within(FOLDER.into(), codes, grab)
    }

    fn within(folder: PathBuf, codes: KeyCodes, grab: bool) -> Self {
        Self {
            folder,
            codes,
            grab,
            listening: true,
            look_due: Duration::ZERO,
            devices: Vec::new(),
            passed_over: HashMap::new(),
            denial_told: false,
            holders: Holders::default(),
            consoles: ConsoleKeys::default(),
            edges: Vec::new(),
            gestures: Gestures::new(KeyMap::default(), Gestures::DEBOUNCE),
            dropped_told: 0,
        }
    }

    /// Whether to listen. While another console is in front, its keys are neither taken nor taken for buttons: every device is
    /// closed, and what was begun on it forgotten.
    pub fn set_listening(&mut self, listening: bool) {
        self.listening = listening;
        if !listening {
            self.devices.clear();
            self.holders = Holders::default();
            self.consoles = ConsoleKeys::default();
            self.gestures.reset();
            self.look_due = Duration::ZERO;
        }
    }

    /// The text console that was asked for by Alt and a function key since the last time, where the kernel has not seen those.
    pub fn console_asked(&mut self) -> Option<u8> {
        self.consoles.asked().filter(|_| self.grab)
    }

    /// Takes in what has happened since the last time.
    fn poll(&mut self) {
        if now() >= self.look_due {
            self.look_due = now() + LOOK_EVERY;
            self.look();
        }
        let Self { codes, devices, passed_over, consoles, edges, .. } = self;
        let grab = self.grab;
        devices.retain_mut(|(node, device)| match device.poll(codes, grab, consoles, edges) {
            Ok(()) => true,
            Err(error) => {
                device.release(codes, edges);
                log::info!("buttons: {device} is gone: {error}");
                passed_over.insert(node.clone(), Passed::NoButtons);
                false
            }
        });
        // Stable: the edges of one device stay in their order.
        edges.sort_by_key(|edge| edge.at);
        for edge in edges.drain(..) {
            if let Some(edge) = self.holders.take(edge) {
                self.gestures.edge(edge);
            }
        }
        self.gestures.advance(now());
        self.tell_dropped();
    }

    fn tell_dropped(&mut self) {
        let dropped = self.gestures.dropped();
        if dropped > self.dropped_told {
            log::warn!("buttons: {} presses came faster than they can be taken", dropped - self.dropped_told);
            self.dropped_told = dropped;
        }
    }

    /// Opens the devices that have come.
    fn look(&mut self) {
        let nodes = nodes(&self.folder);
        self.passed_over.retain(|node, _| nodes.contains(node));
        for node in nodes {
            let is_open = self.devices.iter().any(|(open, _)| *open == node);
            let passed = self.passed_over.get(&node).copied();
            if !is_open && passed != Some(Passed::NoButtons) {
                self.open(node, passed);
            }
        }
    }

    fn open(&mut self, node: Node, passed: Option<Passed>) {
        let passed = match Device::open(&node.path, &self.codes) {
            Ok(Some(device)) => {
                log::info!("buttons: {device}");
                self.passed_over.remove(&node);
                self.devices.push((node, device));
                return;
            }
            Ok(None) => Passed::NoButtons,
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
                if passed.is_some() && !self.denial_told {
                    self.denial_told = true;
                    log::warn!(
                        "buttons: {}: {error}; let the program's user be in the group `input`",
                        node.path.display()
                    );
                }
                Passed::Denied
            }
            Err(error) => {
                log::debug!("buttons: {}: {error}", node.path.display());
                Passed::NoButtons
            }
        };
        self.passed_over.insert(node, passed);
    }
}

impl Buttons for Keyboards {
    fn next_press(&mut self, _frame: u64) -> Option<Press> {
        if !self.listening {
            return None;
        }
        self.gestures.next_press().or_else(|| {
            self.poll();
            self.gestures.next_press()
        })
    }

    fn set_keys(&mut self, keys: KeyMap) {
        self.gestures.set_keys(keys);
    }
}

/// The time by which the kernel stamps events here: it goes on evenly, whatever the clock on the wall is set to.
fn now() -> Duration {
    Duration::try_from(clock_gettime(ClockId::Monotonic)).unwrap_or_default()
}

/// The files of devices in `folder`; none while there is no such folder, as on a board without any device.
fn nodes(folder: &Path) -> Vec<Node> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let events = entries.filter(|entry| entry.file_name().as_encoded_bytes().starts_with(b"event"));
    let mut nodes: Vec<Node> = events
        .filter_map(|entry| Some(Node { path: entry.path(), inode: entry.metadata().ok()?.ino() }))
        .collect();
    nodes.sort_by(|a, b| a.path.cmp(&b.path));
    nodes
}

/// A device of the machine, for people who look for their buttons.
#[derive(Debug)]
pub struct Listed {
    /// Where it stands.
    pub path: PathBuf,
    /// What it is called and which of its keys are buttons; or why it cannot be read.
    pub device: io::Result<(String, Vec<(KeyCode, Button)>)>,
}

impl fmt::Display for Listed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        match &self.device {
            Ok((name, keys)) if keys.is_empty() => write!(f, "{name}, no buttons"),
            Ok((name, keys)) => {
                write!(f, "{name}")?;
                keys.iter().try_for_each(|(key, button)| write!(f, ", {key:?} = {button}"))
            }
            Err(error) => error.fmt(f),
        }
    }
}

/// Every device there is, with the buttons that `codes` sees on it.
pub fn list(codes: &KeyCodes) -> Vec<Listed> {
    let listed = |Node { path, .. }| Listed { device: device::buttons_of(&path, codes), path };
    nodes(Path::new(FOLDER)).into_iter().map(listed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_devices_presses_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut keyboards = Keyboards::within(folder.path().join("input"), KeyCodes::default(), true);
        assert_eq!(keyboards.next_press(0), None);
    }

    #[test]
    fn a_file_that_is_no_device_is_passed_over_until_another_takes_its_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("event3");
        for (name, text) in [("event3", ""), ("mice", "")] {
            fs::write(folder.path().join(name), text).expect("a file");
        }
        let mut keyboards = Keyboards::within(folder.path().into(), KeyCodes::default(), true);
        assert_eq!(keyboards.next_press(0), None);
        let passed: Vec<_> = keyboards.passed_over.drain().collect();
        let [(Node { path: seen, .. }, Passed::NoButtons)] = &passed[..] else { panic!("{passed:?}") };
        assert_eq!(*seen, path);

        fs::remove_file(&path).expect("removed");
        keyboards.look();
        assert!(keyboards.passed_over.is_empty() && keyboards.devices.is_empty());
    }
}
