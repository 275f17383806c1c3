//! The database of videos: a catalogue, the frames, and what is known of every patch (the paper, section 4).
//!
//! ```text
//! DIR/catalogue.sqlite    videos, patches, refusals, the vocabulary, parameters: any SQLite program opens it
//! DIR/frames/CONTENT.png  the frames of one video, lossless: an animated PNG that browsers play; its still image is their mean
//! ```
//!
//! What is known of a patch depends on the frames alone, all but its words: these depend on the vocabulary, and that on the videos that
//! are there. So videos are indexed in any order, by any number of processes, and the words are given at the end: the vocabulary is
//! trained from the 200 videos whose contents' checksums are the lowest, which is the same choice whatever the
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
        let Some(vocabulary) =
            vocabulary.filter(|vocabulary| entries.iter().all(|entry| entry.is_worded_by(vocabulary)))
        else {
            return Err(DatabaseError::Unfinished(directory.to_owned()));
        };
        let files = entries
            .iter()
            .map(|entry| (entry.video.number, frames::path(directory, &entry.content)))
            .collect();
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
        let path = self
            .files
            .get(&number)
            .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, format!("no video {number}")))?;
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

#[cfg(test)]
mod tests {
    use super::{
        index::{Listener, Options, Outcome, index},
        *,
    };
    use crate::video::source::{Extent, Source};
    use image::Rgb;
    use std::{
        fs,
        sync::atomic::{AtomicUsize, Ordering},
    };

    /// Keeps what it is told, and interrupts after so many videos.
    #[derive(Default)]
    struct Told {
        outcomes: Mutex<Vec<(PathBuf, Outcome)>>,
        steps: AtomicUsize,
        most: Option<usize>,
    }

    impl Told {
        fn interrupting_after(videos: usize) -> Self {
            Self { most: Some(videos), ..Self::default() }
        }

        fn of(&self, name: &str) -> Outcome {
            let outcomes = lock(&self.outcomes);
            let found = outcomes.iter().rfind(|(source, _)| source.to_string_lossy().ends_with(name));
            found.unwrap_or_else(|| panic!("nothing about {name} in {outcomes:?}")).1.clone()
        }
    }

    impl Listener for Told {
        fn done(&self, source: &Path, outcome: &Outcome) {
            lock(&self.outcomes).push((source.to_owned(), outcome.clone()));
        }

        fn stage(&self, _: &'static str, _: usize) {}

        fn step(&self) {
            self.steps.fetch_add(1, Ordering::Relaxed);
        }

        fn interrupted(&self) -> bool {
            self.most.is_some_and(|most| self.steps.load(Ordering::Relaxed) >= most)
        }
    }

    fn options() -> Options {
        Options {
            class: None,
            jobs: 2,
            extent: Extent { seconds: 5.0, rate: 10.0 },
            forced: false,
            vocabulary: None,
            wordless: false,
        }
    }

    /// A folder of frames in which spots come and go over a river in the upper part; the lower part is a still bank. `seed` makes another
    /// river of it.
    fn river(folder: &Path, name: &str, seed: u32) {
        let folder = folder.join(name);
        fs::create_dir_all(&folder).unwrap();
        for frame in 0..14u32 {
            let picture = RgbImage::from_fn(144, 120, |x, y| {
                let (x, y, t) = (x as f32, y as f32, frame as f32);
                let seed = seed as f32;
                let texture = |x: f32, y: f32| {
                    ((0.31 + 0.02 * seed) * x + 0.12 * y + seed).sin() + (0.37 * y - 0.17 * x).cos()
                };
                let level = if y < 80.0 {
                    texture(x - (1.0 + 0.3 * seed) * t, y)
                        + (0.9 * t * (1.0 + 0.1 * seed) + 0.2 * y).sin() * (0.4 * x).sin()
                } else {
                    1.5 * texture(x, y)
                };
                Rgb([(128.0 + 30.0 * level) as u8; 3])
            });
            picture.save(folder.join(format!("{frame}.png"))).unwrap();
        }
    }

    fn rivers(count: u32) -> (tempfile::TempDir, Vec<Source>) {
        let folder = tempfile::tempdir().unwrap();
        (0..count).for_each(|seed| river(folder.path(), &format!("water_{seed}"), seed));
        let sources = Source::list(&[folder.path().to_owned()]).unwrap();
        assert_eq!(sources.len(), count as usize);
        (folder, sources)
    }

    fn features(directory: &Path) -> Vec<Features> {
        Database::open(directory).unwrap().features(Class::Water).unwrap()
    }

    #[test]
    fn what_is_indexed_can_be_read() {
        let (folder, sources) = rivers(1);
        let (told, db) = (Told::default(), folder.path().join("db"));
        index(&db, &sources, &options(), &told).unwrap();
        let Outcome::Taken { class, patches, frames, .. } = told.of("water_0") else {
            panic!("{:?}", told.of("water_0"))
        };
        let database = Database::open(&db).unwrap();
        let features = database.features(Class::Water).unwrap();
        assert_eq!((class, features.len(), frames), (Class::Water, patches, 14));
        assert_eq!(database.features(Class::Fire).unwrap(), []);
        let video = database.videos().next().unwrap();
        assert_eq!((video.name.as_str(), video.width, video.height, video.frames), ("water_0", 144, 120, 14));
        assert!(
            features.iter().all(|features| features.patch.video == video.number && features.contrast > 5.0)
        );
        assert!(
            features.iter().all(|features| features.patch.version.scale() < 1.0 || features.patch.y < 40),
            "the bank is no fluid"
        );
        let upright = features.iter().find(|features| features.patch.version.number() == 0).unwrap();
        assert!(upright.motion[0][0] > 0.3, "it flows to the right: {:?}", upright.motion[0]);
        assert_eq!(database.frame(video.number, 13).unwrap().dimensions(), (144, 120));
        assert_eq!(database.frame(video.number, 13).unwrap(), database.frame(video.number, 13).unwrap());
        assert!(database.frame(video.number, 14).is_err() && database.mean(video.number).is_ok());
    }

    #[test]
    fn a_video_is_taken_once_and_what_does_not_suit_is_told_with_the_reason() {
        let (folder, _) = rivers(1);
        river(folder.path(), "water_again", 0);
        let still = folder.path().join("still");
        fs::create_dir(&still).unwrap();
        for frame in 0..14 {
            // A corner that blinks, so that no two frames are the same.
            RgbImage::from_fn(144, 120, |x, y| Rgb([if x + y == 0 { frame * 9 } else { (x * y) as u8 }; 3]))
                .save(still.join(format!("{frame}.png")))
                .unwrap();
        }
        let sources = Source::list(&[folder.path().to_owned()]).unwrap();
        let (told, db) = (Told::default(), folder.path().join("db"));
        index(&db, &sources, &Options { jobs: 1, ..options() }, &told).unwrap();
        assert_eq!(told.of("water_again"), Outcome::Known("water_0".into()));
        assert!(
            matches!(told.of("still"), Outcome::Refused(reason) if reason.contains("nothing in it moves"))
        );
        assert_eq!(Database::open(&db).unwrap().videos().count(), 1);
    }

    #[test]
    fn shards_that_are_merged_have_the_same_patches() {
        let (folder, sources) = rivers(3);
        let at = |name: &str| folder.path().join(name);
        index(&at("whole"), &sources, &options(), &Told::default()).unwrap();
        let shard = Options { wordless: true, ..options() };
        index(&at("one"), &sources[2..], &shard, &Told::default()).unwrap();
        index(&at("two"), &sources[..2], &shard, &Told::default()).unwrap();
        assert!(matches!(Database::open(&at("one")), Err(DatabaseError::Unfinished(_))));
        merge::merge(&at("joined"), &[at("one"), at("two")], 2, &Told::default()).unwrap();
        assert_eq!(features(&at("joined")), features(&at("whole")));
        let videos = |name: &str| Database::open(&at(name)).unwrap().videos().cloned().collect::<Vec<_>>();
        assert_eq!(videos("joined"), videos("whole"));
    }

    #[test]
    fn an_interrupted_run_goes_on_where_it_was() {
        let (folder, sources) = rivers(3);
        let db = folder.path().join("db");
        let one = Options { jobs: 1, ..options() };
        let ended = index(&db, &sources, &one, &Told::interrupting_after(1));
        assert!(matches!(ended, Err(DatabaseError::Interrupted)));
        assert!(matches!(Database::open(&db), Err(DatabaseError::Unfinished(_))));
        // What a killed process leaves behind.
        fs::write(db.join("frames/half.part"), "half").unwrap();
        let told = Told::default();
        index(&db, &sources, &one, &told).unwrap();
        assert!(
            matches!(told.of("water_0"), Outcome::Known(_))
                && matches!(told.of("water_2"), Outcome::Taken { .. })
        );
        assert!(!db.join("frames/half.part").exists());
        index(&folder.path().join("whole"), &sources, &one, &Told::default()).unwrap();
        assert_eq!(features(&db), features(&folder.path().join("whole")));
    }

    #[test]
    fn damage_is_found_told_and_mended() {
        let (folder, sources) = rivers(2);
        let db = folder.path().join("db");
        index(&db, &sources, &options(), &Told::default()).unwrap();
        let before = features(&db);
        let check = || check::check(&db, &Told::default());
        let mend = || index(&db, &[], &options(), &Told::default());
        assert_eq!(check().unwrap(), []);

        // A patch that was changed: its frames are there.
        let catalogue = rusqlite::Connection::open(catalogue::path(&db)).unwrap();
        catalogue.execute("UPDATE patch SET contrast = 99 WHERE rowid = 1", []).unwrap();
        assert!(check().unwrap()[0].cure.contains("from its frames"));
        mend().unwrap();
        assert_eq!((check().unwrap(), features(&db)), (vec![], before.clone()));

        // Frames that were cut: the source is there.
        let path = fs::read_dir(db.join("frames")).unwrap().next().unwrap().unwrap().path();
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let damage = check().unwrap();
        assert!(
            damage[0].what.contains("it was cut") && damage[0].cure.contains("from its source"),
            "{damage:?}"
        );
        mend().unwrap();
        assert_eq!((check().unwrap(), features(&db)), (vec![], before.clone()));

        // A catalogue that is none any more: all comes back from the frames.
        drop(catalogue);
        fs::write(
            catalogue::path(&db),
            "nothing that SQLite knows, but long enough for its header. ".repeat(20),
        )
        .unwrap();
        assert!(matches!(Database::open(&db), Err(DatabaseError::Damaged(..))));
        mend().unwrap();
        assert_eq!((check().unwrap(), features(&db)), (vec![], before));
    }

    #[test]
    fn a_second_writer_and_an_empty_database_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let writer = index::Writer::begin(folder.path()).unwrap();
        assert!(matches!(
            index(folder.path(), &[], &options(), &Told::default()),
            Err(DatabaseError::Locked(_))
        ));
        drop(writer);
        assert!(matches!(
            index(folder.path(), &[], &options(), &Told::default()),
            Err(DatabaseError::Missing(_))
        ));
        drop(catalogue::Catalogue::open_or_create(folder.path()).unwrap());
        assert!(matches!(Database::open(folder.path()), Err(DatabaseError::Empty(_))));
    }
}
