//! The catalogue: an SQLite file.

use super::{DatabaseError, analysis::Moving};
use crate::{
    appearance::vocabulary::Vocabulary,
    features::{CELLS, CHANNELS, Features, PLACES, WordMap},
    footage::{Class, Video},
    patch::{PatchRef, SIDE, STRIDE, VERSIONS, Version},
    video::source::hexadecimal,
};
use rusqlite::{Connection, ErrorCode, OpenFlags, OptionalExtension, Row, params};
use sha2::{Digest, Sha256};
use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

/// The layout of the tables. It rises whenever a program of another version would read something wrong.
pub(super) const LAYOUT: i64 = 1;

/// What SQLite programs know the file by: "YUFL".
const APPLICATION: i64 = 0x5955_464c;

/// What one level of stored motion is, in pixels a frame.
const MOTION_UNIT: f32 = 1.0 / 256.0;

/// What one level of stored texture is, in levels of luminance.
const TEXTURE_UNIT: f32 = 1.0 / 64.0;

/// Channels of motion; those after it are texture.
const MOTION_CHANNELS: usize = 8;

/// How long a writer waits for a reader.
const PATIENCE: Duration = Duration::from_secs(30);

const TABLES: &str = "
    CREATE TABLE parameter (name TEXT PRIMARY KEY, value TEXT NOT NULL);
    CREATE TABLE video (
        number INTEGER PRIMARY KEY, content TEXT NOT NULL UNIQUE, name TEXT NOT NULL, source TEXT NOT NULL,
        class TEXT NOT NULL, class_by TEXT NOT NULL, width INTEGER NOT NULL, height INTEGER NOT NULL,
        frames INTEGER NOT NULL, rate REAL NOT NULL, sharp INTEGER NOT NULL, noise REAL NOT NULL,
        fluid REAL NOT NULL, forced INTEGER NOT NULL, bytes INTEGER NOT NULL, checksum INTEGER NOT NULL, vocabulary TEXT);
    CREATE TABLE patch (
        video INTEGER NOT NULL REFERENCES video, version INTEGER NOT NULL, x INTEGER NOT NULL, y INTEGER NOT NULL,
        contrast REAL NOT NULL, motion BLOB NOT NULL, mean_words BLOB, sharp_words BLOB);
    CREATE INDEX patch_video ON patch (video);
    CREATE TABLE refusal (content TEXT PRIMARY KEY, source TEXT NOT NULL, reason TEXT NOT NULL);
    CREATE TABLE vocabulary (name TEXT PRIMARY KEY, words BLOB NOT NULL, training TEXT NOT NULL);
";

/// A video as the catalogue knows it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) video: Video,
    pub(super) content: String,
    pub(super) source: PathBuf,
    pub(super) class_by: String,
    pub(super) sharp: u32,
    pub(super) noise: f32,
    /// Share of the picture that is fluid.
    pub(super) fluid: f32,
    pub(super) forced: bool,
    /// Size of the file of frames.
    pub(super) bytes: u64,
    /// Of its patches.
    pub(super) checksum: u32,
    /// The vocabulary that its patches' words are of.
    pub(super) vocabulary: Option<String>,
}

impl Entry {
    pub(super) fn is_worded_by(&self, vocabulary: &Named) -> bool {
        self.vocabulary.as_ref() == Some(&vocabulary.name)
    }

    fn of_row(row: &Row<'_>) -> rusqlite::Result<Self> {
        let class: String = row.get("class")?;
        let class = Class::by_name(&class).ok_or_else(|| strange(&format!("class {class}")))?;
        let source: String = row.get("source")?;
        Ok(Self {
            video: Video {
                number: row.get("number")?,
                name: row.get("name")?,
                class,
                width: row.get("width")?,
                height: row.get("height")?,
                frames: row.get("frames")?,
                rate: row.get("rate")?,
            },
            content: row.get("content")?,
            source: source.into(),
            class_by: row.get("class_by")?,
            sharp: row.get("sharp")?,
            noise: row.get("noise")?,
            fluid: row.get("fluid")?,
            forced: row.get("forced")?,
            bytes: row.get::<_, i64>("bytes")? as u64,
            checksum: row.get("checksum")?,
            vocabulary: row.get("vocabulary")?,
        })
    }
}

/// A vocabulary with its name, which is the checksum of its words, and what it was trained from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) words: Vocabulary,
    /// The checksum of the list of videos, or [`Named::GIVEN`].
    pub(super) training: String,
}

impl Named {
    /// What stands for the training of a vocabulary that a person gave.
    pub(super) const GIVEN: &str = "given";

    pub(super) fn new(words: Vocabulary, training: String) -> Self {
        Self { name: hexadecimal(&Sha256::digest(words.to_bytes())), words, training }
    }
}

/// A patch as it is stored.
pub(super) struct Stored {
    row: i64,
    pub(super) patch: PatchRef,
    contrast: f32,
    motion: Vec<u8>,
    words: Option<[WordMap; 2]>,
}

impl Stored {
    fn of_row(row: &Row<'_>) -> rusqlite::Result<Self> {
        let version: u8 = row.get("version")?;
        let version = Version::new(version).ok_or_else(|| strange("a version"))?;
        let patch = PatchRef { video: row.get("video")?, version, x: row.get("x")?, y: row.get("y")? };
        let map = |name: &str| -> rusqlite::Result<Option<WordMap>> {
            let Some(bytes) = row.get_ref(name)?.as_blob_or_null()? else { return Ok(None) };
            WordMap::try_from(bytes).map(Some).map_err(|_| strange("words"))
        };
        let words = map("mean_words")?.zip(map("sharp_words")?).map(<[WordMap; 2]>::from);
        Ok(Self {
            row: row.get("rowid")?,
            patch,
            contrast: row.get("contrast")?,
            motion: row.get("motion")?,
            words,
        })
    }

    fn features(self) -> rusqlite::Result<Features> {
        let motion = unpacked(&self.motion).ok_or_else(|| strange("motion"))?;
        let words = self.words.ok_or_else(|| strange("a patch without words"))?;
        Ok(Features { patch: self.patch, words, contrast: self.contrast, motion })
    }
}

fn strange(what: &str) -> rusqlite::Error {
    rusqlite::Error::FromSqlConversionFailure(
        0,
        rusqlite::types::Type::Blob,
        format!("{what} is strange").into(),
    )
}

fn packed(motion: &[[f32; CHANNELS]; CELLS * CELLS]) -> Vec<u8> {
    let level = |(channel, value): (usize, &f32)| ((value / unit(channel)).round() as i16).to_le_bytes();
    motion.iter().flat_map(|cell| cell.iter().enumerate().flat_map(level)).collect()
}

fn unpacked(bytes: &[u8]) -> Option<[[f32; CHANNELS]; CELLS * CELLS]> {
    let (levels, rest) = bytes.as_chunks::<2>();
    if levels.len() != CHANNELS * CELLS * CELLS || !rest.is_empty() {
        return None;
    }
    let level =
        |cell: usize, channel: usize| f32::from(i16::from_le_bytes(levels[cell * CHANNELS + channel]));
    Some(core::array::from_fn(|cell| core::array::from_fn(|channel| level(cell, channel) * unit(channel))))
}

fn unit(channel: usize) -> f32 {
    if channel < MOTION_CHANNELS { MOTION_UNIT } else { TEXTURE_UNIT }
}

/// An open catalogue.
pub(super) struct Catalogue {
    path: PathBuf,
    connection: Connection,
}

/// Where the catalogue of a directory is.
pub(super) fn path(directory: &Path) -> PathBuf {
    directory.join("catalogue.sqlite")
}

impl Catalogue {
    /// Opens the catalogue of a directory.
    pub(super) fn open(directory: &Path) -> Result<Self, DatabaseError> {
        if !path(directory).is_file() {
            return Err(DatabaseError::Missing(directory.to_owned()));
        }
        let catalogue = Self::connect(directory, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        let application: i64 = catalogue.pragma("application_id")?;
        let layout: i64 = catalogue.pragma("user_version")?;
        if application != APPLICATION {
            return Err(DatabaseError::Damaged(
                directory.to_owned(),
                "its catalogue is one of another program".into(),
            ));
        }
        if layout != LAYOUT {
            return Err(DatabaseError::Version(directory.to_owned(), layout));
        }
        Ok(catalogue)
    }

    /// Opens it, or makes an empty one.
    pub(super) fn open_or_create(directory: &Path) -> Result<Self, DatabaseError> {
        // An empty file is what is left when a process is killed while it makes one.
        let path = path(directory);
        if fs::metadata(&path).is_ok_and(|file| file.len() > 0) {
            return Self::open(directory);
        }
        let frames = directory.join("frames");
        fs::create_dir_all(&frames).map_err(|error| DatabaseError::File(frames, error))?;
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE;
        let mut catalogue = Self::connect(directory, flags)?;
        catalogue.change(|transaction| {
            transaction.execute_batch(TABLES)?;
            for (name, value) in parameters() {
                transaction.execute("INSERT INTO parameter VALUES (?, ?)", params![name, value])?;
            }
            transaction.pragma_update(None, "application_id", APPLICATION)?;
            transaction.pragma_update(None, "user_version", LAYOUT)
        })?;
        Ok(catalogue)
    }

    fn connect(directory: &Path, flags: OpenFlags) -> Result<Self, DatabaseError> {
        let connect = || {
            let connection =
                Connection::open_with_flags(path(directory), flags | OpenFlags::SQLITE_OPEN_NO_MUTEX)?;
            connection.busy_timeout(PATIENCE)?;
            Ok(connection)
        };
        let connection = connect().map_err(|error| failure(directory, error))?;
        Ok(Self { path: directory.to_owned(), connection })
    }

    fn pragma(&self, name: &str) -> Result<i64, DatabaseError> {
        self.named(self.connection.pragma_query_value(None, name, |row| row.get(0)))
    }

    fn named<T>(&self, result: rusqlite::Result<T>) -> Result<T, DatabaseError> {
        result.map_err(|error| failure(&self.path, error))
    }

    /// All of a change, or nothing of it.
    fn change(
        &mut self,
        change: impl FnOnce(&Connection) -> rusqlite::Result<()>,
    ) -> Result<(), DatabaseError> {
        let connection = &mut self.connection;
        let changed = connection.transaction().and_then(|transaction| {
            change(&transaction)?;
            transaction.commit()
        });
        self.named(changed)
    }

    fn list<T>(
        &self,
        query: &str,
        parameters: impl rusqlite::Params,
        read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, DatabaseError> {
        let list = || self.connection.prepare_cached(query)?.query_map(parameters, read)?.collect();
        self.named(list())
    }

    /// All videos, by their numbers.
    pub(super) fn videos(&self) -> Result<Vec<Entry>, DatabaseError> {
        self.list("SELECT * FROM video ORDER BY number", [], Entry::of_row)
    }

    /// What it was made with: names and values.
    pub(super) fn parameters(&self) -> Result<Vec<(String, String)>, DatabaseError> {
        self.list("SELECT name, value FROM parameter ORDER BY name", [], |row| Ok((row.get(0)?, row.get(1)?)))
    }

    /// What was refused: contents, sources, and why.
    pub(super) fn refusals(&self) -> Result<Vec<(String, String, String)>, DatabaseError> {
        let query = "SELECT content, source, reason FROM refusal ORDER BY source";
        self.list(query, [], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))
    }

    /// Why this content was refused before.
    pub(super) fn refusal(&self, content: &str) -> Result<Option<String>, DatabaseError> {
        let query = "SELECT reason FROM refusal WHERE content = ?";
        self.named(self.connection.query_row(query, [content], |row| row.get(0)).optional())
    }

    /// The video of this content.
    pub(super) fn video(&self, content: &str) -> Result<Option<Entry>, DatabaseError> {
        let query = "SELECT * FROM video WHERE content = ?";
        self.named(self.connection.query_row(query, [content], Entry::of_row).optional())
    }

    /// The current vocabulary.
    pub(super) fn vocabulary(&self) -> Result<Option<Named>, DatabaseError> {
        let read = |row: &Row<'_>| {
            let bytes: Vec<u8> = row.get("words")?;
            let words = Vocabulary::from_bytes(&bytes).ok_or_else(|| strange("the vocabulary"))?;
            Ok((row.get::<_, String>("name")?, Named::new(words, row.get("training")?)))
        };
        let found = self.named(self.connection.query_row("SELECT * FROM vocabulary", [], read).optional())?;
        match found {
            Some((name, vocabulary)) if name != vocabulary.name => Err(DatabaseError::Damaged(
                self.path.clone(),
                "the checksum of its vocabulary is wrong".into(),
            )),
            found => Ok(found.map(|(_, vocabulary)| vocabulary)),
        }
    }

    /// Makes this the current vocabulary, or takes a damaged one away.
    pub(super) fn set_vocabulary(&mut self, vocabulary: Option<&Named>) -> Result<(), DatabaseError> {
        self.change(|transaction| {
            transaction.execute("DELETE FROM vocabulary", [])?;
            if let Some(Named { name, words, training }) = vocabulary {
                let bytes = words.to_bytes();
                transaction
                    .execute("INSERT INTO vocabulary VALUES (?, ?, ?)", params![name, bytes, training])?;
            }
            Ok(())
        })
    }

    /// The patches of a video.
    pub(super) fn patches(&self, number: u32) -> Result<Vec<Stored>, DatabaseError> {
        let query = "SELECT rowid, * FROM patch WHERE video = ? ORDER BY version, y, x";
        self.list(query, [number], Stored::of_row)
    }

    /// See [`super::Database::features`].
    pub(super) fn features(&self, class: Class) -> Result<Vec<Features>, DatabaseError> {
        let query = "SELECT patch.rowid, patch.* FROM patch JOIN video ON video.number = patch.video WHERE class = ? \
                     ORDER BY video.number, patch.rowid";
        self.list(query, [class.name()], |row| Stored::of_row(row)?.features())
    }

    /// How many patches each class has.
    pub(super) fn patch_counts(&self) -> Result<Vec<(String, u64, u64)>, DatabaseError> {
        let query = "SELECT class, count(DISTINCT video.number), count(patch.rowid) FROM video \
                     LEFT JOIN patch ON video.number = patch.video GROUP BY class ORDER BY class";
        let count = |row: &Row<'_>, column| row.get::<_, i64>(column).map(|count| count as u64);
        self.list(query, [], |row| Ok((row.get(0)?, count(row, 1)?, count(row, 2)?)))
    }

    /// Adds a video with its patches. Its number comes from its content; the next free one is taken if two contents meet in one.
    pub(super) fn add(&mut self, mut entry: Entry, patches: &[Moving]) -> Result<Entry, DatabaseError> {
        let number = self.free_number(&entry.content)?;
        entry.video.number = number;
        let rows = patches.iter().map(|moving| Stored {
            row: 0,
            patch: PatchRef { video: number, ..moving.patch },
            contrast: moving.contrast,
            motion: packed(&moving.motion),
            words: None,
        });
        self.insert(entry, rows.collect())
    }

    /// Adds a video of another catalogue.
    pub(super) fn add_from(&mut self, other: &Self, entry: &Entry) -> Result<(), DatabaseError> {
        let number = self.free_number(&entry.content)?;
        let mut patches = other.patches(entry.video.number)?;
        patches.iter_mut().for_each(|stored| stored.patch.video = number);
        let mut entry = entry.clone();
        entry.video.number = number;
        self.insert(entry, patches).map(|_| ())
    }

    fn free_number(&self, content: &str) -> Result<u32, DatabaseError> {
        let wanted = content.get(..8).and_then(|digits| u32::from_str_radix(digits, 16).ok()).unwrap_or(0);
        let query = "SELECT number FROM video WHERE number >= ? ORDER BY number";
        // As a rule this list is not read beyond its first row.
        let search = || -> rusqlite::Result<u32> {
            let mut statement = self.connection.prepare_cached(query)?;
            let mut rows = statement.query([wanted])?;
            let mut free = wanted;
            while let Some(row) = rows.next()? {
                if row.get::<_, u32>(0)? != free {
                    break;
                }
                free = free.wrapping_add(1);
            }
            Ok(free)
        };
        self.named(search())
    }

    fn insert(&mut self, mut entry: Entry, patches: Vec<Stored>) -> Result<Entry, DatabaseError> {
        entry.checksum = checksum(&patches);
        let bound = entry.clone();
        self.change(move |transaction| {
            let Entry {
                video,
                content,
                source,
                class_by,
                sharp,
                noise,
                fluid,
                forced,
                bytes,
                checksum,
                vocabulary,
            } = bound;
            transaction.execute("DELETE FROM refusal WHERE content = ?", [&content])?;
            transaction.execute(
                "INSERT INTO video VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                params![
                    video.number,
                    content,
                    video.name,
                    source.to_string_lossy(),
                    video.class.name(),
                    class_by,
                    video.width,
                    video.height,
                    video.frames,
                    video.rate,
                    sharp,
                    noise,
                    fluid,
                    forced,
                    bytes as i64,
                    checksum,
                    vocabulary
                ],
            )?;
            let mut insert =
                transaction.prepare_cached("INSERT INTO patch VALUES (?, ?, ?, ?, ?, ?, ?, ?)")?;
            for Stored { patch, contrast, motion, words, .. } in &patches {
                let map = |index: usize| words.as_ref().map(|words| &words[index][..]);
                let version = patch.version.number();
                insert.execute(params![
                    patch.video,
                    version,
                    patch.x,
                    patch.y,
                    contrast,
                    motion,
                    map(0),
                    map(1)
                ])?;
            }
            Ok(())
        })?;
        Ok(entry)
    }

    /// Gives the patches of a video, as [`Self::patches`] lists them, their words.
    pub(super) fn set_words(
        &mut self,
        number: u32,
        mut patches: Vec<Stored>,
        words: &[[WordMap; 2]],
        vocabulary: &str,
    ) -> Result<(), DatabaseError> {
        patches.iter_mut().zip(words).for_each(|(stored, words)| stored.words = Some(*words));
        let checksum = checksum(&patches);
        self.change(|transaction| {
            let mut update = transaction
                .prepare_cached("UPDATE patch SET mean_words = ?, sharp_words = ? WHERE rowid = ?")?;
            for (stored, [mean, sharp]) in patches.iter().zip(words) {
                update.execute(params![mean, sharp, stored.row])?;
            }
            let query = "UPDATE video SET vocabulary = ?, checksum = ? WHERE number = ?";
            transaction.execute(query, params![vocabulary, checksum, number]).map(|_| ())
        })
    }

    /// Notes that a source does not suit.
    pub(super) fn refuse(&mut self, content: &str, source: &Path, reason: &str) -> Result<(), DatabaseError> {
        self.change(|transaction| {
            let source = source.to_string_lossy();
            transaction
                .execute("INSERT OR REPLACE INTO refusal VALUES (?, ?, ?)", params![content, source, reason])
                .map(|_| ())
        })
    }

    /// Takes a video out.
    pub(super) fn remove(&mut self, number: u32) -> Result<(), DatabaseError> {
        self.change(|transaction| {
            transaction.execute("DELETE FROM patch WHERE video = ?", [number])?;
            transaction.execute("DELETE FROM video WHERE number = ?", [number]).map(|_| ())
        })
    }

    /// Whether SQLite finds its pages in order.
    pub(super) fn check_pages(&self) -> Result<(), DatabaseError> {
        let found = self.named(
            self.connection.pragma_query_value(None, "integrity_check", |row| row.get::<_, String>(0)),
        )?;
        if found == "ok" { Ok(()) } else { Err(DatabaseError::Damaged(self.path.clone(), found)) }
    }

    /// Whether the patches of a video are what was stored.
    pub(super) fn check_patches(&self, entry: &Entry) -> Result<(), String> {
        let patches = self.patches(entry.video.number).map_err(|error| error.to_string())?;
        if checksum(&patches) == entry.checksum {
            Ok(())
        } else {
            Err("the checksum of its patches is wrong".into())
        }
    }
}

fn checksum(patches: &[Stored]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for Stored { patch, contrast, motion, words, .. } in patches {
        hasher.update(&[patch.version.number()]);
        hasher.update(&[patch.x.to_le_bytes(), patch.y.to_le_bytes()].concat());
        hasher.update(&contrast.to_le_bytes());
        hasher.update(motion);
        words.iter().flatten().for_each(|map| hasher.update(map));
    }
    hasher.finalize()
}

fn parameters() -> Vec<(&'static str, String)> {
    vec![
        ("software", format!("yurameki-fluid {}", env!("CARGO_PKG_VERSION"))),
        ("patch side, pixels", SIDE.to_string()),
        ("patch stride, pixels", STRIDE.to_string()),
        ("versions of a video", VERSIONS.to_string()),
        ("places of a patch", PLACES.to_string()),
        ("cells of a patch", (CELLS * CELLS).to_string()),
        ("channels of a cell", CHANNELS.to_string()),
        ("unit of motion, pixels a frame", MOTION_UNIT.to_string()),
        ("unit of texture, levels", TEXTURE_UNIT.to_string()),
    ]
}

/// Damage has a cure of its own.
fn failure(directory: &Path, error: rusqlite::Error) -> DatabaseError {
    match (&error, error.sqlite_error_code()) {
        (_, Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase))
        | (rusqlite::Error::FromSqlConversionFailure(..) | rusqlite::Error::InvalidColumnType(..), _)
        | (rusqlite::Error::IntegralValueOutOfRange(..) | rusqlite::Error::InvalidColumnName(_), _) => {
            DatabaseError::Damaged(directory.to_owned(), error.to_string())
        }
        // A catalogue that lost its tables is as damaged.
        (_, Some(ErrorCode::Unknown)) => DatabaseError::Damaged(directory.to_owned(), error.to_string()),
        _ => DatabaseError::Catalogue(directory.to_owned(), error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_motion_is_exact_to_its_unit() {
        let motion = core::array::from_fn(|cell| {
            core::array::from_fn(|channel| (cell * 12 + channel) as f32 * 0.37 - 20.0)
        });
        let again = unpacked(&packed(&motion)).unwrap();
        for (one, two) in motion.as_flattened().iter().zip(again.as_flattened()) {
            assert!((one - two).abs() <= TEXTURE_UNIT / 2.0);
        }
        assert!(unpacked(&[0; 383]).is_none());
    }

    #[test]
    fn a_catalogue_of_another_layout_or_program_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(Catalogue::open(folder.path()), Err(DatabaseError::Missing(_))));
        let catalogue = Catalogue::open_or_create(folder.path()).unwrap();
        catalogue.connection.pragma_update(None, "user_version", 0).unwrap();
        let error = Catalogue::open(folder.path()).err().unwrap();
        assert!(matches!(error, DatabaseError::Version(_, 0)), "{error}");
        catalogue.connection.pragma_update(None, "application_id", 5).unwrap();
        assert!(matches!(Catalogue::open(folder.path()), Err(DatabaseError::Damaged(..))));
        drop(catalogue);
        fs::write(
            path(folder.path()),
            "no database, and long enough for a header of one hundred bytes: ".repeat(9),
        )
        .unwrap();
        assert!(matches!(Catalogue::open(folder.path()), Err(DatabaseError::Damaged(..))));
    }
}
