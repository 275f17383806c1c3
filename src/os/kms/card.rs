//! Graphics cards: which there are, what is connected to them, and who else holds them.

use super::KmsError;
use drm::control::{Device as _, connector};
use std::{
    fs::{self, File, OpenOptions},
    io,
    os::fd::{AsFd, BorrowedFd},
    path::{Path, PathBuf},
};

/// An open card.
#[derive(Debug)]
pub(in crate::os) struct Card {
    file: File,
    /// Where it was opened, like `/dev/dri/card0`.
    pub(in crate::os) path: PathBuf,
}

impl AsFd for Card {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

impl drm::Device for Card {}
impl drm::control::Device for Card {}

impl Card {
    /// The cards that the kernel has, in their order.
    pub(in crate::os) fn list() -> Vec<PathBuf> {
        let number = |path: &Path| path.file_name()?.to_str()?.strip_prefix("card")?.parse::<u32>().ok();
        let entries = fs::read_dir("/dev/dri").into_iter().flatten().flatten().map(|entry| entry.path());
        let mut cards: Vec<_> = entries.filter_map(|path| Some((number(&path)?, path))).collect();
        cards.sort();
        cards.into_iter().map(|(_, path)| path).collect()
    }

    pub(in crate::os) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// What can be plugged into, asked of the panels anew. That takes up to a tenth of a second for each: never while a
    /// picture moves.
    pub(in crate::os) fn connectors(&self) -> io::Result<Vec<connector::Info>> {
        self.resource_handles()?.connectors().iter().map(|&handle| self.get_connector(handle, true)).collect()
    }

    /// The first connector with a panel, or the one of the name `wanted`, which may be of a kind that cannot tell whether
    /// there is one.
    fn connected(&self, wanted: Option<&str>) -> io::Result<Option<connector::Info>> {
        let fits = |info: &connector::Info| {
            let there = match wanted {
                Some(wanted) if !info.to_string().eq_ignore_ascii_case(wanted) => false,
                Some(_) => info.state() != connector::State::Disconnected,
                None => info.state() == connector::State::Connected,
            };
            there && !info.modes().is_empty()
        };
        Ok(self.connectors()?.into_iter().find(fits))
    }

    /// The first card with a panel, and where that is connected; the one `card` and the connector `wanted`, where they are
    /// named. Cards that only render (a Raspberry Pi has one) have nothing connected, and are passed over.
    pub(super) fn with_panel(
        card: Option<&Path>,
        wanted: Option<&str>,
    ) -> Result<(Self, connector::Info), KmsError> {
        let paths = card.map_or_else(Self::list, |path| vec![path.to_owned()]);
        let mut why = KmsError::NoCard(card.map(Path::to_owned));
        for path in paths {
            let card = match Self::open(&path) {
                Ok(card) => card,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => {
                    why = KmsError::Open { path, error };
                    continue;
                }
            };
            match card.connected(wanted) {
                Ok(Some(connector)) => return Ok((card, connector)),
                Ok(None) => why = KmsError::NothingConnected(wanted.map(str::to_owned)),
                Err(error) => log::debug!("{} shows nothing: {error}", path.display()),
            }
        }
        Err(why)
    }
}

/// The programs, other than this one, that have `device` open, as `NAME (PID)`. Those of other users are seen by root only.
pub(in crate::os) fn holders(device: &Path) -> Vec<String> {
    let own = std::process::id();
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let ids = processes.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let mut holders = Vec::new();
    for id in ids.filter(|&id| id != own) {
        let files = fs::read_dir(format!("/proc/{id}/fd")).into_iter().flatten().flatten();
        if files.filter_map(|file| fs::read_link(file.path()).ok()).any(|target| target == device) {
            let name = fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default();
            holders.push(format!("{} ({id})", name.trim()));
        }
    }
    holders
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};

    #[test]
    fn a_program_that_holds_a_device_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().canonicalize().unwrap().join("card");
        let held = File::create(&path).unwrap();
        assert_eq!(holders(&path), Vec::<String>::new(), "this very program does not count");
        let mut cat = Command::new("cat").stdin(Stdio::piped()).stderr(held).spawn().unwrap();
        let named = holders(&path);
        drop(cat.stdin.take());
        cat.wait().unwrap();
        assert_eq!(named, [format!("cat ({})", cat.id())]);
    }
}
