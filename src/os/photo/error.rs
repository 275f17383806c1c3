//! What can be wrong with a photo, in words for people.

use crate::{
    effect::fluid::ClipError,
    frame::{Layout, Size, resample},
};
use std::{error::Error, fmt, io};

/// A photo, mask or folder that cannot be used. One line says which, what is wrong and the cure; the cause as a library or
/// the system tells it is the [`Error::source`].
#[derive(Debug)]
pub struct PhotoError {
    /// The name of the file.
    pub name: String,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a photo.
#[derive(Debug)]
#[non_exhaustive]
pub enum Fault {
    /// There is no such file or folder.
    Missing,
    /// The system does not let this user read it.
    Forbidden(io::Error),
    /// It is a link that leads to itself.
    LinkLoop(io::Error),
    /// It is no regular file but, say, a folder.
    NotAFile(&'static str),
    /// The system could not read it.
    Read(io::Error),
    /// It holds nothing.
    Empty,
    /// It is in a format that is known by name only.
    Unsupported(&'static str),
    /// It is in no picture format that is known.
    NotAPicture,
    /// Its header says that it has no pixels.
    NoPixels,
    /// It has more pixels than the limit.
    TooManyPixels {
        /// Its size.
        size: Size,
        /// The most pixels that are taken.
        limit: u64,
    },
    /// A side is longer than can be resampled.
    SideTooLong(Size),
    /// Decoding it takes more memory than the limit, or than there is.
    TooMuchMemory {
        /// Bytes that it takes, as far as is known beforehand.
        needed: u64,
        /// The most bytes that may be taken.
        limit: u64,
    },
    /// It ends before its picture does.
    Cut,
    /// Its content is damaged.
    Damaged(image::ImageError),
    /// Its content is damaged such that a decoder gave up in disorder.
    Broken,
    /// It uses a feature of its format that the decoder does not know.
    Feature(image::ImageError),
    /// It is a clip, and damaged or none that can be.
    Clip(ClipError),
    /// The panel has an impossible size.
    PanelSize(Size),
}

impl PhotoError {
    pub(in crate::os) fn new(name: &str, fault: Fault) -> Self {
        // A line stays one line, whatever the name of the file.
        Self { name: name.replace(char::is_control, "\u{fffd}"), fault }
    }
}

impl fmt::Display for PhotoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.fault)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MEBIBYTE: u64 = 1 << 20;
        match self {
            Self::Missing => f.write_str("there is no such file or folder: check the name"),
            Self::Forbidden(_) => f.write_str("may not be read: give this user the right to (chmod a+r)"),
            Self::LinkLoop(_) => f.write_str("is a link that leads to itself: remove it"),
            Self::NotAFile(what) => write!(f, "is {what}, not a photo: name a file"),
            Self::Read(_) => f.write_str("cannot be read: check the disk or card, or copy the file again"),
            Self::Empty => f.write_str("is empty: copy it again"),
            Self::Unsupported(format) => write!(f, "{format} is not supported: convert it to JPEG"),
            Self::NotAPicture => {
                f.write_str("is not a picture: give a JPEG, PNG, WebP, GIF, BMP or TIFF file")
            }
            Self::NoPixels => f.write_str("has a width or height of zero: export it again"),
            Self::TooManyPixels { size, limit } => {
                let millions = *limit as f64 / 1e6;
                write!(f, "has {size} pixels, more than the limit of {millions} million: make it smaller")
            }
            Self::SideTooLong(size) => {
                write!(f, "has {size} pixels, a side over {}: make it smaller", resample::MAX_SIDE)
            }
            Self::TooMuchMemory { needed, limit } => write!(
                f,
                "takes {} MiB of memory, and {} MiB are allowed: make it smaller",
                needed.div_ceil(MEBIBYTE),
                limit / MEBIBYTE
            ),
            Self::Cut => f.write_str("is cut short: copy it again, whole"),
            Self::Damaged(_) | Self::Broken => f.write_str("is damaged: copy it again, or export it again"),
            Self::Feature(_) => f.write_str(
                "uses a rare feature of its format that is not supported: export it as JPEG or PNG",
            ),
            Self::Clip(error) => error.fmt(f),
            Self::PanelSize(size) => {
                write!(f, "cannot be shown on {size} pixels: each side must be 1 to {}", Layout::MAX_SIDE)
            }
        }
    }
}

impl Error for PhotoError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match &self.fault {
            Fault::Forbidden(cause) | Fault::LinkLoop(cause) | Fault::Read(cause) => Some(cause),
            Fault::Damaged(cause) | Fault::Feature(cause) => Some(cause),
            Fault::Clip(cause) => Some(cause),
            _ => None,
        }
    }
}
