//! A labelling as a picture for people.

use super::{Grid, Labelling};
use crate::{
    appearance::view::place,
    footage::Footage,
    patch::{SIDE, STRIDE},
};
use image::RgbImage;
use std::{collections::BTreeMap, io};

/// The picture put together of the means of the chosen patches, where there is fluid: each shows its middle, so that borders are seen as
/// they are. Reads each video's mean once.
pub fn assignment(picture: &RgbImage, labelling: &Labelling, footage: &dyn Footage) -> io::Result<RgbImage> {
    let mut means = BTreeMap::new();
    for patch in labelling.patches.iter().flatten() {
        if let std::collections::btree_map::Entry::Vacant(entry) = means.entry(patch.video) {
            entry.insert(footage.mean(patch.video)?);
        }
    }
    let mut out = picture.clone();
    for (x, y, pixel) in out.enumerate_pixels_mut() {
        let number = owner(labelling.grid, x as usize, y as usize);
        let Some(patch) = labelling.patches[number] else { continue };
        let mean = &means[&patch.video];
        let centre = |patch: usize| (patch * STRIDE) as f32 + (SIDE as f32 - 1.0) / 2.0;
        let dx = x as f32 - centre(number % labelling.grid.columns);
        let dy = y as f32 - centre(number / labelling.grid.columns);
        let (left, top) = (f32::from(patch.x) + dx, f32::from(patch.y) + dy);
        let (left, top) = place(patch.version, left, top, mean.width() as usize, mean.height() as usize);
        let nearest = |place: f32, length: u32| (place.round().max(0.0) as u32).min(length - 1);
        *pixel = *mean.get_pixel(nearest(left, mean.width()), nearest(top, mean.height()));
    }
    Ok(out)
}

/// The patch whose middle is nearest.
fn owner(grid: Grid, x: usize, y: usize) -> usize {
    let nearest =
        |place: usize, patches: usize| (place.saturating_sub((SIDE - STRIDE) / 2) / STRIDE).min(patches - 1);
    nearest(y, grid.rows) * grid.columns + nearest(x, grid.columns)
}
