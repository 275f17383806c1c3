//! What the information on the picture says of a photo.

use super::library::date_taken;
use jiff::{Timestamp, tz::TimeZone};
use std::{ffi::OsStr, fmt::Write as _, fs, os::unix::ffi::OsStrExt, path::Path};
use unicode_normalization::UnicodeNormalization;

/// The name of the photo at `path`, and on a line of its own when it was taken, by the clock of the camera; where the photo does not
/// say, when its file was written, by the clock here. Reads at most 256 KiB.
pub(super) fn of_file(path: &Path) -> String {
    let mut caption = name_of(path);
    if let Some(taken) = date_taken(path) {
        let _ = write!(caption, "\n{}", taken.strftime("%Y-%m-%d %H:%M"));
    } else if let Some(written) = written(path) {
        let _ = write!(caption, "\nfile of {written}");
    }
    caption
}

/// The name of the photo at `path`, as one line.
pub(super) fn name_of(path: &Path) -> String {
    name(path.file_name().unwrap_or(path.as_os_str()))
}

fn written(path: &Path) -> Option<String> {
    let time = Timestamp::try_from(fs::metadata(path).ok()?.modified().ok()?).ok()?;
    Some(TimeZone::system().to_datetime(time).date().to_string())
}

/// A name as one line of text: accents are joined to their letters (macOS writes them apart: NFC of Unicode, UAX #15), and bytes
/// that are no UTF-8 are shown as \\xE9.
fn name(name: &OsStr) -> String {
    let mut text = String::new();
    for chunk in name.as_bytes().utf8_chunks() {
        text.extend(
            chunk.valid().nfc().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }),
        );
        for byte in chunk.invalid() {
            let _ = write!(text, "\\x{byte:02X}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, SystemTime};

    #[test]
    fn a_name_is_one_line_of_composed_letters_and_undecodable_bytes_are_shown() {
        let shown = |bytes: &[u8]| name(OsStr::from_bytes(bytes));
        assert_eq!(shown("Cafe\u{301} か\u{3099}.jpg".as_bytes()), "Café が.jpg");
        assert_eq!(shown("Café が.jpg".as_bytes()), "Café が.jpg");
        assert_eq!(shown(b"Caf\xe9\xff.jpg"), "Caf\\xE9\\xFF.jpg");
        assert_eq!(shown(b"two\nlines.jpg"), "two\u{fffd}lines.jpg");
    }

    #[test]
    fn the_date_is_the_cameras_else_that_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        fs::write(&path, "no EXIF").unwrap();
        let noon = SystemTime::UNIX_EPOCH + Duration::from_secs(1_721_563_200);
        fs::File::options().write(true).open(&path).unwrap().set_modified(noon).unwrap();
        assert_eq!(of_file(&path), "a.jpg\nfile of 2024-07-21");
        fs::write(&path, crate::os::library::tests::jpeg_of("1999:12:31 23:59:58")).unwrap();
        assert_eq!(of_file(&path), "a.jpg\n1999-12-31 23:59");
        assert_eq!(of_file(&folder.path().join("gone.jpg")), "gone.jpg");
    }
}
