//! The photos of folders.

use super::{
    PhotoError,
    file::from_io,
    mask::{MASK_SUFFIX, mask_paths},
};
use crate::os::sidecar;
use std::{
    cmp::Ordering,
    collections::HashSet,
    fs, io,
    os::unix::{ffi::OsStrExt, fs::MetadataExt},
    path::{Path, PathBuf},
};

/// Extensions of what may be a photo. Those of formats that are not supported are among them, so that it is said once that
/// such a photo is skipped, and why. A clip is one of the photos.
const EXTENSIONS: [&str; 33] = [
    "jpg", "jpeg", "jpe", "jfif", "png", "apng", "webp", "gif", "bmp", "dib", "tif", "tiff", "heic", "heif",
    "hif", "avif", "jxl", "jp2", "dng", "cr2", "cr3", "nef", "nrw", "arw", "orf", "raf", "rw2", "pef", "srw",
    "raw", "psd", "x3f", "yfl",
];

/// The photos at `paths`: files as they are named, and those of folders and of the folders in them.
///
/// In folders, files are taken whose extension is that of a picture (what they are is told by their content later). Hidden
/// files and folders (`.name`, also `._name`) and masks (`*.mask.png`) are passed over. Links are followed; a folder that
/// is reached twice is taken once, so loops end. The photos of each of `paths` are in the natural order of their names (2
/// before 10). A folder inside that cannot be read is told and passed over.
///
/// # Errors
/// If one of `paths` does not exist or cannot be read.
pub fn list<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Result<Vec<PathBuf>, PhotoError> {
    list_telling(paths, &mut |error| log::warn!("skipped: {error}"))
}

/// As [`list`]; what is passed over because it cannot be read is told to `tell`.
///
/// # Errors
/// As [`list`].
pub fn list_telling<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    tell: &mut dyn FnMut(PhotoError),
) -> Result<Vec<PathBuf>, PhotoError> {
    Ok(find(paths, tell)?.photos)
}

/// What there is at some paths.
#[derive(Debug, Default)]
pub(in crate::os) struct Found {
    /// The photos, as [`list`] gives them.
    pub(in crate::os) photos: Vec<PathBuf>,
    /// Masks and sidecars, whether there is a photo that they belong to or not.
    companions: HashSet<PathBuf>,
}

impl Found {
    /// The mask and the sidecar of the photo at `path`, those of them that there are.
    pub(in crate::os) fn companions(&self, path: &Path) -> impl Iterator<Item = &PathBuf> {
        let possible = mask_paths(path).into_iter().chain(sidecar::paths(path));
        possible.filter_map(|path| self.companions.get(&path))
    }
}

/// As [`list_telling`], with masks and sidecars.
///
/// # Errors
/// As [`list`].
pub(in crate::os) fn find<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    tell: &mut dyn FnMut(PhotoError),
) -> Result<Found, PhotoError> {
    let mut all = Found::default();
    let mut seen = HashSet::new();
    for path in paths {
        let path = path.as_ref();
        let named = |fault| PhotoError::new(&path.to_string_lossy(), fault);
        let metadata = fs::metadata(path).map_err(from_io).map_err(named)?;
        if !metadata.is_dir() {
            let possible = mask_paths(path).into_iter().chain(sidecar::paths(path));
            all.companions.extend(possible.filter(|path| path.exists()));
            all.photos.push(path.to_owned());
            continue;
        }
        let mut found = Found { companions: std::mem::take(&mut all.companions), ..Found::default() };
        seen.insert((metadata.dev(), metadata.ino()));
        let mut folders = visit(path, &mut seen, &mut found, tell).map_err(from_io).map_err(named)?;
        while let Some(folder) = folders.pop() {
            match visit(&folder, &mut seen, &mut found, tell) {
                Ok(inner) => folders.extend(inner),
                Err(error) => tell(unreadable(&folder, error)),
            }
        }
        found.photos.sort_by(|a, b| natural(a, b));
        all.photos.append(&mut found.photos);
        all.companions = found.companions;
    }
    Ok(all)
}

/// Adds what is in one folder to `found`, and gives the folders in it that were not seen before.
fn visit(
    folder: &Path,
    seen: &mut HashSet<(u64, u64)>,
    found: &mut Found,
    tell: &mut dyn FnMut(PhotoError),
) -> io::Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (name, path) = (entry.file_name(), entry.path());
        if name.as_bytes().starts_with(b".") {
            continue;
        }
        // Plain files, the most by far, are not asked for again.
        if entry.file_type().is_ok_and(|kind| kind.is_file()) {
            if is_photo(&path) {
                found.photos.push(path);
            } else if is_companion(&path) {
                found.companions.insert(path);
            }
            continue;
        }
        match fs::metadata(&path) {
            Ok(metadata) if metadata.is_dir() => {
                if seen.insert((metadata.dev(), metadata.ino())) {
                    folders.push(path);
                }
            }
            Ok(_) if is_photo(&path) => found.photos.push(path),
            Ok(_) if is_companion(&path) => drop(found.companions.insert(path)),
            Err(error) if is_photo(&path) => tell(unreadable(&path, error)),
            Ok(_) | Err(_) => {}
        }
    }
    Ok(folders)
}

fn unreadable(path: &Path, error: io::Error) -> PhotoError {
    PhotoError::new(&path.to_string_lossy(), from_io(error))
}

/// Whether a name is that of a photo.
fn is_photo(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    EXTENSIONS.contains(&extension) && !name.ends_with(MASK_SUFFIX)
}

/// Whether a name is that of a mask or a sidecar.
fn is_companion(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_bytes();
    name.ends_with(MASK_SUFFIX.as_bytes()) || name.ends_with(b".toml")
}

/// The natural order of two paths: digits compare as numbers, letters without regard to case (of ASCII).
fn natural(a: &Path, b: &Path) -> Ordering {
    let order = |a: &[u8], b: &[u8]| {
        let (mut a, mut b) = (a, b);
        while let (Some(&x), Some(&y)) = (a.first(), b.first()) {
            let order = if x.is_ascii_digit() && y.is_ascii_digit() {
                let (x, y) = (take_number(&mut a), take_number(&mut b));
                x.len().cmp(&y.len()).then(x.cmp(y))
            } else {
                (a, b) = (&a[1..], &b[1..]);
                x.to_ascii_lowercase().cmp(&y.to_ascii_lowercase())
            };
            if order.is_ne() {
                return order;
            }
        }
        a.len().cmp(&b.len())
    };
    let mut parts = a.components().zip(b.components());
    parts
        .find_map(|(a, b)| {
            Some(order(a.as_os_str().as_bytes(), b.as_os_str().as_bytes())).filter(|order| order.is_ne())
        })
        .unwrap_or_else(|| a.components().count().cmp(&b.components().count()))
        .then_with(|| a.cmp(b))
}

/// Takes the number at the start, without its leading zeros.
fn take_number<'a>(text: &mut &'a [u8]) -> &'a [u8] {
    let end = text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let (number, rest) = text.split_at(end);
    *text = rest;
    let zeros = number.iter().position(|&byte| byte != b'0').unwrap_or(number.len());
    &number[zeros..]
}
