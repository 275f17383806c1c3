//! Indexing: videos come in.

use super::{
    DatabaseError,
    analysis::{Analysis, analyse},
    catalogue::{Catalogue, Entry, Named},
    check,
    frames::{self, FrameFile, Notes},
    lock,
    words::{self, Pictures, TRAINING_VIDEOS},
};
use crate::{
    appearance::vocabulary::Vocabulary,
    footage::{Class, Video},
    patch::PatchRef,
    video::{
        class,
        denoise::denoise,
        source::{Extent, Source, hexadecimal},
        suitability::Refusal,
    },
};
use image::RgbImage;
use sha2::{Digest, Sha256};
use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

/// How videos are indexed.
#[derive(Clone, Debug)]
pub struct Options {
    /// Of all videos, where nothing else is known.
    pub class: Option<Class>,
    /// Videos that are worked on at a time. About 300 MB of memory each.
    pub jobs: usize,
    /// How much of a video is read.
    pub extent: Extent,
    /// Whether moving cameras and loops are taken.
    pub forced: bool,
    /// A vocabulary that is not trained here.
    pub vocabulary: Option<Vocabulary>,
    /// Whether words are left to a later merge.
    pub wordless: bool,
}

/// What became of a video.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It is in the database now.
    Taken {
        /// Its class.
        class: Class,
        /// Who said so.
        class_by: String,
        /// Its patches.
        patches: usize,
        /// Frames that are kept.
        frames: usize,
        /// Share of the picture that is fluid.
        fluid: f32,
    },
    /// It was there before, as the video of this name.
    Known(String),
    /// It does not suit.
    Refused(String),
}

/// Who hears of the work, and can end it.
pub trait Listener: Sync {
    /// A video is done with.
    fn done(&self, source: &Path, outcome: &Outcome);

    /// Work of so many steps begins.
    fn stage(&self, name: &'static str, steps: usize);

    /// A step is done.
    fn step(&self);

    /// Whether the work should end.
    fn interrupted(&self) -> bool;
}

/// The right to write to a database: one process at a time. It goes with the process, however that ends.
pub(super) struct Writer(#[expect(dead_code, reason = "the lock is held as long as the file is open")] File);

impl Writer {
    /// # Errors
    ///
    /// The directory cannot be made; another process writes.
    pub(super) fn begin(directory: &Path) -> Result<Self, DatabaseError> {
        fs::create_dir_all(directory).map_err(|error| DatabaseError::File(directory.to_owned(), error))?;
        let path = directory.join("lock");
        let file = File::create(&path).map_err(|error| DatabaseError::File(path.clone(), error))?;
        match file.try_lock() {
            Ok(()) => Ok(Self(file)),
            Err(fs::TryLockError::WouldBlock) => Err(DatabaseError::Locked(directory.to_owned())),
            Err(fs::TryLockError::Error(error)) => Err(DatabaseError::File(path, error)),
        }
    }
}

/// Indexes videos into the database of a directory, which is made if there is none. Without sources it looks through all that is there and
/// mends what is damaged, as far as frames or sources are left.
///
/// # Errors
///
/// The database cannot be opened or written; the work was interrupted. What does not suit is no error.
pub fn index(
    directory: &Path,
    sources: &[Source],
    options: &Options,
    listener: &impl Listener,
) -> Result<(), DatabaseError> {
    let _writer = Writer::begin(directory)?;
    let (mut catalogue, again) = if sources.is_empty() {
        check::mend(directory, options, listener)?
    } else {
        (Catalogue::open_or_create(directory)?, Vec::new())
    };
    let sources = if sources.is_empty() { &again } else { sources };
    remove_parts(directory)?;
    if let Some(words) = &options.vocabulary {
        catalogue.set_vocabulary(Some(&Named::new(words.clone(), Named::GIVEN.into())))?;
    }
    let catalogue = Mutex::new(catalogue);
    listener.stage("videos", sources.len());
    for_each(sources, options.jobs, listener, |source| {
        let outcome = take(directory, source, options, &catalogue, listener)?;
        listener.done(source.path(), &outcome);
        listener.step();
        Ok(())
    })?;
    if options.wordless && options.vocabulary.is_none() {
        Ok(())
    } else {
        give_words(directory, &catalogue, options.jobs, listener)
    }
}

/// Does the work for each of the items, some at a time, until an error or an interruption.
pub(super) fn for_each<T: Sync>(
    items: &[T],
    jobs: usize,
    listener: &impl Listener,
    work: impl Fn(&T) -> Result<(), DatabaseError> + Sync,
) -> Result<(), DatabaseError> {
    let next = AtomicUsize::new(0);
    let failed = Mutex::new(None);
    let run = || {
        while lock(&failed).is_none() {
            let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
            let result = if listener.interrupted() { Err(DatabaseError::Interrupted) } else { work(item) };
            if let Err(error) = result {
                lock(&failed).get_or_insert(error);
            }
        }
    };
    // Plain threads, whose parts run in the pool: a pool that steals whole videos would hold more of them in memory.
    thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, items.len().max(1)) {
            scope.spawn(run);
        }
    });
    failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
}

fn take(
    directory: &Path,
    source: &Source,
    options: &Options,
    catalogue: &Mutex<Catalogue>,
    listener: &impl Listener,
) -> Result<Outcome, DatabaseError> {
    let content = match source.content() {
        Ok(content) => content,
        Err(error) => return Ok(Outcome::Refused(Refusal::Unreadable(error.to_string()).to_string())),
    };
    if let Some(entry) = known(directory, &content, catalogue)? {
        return Ok(Outcome::Known(entry.video.name));
    }
    let before = lock(catalogue).refusal(&content)?;
    if let Some(reason) = before.filter(|_| !options.forced) {
        return Ok(Outcome::Refused(reason));
    }
    let (rate, looked) = match source.read(options.extent) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(DatabaseError::File(source.path().to_owned(), error));
        }
        Err(error) => (0.0, Err(Refusal::Unreadable(error.to_string()))),
        Ok(clip) => {
            let frames = denoise(&clip.frames);
            drop(clip.frames);
            (clip.rate, analyse(&frames, options.forced).map(|analysis| (analysis, frames)))
        }
    };
    if listener.interrupted() {
        return Err(DatabaseError::Interrupted);
    }
    match looked {
        Ok((analysis, frames)) => {
            let (class, class_by) = class_of(source, options, &analysis);
            let notes = Notes { content, source: absolute(source.path()), class, class_by, rate };
            frames::write(&frames::path(directory, &notes.content), &notes, &analysis.mean, &frames)?;
            keep(directory, notes, &analysis, &frames, options.forced, catalogue)
        }
        Err(refusal) => {
            let reason = refusal.to_string();
            // What cannot be read now may be readable tomorrow.
            if !matches!(refusal, Refusal::Unreadable(_)) {
                lock(catalogue).refuse(&content, source.path(), &reason)?;
            }
            Ok(Outcome::Refused(reason))
        }
    }
}

/// The video of this content, if its frames are there too.
fn known(
    directory: &Path,
    content: &str,
    catalogue: &Mutex<Catalogue>,
) -> Result<Option<Entry>, DatabaseError> {
    let mut catalogue = lock(catalogue);
    let Some(entry) = catalogue.video(content)? else { return Ok(None) };
    if fs::metadata(frames::path(directory, content)).is_ok_and(|file| file.len() == entry.bytes) {
        return Ok(Some(entry));
    }
    catalogue.remove(entry.video.number)?;
    Ok(None)
}

/// Puts a video whose frames are written into the catalogue.
pub(super) fn keep(
    directory: &Path,
    notes: Notes,
    analysis: &Analysis,
    frames: &[RgbImage],
    forced: bool,
    catalogue: &Mutex<Catalogue>,
) -> Result<Outcome, DatabaseError> {
    let path = frames::path(directory, &notes.content);
    let bytes = fs::metadata(&path).map_err(|error| DatabaseError::File(path, error))?.len();
    let source = PathBuf::from(&notes.source);
    let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (width, height) = analysis.mean.dimensions();
    let fluid = analysis.field.fluid_share();
    let entry = Entry {
        video: Video {
            number: 0,
            name,
            class: notes.class,
            width,
            height,
            frames: frames.len() as u32,
            rate: notes.rate,
        },
        content: notes.content,
        source,
        class_by: notes.class_by.clone(),
        sharp: analysis.sharp,
        noise: analysis.field.noise,
        fluid,
        forced,
        bytes,
        checksum: 0,
        vocabulary: None,
    };
    lock(catalogue).add(entry, &analysis.patches)?;
    let patches = analysis.patches.len();
    Ok(Outcome::Taken { class: notes.class, class_by: notes.class_by, patches, frames: frames.len(), fluid })
}

fn class_of(source: &Source, options: &Options, analysis: &Analysis) -> (Class, String) {
    if let Some(class) = options.class {
        return (class, "given".into());
    }
    match source.class_by_name() {
        Some(class) => (class, "by name".into()),
        None => (class::guess(&analysis.mean, &analysis.field), "guessed by colour and texture".into()),
    }
}

fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).to_string_lossy().into_owned()
}

/// Files that were being written when a process was killed.
fn remove_parts(directory: &Path) -> Result<(), DatabaseError> {
    let folder = directory.join("frames");
    let named = |error| DatabaseError::File(folder.clone(), error);
    for entry in fs::read_dir(&folder).map_err(named)? {
        let path = entry.map_err(named)?.path();
        if path.extension().is_some_and(|extension| extension == "part") {
            fs::remove_file(&path).map_err(|error| DatabaseError::File(path, error))?;
        }
    }
    Ok(())
}

/// Trains the vocabulary if the videos that it is trained from are not those of the last time, and gives words to all patches that have
/// none of it.
pub(super) fn give_words(
    directory: &Path,
    catalogue: &Mutex<Catalogue>,
    jobs: usize,
    listener: &impl Listener,
) -> Result<(), DatabaseError> {
    let mut entries = lock(catalogue).videos()?;
    if entries.is_empty() {
        return Ok(());
    }
    let vocabulary = vocabulary(directory, &entries, catalogue)?;
    entries.retain(|entry| !entry.is_worded_by(&vocabulary));
    listener.stage("words", entries.len());
    for_each(&entries, jobs, listener, |entry| {
        let patches = lock(catalogue).patches(entry.video.number)?;
        let references: Vec<PatchRef> = patches.iter().map(|stored| stored.patch).collect();
        let words = pictures(directory, entry)?.words(&references, &vocabulary.words);
        lock(catalogue).set_words(entry.video.number, patches, &words, &vocabulary.name)?;
        listener.step();
        Ok(())
    })
}

fn vocabulary(
    directory: &Path,
    entries: &[Entry],
    catalogue: &Mutex<Catalogue>,
) -> Result<Named, DatabaseError> {
    let mut training: Vec<&Entry> = entries.iter().collect();
    training.sort_by(|a, b| a.content.cmp(&b.content));
    training.truncate(TRAINING_VIDEOS);
    let mut hash = Sha256::new();
    training.iter().for_each(|entry| hash.update(&entry.content));
    let name = hexadecimal(&hash.finalize());
    let current = lock(catalogue).vocabulary()?;
    if let Some(current) =
        current.filter(|current| [name.as_str(), Named::GIVEN].contains(&current.training.as_str()))
    {
        return Ok(current);
    }
    let share = words::share(training.len());
    let mut samples = Vec::new();
    for entry in training {
        let patches: Vec<PatchRef> =
            lock(catalogue).patches(entry.video.number)?.iter().map(|stored| stored.patch).collect();
        samples.extend(pictures(directory, entry)?.samples(&patches, share));
    }
    let vocabulary = Named::new(Vocabulary::train(&samples), name);
    lock(catalogue).set_vocabulary(Some(&vocabulary))?;
    Ok(vocabulary)
}

fn pictures(directory: &Path, entry: &Entry) -> Result<Pictures, DatabaseError> {
    let path = frames::path(directory, &entry.content);
    let read = || Pictures::read(&FrameFile::open(&path)?, entry.sharp);
    read().map_err(|error| DatabaseError::Damaged(directory.to_owned(), error.to_string()))
}
