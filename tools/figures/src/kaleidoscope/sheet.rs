//! Pairs of photos and what becomes of them, a pair a row: the photo, the reference, and every mode.

use super::Picture;
use crate::Failure;
use std::path::Path;
use yurameki::{
    frame::{FrameRef, Layout, PixelFormat, Size},
    os::output::{FrameRate, Target, Writer},
};

/// What each picture lies in the middle of.
pub(super) const CELL: Size = Size::new(480, 320);

pub(super) fn draw(path: &Path, rows: &[Vec<Picture>]) -> Result<(), Failure> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let size = Size::new(CELL.width * columns as u32, CELL.height * rows.len() as u32);
    let mut all = vec![[255; 3]; size.pixels()];
    for (i, row) in rows.iter().enumerate() {
        for (j, picture) in row.iter().enumerate() {
            let left = (CELL.width * j as u32 + (CELL.width - picture.size.width) / 2) as usize;
            let top = (CELL.height * i as u32 + (CELL.height - picture.size.height) / 2) as usize;
            let lines = picture.rgb.as_chunks::<3>().0.chunks_exact(picture.size.width as usize);
            for (line, y) in lines.zip(top..) {
                all[y * size.width as usize + left..][..line.len()].copy_from_slice(line);
            }
        }
    }
    let once = FrameRate::new(1, 1).ok_or("one frame a second is no rate")?;
    let mut writer = Writer::create(&Target::parse(path.as_os_str())?, size, once, 1)?;
    writer.write(FrameRef::new(all.as_flattened(), Layout::new(size, PixelFormat::Bgr888, None)?)?)?;
    writer.finish()?;
    println!("{}", path.display());
    Ok(())
}
