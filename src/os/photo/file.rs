//! Reading a file that may be anything.

use super::Fault;
use rustix::{
    fs::{Mode, OFlags},
    io::Errno,
};
use std::{
    fs::{File, FileType},
    io::{self, Read},
    os::unix::fs::FileTypeExt,
    path::Path,
};

/// Opens the regular file at `path`.
pub(super) fn open(path: &Path) -> Result<File, Fault> {
    // Asked before it is opened: opening a device can set it going.
    regular(std::fs::metadata(path).map_err(from_io)?.file_type())?;
    // Asked again once it is open, as it may have been replaced meanwhile; opening a FIFO this way does not wait for a writer.
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let file = File::from(rustix::fs::open(path, flags, Mode::empty()).map_err(|e| from_io(e.into()))?);
    regular(file.metadata().map_err(from_io)?.file_type())?;
    Ok(file)
}

/// The bytes of the regular file at `path`, at the most `limit`.
pub(super) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, Fault> {
    let file = open(path)?;
    let len = file.metadata().map_err(from_io)?.len();
    let too_large = |needed| Fault::TooMuchMemory { needed, limit };
    if len > limit {
        return Err(too_large(len));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(len as usize + 1).map_err(|_| too_large(len))?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(from_io)?;
    match bytes.len() as u64 {
        0 => Err(Fault::Empty),
        len if len > limit => Err(too_large(len)),
        _ => Ok(bytes),
    }
}

fn regular(kind: FileType) -> Result<(), Fault> {
    let what = match kind {
        k if k.is_file() => return Ok(()),
        k if k.is_dir() => "a folder",
        k if k.is_fifo() => "a FIFO",
        k if k.is_socket() => "a socket",
        _ => "a device",
    };
    Err(Fault::NotAFile(what))
}

/// What the system's `error` means for people.
pub(super) fn from_io(error: io::Error) -> Fault {
    match error.kind() {
        io::ErrorKind::NotFound => Fault::Missing,
        io::ErrorKind::PermissionDenied => Fault::Forbidden(error),
        _ if error.raw_os_error() == Some(Errno::LOOP.raw_os_error()) => Fault::LinkLoop(error),
        _ => Fault::Read(error),
    }
}
