//! Clips as files: `.yfl`.
//!
//! ```text
//!  0  "YFL"        3 bytes
//!  3  version      1
//!  4  kind         1   0 luma, 1 colour
//!  5  step         1   levels in a unit of change, 1 to 4
//!  6  correlation  2   of a frame's change with that of the next, in units of 2^-15
//!  8  rate         4   frames in 1,000 seconds
//! 12  frames       4
//! 16  base         4   width and height, 2 bytes each; all numbers are little-endian
//! 20  grid         4
//! 24  rectangle    8   left, top, width, height: what of the base the grid covers
//! 32  matte        4   bytes
//! 36  picture      4   bytes
//! 40  longest      4   bytes of the longest frame
//! 44  length       8   of the file
//! 52  checksum     4   of the tint
//! 56  checksum     4   of the matte
//! 60  checksum     4   of the picture
//! 64  checksum     4   of the index
//! 68  checksum     4   of bytes 0..68
//! 72  tint       768
//!     matte            coded as [`code`](super::code) codes one plane, every column of every row
//!     picture          the base as the file of a photo
//!     frames           each coded on its own, within the extents of the matte
//!     index       16   for each frame: where it starts (8), its bytes (4), their checksum (4)
//! ```
//!
//! [`Clip::open`] reads the header and the index, which say how much memory everything takes, before any is taken; tint, matte and picture are checked
//! when they are read. Frames are checked one at a time when they are played: a clip is tens of megabytes, and from a memory card
//! checking all of it would keep the show waiting for seconds.
//!
//! The index comes last, so that a clip is written in one go, whatever the number of its frames.

use super::code;
use crate::{
    effect::checksum::{checksum, longer},
    frame::{Rect, Size},
};
use core::{fmt, ops::Range};

/// The first bytes of a file of this version.
pub const MAGIC: [u8; 4] = *b"YFL\x01";

/// Bytes of the header.
pub const HEADER: usize = 72;

/// Bytes of a frame's line in the index.
pub const ENTRY: usize = 16;

/// The longest side of a base.
pub const LONGEST_BASE: u32 = 16_384;

/// The largest grid, either way up: above it no small board plays.
pub const LARGEST_GRID: Size = Size::new(1920, 1920);

/// Frames in 1,000 seconds.
pub const RATES: core::ops::RangeInclusive<u32> = 1_000..=240_000;

/// Levels in a unit of change.
pub const STEPS: core::ops::RangeInclusive<u8> = 1..=4;

/// Frames of a clip: one is no motion, and more than these play for an hour.
pub const FRAMES: core::ops::RangeInclusive<u32> = 2..=100_000;

/// What of its base a clip changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The luma, in one plane; the [`Tint`] says what that means for the colours. For water and smoke.
    Luma,
    /// Red, green and blue, each in a plane. For fire, and wherever an outline moves over what is behind it.
    Colour,
}

impl Kind {
    /// Planes of a frame.
    pub const fn planes(self) -> usize {
        match self {
            Self::Luma => 1,
            Self::Colour => 3,
        }
    }
}

/// The measures of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// What changes.
    pub kind: Kind,
    /// Frames in 1,000 seconds, [`RATES`]: 25,000 for 25 a second.
    pub millihertz: u32,
    /// Levels (of 255) in a unit of change, [`STEPS`]. A frame's change goes up to 127 units up and down.
    pub step: u8,
    /// The size of the base picture.
    pub base: Size,
    /// The size of a frame of changes, within [`LARGEST_GRID`].
    pub grid: Size,
    /// What of the base the grid covers, in its pixels.
    pub rect: Rect,
}

impl Shape {
    /// # Errors
    /// What is out of its bounds.
    pub fn check(&self) -> Result<(), ClipError> {
        let within = |size: Size, most: Size| {
            (1..=most.width).contains(&size.width) && (1..=most.height).contains(&size.height)
        };
        let Rect { x, y, size } = self.rect;
        let right = u64::from(x) + u64::from(size.width);
        let bottom = u64::from(y) + u64::from(size.height);
        let inside = right <= u64::from(self.base.width) && bottom <= u64::from(self.base.height);
        if !within(self.base, Size::new(LONGEST_BASE, LONGEST_BASE)) {
            Err(ClipError::Base(self.base))
        } else if !within(self.grid, LARGEST_GRID) {
            Err(ClipError::Grid(self.grid))
        } else if size.width == 0 || size.height == 0 || !inside {
            Err(ClipError::Rectangle(self.rect))
        } else if !RATES.contains(&self.millihertz) {
            Err(ClipError::Rate(self.millihertz))
        } else if !STEPS.contains(&self.step) {
            Err(ClipError::Step(self.step))
        } else {
            Ok(())
        }
    }

    /// Bytes of one frame of changes.
    pub const fn values(&self) -> usize {
        self.grid.pixels() * self.kind.planes()
    }
}

/// By how much red, green and blue change for each level by which the luma does, in 64ths, where the luma of the base is 0 to 255: the slope of
/// the photo's own curve from luma to colour. The same change on all three makes grey stains on what is saturated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tint(pub [[u8; 3]; 256]);

impl Tint {
    /// The unit.
    pub const ONE: u8 = 64;

    /// All three alike.
    pub const GREY: Self = Self([[Self::ONE; 3]; 256]);
}

/// Why a file is no clip that can be played, or a clip cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipError {
    /// It begins otherwise.
    NotAClip,
    /// Another version than 1.
    Version(u8),
    /// It ends before its header says.
    Cut,
    /// It goes on after its header says.
    Longer,
    /// The checksum of a part is that of other bytes.
    Checksum(Part),
    /// A kind that there is not.
    Kind(u8),
    /// A base without pixels, or too large.
    Base(Size),
    /// A grid without pixels, or too large.
    Grid(Size),
    /// A rectangle without pixels, or beyond the base.
    Rectangle(Rect),
    /// A rate out of bounds.
    Rate(u32),
    /// A step out of bounds.
    Step(u8),
    /// Too few frames, or too many.
    Frames(u32),
    /// Parts that cannot be as long as the header says, or do not lie as the index says.
    Layout,
    /// The matte cannot be decoded.
    Matte,
    /// The base has another size than the header says.
    Picture(Size),
}

/// A part of a file that has a checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Bytes 0..72.
    Header,
    /// The tint.
    Tint,
    /// The matte.
    Matte,
    /// The base.
    Picture,
    /// The index of the frames.
    Index,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Header => "header",
            Self::Tint => "tint",
            Self::Matte => "matte",
            Self::Picture => "base picture",
            Self::Index => "index",
        })
    }
}

impl fmt::Display for ClipError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAClip => write!(f, "this is no .yfl clip"),
            Self::Version(version) => {
                write!(
                    f,
                    "this clip has version {version}, and this program plays version 1; animate the picture again"
                )
            }
            Self::Cut => write!(f, "the clip is cut short; copy it again"),
            Self::Longer => write!(f, "the clip goes on after its end; copy it again"),
            Self::Checksum(part) => {
                write!(f, "the clip is damaged: the checksum of its {part} is wrong; copy it again")
            }
            Self::Kind(kind) => {
                write!(f, "the clip is of kind {kind}, and there are 0 (luma) and 1 (colour)")
            }
            Self::Base(size) => {
                write!(f, "the clip claims a base of {size} pixels; 1 to {LONGEST_BASE} a side can be")
            }
            Self::Grid(size) => {
                write!(f, "the clip claims frames of {size} pixels; up to {LARGEST_GRID} can be played")
            }
            Self::Rectangle(Rect { x, y, size }) => {
                write!(f, "the clip moves {size} pixels from {x}, {y} on, which is not within its base")
            }
            Self::Rate(rate) => {
                write!(f, "the clip claims {rate} frames in 1000 seconds; 1000 to 240000 can be")
            }
            Self::Step(step) => write!(f, "the clip has steps of {step} levels; 1 to 4 can be"),
            Self::Frames(count) => write!(f, "the clip has {count} frames; 2 to 100000 can be"),
            Self::Layout => {
                write!(f, "the parts of the clip are not where they can be; animate the picture again")
            }
            Self::Picture(size) => {
                write!(
                    f,
                    "the base of the clip has {size} pixels, which its header denies; animate the picture again"
                )
            }
            Self::Matte => write!(f, "the clip has a matte that cannot be; animate the picture again"),
        }
    }
}

impl core::error::Error for ClipError {}

/// Where the bytes of a clip come from.
///
/// Not a slice, though a file could be mapped: a mapped file that is cut, or whose disk is pulled out, while it is played ends the
/// program by a signal. Bytes that are read are there or are not, and the copy of a frame takes some microseconds.
pub trait Source {
    /// How many bytes there are.
    fn len(&self) -> u64;

    /// Fills `into` with the bytes from `at` on; `false` if they are not there.
    fn read(&self, at: u64, into: &mut [u8]) -> bool;

    /// Is told that frame number `frame` is damaged. Logs it, for one.
    fn damaged(&self, frame: u32);
}

impl Source for &[u8] {
    fn len(&self) -> u64 {
        <[u8]>::len(self) as u64
    }

    fn read(&self, at: u64, into: &mut [u8]) -> bool {
        let from = usize::try_from(at).ok().and_then(|at| self.get(at..)?.get(..into.len()));
        from.map(|from| into.copy_from_slice(from)).is_some()
    }

    fn damaged(&self, frame: u32) {
        log::warn!("frame {frame} of the clip is damaged; the one before it stays");
    }
}

/// What the header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The measures.
    pub shape: Shape,
    /// The correlation of the change of a frame with that of the next, 0..2^15.
    pub correlation: u16,
    /// How many frames.
    pub frames: u32,
    /// Bytes of the matte.
    pub matte: u32,
    /// Bytes of the picture.
    pub picture: u32,
    /// Bytes of the longest frame.
    pub longest: u32,
    /// Bytes of the file.
    pub length: u64,
    /// Checksums of the tint, the matte, the picture and the index.
    pub checksums: [u32; 4],
}

impl Header {
    /// The bytes of the header.
    pub fn write(&self) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        let mut rest = &mut bytes[..];
        let mut put = |part: &[u8]| {
            if let Some(place) = rest.split_off_mut(..part.len()) {
                place.copy_from_slice(part);
            }
        };
        let Shape { kind, millihertz, step, base, grid, rect } = self.shape;
        put(&MAGIC);
        put(&[matches!(kind, Kind::Colour).into(), step]);
        put(&self.correlation.to_le_bytes());
        put(&millihertz.to_le_bytes());
        put(&self.frames.to_le_bytes());
        let sides = [base.width, base.height, grid.width, grid.height];
        for side in sides.into_iter().chain([rect.x, rect.y, rect.size.width, rect.size.height]) {
            put(&(side as u16).to_le_bytes());
        }
        for length in [self.matte, self.picture, self.longest] {
            put(&length.to_le_bytes());
        }
        put(&self.length.to_le_bytes());
        for sum in self.checksums {
            put(&sum.to_le_bytes());
        }
        seal(&mut bytes);
        bytes
    }

    /// Reads a header that belongs to a file of `length` bytes.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(bytes: &[u8; HEADER], length: u64) -> Result<Self, ClipError> {
        if bytes[..3] != MAGIC[..3] {
            return Err(ClipError::NotAClip);
        }
        if bytes[3] != MAGIC[3] {
            return Err(ClipError::Version(bytes[3]));
        }
        if length < HEADER as u64 {
            return Err(ClipError::Cut);
        }
        let two = |at: usize| u32::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let four = |at: usize| u32::from_le_bytes(core::array::from_fn(|i| bytes[at + i]));
        if checksum(&[&bytes[..68]]) != four(68) {
            return Err(ClipError::Checksum(Part::Header));
        }
        let kind = match bytes[4] {
            0 => Kind::Luma,
            1 => Kind::Colour,
            other => return Err(ClipError::Kind(other)),
        };
        let size = |at: usize| Size::new(two(at), two(at + 2));
        let rect = Rect { x: two(24), y: two(26), size: size(28) };
        let shape = Shape { kind, millihertz: four(8), step: bytes[5], base: size(16), grid: size(20), rect };
        let header = Self {
            shape,
            correlation: two(6) as u16,
            frames: four(12),
            matte: four(32),
            picture: four(36),
            longest: four(40),
            length: u64::from(four(44)) | u64::from(four(48)) << 32,
            checksums: [four(52), four(56), four(60), four(64)],
        };
        header.check()?;
        match length.cmp(&header.length) {
            core::cmp::Ordering::Less => Err(ClipError::Cut),
            core::cmp::Ordering::Greater => Err(ClipError::Longer),
            core::cmp::Ordering::Equal => Ok(header),
        }
    }

    fn check(&self) -> Result<(), ClipError> {
        self.shape.check()?;
        if !FRAMES.contains(&self.frames) {
            return Err(ClipError::Frames(self.frames));
        }
        let matte_fits = self.matte as usize <= code::most_bytes(self.shape.grid.pixels());
        let frames_fit = self.longest as usize <= code::most_bytes(self.shape.values());
        let ends = self.index().end == self.length;
        let correlated = self.correlation <= 1 << 15;
        if matte_fits && frames_fit && ends && correlated { Ok(()) } else { Err(ClipError::Layout) }
    }

    /// Where the tint lies.
    pub const fn tint_place(&self) -> Range<u64> {
        HEADER as u64..HEADER as u64 + 768
    }

    /// Where the matte lies.
    pub const fn matte_place(&self) -> Range<u64> {
        let start = self.tint_place().end;
        start..start + self.matte as u64
    }

    /// Where the picture lies.
    pub const fn picture_place(&self) -> Range<u64> {
        let start = self.matte_place().end;
        start..start + self.picture as u64
    }

    /// Where the index lies: at the end, at the earliest behind the picture.
    fn index(&self) -> Range<u64> {
        let bytes = u64::from(self.frames) * ENTRY as u64;
        let start = self.length.saturating_sub(bytes).max(self.picture_place().end);
        start..start + bytes
    }
}

/// Gives a header its checksum, whatever else it is; what is shorter stays as it is.
pub fn seal(header: &mut [u8]) {
    if header.len() >= HEADER {
        let sum = checksum(&[&header[..68]]);
        header[68..HEADER].copy_from_slice(&sum.to_le_bytes());
    }
}

/// A frame's line in the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Where the frame starts in the file.
    pub start: u64,
    /// Its bytes.
    pub length: u32,
    /// Their checksum.
    pub checksum: u32,
}

impl Entry {
    /// The line of a frame of `bytes` that starts at `start`.
    pub fn of(start: u64, bytes: &[u8]) -> Self {
        Self { start, length: bytes.len() as u32, checksum: checksum(&[bytes]) }
    }

    /// The bytes of the line.
    pub fn write(&self) -> [u8; ENTRY] {
        let mut bytes = [0; ENTRY];
        bytes[..8].copy_from_slice(&self.start.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.length.to_le_bytes());
        bytes[12..].copy_from_slice(&self.checksum.to_le_bytes());
        bytes
    }

    fn read(bytes: &[u8; ENTRY]) -> Self {
        let word = u128::from_le_bytes(*bytes);
        Self { start: word as u64, length: (word >> 64) as u32, checksum: (word >> 96) as u32 }
    }
}

/// The checksum of a part, for a [`Header`].
pub fn part_checksum(bytes: &[u8]) -> u32 {
    checksum(&[bytes])
}

/// Lines of the index that are checked at a time.
const LINES: usize = 64;

/// A clip whose header and index are good.
#[derive(Clone, Debug)]
pub struct Clip<C> {
    header: Header,
    source: C,
}

impl<C: Source> Clip<C> {
    /// Checks the header and the index of a clip; takes no memory.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn open(source: C) -> Result<Self, ClipError> {
        let mut start = [0; HEADER];
        let there = source.len().min(HEADER as u64) as usize;
        if !source.read(0, &mut start[..there]) {
            return Err(ClipError::Cut);
        }
        let clip = Self { header: Header::read(&start, source.len())?, source };
        clip.check_index()?;
        Ok(clip)
    }

    fn check_index(&self) -> Result<(), ClipError> {
        let index = self.header.index();
        let mut lines = [0; LINES * ENTRY];
        let (mut at, mut sum, mut behind) = (index.start, 0, self.header.picture_place().end);
        let mut good = true;
        while at < index.end {
            let bytes = &mut lines[..(index.end - at).min((LINES * ENTRY) as u64) as usize];
            if !self.source.read(at, bytes) {
                return Err(ClipError::Cut);
            }
            at += bytes.len() as u64;
            sum = longer(sum, bytes);
            for entry in bytes.as_chunks::<ENTRY>().0.iter().map(Entry::read) {
                good &= entry.start == behind && entry.length <= self.header.longest;
                behind = behind.wrapping_add(entry.length.into());
            }
        }
        if sum != self.header.checksums[3] {
            return Err(ClipError::Checksum(Part::Index));
        }
        if good && behind == index.start { Ok(()) } else { Err(ClipError::Layout) }
    }

    /// What the header says.
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// Where the bytes come from.
    pub const fn source(&self) -> &C {
        &self.source
    }

    /// Reads the picture, the file of a photo, into `bytes`, which are as many as it has.
    ///
    /// # Errors
    /// If they are not there, or damaged.
    ///
    /// # Panics
    /// If `bytes` has another length.
    pub fn read_picture(&self, bytes: &mut [u8]) -> Result<(), ClipError> {
        self.read_part(self.header.picture_place(), Part::Picture, 2, bytes)
    }

    /// Reads the matte into `matte`, a byte a pixel of the grid. `packed` and `residuals` are scratch memory: the bytes of the matte, and a
    /// byte a pixel; `extents` one for each row.
    pub(super) fn read_matte(
        &self,
        packed: &mut [u8],
        residuals: &mut [u8],
        extents: &mut [code::Extent],
        matte: &mut [i8],
    ) -> Result<(), ClipError> {
        let grid = self.header.shape.grid;
        let packed = &mut packed[..self.header.matte as usize];
        self.read_part(self.header.matte_place(), Part::Matte, 1, packed)?;
        extents.fill(code::Extent { start: 0, end: grid.width as u16 });
        let planes = code::Planes { width: grid.width as usize, extents, count: 1 };
        code::decode(&planes, packed, residuals, matte).ok_or(ClipError::Matte)
    }

    pub(super) fn read_tint(&self) -> Result<Tint, ClipError> {
        let mut tint = Tint::GREY;
        self.read_part(self.header.tint_place(), Part::Tint, 0, tint.0.as_flattened_mut())?;
        Ok(tint)
    }

    fn read_part(
        &self,
        place: Range<u64>,
        part: Part,
        sum: usize,
        bytes: &mut [u8],
    ) -> Result<(), ClipError> {
        assert_eq!(bytes.len() as u64, place.end - place.start, "the {part} has another length");
        if !self.source.read(place.start, bytes) {
            return Err(ClipError::Cut);
        }
        let good = checksum(&[bytes]) == self.header.checksums[sum];
        if good { Ok(()) } else { Err(ClipError::Checksum(part)) }
    }

    /// Reads frame number `frame` into the start of `packed`, which holds the longest; `None` if it is not there, or damaged.
    pub(super) fn read_frame<'p>(&self, frame: u32, packed: &'p mut [u8]) -> Option<&'p [u8]> {
        let mut line = [0; ENTRY];
        let at = self.header.index().start + u64::from(frame) * ENTRY as u64;
        if !self.source.read(at, &mut line) {
            return None;
        }
        // The file may have changed since it was opened.
        let entry = Entry::read(&line);
        let packed = packed.get_mut(..entry.length as usize)?;
        let there = self.source.read(entry.start, packed);
        (there && checksum(&[packed]) == entry.checksum).then_some(&*packed)
    }
}
