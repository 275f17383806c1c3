//! Joining databases that were indexed apart.

use super::{
    DatabaseError,
    catalogue::{Catalogue, Entry, Named},
    frames,
    index::{Listener, Writer, give_words},
};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

/// Adds the videos of other databases to that of a directory, which is made if there is none; then all patches get words. The result has
/// the same patches as if all videos had been indexed into one. A video that is there already is passed over, so that a merge that was
/// broken off can be started again.
///
/// Files of frames are linked where that is possible, and copied elsewhere.
///
/// # Errors
///
/// A part is no database, damaged, or of another version; the result cannot be written; the work was interrupted.
pub fn merge(
    directory: &Path,
    parts: &[PathBuf],
    jobs: usize,
    listener: &impl Listener,
) -> Result<(), DatabaseError> {
    let _writer = Writer::begin(directory)?;
    let mut catalogue = Catalogue::open_or_create(directory)?;
    for part in parts {
        let other = Catalogue::open(part)?;
        take_vocabulary(&mut catalogue, &other)?;
        let entries = other.videos()?;
        listener.stage("videos", entries.len());
        for entry in &entries {
            if listener.interrupted() {
                return Err(DatabaseError::Interrupted);
            }
            take(directory, part, &mut catalogue, &other, entry)?;
            listener.step();
        }
        for (content, source, reason) in other.refusals()? {
            if catalogue.video(&content)?.is_none() {
                catalogue.refuse(&content, Path::new(&source), &reason)?;
            }
        }
    }
    give_words(directory, &Mutex::new(catalogue), jobs, listener)
}

/// A vocabulary that was given to all parts stays; one that is not common to all is trained anew.
fn take_vocabulary(catalogue: &mut Catalogue, other: &Catalogue) -> Result<(), DatabaseError> {
    let given = |vocabulary: &Named| vocabulary.training == Named::GIVEN;
    let theirs = other.vocabulary()?.filter(given);
    let ours = catalogue.vocabulary()?;
    match (ours, theirs) {
        (None, Some(theirs)) if catalogue.videos()?.is_empty() => catalogue.set_vocabulary(Some(&theirs)),
        (Some(ours), theirs) if given(&ours) && theirs.as_ref() != Some(&ours) => {
            catalogue.set_vocabulary(None)
        }
        _ => Ok(()),
    }
}

fn take(
    directory: &Path,
    part: &Path,
    catalogue: &mut Catalogue,
    other: &Catalogue,
    entry: &Entry,
) -> Result<(), DatabaseError> {
    if catalogue.video(&entry.content)?.is_some() {
        return Ok(());
    }
    other.check_patches(entry).map_err(|what| {
        DatabaseError::Damaged(part.to_owned(), format!("{}: {what}", entry.source.display()))
    })?;
    let (from, to) = (frames::path(part, &entry.content), frames::path(directory, &entry.content));
    link_or_copy(&from, &to).map_err(|error| DatabaseError::File(from, error))?;
    catalogue.add_from(other, entry)
}

fn link_or_copy(from: &Path, to: &Path) -> std::io::Result<()> {
    if to.exists() {
        fs::remove_file(to)?;
    }
    if fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    // Another file system, or one without links.
    let unfinished = to.with_extension("part");
    fs::copy(from, &unfinished)?;
    fs::File::open(&unfinished)?.sync_all()?;
    fs::rename(&unfinished, to)
}
