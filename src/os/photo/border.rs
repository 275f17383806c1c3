//! The border around a photo: a blurred, darkened enlargement of itself.
//!
//! The middle of the photo, cut to the panel's shape, is shrunk to a grid of few cells, blurred there and enlarged to the
//! panel, all in linear light: the cost is that of painting the border once, whatever the strength of the blur.

use crate::frame::{
    Rect, Size,
    resample::{Axis, resample, storage_len},
    srgb,
};

/// Cells along the longer side of the grid. With three passes of (1, 2, 1) / 4 over it the blur has a standard deviation of
/// 1/40 of the panel: no shape of the photo is left, only its colours.
const CELLS: u32 = 48;
const PASSES: usize = 3;

/// How bright the border is, of 256 in linear light: dark enough that the photo stands out, bright enough to be no frame.
const BRIGHTNESS: u32 = 80;

/// Fills all of `rgb`, a panel of `size` pixels, but the photo in `picture`, which is there already.
pub(super) fn blur(rgb: &mut [u8], size: Size, picture: Rect) {
    let longer = size.width.max(size.height);
    let cells = |side: u32| (side * CELLS).div_ceil(longer).min(side);
    let grid = Size::new(cells(size.width), cells(size.height));
    let mut light = shrink(rgb, size, picture, grid);
    for _ in 0..PASSES {
        soften(&mut light, grid);
    }
    enlarge(&light, grid, rgb, size, picture);
}

/// The middle of the photo, in the shape of the panel, as darkened linear light: rows of three planes.
fn shrink(rgb: &[u8], size: Size, picture: Rect, grid: Size) -> Vec<u16> {
    let (width, height) = (u64::from(picture.size.width), u64::from(picture.size.height));
    let (photo, panel) = (width * u64::from(size.height), height * u64::from(size.width));
    let columns = Axis::centred(picture.size.width, (panel.min(photo), photo), grid.width);
    let rows = Axis::centred(picture.size.height, (photo.min(panel), panel), grid.height);
    let mut storage = vec![0; storage_len(columns, rows, 3)];
    let mut light = Vec::with_capacity(3 * grid.pixels());
    let dark = |value: &u16| (u32::from(*value) * BRIGHTNESS / 256) as u16;
    let drawn = resample(
        columns,
        rows,
        3,
        &mut storage,
        |y, planes| {
            let start = (picture.y + y) as usize * size.width as usize + picture.x as usize;
            let row = &rgb[3 * start..][..3 * picture.size.width as usize];
            for (channel, plane) in planes.chunks_exact_mut(picture.size.width as usize).enumerate() {
                let codes = row.iter().skip(channel).step_by(3);
                plane.iter_mut().zip(codes).for_each(|(out, &code)| *out = srgb::to_linear(code));
            }
        },
        |_, planes| light.extend(planes.iter().map(dark)),
    );
    debug_assert_eq!(drawn, Ok(()), "the storage has the length of the formula");
    light
}

/// One pass of (1, 2, 1) / 4 along rows and columns, edges repeated.
fn soften(light: &mut [u16], grid: Size) {
    let (width, height) = (grid.width as usize, grid.height as usize);
    for plane in light.chunks_exact_mut(width) {
        soften_line(plane, 0, 1, width);
    }
    for column in 0..3 * width {
        soften_line(light, column, 3 * width, height);
    }
}

/// One pass along `count` values that lie `step` apart.
fn soften_line(light: &mut [u16], start: usize, step: usize, count: usize) {
    let mut before = u32::from(light[start]);
    for i in 0..count {
        let here = u32::from(light[start + i * step]);
        let after = u32::from(light[start + (i + 1).min(count - 1) * step]);
        light[start + i * step] = ((before + 2 * here + after + 2) / 4) as u16;
        before = here;
    }
}

/// Paints the grid over the panel, around the photo.
fn enlarge(light: &[u16], grid: Size, rgb: &mut [u8], size: Size, picture: Rect) {
    let (columns, rows) = (Axis::whole(grid.width, size.width), Axis::whole(grid.height, size.height));
    let mut storage = vec![0; storage_len(columns, rows, 3)];
    let (width, row_len) = (size.width as usize, 3 * grid.width as usize);
    let photo = picture.x..picture.x + picture.size.width;
    let drawn = resample(
        columns,
        rows,
        3,
        &mut storage,
        |y, planes| planes.copy_from_slice(&light[y as usize * row_len..][..row_len]),
        |y, planes| {
            let beside = (picture.y..picture.y + picture.size.height).contains(&y);
            for x in (0..size.width).filter(|x| !(beside && photo.contains(x))) {
                let pixel = &mut rgb[3 * (y as usize * width + x as usize)..][..3];
                for (channel, out) in pixel.iter_mut().enumerate() {
                    *out = srgb::to_srgb_dithered(planes[channel * width + x as usize], dither(x, y));
                }
            }
        },
    );
    debug_assert_eq!(drawn, Ok(()), "the storage has the length of the formula");
}

/// The dither threshold of a pixel: Bayer's matrix of 8 × 8 (1973), without which the slow gradients show as bands.
fn dither(x: u32, y: u32) -> u8 {
    let bit = |value: u32, i: u32| value >> i & 1;
    let threshold = (0..3).fold(0, |sum, i| sum << 2 | bit(x ^ y, i) << 1 | bit(y, i));
    (threshold * 4 + 2) as u8
}
