//! A panel on a graphics card, by the kernel's mode setting (KMS): two dumb buffers in turn, flipped at the panel's refresh.
//!
//! Dumb buffers may be write-combined memory, which is slow to read: painters only write to them.
//!
//! Hot plug needs no udev: the kernel notices a panel that comes or goes by itself, and is asked once a second. A panel that
//! is gone gives [`DisplayError::Lost`] until it is back; a different one then gives [`DisplayError::ModeChanged`].

mod card;
mod output;

pub(super) use card::{Card, holders};
pub(super) use output::{buffers_for, mode_name};

use super::{args::KmsChoice, console::Shared, panel::Prospect};
use crate::display::{BackBuffer, Display, DisplayError, Mode};
use output::Output;
use std::{
    fmt, io,
    path::PathBuf,
    time::{Duration, Instant},
};

/// A panel that comes back is seen so soon, and one that is gone is noticed.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Why no panel can be shown on by KMS.
#[derive(Debug)]
pub(super) enum KmsError {
    /// The kernel has no graphics card, or not the one asked for.
    NoCard(Option<PathBuf>),
    /// The card cannot be opened.
    Open { path: PathBuf, error: io::Error },
    /// No panel is plugged in, or none into the connector asked for.
    NothingConnected(Option<String>),
    /// Another program decides what the card shows.
    Held { path: PathBuf, holders: Vec<String> },
    /// The card has no more of something, or cannot do it.
    Refused { path: PathBuf, what: &'static str, error: io::Error },
}

impl KmsError {
    pub(super) fn prospect(&self) -> Prospect {
        match self {
            Self::NoCard(_) => Prospect::NoDevice,
            Self::NothingConnected(_) => Prospect::NoPanel,
            Self::Held { .. } => Prospect::Held,
            Self::Open { error, .. } if error.kind() == io::ErrorKind::PermissionDenied => Prospect::Denied,
            Self::Open { .. } | Self::Refused { .. } => Prospect::None,
        }
    }
}

impl fmt::Display for KmsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCard(None) => f.write_str("there is no graphics card at /dev/dri"),
            Self::NoCard(Some(path)) => write!(f, "there is no graphics card {}", path.display()),
            Self::Open { path, error } if error.kind() == io::ErrorKind::PermissionDenied => {
                write!(f, "{}: {error}; the user must be in the group video", path.display())
            }
            Self::Open { path, error } => write!(f, "{}: {error}", path.display()),
            Self::NothingConnected(None) => f.write_str("no panel is connected to a graphics card"),
            Self::NothingConnected(Some(name)) => {
                write!(f, "no panel is connected to {name}; `yurameki probe` lists the connectors")
            }
            Self::Held { path, holders } if holders.is_empty() => {
                write!(f, "{} is held by another program (a desktop?); end it first", path.display())
            }
            Self::Held { path, holders } => {
                write!(f, "{} is held by {}; end that first", path.display(), holders.join(", "))
            }
            Self::Refused { path, what, error } => write!(f, "{} gives no {what}: {error}", path.display()),
        }
    }
}

impl std::error::Error for KmsError {}

/// A panel on a graphics card.
pub(super) struct Kms {
    choice: KmsChoice,
    /// `None` while the panel is gone.
    output: Option<Output>,
    mode: Mode,
    power: bool,
    next_look: Instant,
}

impl Kms {
    /// Opens the panel that was asked for.
    pub(super) fn open(choice: &KmsChoice) -> Result<Self, KmsError> {
        let output = Output::open(choice)?;
        log::info!("showing on {output}");
        Ok(Self {
            choice: choice.clone(),
            mode: output.mode(),
            output: Some(output),
            power: true,
            next_look: Instant::now() + LOOK_EVERY,
        })
    }

    /// Looks after the panel, once a second.
    fn look_at_times(&mut self) -> Result<(), DisplayError> {
        if Instant::now() < self.next_look {
            return Ok(());
        }
        self.next_look = Instant::now() + LOOK_EVERY;
        self.look()
    }

    /// Notices a panel that has gone or come.
    fn look(&mut self) -> Result<(), DisplayError> {
        match &self.output {
            Some(output) if output.is_connected() => return Ok(()),
            Some(output) => {
                log::warn!("gone: {output}; waiting for it");
                self.output = None;
                return Err(DisplayError::Lost);
            }
            None => {}
        }
        let output = Output::open(&self.choice).map_err(|error| {
            log::debug!("{error}");
            DisplayError::Lost
        })?;
        log::info!("showing on {output}");
        let before = std::mem::replace(&mut self.mode, output.mode());
        self.output = Some(output);
        if before == self.mode { Ok(()) } else { Err(DisplayError::ModeChanged) }
    }

    /// Does something with the panel; a panel that fails is gone.
    fn attempt<T>(&mut self, act: impl FnOnce(&mut Output) -> io::Result<T>) -> Result<T, DisplayError> {
        act(self.output.as_mut().ok_or(DisplayError::Lost)?).map_err(|error| {
            self.output = None;
            output::lost(&error)
        })
    }
}

impl Display for Kms {
    fn mode(&self) -> Mode {
        self.mode
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        self.look_at_times()?;
        self.attempt(Output::finish_flip)?;
        self.output.as_mut().ok_or(DisplayError::Lost)?.back_buffer()
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        if self.power { self.attempt(Output::present) } else { Ok(()) }
    }

    fn set_power(&mut self, on: bool) -> Result<bool, DisplayError> {
        let could = self.attempt(|output| output.set_power(on))?;
        self.power = on || !could;
        Ok(could)
    }
}

impl Shared for Kms {
    fn pause(&mut self) {
        if let Some(output) = &mut self.output {
            output.pause();
        }
    }

    fn resume(&mut self) {
        if let Some(Err(error)) = self.output.as_mut().map(Output::resume) {
            output::lost(&error);
            self.output = None;
        }
    }
}
