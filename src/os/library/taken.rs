//! When a photo was taken.

use jiff::civil::DateTime;
use rustix::fs::{Mode, OFlags};
use std::{
    fs::File,
    io::{Cursor, Read},
    panic::catch_unwind,
    path::Path,
};

/// What is read of a file to find its EXIF data: in a JPEG it is one segment of at most 64 KiB among the first ones. In other
/// formats it may lie anywhere; what lies further is not found.
const PREFIX: u64 = 256 << 10;

/// When the photo at `path` was taken, by the clock of the camera: EXIF `DateTimeOriginal`, else `DateTime` (CIPA DC-008, 4.6.5).
/// Reads at most 256 KiB. `None` if it does not say.
pub fn date_taken(path: &Path) -> Option<DateTime> {
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let file = File::from(rustix::fs::open(path, flags, Mode::empty()).ok()?);
    if !file.metadata().ok()?.is_file() {
        return None;
    }
    let mut start = Vec::new();
    file.take(PREFIX).read_to_end(&mut start).ok()?;
    // A panic in the reader concerns this photo only.
    catch_unwind(|| from_exif(&start)).ok()?
}

fn from_exif(file: &[u8]) -> Option<DateTime> {
    let exif = exif::Reader::new().read_from_container(&mut Cursor::new(file)).ok()?;
    [exif::Tag::DateTimeOriginal, exif::Tag::DateTime].into_iter().find_map(|tag| {
        let exif::Value::Ascii(text) = &exif.get_field(tag, exif::In::PRIMARY)?.value else { return None };
        let date = exif::DateTime::from_ascii(text.first()?).ok()?;
        let small = |number: u8| i8::try_from(number).ok();
        DateTime::new(
            i16::try_from(date.year).ok().filter(|&year| year > 0)?,
            small(date.month)?,
            small(date.day)?,
            small(date.hour)?,
            small(date.minute)?,
            small(date.second)?.min(59),
            0,
        )
        .ok()
    })
}
