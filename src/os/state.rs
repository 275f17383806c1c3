//! What a frame remembers over a restart or a power cut.
//!
//! Two small texts in a folder of their own:
//!
//! - `state`: what was shown and chosen. Its first line has the version and the SHA-256 of the rest. What is damaged, cut or of
//!   another version is put aside as `state.bad`, and the show starts afresh.
//! - `hidden.txt`: the photos that are never shown again, a path a line. People may edit it while the frame is off; a line
//!   that begins with # is a remark, `\n` is a line break in a name and `\\` a backslash.
//!
//! Both are replaced as a whole: the new text goes to a temporary file, which is synchronised to the disk and renamed over the old
//! one, and the folder is synchronised. Whenever the power is cut, the old text is there or the new one. `state` is
//! written at most once a minute, to spare the card.
//!
//! Where nothing can be written (a read-only or full disk) the show goes on from memory, which is told once.

use crate::{
    app::playlist::{PhotoId, Snapshot},
    config::Order,
    noise::Kind,
};
use sha2::{Digest, Sha256};
use std::{
    ffi::{OsStr, OsString},
    fmt::{self, Write as _},
    fs::{self, File},
    io::{self, Read, Write as _},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::{Path, PathBuf},
    time::Duration,
};

const STATE: &str = "state";
const HIDDEN: &str = "hidden.txt";

/// What the first line of a state begins with.
const TITLE: &str = "yurameki state ";

/// The version of the format. Whatever changes the meaning of a line counts it up.
const VERSION: u32 = 1;

/// The shortest time between two writes of the state: half a million writes a year.
const PAUSE: Duration = Duration::from_secs(60);

/// No text of ours is longer: a state has 12 KiB at the most, and this is room for 16,000 hidden photos.
const LONGEST: u64 = 1 << 20;

/// What a show remembers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// The deck and what was shown.
    pub playlist: Snapshot,
    /// The noise of the amplitude, if the person has chosen one.
    pub amplitude: Option<Kind>,
    /// The noise of the frequency, if the person has chosen one.
    pub frequency: Option<Kind>,
}

/// Why a state cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Its first line is not that of a state.
    Foreign,
    /// It was written by another version of the program.
    Version(u32),
    /// It is not what was written: cut, or changed on the disk.
    Checksum,
    /// A line that makes no sense, by its number.
    Line(usize),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => f.write_str("it is no state of this program"),
            Self::Version(version) => {
                write!(f, "it has version {version}, and this program writes {VERSION}")
            }
            Self::Checksum => f.write_str("it is damaged"),
            Self::Line(line) => write!(f, "line {line} makes no sense"),
        }
    }
}

impl std::error::Error for Fault {}

impl State {
    /// The text that is written.
    pub fn to_text(&self) -> String {
        let body = self.body();
        let sum = checksum(body.as_bytes());
        format!("{TITLE}{VERSION} {sum}\n{body}")
    }

    fn body(&self) -> String {
        let Snapshot { order, salt, place, history, back, early } = &self.playlist;
        let mut body = format!("order {order}\nsalt {salt:016x}\nback {back}\nhistory");
        // Writing to a string cannot fail.
        let _ = history.iter().try_for_each(|id| write!(body, " {:016x}", id.0));
        body.push('\n');
        let _ = place.iter().try_for_each(|(key, id)| writeln!(body, "place {key:016x} {:016x}", id.0));
        let _ = early.iter().try_for_each(|(id, key)| writeln!(body, "early {key:016x} {:016x}", id.0));
        let _ = self.amplitude.iter().try_for_each(|kind| writeln!(body, "amplitude {kind}"));
        let _ = self.frequency.iter().try_for_each(|kind| writeln!(body, "frequency {kind}"));
        body
    }

    /// Reads what [`Self::to_text`] has written.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn from_text(text: &[u8]) -> Result<Self, Fault> {
        let end = text.iter().position(|&byte| byte == b'\n').ok_or(Fault::Foreign)?;
        let (title, body) = (&text[..end], &text[end + 1..]);
        let title = str::from_utf8(title).ok().and_then(|title| title.strip_prefix(TITLE));
        let (version, sum) = title.and_then(|rest| rest.split_once(' ')).ok_or(Fault::Foreign)?;
        match version.parse() {
            Ok(VERSION) => {}
            Ok(version) => return Err(Fault::Version(version)),
            Err(_) => return Err(Fault::Foreign),
        }
        if sum != checksum(body) {
            return Err(Fault::Checksum);
        }
        let body = str::from_utf8(body).map_err(|_| Fault::Checksum)?;
        let mut state = Self {
            playlist: Snapshot {
                order: Order::default(),
                salt: 0,
                place: None,
                history: heapless::Vec::new(),
                back: 0,
                early: heapless::Vec::new(),
            },
            amplitude: None,
            frequency: None,
        };
        for (number, line) in (2..).zip(body.lines()) {
            state.read_line(line).ok_or(Fault::Line(number))?;
        }
        Ok(state)
    }

    /// Takes a line in; none if it makes no sense.
    fn read_line(&mut self, line: &str) -> Option<()> {
        let (name, words) = line.split_once(' ').unwrap_or((line, ""));
        let number = |word: &str| u64::from_str_radix(word, 16).ok();
        let pair = || words.split_once(' ').and_then(|(key, id)| Some((number(key)?, PhotoId(number(id)?))));
        let playlist = &mut self.playlist;
        match name {
            "order" => playlist.order = words.parse().ok()?,
            "salt" => playlist.salt = number(words)?,
            "back" => playlist.back = words.parse().ok()?,
            "history" => {
                for word in words.split_ascii_whitespace() {
                    playlist.history.push(PhotoId(number(word)?)).ok()?;
                }
            }
            "place" => playlist.place = Some(pair()?),
            "early" => {
                let (key, id) = pair()?;
                playlist.early.push((id, key)).ok()?;
            }
            "amplitude" => self.amplitude = Some(words.parse().ok()?),
            "frequency" => self.frequency = Some(words.parse().ok()?),
            _ => return None,
        }
        Some(())
    }
}

fn checksum(body: &[u8]) -> String {
    Sha256::digest(body).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The folder for what a frame remembers: `$STATE_DIRECTORY` (as systemd sets it; the first of several), else
/// `$XDG_STATE_HOME/yurameki`, else `~/.local/state/yurameki`. None where there is not even a home. `variable` gives the
/// variables of the environment, as [`std::env::var_os`] does.
pub fn default_folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // A relative path in XDG_STATE_HOME is to be ignored (XDG Base Directory Specification 0.8).
    let absolute = |name| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let service = variable("STATE_DIRECTORY").and_then(|list| {
        let first = list.as_bytes().split(|&byte| byte == b':').next()?;
        (!first.is_empty()).then(|| PathBuf::from(OsStr::from_bytes(first)))
    });
    service
        .or_else(|| absolute("XDG_STATE_HOME").map(|home| home.join("yurameki")))
        .or_else(|| absolute("HOME").map(|home| home.join(".local/state/yurameki")))
}

/// The folder in which a show remembers.
#[derive(Debug)]
pub struct Memory {
    folder: Option<PathBuf>,
    /// What `state` holds, as far as is known.
    text: String,
    written: Option<Duration>,
    /// What `hidden.txt` holds.
    hidden_text: Vec<u8>,
    hidden: Vec<PathBuf>,
    /// `hidden.txt` is there but cannot be read: it is not to be replaced.
    keep_hidden: bool,
    failing: bool,
}

impl Memory {
    /// Opens `folder`, which need not be there yet, and gives what was remembered. Without a folder nothing is remembered.
    pub fn open(folder: Option<PathBuf>) -> (Self, Option<State>) {
        let mut memory = Self {
            folder,
            text: String::new(),
            written: None,
            hidden_text: Vec::new(),
            hidden: Vec::new(),
            keep_hidden: false,
            failing: false,
        };
        let Some(folder) = memory.folder.clone() else {
            log::warn!("there is no folder to remember anything in: set STATE_DIRECTORY or HOME");
            memory.failing = true;
            return (memory, None);
        };
        match read(&folder.join(HIDDEN)) {
            Ok(text) => {
                memory.hidden = text.split(|&byte| byte == b'\n').filter_map(path_of_line).collect();
                memory.hidden_text = text;
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => {
                let path = folder.join(HIDDEN);
                log::warn!("{}: {error}: no photo is hidden until it can be read", path.display());
                memory.keep_hidden = true;
            }
        }
        let state = memory.read_state(&folder);
        (memory, state)
    }

    fn read_state(&mut self, folder: &Path) -> Option<State> {
        let path = folder.join(STATE);
        let why = match read(&path) {
            Ok(text) => match State::from_text(&text) {
                Ok(state) => {
                    self.text = state.to_text();
                    return Some(state);
                }
                Err(fault) => fault.to_string(),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            Err(error) => error.to_string(),
        };
        let kept = match fs::rename(&path, folder.join("state.bad")) {
            Ok(()) => "; it is kept as state.bad",
            Err(_) => "",
        };
        log::warn!("{}: {why}: starting afresh{kept}", path.display());
        None
    }

    /// Remembers what `state` gives, if it is something else and the last time was a minute ago. `now` is since any fixed
    /// moment. To be called as often as is handy.
    pub fn keep(&mut self, now: Duration, state: impl FnOnce() -> State) {
        if self.written.is_none_or(|written| now.saturating_sub(written) >= PAUSE) {
            self.written = Some(now);
            self.keep_now(&state());
        }
    }

    /// Remembers `state` at once: at the end of the show.
    pub fn keep_now(&mut self, state: &State) {
        let text = state.to_text();
        if text != self.text && self.replace(STATE, text.as_bytes()) {
            self.text = text;
        }
    }

    /// The photos that are never to be shown again.
    pub fn hidden(&self) -> &[PathBuf] {
        &self.hidden
    }

    /// Adds `photo` to the hidden ones, at once.
    pub fn hide(&mut self, photo: &Path) {
        if self.hidden.iter().any(|hidden| hidden == photo) {
            return;
        }
        self.hidden.push(photo.to_owned());
        let mut text = self.hidden_text.clone();
        if text.last().is_some_and(|&byte| byte != b'\n') {
            text.push(b'\n');
        }
        text.extend(line_of_path(photo));
        if !self.keep_hidden {
            // Also what could not be written now is written with the next.
            self.replace(HIDDEN, &text);
        }
        self.hidden_text = text;
    }

    /// Replaces a file, and tells whether that worked. Of failures in a row the first is told.
    fn replace(&mut self, name: &str, text: &[u8]) -> bool {
        let Some(folder) = &self.folder else { return false };
        let done = replace(folder, name, text);
        let folder = folder.display();
        match &done {
            Err(error) if !self.failing => {
                log::warn!(
                    "{folder}: {error}: the show goes on, but nothing is remembered; make it writable"
                );
            }
            Ok(()) if self.failing => log::info!("{folder} can be written again"),
            Err(_) | Ok(()) => {}
        }
        self.failing = done.is_err();
        done.is_ok()
    }
}

/// Replaces the file `name` of `folder` such that at any moment the old text is there, or the new.
fn replace(folder: &Path, name: &str, text: &[u8]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let new = folder.join(format!("{name}.new"));
    let write = || {
        let mut file = File::create(&new)?;
        file.write_all(text)?;
        file.sync_all()?;
        fs::rename(&new, folder.join(name))
    };
    write().inspect_err(|_| {
        // What is left of it takes room on a disk that may be full.
        let _ = fs::remove_file(&new);
    })?;
    File::open(folder)?.sync_all()
}

/// The content of a regular file that is not too long to be one of ours.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is no file"));
    }
    let mut text = Vec::new();
    File::open(path)?.take(LONGEST + 1).read_to_end(&mut text)?;
    if text.len() as u64 > LONGEST {
        return Err(io::Error::other("it is too long"));
    }
    Ok(text)
}

fn line_of_path(path: &Path) -> Vec<u8> {
    let mut line = Vec::new();
    for &byte in path.as_os_str().as_bytes() {
        match byte {
            b'\n' => line.extend(b"\\n"),
            b'\\' => line.extend(b"\\\\"),
            byte => line.push(byte),
        }
    }
    line.push(b'\n');
    line
}

fn path_of_line(line: &[u8]) -> Option<PathBuf> {
    if line.is_empty() || line.starts_with(b"#") {
        return None;
    }
    let (mut path, mut bytes) = (Vec::new(), line.iter());
    while let Some(&byte) = bytes.next() {
        path.push(match (byte, bytes.as_slice().first()) {
            (b'\\', Some(b'n')) => {
                bytes.next();
                b'\n'
            }
            (b'\\', Some(b'\\')) => {
                bytes.next();
                b'\\'
            }
            _ => byte,
        });
    }
    Some(PathBuf::from(OsString::from_vec(path)))
}
