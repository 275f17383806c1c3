//! Coded pictures as files: `.yfc`.
//!
//! ```text
//!  0  "YFC"       3 bytes
//!  3  version     1
//!  4  width       2   of the picture, in pixels; all numbers are little-endian
//!  6  height      2
//!  8  leaves      4   how many
//! 12  body        4   how many bytes
//! 16  checksum    4   CRC-32 (IEEE 802.3) of bytes 0..16 and the body
//! 20  body
//! ```
//!
//! The body is a stream of bits, the most significant first: blocks of 16 × 16 row by row, each a tree. A square of more than 4 × 4 has a bit
//! that says whether it is cut in four. One that is not has a leaf: brightness (7 bits), contrast + 15 (5 bits) and, if the
//! contrast is not 0, one bit that says whether the domain is the concentric one, else its isometry (3 bits), column and row (as many bits as the
//! largest takes). The last byte is filled up with zeros.
//!
//! A file is checked whole, to its last bit, before anything is lent to it: [`Checked`] tells what it takes.

use super::{Code, LARGEST, LONGEST_SIDE, Leaf, SMALLEST, block::STEEPEST, most_leaves, plane_size};
use crate::{effect::checksum::checksum, frame::Size};
use core::fmt;

/// The first bytes of a file of this version.
const MAGIC: [u8; 4] = *b"YFC\x01";
const HEADER: usize = 20;

/// The most bits of a leaf, with its share of the bits that cut: at the most one for each leaf but the largest, and one more.
const MOST_LEAF_BITS: usize = 2 + 7 + 5 + 1 + 3 + 2 * 14;

/// The most bytes of the file of a picture of `size`.
pub const fn most_bytes(size: Size) -> usize {
    HEADER + (most_leaves(plane_size(size, (0, 0))) * MOST_LEAF_BITS).div_ceil(8)
}

/// Why a file is no coded picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileError {
    /// It begins otherwise.
    NotCoded,
    /// Another version than 1.
    Version(u8),
    /// It ends before its header says.
    Cut,
    /// It goes on after its header says.
    Longer,
    /// The checksum is that of other bytes.
    Checksum,
    /// A picture without pixels, or one with a side of more than 16,384.
    Size(Size),
    /// The number of leaves is none that such a picture has.
    Leaves(u32),
    /// A leaf of the body has a contrast or a domain that it cannot have, or the body has fewer or more leaves than the header says.
    Body,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCoded => write!(f, "this is no .yfc file; `yurameki encode` makes one of a photo"),
            Self::Version(version) => {
                write!(
                    f,
                    "this .yfc file has version {version}, and this program reads version 1; encode the photo again"
                )
            }
            Self::Cut => write!(f, "the .yfc file is cut short; copy it again"),
            Self::Longer => write!(f, "the .yfc file goes on after its end; copy it again"),
            Self::Checksum => write!(f, "the .yfc file is damaged: its checksum is wrong; copy it again"),
            Self::Size(size) => {
                write!(f, "the .yfc file claims {size} pixels; 1 to 16384 a side can be read")
            }
            Self::Leaves(count) => {
                write!(f, "the .yfc file claims {count} ranges, which no picture of its size has")
            }
            Self::Body => write!(f, "the .yfc file describes a range that cannot be; encode the photo again"),
        }
    }
}

impl core::error::Error for FileError {}

/// A file that was checked: reading it cannot fail.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a> {
    size: Size,
    leaves: usize,
    body: &'a [u8],
}

impl<'a> Checked<'a> {
    /// Checks a whole file; takes no memory.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    pub fn new(bytes: &'a [u8]) -> Result<Self, FileError> {
        let magic = bytes.get(..4).ok_or(FileError::NotCoded)?;
        if magic[..3] != MAGIC[..3] {
            return Err(FileError::NotCoded);
        }
        if magic[3] != MAGIC[3] {
            return Err(FileError::Version(magic[3]));
        }
        let (header, body) = bytes.split_at_checked(HEADER).ok_or(FileError::Cut)?;
        let two = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]).into();
        let four = |at: usize| u32::from_le_bytes(core::array::from_fn(|i| header[at + i]));
        let (size, leaves, length) = (Size::new(two(4), two(6)), four(8), four(12) as usize);
        if body.len() != length {
            return Err(if body.len() < length { FileError::Cut } else { FileError::Longer });
        }
        if checksum(&[&header[..16], body]) != four(16) {
            return Err(FileError::Checksum);
        }
        let sides = 1..=LONGEST_SIDE - 2 * LARGEST as u32;
        if !sides.contains(&size.width) || !sides.contains(&size.height) {
            return Err(FileError::Size(size));
        }
        let most = most_leaves(plane_size(size, (0, 0)));
        if !(most / 16..=most).contains(&(leaves as usize)) {
            return Err(FileError::Leaves(leaves));
        }
        let checked = Self { size, leaves: leaves as usize, body };
        let mut found = 0;
        checked.walk(|_| found += 1).filter(|()| found == checked.leaves).ok_or(FileError::Body)?;
        Ok(checked)
    }

    /// The size of the picture.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// How many leaves it has.
    pub const fn leaves(&self) -> usize {
        self.leaves
    }

    /// Reads the code into `leaves`.
    ///
    /// # Panics
    /// If `leaves` holds fewer than [`Self::leaves`].
    pub fn read<'l>(&self, leaves: &'l mut [Leaf]) -> Code<'l> {
        let mut places = leaves[..self.leaves].iter_mut();
        self.walk(|leaf| {
            if let Some(place) = places.next() {
                *place = leaf;
            }
        });
        Code { plane: plane_size(self.size, (0, 0)), leaves: &leaves[..self.leaves] }
    }

    /// Tells all leaves; `None` at the first that cannot be, and if there is more, or less, than them.
    fn walk(&self, mut leaf: impl FnMut(Leaf)) -> Option<()> {
        let mut bits = Reader { bytes: self.body, at: 0 };
        let plane = plane_size(self.size, (0, 0));
        for y in (0..plane.height).step_by(LARGEST) {
            for x in (0..plane.width).step_by(LARGEST) {
                bits.tree(x as u16, y as u16, LARGEST as u8, plane, &mut leaf)?;
            }
        }
        bits.ends().then_some(())
    }
}

/// Writes the `code` of a picture of `size` into `file`, which holds [`most_bytes`], and tells how many bytes it takes.
///
/// # Panics
/// If `file` is too short, or the code is that of a plane of another size.
pub fn write(code: &Code<'_>, size: Size, file: &mut [u8]) -> usize {
    assert_eq!(code.plane, plane_size(size, (0, 0)), "the code is one of another size");
    let (header, body) = file.split_at_mut(HEADER);
    body.fill(0);
    let mut bits = Writer { bytes: body, at: 0 };
    for leaf in code.leaves {
        bits.cuts(*leaf);
        bits.leaf(*leaf, code.plane);
    }
    let length = bits.at.div_ceil(8);
    header[..4].copy_from_slice(&MAGIC);
    header[4..6].copy_from_slice(&(size.width as u16).to_le_bytes());
    header[6..8].copy_from_slice(&(size.height as u16).to_le_bytes());
    header[8..12].copy_from_slice(&(code.leaves.len() as u32).to_le_bytes());
    seal(&mut file[..HEADER + length]);
    HEADER + length
}

/// Gives `file` the length of its body and its checksum, whatever else it is; one without room for a header stays as it is.
pub fn seal(file: &mut [u8]) {
    let Some((header, body)) = file.split_at_mut_checked(HEADER) else { return };
    header[12..16].copy_from_slice(&(body.len() as u32).to_le_bytes());
    let sum = checksum(&[&header[..16], body]);
    header[16..20].copy_from_slice(&sum.to_le_bytes());
}

/// Bits that a place in the contracted plane takes.
const fn place_bits(length: u32, side: u8) -> u32 {
    u32::BITS - (length / 2 - side as u32).leading_zeros()
}

struct Writer<'a> {
    bytes: &'a mut [u8],
    /// In bits.
    at: usize,
}

impl Writer<'_> {
    fn put(&mut self, value: u32, count: u32) {
        for bit in (0..count).rev() {
            self.bytes[self.at / 8] |= ((value >> bit & 1) as u8) << (7 - self.at % 8);
            self.at += 1;
        }
    }

    /// The bits of the squares that begin where `leaf` does: larger ones are cut, its own is not.
    fn cuts(&mut self, leaf: Leaf) {
        let begins = |side: u16| leaf.x.is_multiple_of(side) && leaf.y.is_multiple_of(side);
        for side in [16_u8, 8] {
            if side > leaf.side && begins(side.into()) {
                self.put(1, 1);
            } else if side == leaf.side {
                self.put(0, 1);
            }
        }
    }

    fn leaf(&mut self, leaf: Leaf, plane: Size) {
        self.put(leaf.brightness.into(), 7);
        self.put((i32::from(leaf.contrast) + STEEPEST as i32) as u32, 5);
        if leaf.contrast == 0 {
            return;
        }
        self.put(leaf.is_concentric(plane).into(), 1);
        if !leaf.is_concentric(plane) {
            self.put(leaf.isometry.into(), 3);
            self.put(leaf.domain_x.into(), place_bits(plane.width, leaf.side));
            self.put(leaf.domain_y.into(), place_bits(plane.height, leaf.side));
        }
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    /// In bits.
    at: usize,
}

impl Reader<'_> {
    fn take(&mut self, count: u32) -> Option<u32> {
        let mut value = 0;
        for _ in 0..count {
            let byte = self.bytes.get(self.at / 8)?;
            value = value << 1 | u32::from(byte >> (7 - self.at % 8) & 1);
            self.at += 1;
        }
        Some(value)
    }

    /// Nothing but zeros to fill up the last byte.
    fn ends(&mut self) -> bool {
        let rest = self.bytes.len() * 8 - self.at;
        rest < 8 && self.take(rest as u32) == Some(0)
    }

    fn tree(&mut self, x: u16, y: u16, side: u8, plane: Size, leaf: &mut impl FnMut(Leaf)) -> Option<()> {
        if usize::from(side) == SMALLEST || self.take(1)? == 0 {
            leaf(self.leaf(Leaf::concentric(x, y, side, plane), plane)?);
            return Some(());
        }
        let half = u16::from(side / 2);
        for (dx, dy) in [(0, 0), (half, 0), (0, half), (half, half)] {
            self.tree(x + dx, y + dy, side / 2, plane, leaf)?;
        }
        Some(())
    }

    fn leaf(&mut self, concentric: Leaf, plane: Size) -> Option<Leaf> {
        let brightness = self.take(7)? as u8;
        let contrast = self.take(5)? as i64 - STEEPEST;
        if contrast > STEEPEST {
            return None;
        }
        let leaf = Leaf { brightness, contrast: contrast as i8, ..concentric };
        if contrast == 0 || self.take(1)? == 1 {
            return Some(leaf);
        }
        let isometry = self.take(3)? as u8;
        let mut place = |length: u32| {
            let most = length / 2 - u32::from(leaf.side);
            self.take(place_bits(length, leaf.side)).filter(|&at| at <= most).map(|at| at as u16)
        };
        let (domain_x, domain_y) = (place(plane.width)?, place(plane.height)?);
        Some(Leaf { isometry, domain_x, domain_y, ..leaf })
    }
}
