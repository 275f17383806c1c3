//! # The library
//!
//! The photos of folders that change while the show is running: files are copied, sticks plugged in and pulled out, network
//! folders come and go. A thread looks through the folders once something in them has changed and half a second was
//! quiet, when another file system is mounted, and in any case every minute (the kernel does not tell of changes that other
//! machines make). What is being copied is taken when it has not changed for two seconds. A folder that is not there is
//! waited for.
//!
//! Memory: the path of every photo and some words. A mask or a sidecar that changes is a change of its photo. Cost of a look: one `stat` for every photo, mask and sidecar, and, in the order of dates, 256 KiB read of each
//! that is new. The pause between two looks is at least four times as long as a look takes.

mod scan;
mod taken;

pub use taken::date_taken;

use crate::{app::playlist::PhotoId, config::Order};
use notify::{
    RecommendedWatcher, RecursiveMode, Watcher as _,
    event::{AccessKind, AccessMode, EventKind},
};
use scan::{Listing, SETTLED, Scanner};
use sha2::{Digest, Sha256};
use std::{
    fs,
    os::unix::{ffi::OsStrExt, fs::MetadataExt},
    path::{self, Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread,
    time::{Duration, Instant},
};

/// How often the thread wakes up: often enough that a photo that was copied comes soon, seldom enough to cost nothing.
const TICK: Duration = Duration::from_millis(500);

/// While files keep changing, the folders are looked through this often.
const BUSY: Duration = Duration::from_secs(2);

/// How often it is asked whether a folder has come, gone, or been mounted over.
const MOUNTS: Duration = Duration::from_secs(2);

/// How often the folders are looked through though nothing is known to have changed.
const POLL: Duration = Duration::from_secs(60);

/// The id of the photo at `path`: the first 8 bytes of the SHA-256 of its absolute path. Of 65,536 photos two have the same with a
/// probability of 10⁻¹⁰.
pub fn photo_id(path: &Path) -> PhotoId {
    let hash = Sha256::digest(path.as_os_str().as_bytes());
    PhotoId(hash.iter().take(8).fold(0, |id, &byte| id << 8 | u64::from(byte)))
}

/// What has happened to the photos since the last time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct News {
    /// Photos that have another content now.
    pub changed: Vec<PhotoId>,
}

/// Folders that are watched.
#[derive(Debug)]
pub struct Library {
    listing: Listing,
    listings: Receiver<Listing>,
    stop: Arc<AtomicBool>,
}

impl Library {
    /// Looks through `paths` (photos and folders of photos) and watches them from then on. The `order` decides how they are
    /// listed: by date, or by name for all others.
    pub fn watch<P: AsRef<Path>>(paths: &[P], order: Order) -> Self {
        let absolute = |path: &P| path::absolute(path).unwrap_or_else(|_| path.as_ref().to_owned());
        let roots: Vec<PathBuf> = paths.iter().map(absolute).collect();
        let (stop, touched) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        // Watched before they are looked through, so that nothing is missed in between.
        let watch = Watch::new(roots.clone(), Arc::clone(&touched));
        let mut scanner = Scanner::new(roots, order);
        let clock = Instant::now();
        let listing = scanner.scan(clock.elapsed());
        let (sender, listings) = channel();
        let photos = listing.photos.clone();
        let thread = Thread { scanner, watch, touched, stop: Arc::clone(&stop), clock, photos, sender };
        if let Err(error) = thread::Builder::new().name("library".into()).spawn(move || thread.run()) {
            log::warn!("the folders cannot be watched ({error}): photos that come later are not shown");
        }
        Self { listing, listings, stop }
    }

    /// The photos, in the order of the listing.
    pub fn photos(&self) -> &[PhotoId] {
        &self.listing.photos
    }

    /// Where a photo is.
    pub fn path(&self, photo: PhotoId) -> Option<&Path> {
        self.listing.paths.get(&photo).map(AsRef::as_ref)
    }

    /// What has happened since the last call, if anything has: [`Self::photos`] are others then, or some have changed. Does not
    /// wait.
    pub fn news(&mut self) -> Option<News> {
        let mut news = None;
        while let Ok(listing) = self.listings.try_recv() {
            let News { changed } = news.get_or_insert_default();
            changed.extend(&listing.changed);
            self.listing = listing;
        }
        news
    }
}

impl Drop for Library {
    /// The thread ends by itself: it may be waiting for a network.
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Notices that something in the folders has changed.
struct Watch {
    roots: Vec<PathBuf>,
    watcher: Option<RecommendedWatcher>,
    touched: Arc<AtomicBool>,
    /// What is mounted, and which folders there are.
    mounts: Mounts,
    told: bool,
}

type Mounts = (String, Vec<Option<(u64, u64)>>);

impl Watch {
    fn new(roots: Vec<PathBuf>, touched: Arc<AtomicBool>) -> Self {
        let mounts = mounts(&roots);
        let mut watch = Self { roots, watcher: None, touched, mounts, told: false };
        watch.start();
        watch
    }

    /// Watches the folders that there are now.
    fn start(&mut self) {
        let touched = Arc::clone(&self.touched);
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            if event.map_or(true, |event| is_change(event.kind)) {
                touched.store(true, Ordering::Relaxed);
            }
        });
        let failed = match watcher {
            Ok(mut watcher) => {
                let there = self.roots.iter().filter(|root| root.exists());
                let failed =
                    there.filter_map(|root| watcher.watch(root, RecursiveMode::Recursive).err()).last();
                self.watcher = Some(watcher);
                failed
            }
            Err(error) => Some(error),
        };
        if let Some(error) = failed.filter(|_| !self.told) {
            log::warn!("new photos come up to a minute late: {error}; see fs.inotify.max_user_watches");
            self.told = true;
        }
    }

    /// Starts again if a folder has come or gone or been mounted over; tells whether it has.
    fn follow_mounts(&mut self) -> bool {
        let mounts = mounts(&self.roots);
        let other = mounts != self.mounts;
        if other {
            self.mounts = mounts;
            self.start();
        }
        other
    }
}

fn mounts(roots: &[PathBuf]) -> Mounts {
    let identity = |root: &PathBuf| fs::metadata(root).ok().map(|metadata| (metadata.dev(), metadata.ino()));
    let mounted = fs::read_to_string("/proc/self/mountinfo").unwrap_or_default();
    (mounted, roots.iter().map(identity).collect())
}

/// Whether an event means that a file has changed; we ourselves open and read them.
const fn is_change(kind: EventKind) -> bool {
    match kind {
        EventKind::Access(AccessKind::Close(AccessMode::Write)) => true,
        EventKind::Access(_) => false,
        _ => true,
    }
}

/// The thread that looks through the folders.
struct Thread {
    scanner: Scanner,
    watch: Watch,
    touched: Arc<AtomicBool>,
    stop: Arc<AtomicBool>,
    clock: Instant,
    /// Those that were told last.
    photos: Vec<PhotoId>,
    sender: Sender<Listing>,
}

impl Thread {
    fn run(mut self) {
        let (mut scanned, mut took) = (self.clock.elapsed(), Duration::ZERO);
        let mut asked = scanned;
        // Since when something is known to have changed.
        let mut dirty = None;
        while !self.stop.load(Ordering::Relaxed) {
            thread::sleep(TICK);
            let now = self.clock.elapsed();
            let touched = self.touched.swap(false, Ordering::Relaxed);
            if touched {
                dirty.get_or_insert(now);
            }
            let mut due = dirty.is_some_and(|since| !touched || now - since >= BUSY);
            if now - asked >= MOUNTS {
                asked = now;
                due |= self.watch.follow_mounts();
            }
            let pause = if self.scanner.is_settling() { SETTLED } else { POLL };
            due |= now - scanned >= pause;
            if !due || now - scanned < took * 4 {
                continue;
            }
            dirty = None;
            let listing = self.scanner.scan(now);
            scanned = self.clock.elapsed();
            took = scanned - now;
            if listing.photos == self.photos && listing.changed.is_empty() {
                continue;
            }
            self.photos.clone_from(&listing.photos);
            if self.sender.send(listing).is_err() {
                return;
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    /// A JPEG of nothing but an EXIF segment, with one entry: `date` as DateTime (0x0132), 20 bytes of text at 26.
    pub(in crate::os) fn jpeg_of(date: &str) -> Vec<u8> {
        let mut tiff = b"MM\0*\0\0\0\x08\0\x01\x01\x32\0\x02\0\0\0\x14\0\0\0\x1a\0\0\0\0".to_vec();
        tiff.extend(date.as_bytes());
        tiff.push(0);
        let mut jpeg = b"\xff\xd8\xff\xe1".to_vec();
        jpeg.extend((tiff.len() as u16 + 8).to_be_bytes());
        jpeg.extend(b"Exif\0\0");
        jpeg.extend(&tiff);
        jpeg.extend(b"\xff\xd9");
        jpeg
    }
}
