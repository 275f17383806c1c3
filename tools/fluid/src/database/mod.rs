//! The database of videos: a catalogue, the frames, and what is known of every patch (the paper, section 4).
//!
//! ```text
//! DIR/catalogue.sqlite    videos, patches, refusals, the vocabulary, parameters: any SQLite program opens it
//! DIR/frames/CONTENT.png  the frames of one video, lossless: an animated PNG that browsers play; its still image is their mean
//! ```
//!
//! What is known of a patch depends on the frames alone, all but its words: these depend on the vocabulary, and that on the videos that
//! are there. So videos are indexed in any order, by any number of processes, and the words are given at the end: the vocabulary is
//! trained from the [`words::TRAINING_VIDEOS`] videos whose contents' checksums are the lowest, which is the same choice whatever the
//! split. A video's number too comes from its content.

pub mod analysis;
mod catalogue;
pub mod check;
mod error;
mod frames;
pub mod index;
pub mod merge;
pub mod stats;
mod words;

pub use error::DatabaseError;

use crate::{
    appearance::vocabulary::Vocabulary,
    features::Features,
    footage::{Class, Footage, Video},
};
use catalogue::Catalogue;
use frames::FrameFile;
use image::RgbImage;
use std::{
    collections::{BTreeMap, HashMap, VecDeque},
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Frames that are kept unpacked: 44 MB of 640 × 360 pixels.
const CACHED_FRAMES: usize = 64;

/// A database that is complete, open for reading.
#[derive(Debug)]
pub struct Database {
    directory: PathBuf,
    videos: BTreeMap<u32, Video>,
    vocabulary: Vocabulary,
    files: BTreeMap<u32, PathBuf>,
    opened: Mutex<HashMap<u32, Arc<FrameFile>>>,
    cache: Mutex<VecDeque<((u32, u32), RgbImage)>>,
}

impl Database {
    /// Opens the database of a directory.
    ///
    /// # Errors
    ///
    /// There is none; it is of another version, damaged, empty, or its indexing was not ended.
    pub fn open(directory: &Path) -> Result<Self, DatabaseError> {
        let catalogue = Catalogue::open(directory)?;
        let entries = catalogue.videos()?;
        if entries.is_empty() {
            return Err(DatabaseError::Empty(directory.to_owned()));
        }
        let vocabulary = catalogue.vocabulary()?;
        let Some(vocabulary) = vocabulary.filter(|vocabulary| entries.iter().all(|entry| entry.is_worded_by(vocabulary)))
        else {
            return Err(DatabaseError::Unfinished(directory.to_owned()));
        };
        let files = entries.iter().map(|entry| (entry.video.number, frames::path(directory, &entry.content))).collect();
        Ok(Self {
            directory: directory.to_owned(),
            videos: entries.into_iter().map(|entry| (entry.video.number, entry.video)).collect(),
            vocabulary: vocabulary.words,
            files,
            opened: Mutex::default(),
            cache: Mutex::default(),
        })
    }

    /// All videos, by their numbers. The numbers are not consecutive.
    pub fn videos(&self) -> impl Iterator<Item = &Video> {
        self.videos.values()
    }

    /// The vocabulary that the patches' words are of.
    pub fn vocabulary(&self) -> &Vocabulary {
        &self.vocabulary
    }

    /// The features of all patches of the videos of a class, by video, version, row and column.
    ///
    /// About 1 kB of memory a patch.
    ///
    /// # Errors
    ///
    /// The catalogue cannot be read or is damaged.
    pub fn features(&self, class: Class) -> Result<Vec<Features>, DatabaseError> {
        Catalogue::open(&self.directory)?.features(class)
    }

    fn file(&self, number: u32) -> io::Result<Arc<FrameFile>> {
        let mut opened = lock(&self.opened);
        if let Some(file) = opened.get(&number) {
            return Ok(Arc::clone(file));
        }
        let path = self.files.get(&number).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, format!("no video {number}")))?;
        let file = Arc::new(FrameFile::open(path)?);
        opened.insert(number, Arc::clone(&file));
        Ok(file)
    }
}

impl Footage for Database {
    fn video(&self, number: u32) -> Option<&Video> {
        self.videos.get(&number)
    }

    fn frame(&self, number: u32, index: u32) -> io::Result<RgbImage> {
        let key = (number, index);
        if let Some((_, frame)) = lock(&self.cache).iter().find(|(cached, _)| *cached == key) {
            return Ok(frame.clone());
        }
        let frame = self.file(number)?.frame(index)?;
        let mut cache = lock(&self.cache);
        if cache.len() == CACHED_FRAMES {
            cache.pop_front();
        }
        cache.push_back((key, frame.clone()));
        Ok(frame)
    }

    fn mean(&self, number: u32) -> io::Result<RgbImage> {
        self.file(number)?.mean()
    }
}

/// What a lock protects here is whole after every statement, so a panic elsewhere spoils nothing.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
