//! Looking for damage, and mending it.

use super::{
    DatabaseError,
    analysis::analyse,
    catalogue::{self, Catalogue, Entry},
    frames::{self, FrameFile},
    index::{Listener, Options, Outcome, keep},
};
use crate::video::source::Source;
use std::{
    fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

/// Something that is not as it was stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Damage {
    /// The video, by its source.
    pub source: PathBuf,
    /// What is wrong.
    pub what: String,
    /// What `index` will do about it.
    pub cure: &'static str,
}

/// Reads the whole database for its checksums. The damage that is found; none if all is well.
///
/// About 0.1 s a video of 125 frames of 640 × 360 pixels.
///
/// # Errors
///
/// The catalogue cannot be opened at all.
pub fn check(directory: &Path, listener: &impl Listener) -> Result<Vec<Damage>, DatabaseError> {
    let catalogue = Catalogue::open(directory)?;
    catalogue.check_pages()?;
    let entries = catalogue.videos()?;
    listener.stage("videos", entries.len());
    let mut damage = Vec::new();
    for entry in &entries {
        if listener.interrupted() {
            return Err(DatabaseError::Interrupted);
        }
        let patches = catalogue.check_patches(entry);
        let frames = check_frames(directory, entry);
        listener.step();
        let cure = match (&patches, &frames) {
            (Ok(()), Ok(())) => continue,
            (Err(_), Ok(())) => "its patches can be made anew from its frames",
            _ if entry.source.exists() => "it can be indexed again from its source",
            _ => "its source is gone: it is lost",
        };
        let what = [patches.err(), frames.err()].into_iter().flatten().collect::<Vec<_>>().join("; ");
        damage.push(Damage { source: entry.source.clone(), what, cure });
    }
    Ok(damage)
}

fn check_frames(directory: &Path, entry: &Entry) -> Result<(), String> {
    let check = || {
        let file = FrameFile::open(&frames::path(directory, &entry.content))?;
        file.check()?;
        Ok(file.len())
    };
    match check() {
        Ok(count) if count == entry.video.frames as usize => Ok(()),
        Ok(count) => Err(format!("{count} of {} frames", entry.video.frames)),
        Err(error) => Err(std::io::Error::to_string(&error)),
    }
}

/// Makes the database whole as far as it can be. Videos whose frames are good but which the catalogue does not know rightly are looked at
/// again; others are to be read again from their sources, which are handed back; what has neither is taken out and told as lost.
pub(super) fn mend(
    directory: &Path,
    options: &Options,
    listener: &impl Listener,
) -> Result<(Catalogue, Vec<Source>), DatabaseError> {
    let mut catalogue = open_or_replace(directory)?;
    if matches!(catalogue.vocabulary(), Err(DatabaseError::Damaged(..))) {
        catalogue.set_vocabulary(None)?;
    }
    let mut again = Vec::new();
    for entry in catalogue.videos()? {
        let frames = check_frames(directory, &entry);
        if frames.is_ok() && catalogue.check_patches(&entry).is_ok() {
            continue;
        }
        catalogue.remove(entry.video.number)?;
        if let Err(what) = frames {
            // A file that is not there is as good as removed.
            let _ = fs::remove_file(frames::path(directory, &entry.content));
            match Source::again(&entry.source) {
                Ok(source) => again.push(source),
                Err(error) => {
                    let lost = format!("lost: {what}; its source is gone: {error}");
                    listener.done(&entry.source, &Outcome::Refused(lost));
                }
            }
        }
    }
    let catalogue = Mutex::new(catalogue);
    adopt(directory, options, listener, &catalogue)?;
    Ok((catalogue.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner), again))
}

/// A catalogue that cannot be read goes aside; its videos come back from their frames.
fn open_or_replace(directory: &Path) -> Result<Catalogue, DatabaseError> {
    let opened = Catalogue::open(directory).and_then(|catalogue| catalogue.check_pages().map(|()| catalogue));
    match opened {
        Err(DatabaseError::Damaged(..)) => {
            let path = catalogue::path(directory);
            let aside = path.with_extension("damaged");
            fs::rename(&path, &aside).map_err(|error| DatabaseError::File(path, error))?;
            Catalogue::open_or_create(directory)
        }
        opened => opened,
    }
}

/// Takes files of frames that the catalogue does not know.
fn adopt(
    directory: &Path,
    options: &Options,
    listener: &impl Listener,
    catalogue: &Mutex<Catalogue>,
) -> Result<(), DatabaseError> {
    let folder = directory.join("frames");
    let named = |error| DatabaseError::File(folder.clone(), error);
    let mut paths: Vec<PathBuf> = fs::read_dir(&folder)
        .map_err(named)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .map_err(named)?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "png"));
    paths.sort();
    for path in paths {
        if listener.interrupted() {
            return Err(DatabaseError::Interrupted);
        }
        let content = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if super::lock(catalogue).video(&content)?.is_some() {
            continue;
        }
        let outcome = match FrameFile::open(&path).and_then(|file| Ok((file.frames()?, file))) {
            Err(error) => Outcome::Refused(error.to_string()),
            // It was taken once: what spoke against it was forced then.
            Ok((frames, file)) => match analyse(&frames, true) {
                Ok(analysis) => {
                    keep(directory, file.notes.clone(), &analysis, &frames, options.forced, catalogue)?
                }
                Err(refusal) => Outcome::Refused(refusal.to_string()),
            },
        };
        listener.done(&path, &outcome);
    }
    Ok(())
}
