//! `yurameki mask`: the automatic mask of a photo, to look at and edit.

use super::{
    Failure, args,
    output::{FrameRate, Writer},
    photo, scene,
    stdout::print_line,
};
use crate::frame::{FrameRef, Layout, PixelFormat, Size};

/// The largest mask: that of a large panel. A mask need not be as fine as the photo.
const LARGEST: Size = Size::new(1920, 1920);

pub(super) fn mask(args: &args::Mask) -> Result<(), Failure> {
    let photo = photo::load_within(&args.photo, LARGEST, &photo::Limits::default())?;
    let size = photo.size;
    let mask = scene::automatic(&photo);

    let grey: Vec<u8> = mask.iter().flat_map(|&level| [level; 3]).collect();
    let frame = FrameRef::new(&grey, Layout::new(size, PixelFormat::Bgr888, None)?)?;
    let once = FrameRate::new(1, 1).unwrap_or_else(|| unreachable!("one frame a second is a rate"));
    let mut writer = Writer::create(&args.out, size, once, 1)?;
    writer.write(frame)?;
    writer.finish()?;
    let moving = mask.iter().map(|&level| u64::from(level)).sum::<u64>() * 100 / 255 / size.pixels() as u64;
    print_line(format_args!("{}: {moving} % of the photo moves", args.out))
}
