//! What photos there are, told from what there were.

use super::{photo_id, taken::date_taken};
use crate::{
    app::playlist::PhotoId,
    config::Order,
    os::photo::{self, Found},
};
use jiff::{Timestamp, tz::TimeZone};
use std::{
    collections::{HashMap, HashSet},
    fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, SystemTime},
};

/// A file that has not changed for so long has been copied to its end: a copy over a slow network writes more often.
pub(super) const SETTLED: Duration = Duration::from_secs(2);

/// The photos at one moment.
#[derive(Clone, Debug, Default)]
pub(super) struct Listing {
    /// In the order of the listing.
    pub(super) photos: Vec<PhotoId>,
    pub(super) paths: HashMap<PhotoId, Arc<Path>>,
    /// Those that have another content than when they were listed last.
    pub(super) changed: Vec<PhotoId>,
}

/// What tells one content of a file from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    len: u64,
    modified: Option<SystemTime>,
    /// The same of its mask and its sidecar, as a hash.
    companions: u64,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    id: PhotoId,
    stamp: Stamp,
    /// Seconds since 1970 of the camera's clock; 0 where the order does not ask for it.
    taken: i64,
}

/// Looks through folders again and again.
#[derive(Debug)]
pub(super) struct Scanner {
    roots: Vec<PathBuf>,
    order: Order,
    known: HashMap<Arc<Path>, Known>,
    /// Files that are new or have changed, and since when they have been what they are.
    settling: HashMap<Arc<Path>, (Stamp, Duration)>,
    /// What was told at the last scan, and is not told again.
    told: HashSet<String>,
    scanned: bool,
}

impl Scanner {
    pub(super) fn new(roots: Vec<PathBuf>, order: Order) -> Self {
        Self {
            roots,
            order,
            known: HashMap::new(),
            settling: HashMap::new(),
            told: HashSet::new(),
            scanned: false,
        }
    }

    /// Whether there are files to be looked at again once [`SETTLED`] has passed.
    pub(super) fn is_settling(&self) -> bool {
        !self.settling.is_empty()
    }

    /// The photos there are now. At the first scan all are taken as they are, so that the show can begin; those that are found half
    /// copied are taken as changed when they are whole.
    pub(super) fn scan(&mut self, now: Duration) -> Listing {
        let (mut files, found) = self.files();
        let mut seen = HashSet::with_capacity(files.len());
        let mut listing = Listing::default();
        files.retain(|path| {
            seen.insert(Arc::clone(path)) && self.look(path, &found, now, &mut listing.changed)
        });
        self.known.retain(|path, _| seen.contains(path));
        self.settling.retain(|path, _| seen.contains(path));
        self.scanned = true;
        if self.order == Order::Date {
            // Stable: of the same second, by name.
            files.sort_by_key(|path| self.known[path].taken);
        }
        listing.photos = files.iter().map(|path| self.known[path].id).collect();
        listing.paths = files.into_iter().map(|path| (self.known[&path].id, path)).collect();
        listing
    }

    /// The photos of all folders that are there, and what was found in each.
    fn files(&mut self) -> (Vec<Arc<Path>>, Vec<Found>) {
        let (mut files, mut all, mut told) = (Vec::new(), Vec::new(), HashSet::new());
        let mut tell = |line: String| {
            if !self.told.contains(&line) {
                log::warn!("{line}");
            }
            told.insert(line);
        };
        for root in &self.roots {
            match photo::find([root], &mut |error| tell(format!("skipped: {error}"))) {
                Ok(mut found) => {
                    files.extend(found.photos.drain(..).map(Arc::from));
                    all.push(found);
                }
                Err(error) => tell(format!("{error}; waiting for it")),
            }
        }
        self.told = told;
        (files, all)
    }

    /// Whether the file at `path` is a photo to be shown.
    fn look(&mut self, path: &Arc<Path>, found: &[Found], now: Duration, changed: &mut Vec<PhotoId>) -> bool {
        // It may be gone since it was listed.
        let Ok(metadata) = fs::metadata(path) else { return false };
        let companions = hash(found.iter().flat_map(|found| found.companions(path)));
        let stamp = Stamp { len: metadata.len(), modified: metadata.modified().ok(), companions };
        let known = self.known.get(path).copied();
        if known.is_some_and(|known| known.stamp == stamp) {
            self.settling.remove(path);
            return true;
        }
        if self.scanned && !self.has_settled(path, stamp, now) {
            return known.is_some();
        }
        let id = photo_id(path);
        if known.is_some() {
            changed.push(id);
        }
        let taken = if self.order == Order::Date { taken(path, stamp) } else { 0 };
        self.known.insert(Arc::clone(path), Known { id, stamp, taken });
        true
    }

    fn has_settled(&mut self, path: &Arc<Path>, stamp: Stamp, now: Duration) -> bool {
        match self.settling.get(path) {
            Some(&(before, since)) if before == stamp => {
                let settled = now.saturating_sub(since) >= SETTLED;
                if settled {
                    self.settling.remove(path);
                }
                settled
            }
            _ => {
                self.settling.insert(Arc::clone(path), (stamp, now));
                false
            }
        }
    }
}

/// The names, lengths and times of files, as one number.
fn hash<'a>(files: impl Iterator<Item = &'a PathBuf>) -> u64 {
    let mut hasher = DefaultHasher::new();
    for path in files {
        let metadata = fs::metadata(path).ok();
        let content = metadata.map(|metadata| (metadata.len(), metadata.modified().ok()));
        (path, content).hash(&mut hasher);
    }
    hasher.finish()
}

/// When the photo was taken, else when its file was written.
fn taken(path: &Path, stamp: Stamp) -> i64 {
    let camera = date_taken(path).and_then(|date| TimeZone::UTC.to_timestamp(date).ok());
    let file = || stamp.modified.and_then(|time| Timestamp::try_from(time).ok());
    camera.or_else(file).map_or(0, Timestamp::as_second)
}

#[cfg(test)]
mod tests {
    use super::{super::tests::jpeg_of, *};

    const SECOND: Duration = Duration::from_secs(1);

    fn names(listing: &Listing) -> Vec<String> {
        let name = |id| listing.paths[id].file_name().unwrap().to_string_lossy().into_owned();
        listing.photos.iter().map(name).collect()
    }

    #[test]
    fn a_photo_that_is_being_copied_is_taken_once_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let mut scanner = Scanner::new(vec![folder.path().to_owned()], Order::Name);
        fs::write(folder.path().join("a.jpg"), "as it is").unwrap();
        assert_eq!(names(&scanner.scan(Duration::ZERO)), ["a.jpg"]);

        let copy = folder.path().join("b.jpg");
        for second in 1..6 {
            fs::write(&copy, "x".repeat(second)).unwrap();
            assert_eq!(names(&scanner.scan(SECOND * second as u32)), ["a.jpg"]);
            assert!(scanner.is_settling());
        }
        assert_eq!(names(&scanner.scan(SECOND * 6)), ["a.jpg"], "unchanged for a second only");
        let listing = scanner.scan(SECOND * 7);
        assert_eq!((names(&listing), listing.changed.len()), (vec!["a.jpg".into(), "b.jpg".into()], 0));
        assert!(!scanner.is_settling());
    }

    #[test]
    fn a_photo_that_changes_is_told_once_it_is_whole_and_is_shown_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let photo = folder.path().join("a.jpg");
        fs::write(&photo, "half").unwrap();
        let mut scanner = Scanner::new(vec![photo.clone()], Order::Shuffle);
        scanner.scan(Duration::ZERO);
        fs::write(&photo, "the whole").unwrap();
        let during = scanner.scan(SECOND);
        assert_eq!((during.photos.len(), during.changed.len()), (1, 0));
        assert_eq!(scanner.scan(SECOND * 3).changed, [photo_id(&photo)]);
        assert!(scanner.scan(SECOND * 4).changed.is_empty());
        fs::remove_file(&photo).unwrap();
        assert!(scanner.scan(SECOND * 5).photos.is_empty());
    }

    #[test]
    fn a_mask_or_a_sidecar_that_comes_changes_or_goes_is_a_change_of_its_photo() {
        let folder = tempfile::tempdir().unwrap();
        let [photo, other] = ["a.jpg", "b.jpg"].map(|name| folder.path().join(name));
        for path in [&photo, &other] {
            fs::write(path, "x").unwrap();
        }
        let alone = Scanner::new(vec![photo.clone()], Order::Name);
        for mut scanner in [Scanner::new(vec![folder.path().to_owned()], Order::Name), alone] {
            let mut clock = Duration::ZERO;
            let mut changed = || {
                scanner.scan(clock);
                clock += SECOND * 3;
                let changed = scanner.scan(clock).changed;
                clock += SECOND * 3;
                changed
            };
            assert_eq!(changed(), []);
            for name in ["a.jpg.mask.png", "a.mask.png", "a.jpg.toml", "a.toml"] {
                let path = folder.path().join(name);
                fs::write(&path, "half").unwrap();
                assert_eq!(changed(), [photo_id(&photo)], "{name} has come");
                fs::write(&path, "the whole").unwrap();
                assert_eq!(changed(), [photo_id(&photo)], "{name} has changed");
                fs::remove_file(&path).unwrap();
                assert_eq!(changed(), [photo_id(&photo)], "{name} has gone");
                assert_eq!(changed(), [], "{name}");
            }
            for name in ["c.toml", "notes.txt"] {
                fs::write(folder.path().join(name), "x").unwrap();
                assert_eq!(changed(), [], "{name}");
            }
        }
    }

    #[test]
    fn by_date_the_exif_date_counts_and_else_that_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let jpeg = jpeg_of("1999:12:31 23:59:58");
        for (name, bytes, seconds) in
            [("a.jpg", &b""[..], 2_000_000_000), ("b.jpg", b"", 5), ("c.jpg", &jpeg, 2)]
        {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
            fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        }
        let taken = date_taken(&folder.path().join("c.jpg")).unwrap();
        assert_eq!(taken.to_string(), "1999-12-31T23:59:58");
        assert_eq!(date_taken(&folder.path().join("b.jpg")), None);
        assert_eq!(date_taken(folder.path()), None);
        let listed = |order| names(&Scanner::new(vec![folder.path().to_owned()], order).scan(Duration::ZERO));
        assert_eq!(listed(Order::Date), ["b.jpg", "c.jpg", "a.jpg"]);
        assert_eq!(listed(Order::Name), ["a.jpg", "b.jpg", "c.jpg"]);
    }

    #[test]
    fn a_photo_that_is_named_twice_is_listed_once() {
        let folder = tempfile::tempdir().unwrap();
        let photo = folder.path().join("a.jpg");
        fs::write(&photo, "x").unwrap();
        let mut scanner = Scanner::new(vec![folder.path().to_owned(), photo], Order::Name);
        assert_eq!(scanner.scan(Duration::ZERO).photos.len(), 1);
    }
}
