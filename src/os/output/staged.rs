//! Files and folders that appear under their name only when they are whole.

use super::Problem;
use std::{
    fs::{self, File, Permissions},
    io,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};
use tempfile::{Builder, NamedTempFile, TempDir};

/// Temporary names start with it, so that a folder listing hides them.
const PREFIX: &str = ".yurameki-";

/// The permissions of new files and folders before the user's umask takes its part, as everywhere.
const FILE_MODE: u32 = 0o666;
const FOLDER_MODE: u32 = 0o777;

/// A file with a temporary name beside the one it gets at the end.
pub(in crate::os) struct StagedFile {
    file: NamedTempFile,
    path: PathBuf,
}

impl StagedFile {
    /// Opens a temporary file in the folder of `path`. A link is followed, so that it stays a link.
    pub(in crate::os) fn create(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let mode = Permissions::from_mode(FILE_MODE);
        let file = Builder::new().prefix(PREFIX).permissions(mode).tempfile_in(folder_of(&path))?;
        Ok(Self { file, path })
    }

    /// Another handle to the file.
    pub(in crate::os) fn open(&self) -> io::Result<File> {
        self.file.as_file().try_clone()
    }

    /// Waits until the file is on the disk and gives it its name, in the place of one that has it already.
    pub(in crate::os) fn commit(self) -> io::Result<()> {
        self.file.as_file().sync_all()?;
        self.file.persist(&self.path).map_err(|e| e.error)?;
        sync_folder(folder_of(&self.path));
        Ok(())
    }
}

/// A folder of frames with a temporary name: within the folder it is to fill, if that is there already, else beside it.
pub(super) struct StagedFolder {
    staging: TempDir,
    path: PathBuf,
    exists: bool,
}

impl StagedFolder {
    /// Opens a temporary folder. A folder at `path` must be empty or hold only frames of an earlier run.
    pub(super) fn create(path: &Path) -> Result<Self, Problem> {
        let exists = match path.metadata() {
            Ok(meta) if !meta.is_dir() => return Err(Problem::FileInPlace),
            Ok(_) => true,
            Err(_) => false,
        };
        if exists && let Some(example) = file_names(path)?.into_iter().find(|name| !is_ours(name)) {
            return Err(Problem::OtherFiles { example });
        }
        let mode = Permissions::from_mode(FOLDER_MODE);
        let parent = if exists { path } else { folder_of(path) };
        let staging = Builder::new().prefix(PREFIX).permissions(mode).tempdir_in(parent)?;
        Ok(Self { staging, path: path.into(), exists })
    }

    /// Where the frames are to be written.
    pub(super) fn path(&self) -> &Path {
        self.staging.path()
    }

    /// Gives the folder its name, or moves its frames to the existing folder in the place of those that are there.
    pub(super) fn commit(mut self) -> io::Result<()> {
        if !self.exists {
            fs::rename(self.staging.path(), &self.path)?;
            self.staging.disable_cleanup(true);
            sync_folder(folder_of(&self.path));
            return Ok(());
        }
        let new = file_names(self.staging.path())?;
        for name in &new {
            fs::rename(self.staging.path().join(name), self.path.join(name))?;
        }
        for name in file_names(&self.path)?.iter().filter(|name| is_frame(name) && !new.contains(*name)) {
            fs::remove_file(self.path.join(name))?;
        }
        self.staging.close()?;
        sync_folder(&self.path);
        Ok(())
    }
}

/// The name of frame `index`.
pub(super) fn frame_name(index: u32) -> String {
    format!("frame_{index:05}.png")
}

fn is_frame(name: &str) -> bool {
    let digits = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
    digits.is_some_and(|digits| digits.len() >= 5 && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether a file in a folder of frames does no harm there: a frame, or hidden (what file browsers and killed runs leave).
fn is_ours(name: &str) -> bool {
    is_frame(name) || name.starts_with('.')
}

fn file_names(folder: &Path) -> io::Result<std::collections::BTreeSet<String>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Makes a rename last over a power cut. Some file systems cannot sync a folder; what was renamed is whole there too.
fn sync_folder(folder: &Path) {
    if let Err(error) = File::open(folder).and_then(|folder| folder.sync_all()) {
        log::debug!("{}: not synced ({error})", folder.display());
    }
}
