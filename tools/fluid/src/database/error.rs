//! What can be wrong with a database.

use std::{fmt, io, path::PathBuf};

/// Why a database cannot be opened, read or written.
#[derive(Debug)]
pub enum DatabaseError {
    /// There is none in this directory.
    Missing(PathBuf),
    /// It has the layout of another version of this program.
    Version(PathBuf, i64),
    /// There is no video in it.
    Empty(PathBuf),
    /// Indexing was broken off, or is a part that was not merged: not all patches have words.
    Unfinished(PathBuf),
    /// Its catalogue is damaged.
    Damaged(PathBuf, String),
    /// Another process writes to it.
    Locked(PathBuf),
    /// A file cannot be read or written.
    File(PathBuf, io::Error),
    /// The catalogue cannot be read or written.
    Catalogue(PathBuf, rusqlite::Error),
    /// The person asked for the end.
    Interrupted,
}

impl std::error::Error for DatabaseError {}

impl fmt::Display for DatabaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(path) => write!(
                f,
                "{}: no database; `index VIDEO... --db {}` makes one",
                path.display(),
                path.display()
            ),
            Self::Version(path, version) => write!(
                f,
                "{}: a database of layout {version}, this program reads {}; index the videos into a new directory",
                path.display(),
                super::catalogue::LAYOUT
            ),
            Self::Empty(path) => write!(
                f,
                "{}: no video in the database; `index VIDEO... --db {}` adds some",
                path.display(),
                path.display()
            ),
            Self::Unfinished(path) => write!(
                f,
                "{}: indexing was not ended; `index --db {}` ends it, or `merge` if this is a shard",
                path.display(),
                path.display()
            ),
            Self::Damaged(path, what) => write!(
                f,
                "{}: damaged: {what}; `check --db {}` tells what is lost, `index --db {}` mends it",
                path.display(),
                path.display(),
                path.display()
            ),
            Self::Locked(path) => {
                write!(f, "{}: another process writes to this database; wait for its end", path.display())
            }
            Self::File(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Catalogue(path, error) => write!(f, "{}: catalogue: {error}", path.display()),
            Self::Interrupted => write!(f, "interrupted: the same command goes on from here"),
        }
    }
}
