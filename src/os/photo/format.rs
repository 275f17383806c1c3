//! What a file is, by its first bytes, and whether it is all there.

use super::Fault;
use image::ImageFormat;

/// Formats that are known by name only: where in the file, what bytes, and the name.
const UNSUPPORTED: [(usize, &[u8], &str); 10] = [
    JXL[0],
    JXL[1],
    (4, b"jP  \r\n\x87\n", "JPEG 2000"),
    (8, b"CR\x02", "camera RAW"),
    (0, b"IIRO", "camera RAW"),
    (0, b"IIRS", "camera RAW"),
    (0, b"IIU\0", "camera RAW"),
    (0, b"FUJIFILMCCD-RAW", "camera RAW"),
    (0, b"FOVb", "camera RAW"),
    (0, b"8BPS", "Photoshop (PSD)"),
];

/// JPEG XL, bare and in a container; the cargo feature `jxl` takes it.
const JXL: [(usize, &[u8], &str); 2] = [(0, b"\xff\x0a", "JPEG XL"), (4, b"JXL \r\n\x87\n", "JPEG XL")];

/// Whether a file is JPEG XL.
#[cfg(feature = "jxl")]
pub(super) fn is_jxl(bytes: &[u8]) -> bool {
    JXL.iter().any(|(start, magic, _)| bytes.get(*start..).is_some_and(|rest| rest.starts_with(magic)))
}

/// What the brands of a file of boxes (ISO/IEC 14496-12) say that it holds: a brand begins so, and the name. Of AVIF and HEIC, which
/// both may have the brand mif1 too, the more telling brand may come later.
const BRANDS: [(&[u8], &str); 6] = [
    (b"avi", "AVIF"),
    (b"hei", "HEIC"),
    (b"hev", "HEIC"),
    (b"crx", "camera RAW"),
    (b"mif1", "HEIF"),
    (b"msf1", "HEIF"),
];

/// The name of the format of a file of boxes; `None` for other files.
fn boxed(bytes: &[u8]) -> Option<&'static str> {
    let (&length, rest) = bytes.split_first_chunk::<4>()?;
    let rest = rest.strip_prefix(b"ftyp")?;
    let length = (u32::from_be_bytes(length) as usize).saturating_sub(8).min(rest.len());
    // After the first brand comes its version.
    let brands = rest[..length].chunks_exact(4).enumerate().filter(|(i, _)| *i != 1).map(|(_, brand)| brand);
    let is = |start: &[u8]| brands.clone().any(|brand| brand.starts_with(start));
    Some(BRANDS.iter().find(|(start, _)| is(start)).map_or("video", |(_, name)| name))
}

/// The format of a file, by its content.
pub(super) fn guess(bytes: &[u8]) -> Result<ImageFormat, Fault> {
    if bytes.is_empty() {
        return Err(Fault::Empty);
    }
    let unsupported = UNSUPPORTED
        .iter()
        .find(|(start, magic, _)| bytes.get(*start..).is_some_and(|rest| rest.starts_with(magic)));
    if let Some(name) = unsupported.map(|(.., name)| *name).or_else(|| boxed(bytes)) {
        return Err(Fault::Unsupported(name));
    }
    use ImageFormat::{Bmp, Gif, Jpeg, Png, Tiff, WebP};
    match image::guess_format(bytes) {
        Ok(Tiff) if is_raw(bytes) => Err(Fault::Unsupported("camera RAW")),
        Ok(format @ (Jpeg | Png | WebP | Gif | Bmp | Tiff)) => Ok(format),
        _ => Err(Fault::NotAPicture),
    }
}

/// Whether a TIFF is a camera's RAW in TIFF's clothes (DNG, NEF, ARW …): its first picture is marked as a preview, or it has a
/// DNG version.
fn is_raw(bytes: &[u8]) -> bool {
    const NEW_SUBFILE_TYPE: u32 = 254;
    const DNG_VERSION: u32 = 50_706;
    let big = bytes.starts_with(b"MM");
    let number = |start: usize, len: usize| -> Option<u32> {
        let bytes = bytes.get(start..start.checked_add(len)?)?;
        let join = |sum: u32, byte: &u8| sum << 8 | u32::from(*byte);
        Some(if big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) })
    };
    let Some(directory) = number(4, 4).map(|start| start as usize) else { return false };
    let entries = number(directory, 2).unwrap_or(0) as usize;
    (0..entries).any(|i| {
        let entry = directory.saturating_add(2 + 12 * i);
        match number(entry, 2) {
            Some(DNG_VERSION) => true,
            Some(NEW_SUBFILE_TYPE) => number(entry.saturating_add(8), 4).is_some_and(|kind| kind & 1 == 1),
            _ => false,
        }
    })
}

/// What the markers of a JPEG tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct JpegOutline {
    /// Its end is there. Decoders paint what is missing grey and do not complain.
    pub(super) whole: bool,
    /// It is progressive, so that its decoder holds all coefficients in memory.
    pub(super) progressive: bool,
}

impl JpegOutline {
    /// Follows the markers from the start to the end of the picture; previews inside of segments and whatever follows the
    /// end do not count.
    pub(super) fn new(bytes: &[u8]) -> Self {
        const START_OF_FRAME_PROGRESSIVE: u8 = 0xc2;
        const END: u8 = 0xd9;
        let mut outline = Self { whole: false, progressive: false };
        let mut rest = bytes.get(2..).unwrap_or(&[]);
        while let Some(marker) = next_marker(&mut rest) {
            match marker {
                END => {
                    outline.whole = true;
                    break;
                }
                0x00 | 0x01 | 0xd0..=0xd8 => continue,
                START_OF_FRAME_PROGRESSIVE => outline.progressive = true,
                _ => {}
            }
            let len = rest.first_chunk().map_or(0, |&len| usize::from(u16::from_be_bytes(len)));
            rest = rest.get(len..).unwrap_or(&[]);
        }
        outline
    }
}

/// Skips to the next marker, which is a byte after one or more of 255, and takes it.
fn next_marker(rest: &mut &[u8]) -> Option<u8> {
    let start = rest.iter().position(|&byte| byte == 0xff)?;
    let len = rest[start..].iter().position(|&byte| byte != 0xff)?;
    let (marker, after) = rest[start + len..].split_first()?;
    *rest = after;
    Some(*marker)
}
