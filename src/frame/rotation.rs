use super::{Rect, Size};
use core::{fmt, str::FromStr};

/// How far a picture is turned clockwise, for a panel that is mounted turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rotation {
    /// As it is.
    #[default]
    None,
    /// By 90° clockwise.
    Quarter,
    /// By 180°.
    Half,
    /// By 270° clockwise.
    ThreeQuarter,
}

/// The side of the squares in which pixels are moved, so that both the rows read and the rows written stay in the cache.
const TILE: u32 = 32;

impl Rotation {
    /// Every rotation, in order.
    pub const ALL: [Self; 4] = [Self::None, Self::Quarter, Self::Half, Self::ThreeQuarter];

    /// The clockwise angle in degrees.
    pub const fn degrees(self) -> u32 {
        self as u32 * 90
    }

    /// The rotation that undoes this one.
    #[must_use]
    pub const fn inverse(self) -> Self {
        match self {
            Self::Quarter => Self::ThreeQuarter,
            Self::ThreeQuarter => Self::Quarter,
            same => same,
        }
    }

    /// The size of a picture of `size` once it is turned.
    #[must_use]
    pub const fn turned(self, size: Size) -> Size {
        match self {
            Self::None | Self::Half => size,
            Self::Quarter | Self::ThreeQuarter => size.transposed(),
        }
    }

    /// Where `rect` of a picture of `size` lies once the picture is turned.
    #[must_use]
    pub const fn turned_rect(self, rect: Rect, size: Size) -> Rect {
        let Rect { x, y, size: Size { width, height } } = rect;
        let (right, below) = (size.width - x - width, size.height - y - height);
        let (x, y) = match self {
            Self::None => (x, y),
            Self::Quarter => (below, x),
            Self::Half => (right, below),
            Self::ThreeQuarter => (y, right),
        };
        Rect { x, y, size: self.turned(rect.size) }
    }

    /// Where the pixel at (x, y) of a picture of `size` lies once the picture is turned, row by row.
    #[must_use]
    pub const fn turned_place(self, (x, y): (usize, usize), size: Size) -> usize {
        let (width, height) = (size.width as usize, size.height as usize);
        match self {
            Self::None => y * width + x,
            Self::Quarter => x * height + (height - 1 - y),
            Self::Half => (height - 1 - y) * width + (width - 1 - x),
            Self::ThreeQuarter => (width - 1 - x) * height + y,
        }
    }
}

/// Turns the picture `source` of `size` pixels into `out`, whose size is [`Rotation::turned`]. Each pixel is moved once.
///
/// # Panics
/// If `source` or `out` holds fewer pixels than `size` has.
pub fn rotate<T: Copy>(rotation: Rotation, source: &[T], size: Size, out: &mut [T]) {
    let (source, out) = (&source[..size.pixels()], &mut out[..size.pixels()]);
    if rotation == Rotation::None {
        return out.copy_from_slice(source);
    }
    let width = size.width as usize;
    for top in (0..size.height).step_by(TILE as usize) {
        for left in (0..size.width).step_by(TILE as usize) {
            for y in top as usize..(top + TILE).min(size.height) as usize {
                for x in left as usize..(left + TILE).min(size.width) as usize {
                    out[rotation.turned_place((x, y), size)] = source[y * width + x];
                }
            }
        }
    }
}

impl fmt::Display for Rotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.degrees())
    }
}

/// A word that names no [`Rotation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownRotation;

impl fmt::Display for UnknownRotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown rotation; the known ones are 0, 90, 180 and 270 (degrees clockwise)")
    }
}

impl core::error::Error for UnknownRotation {}

impl FromStr for Rotation {
    type Err = UnknownRotation;

    fn from_str(word: &str) -> Result<Self, UnknownRotation> {
        let degrees: u32 = word.parse().map_err(|_| UnknownRotation)?;
        Self::ALL.into_iter().find(|r| r.degrees() == degrees).ok_or(UnknownRotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quarter_turns_clockwise() {
        let mut out = [0; 6];
        rotate(Rotation::Quarter, &[1, 2, 3, 4, 5, 6], Size::new(3, 2), &mut out);
        assert_eq!(out, [4, 1, 5, 2, 6, 3]);
    }

    #[test]
    fn a_rotation_is_read_back_as_it_is_written() {
        for rotation in Rotation::ALL {
            extern crate std;
            assert_eq!(std::format!("{rotation}").parse(), Ok(rotation));
        }
        assert_eq!("45".parse::<Rotation>(), Err(UnknownRotation));
        assert_eq!("-90".parse::<Rotation>(), Err(UnknownRotation));
    }

    proptest! {
        #[test]
        fn a_rectangle_turns_as_its_pixels_do(x in 0_u32..9, y in 0_u32..9, width in 1_u32..5, height in 1_u32..5) {
            let (size, rect) = (Size::new(13, 14), Rect { x, y, size: Size::new(width, height) });
            let holds = |rect: Rect, x: u32, y: u32| rect.columns().contains(&(x as usize)) && rect.rows().contains(&y);
            let inside: [bool; 13 * 14] = core::array::from_fn(|i| holds(rect, i as u32 % 13, i as u32 / 13));
            for rotation in Rotation::ALL {
                let mut out = [false; 13 * 14];
                rotate(rotation, &inside, size, &mut out);
                let (turned, width) = (rotation.turned_rect(rect, size), rotation.turned(size).width);
                for (i, &inside) in out.iter().enumerate() {
                    prop_assert_eq!(inside, holds(turned, i as u32 % width, i as u32 / width));
                }
            }
        }

        #[test]
        fn quarters_add_up_and_the_inverse_undoes(width in 1_u32..70, height in 1_u32..70) {
            extern crate std;
            let size = Size::new(width, height);
            let source: std::vec::Vec<usize> = (0..size.pixels()).collect();
            let turn = |rotation, pixels: &[usize], size| {
                let mut out = std::vec![0; pixels.len()];
                rotate(rotation, pixels, size, &mut out);
                out
            };
            let mut quarters = (source.clone(), size);
            for rotation in Rotation::ALL {
                let once = turn(rotation, &source, size);
                prop_assert_eq!(&once, &quarters.0);
                prop_assert_eq!(&turn(rotation.inverse(), &once, rotation.turned(size)), &source);
                quarters = (turn(Rotation::Quarter, &quarters.0, quarters.1), quarters.1.transposed());
            }
        }
    }
}
