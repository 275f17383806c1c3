//! The mask beside a photo: what moves and what stays.

use super::{
    super::once::once,
    Photo, PhotoError,
    decode::{self, Decoded},
    file,
    fit::Placement,
};
use crate::frame::resample::{resample, storage_len};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// The end of the name of every mask.
pub(super) const MASK_SUFFIX: &str = ".mask.png";

/// The mask of the photo at `photo`, if there is one: the file beside it whose name is the photo's with `.mask.png` added
/// (`lake.jpg.mask.png`), or else with `.mask.png` instead of its extension (`lake.mask.png`). Where both are there the
/// former wins, as it is meant for this very photo while the latter also serves a `lake.png`. Where neither is there it is
/// the latter, which then can be written.
pub fn mask_path(photo: &Path) -> PathBuf {
    let [longer, shorter] = mask_paths(photo);
    if longer.exists() { longer } else { shorter }
}

/// Where the mask of the photo at `photo` may be, that which goes before first.
pub(super) fn mask_paths(photo: &Path) -> [PathBuf; 2] {
    let mut longer = OsString::from(photo);
    longer.push(MASK_SUFFIX);
    [longer.into(), photo.with_extension("mask.png")]
}

/// Loads the mask at `path` for `photo`: for every pixel of the panel how much of it moves, from 0 (still) to 255.
///
/// Any picture is a mask: its brightness (Rec. 709 luma of its codes, times its opacity) counts, white moves. It covers the
/// whole photo, and is stretched over it where it has another size; what of the photo is cut off is cut off it too.
/// The border around a photo is still.
///
/// # Errors
/// As [`super::load`].
pub fn load_mask(path: &Path, photo: &Photo, limits: &super::Limits) -> Result<Vec<u8>, PhotoError> {
    let name = path.to_string_lossy();
    let bytes = file::read(path, limits.bytes).map_err(|fault| PhotoError::new(&name, fault))?;
    mask_from_bytes(&name, &bytes, photo, limits)
}

/// Loads a mask from the `bytes` of a file, as [`load_mask`] does; `name` stands for it in messages.
///
/// # Errors
/// As [`load_mask`].
pub fn mask_from_bytes(
    name: &str,
    bytes: &[u8],
    photo: &Photo,
    limits: &super::Limits,
) -> Result<Vec<u8>, PhotoError> {
    let mask = decode::decode(bytes, limits, |size| size).map_err(|fault| PhotoError::new(name, fault))?;
    let (size, source_size) = (mask.oriented_size(), photo.source_size);
    if size != source_size {
        let line = format!("{name}: a mask of {size} pixels is stretched over a photo of {source_size}");
        once(log::Level::Info, line);
    }
    Ok(spread(&mask, photo))
}

/// The mask on the panel.
fn spread(mask: &Decoded, photo: &Photo) -> Vec<u8> {
    let placement = Placement::new(photo.source_size, photo.size, photo.fit);
    let (columns, rows) = placement.axes(mask.size, mask.turn);
    let mut storage = vec![0; storage_len(columns, rows, 1)];
    let mut planes = vec![0; mask.channels() * mask.size.width as usize];
    let mut out = vec![0; photo.size.pixels()];
    let drawn = resample(
        columns,
        rows,
        1,
        &mut storage,
        |y, luma| mask.luma_row(y, &mut planes, luma),
        |y, luma| {
            for (x, &value) in (0..).zip(luma) {
                out[mask.turn.index(placement.picture, photo.size, x, y)] =
                    ((u32::from(value) + 128) / 257) as u8;
            }
        },
    );
    debug_assert_eq!(drawn, Ok(()), "the storage has the length of the formula");
    out
}
