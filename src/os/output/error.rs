use crate::frame::{Layout, Size};
use std::{fmt, io};

/// Frames that could not be written, and where. Its text is one line that names the place and the cure.
#[derive(Debug)]
pub struct OutputError {
    place: String,
    problem: Problem,
}

/// What keeps frames from being written.
#[derive(Debug)]
pub enum Problem {
    /// The operating system refused.
    Io(io::Error),
    /// A target without a known extension is a folder, but there is a file of that name.
    FileInPlace,
    /// The folder holds something that is no frame of an earlier run.
    OtherFiles {
        /// The name of one such file.
        example: String,
    },
    /// A frame of another size than was promised, or a size that no frame can have.
    Size {
        /// The size the writer was created for.
        promised: Size,
        /// The size that came.
        got: Size,
    },
    /// Another number of frames than was promised, or none.
    Count {
        /// The number the writer was created for.
        promised: u32,
        /// The number that came.
        written: u32,
    },
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl OutputError {
    pub(super) fn new(place: &str, problem: Problem) -> Self {
        Self { place: place.to_owned(), problem }
    }

    /// What went wrong.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => write_io(f, error),
            Self::FileInPlace => {
                f.write_str("a file, not a folder; name another folder, or a file with a known extension")
            }
            Self::OtherFiles { example } => {
                write!(f, "the folder holds other files ({example}); name an empty or a new folder")
            }
            Self::Size { promised, got } if promised == got => {
                write!(f, "no picture of {got} pixels; each side must be 1 to {}", Layout::MAX_SIDE)
            }
            Self::Size { promised, got } => write!(f, "a frame of {got} pixels among frames of {promised}"),
            Self::Count { promised: 0, .. } => f.write_str("no frames to write; ask for at least one"),
            Self::Count { promised, written } if written < promised => {
                write!(f, "ended after {written} of {promised} frames")
            }
            Self::Count { promised, .. } => write!(f, "more than the {promised} frames asked for"),
        }
    }
}

fn write_io(f: &mut fmt::Formatter<'_>, error: &io::Error) -> fmt::Result {
    use io::ErrorKind as Kind;
    f.write_str(match error.kind() {
        Kind::StorageFull | Kind::QuotaExceeded => "the disk is full; free some space or write elsewhere",
        Kind::PermissionDenied => "no permission to write there; choose another place",
        Kind::ReadOnlyFilesystem => "the file system is read-only; choose another place",
        Kind::NotFound => "its folder does not exist; create it first",
        Kind::NotADirectory => "a part of the path is a file, not a folder; check the path",
        Kind::BrokenPipe => "the reader closed the pipe before the last frame; see what it says",
        _ => return write!(f, "cannot be written ({error}); choose another place"),
    })
}

impl std::error::Error for OutputError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            Problem::Io(error) => Some(error),
            _ => None,
        }
    }
}
