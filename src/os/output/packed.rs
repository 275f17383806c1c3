use crate::frame::{FrameRef, PixelFormat};

/// Fills `rgb` with the pixels of `frame` as packed 8-bit red, green, blue: the values of [`PixelFormat::unpack`], a row at a
/// time.
pub(super) fn pack_rgb(frame: FrameRef<'_>, rgb: &mut Vec<u8>) {
    let layout = frame.layout();
    rgb.resize(layout.size.pixels() * 3, 0);
    let width = layout.size.width as usize;
    for (row, out) in frame.rows().zip(rgb.chunks_exact_mut(width * 3)) {
        match layout.format {
            PixelFormat::Xrgb8888 => pack_row::<4>(row, out, |[b, g, r, _]| [r, g, b]),
            PixelFormat::Xbgr8888 => pack_row::<4>(row, out, |[r, g, b, _]| [r, g, b]),
            PixelFormat::Rgb888 => pack_row::<3>(row, out, |[b, g, r]| [r, g, b]),
            PixelFormat::Bgr888 => out.copy_from_slice(row),
            format @ (PixelFormat::Rgb565 | PixelFormat::Bgr565) => {
                pack_row::<2>(row, out, |pixel| format.unpack(&pixel));
            }
            format @ PixelFormat::Xrgb2101010 => pack_row::<4>(row, out, |pixel| format.unpack(&pixel)),
        }
    }
}

fn pack_row<const N: usize>(row: &[u8], out: &mut [u8], unpack: impl Fn([u8; N]) -> [u8; 3]) {
    let (pixels, _) = row.as_chunks::<N>();
    let (out, _) = out.as_chunks_mut::<3>();
    for (pixel, out) in pixels.iter().zip(out) {
        *out = unpack(*pixel);
    }
}
