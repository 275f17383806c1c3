//! An animation as a clip that the frame plays.

use super::{Animation, Paint, Progress, Stage};
use std::path::Path;
use yurameki::effect::fluid::{Kind, Shape, Tint};
use yurameki::frame::{Rect, Size};
use yurameki::os::clip::{ClipWriter, WriteError, Written};

/// Writes the clip at `path`; the file has its name only when all of it is there.
///
/// # Errors
/// A file that cannot be written.
pub fn write_clip(
    animation: &Animation,
    path: &Path,
    progress: &Progress<'_>,
) -> Result<Written, WriteError> {
    let (base, small) = (&animation.base, &animation.small);
    let (kind, step, tint) = match &animation.paint {
        Paint::Luma(tint) => (Kind::Luma, 1, tint.as_ref()),
        Paint::Colour(_) => (Kind::Colour, 2, &Tint::GREY),
    };
    let size = Size::new(base.width(), base.height());
    let grid = Size::new(small.width(), small.height());
    let millihertz = (animation.rate * 1000.0).round() as u32;
    let shape = Shape { kind, millihertz, step, base: size, grid, rect: Rect::whole(size) };
    let mut writer = ClipWriter::create(path, &shape, base.as_raw(), &animation.matte, tint)?;
    for index in 0..animation.frames() {
        progress(Stage::Write, index, animation.frames());
        writer.frame(&animation.change(index))?;
    }
    progress(Stage::Write, animation.frames(), animation.frames());
    writer.finish()
}
