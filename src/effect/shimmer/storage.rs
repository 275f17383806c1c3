//! The planes of a prepared photo, carved out of lent memory.

use super::{
    super::{Photo, StorageTooSmall},
    spans::{self, Span},
};
use crate::frame::Size;
use bytemuck::Pod;

/// The x and the y of a slope in the frame of the light: `u` towards the light, `v` across.
#[derive(Debug)]
pub(super) struct Slopes<'a> {
    pub(super) u: &'a mut [i16],
    pub(super) v: &'a mut [i16],
}

/// What is kept of a photo: 18 bytes a pixel, and the spans.
#[derive(Debug)]
pub(super) struct Planes<'a> {
    pub(super) size: Size,
    pub(super) red: &'a mut [u8],
    pub(super) green: &'a mut [u8],
    pub(super) blue: &'a mut [u8],
    pub(super) mask: &'a mut [u8],
    /// ∇P, what sin θ multiplies, Q14.
    pub(super) sine: Slopes<'a>,
    /// ∇Q, what cos θ multiplies, Q14.
    pub(super) cosine: Slopes<'a>,
    /// ∇C, Q14.
    pub(super) centre: Slopes<'a>,
    /// S̄, the mean shade over a cycle, Q14. Holds the luma while the photo is prepared.
    pub(super) mean_shade: &'a mut [i16],
    /// The spans of row y, of which there are at most `spans::most(width)`.
    pub(super) spans: &'a mut [Span],
    /// Scratch of preparation: [`SCRATCH_ROWS`] rows, or columns where they are longer.
    pub(super) scratch: &'a mut [i32],
}

/// Rows of i32 that preparation needs besides the planes.
const SCRATCH_ROWS: usize = 3;

/// Words of 64 bits that [`super::Shimmer::prepare`] needs for a photo of `size`: 18 bytes a pixel, 1/8 byte a pixel for the
/// spans of what moves, and three rows of scratch.
pub const fn storage_len(size: Size) -> usize {
    let pixels = size.pixels();
    let bytes = words::<u8>(pixels) * 4 + words::<i16>(pixels) * 7;
    bytes + words::<Span>(spans::most(size.width) * size.height as usize) + words::<i32>(scratch_len(size))
}

const fn scratch_len(size: Size) -> usize {
    let side = if size.width > size.height { size.width } else { size.height };
    SCRATCH_ROWS * side as usize
}

const fn words<T>(count: usize) -> usize {
    (count * size_of::<T>()).div_ceil(8)
}

fn take<'a, T: Pod>(memory: &mut &'a mut [u64], count: usize) -> Option<&'a mut [T]> {
    let taken = memory.split_off_mut(..words::<T>(count))?;
    bytemuck::cast_slice_mut(taken).get_mut(..count)
}

impl<'a> Planes<'a> {
    pub(super) fn carve(size: Size, storage: &'a mut [u64]) -> Result<Self, StorageTooSmall> {
        let error = StorageTooSmall { needed: storage_len(size), got: storage.len() };
        Self::try_carve(size, storage).ok_or(error)
    }

    fn try_carve(size: Size, mut memory: &'a mut [u64]) -> Option<Self> {
        let pixels = size.pixels();
        let memory = &mut memory;
        let slopes = |memory: &mut _| Some(Slopes { u: take(memory, pixels)?, v: take(memory, pixels)? });
        Some(Self {
            size,
            red: take(memory, pixels)?,
            green: take(memory, pixels)?,
            blue: take(memory, pixels)?,
            mask: take(memory, pixels)?,
            sine: slopes(memory)?,
            cosine: slopes(memory)?,
            centre: slopes(memory)?,
            mean_shade: take(memory, pixels)?,
            spans: take(memory, spans::most(size.width) * size.height as usize)?,
            scratch: take(memory, scratch_len(size))?,
        })
    }

    /// Takes over the photo's colours and mask, and finds the spans of what moves.
    pub(super) fn fill_photo(&mut self, photo: Photo<'_>) {
        assert_eq!(photo.rgb.len(), photo.size.pixels() * 3, "the photo's colours do not have its size");
        self.mask.copy_from_slice(photo.mask);
        for (i, &[r, g, b]) in photo.rgb.as_chunks().0.iter().enumerate() {
            (self.red[i], self.green[i], self.blue[i]) = (r, g, b);
        }
        let width = photo.size.width as usize;
        let rows = self.spans.chunks_exact_mut(spans::most(photo.size.width));
        for (spans, mask) in rows.zip(self.mask.chunks_exact(width)) {
            spans::find(mask, spans);
        }
    }
}
