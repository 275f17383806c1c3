//! The numbers of the kaleidoscope: its coder, what its pictures keep of the photo, how they move, and what they cost.

mod coding;
mod cost;
mod likeness;
mod pictures;
mod sheet;

use crate::Failure;
use std::path::PathBuf;
use yurameki::{
    frame::Size,
    os::photo::{Limits, load_within},
};

/// Arguments of `kaleidoscope`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Pictures to code, as they are and shrunk to 256 pixels.
    #[arg(long, value_name = "PICTURE", num_args = 1..)]
    coding: Vec<PathBuf>,
    /// A photo and its reference, as often as you like.
    #[arg(long, value_names = ["PHOTO", "REFERENCE"], num_args = 2)]
    pair: Vec<PathBuf>,
    /// Draw all pairs, in every mode, on one sheet.
    #[arg(long, value_name = "FILE", requires = "pair")]
    sheet: Option<PathBuf>,
    /// Also count the instructions of a frame, with valgrind.
    #[arg(long)]
    instructions: bool,
    /// Render so many frames of the first pair; what `--instructions` counts.
    #[arg(long, hide = true)]
    counted_frames: Option<u32>,
    /// The mode of the counted frames.
    #[arg(long, hide = true, default_value = "watercolour")]
    counted_mode: yurameki::effect::kaleidoscope::Mode,
    /// The side of the counted frames, in pixels.
    #[arg(long, hide = true, default_value_t = 256)]
    counted_side: u32,
    /// Count frames of a source that moves.
    #[arg(long, hide = true)]
    counted_moving: bool,
}

pub(crate) fn measure(args: &Args) -> Result<(), Failure> {
    if let Some(frames) = args.counted_frames {
        cost::render(frames, args.counted_mode, args.counted_side, args.counted_moving);
        return Ok(());
    }
    for path in &args.coding {
        for side in [512, 256] {
            coding::table(&Picture::load(path, Size::new(side, side))?)?;
        }
    }
    let mut rows = Vec::new();
    for pair in args.pair.chunks_exact(2) {
        let [photo, reference] =
            [Picture::load(&pair[0], sheet::CELL)?, Picture::load(&pair[1], sheet::CELL)?];
        let shown = pictures::table(&photo, &reference)?;
        rows.push([vec![photo, reference], shown].concat());
    }
    if let Some(path) = &args.sheet {
        sheet::draw(path, &rows)?;
    }
    println!("allocations a frame: {}", cost::allocations());
    if args.instructions {
        cost::table()?;
    }
    Ok(())
}

/// A picture within a size.
#[derive(Clone)]
struct Picture {
    name: String,
    size: Size,
    rgb: Vec<u8>,
}

impl Picture {
    fn load(path: &std::path::Path, bounds: Size) -> Result<Self, Failure> {
        let photo = load_within(path, bounds, &Limits::default())?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, size: photo.size, rgb: photo.rgb })
    }

    fn luma(&self) -> Vec<u8> {
        luma(&self.rgb)
    }
}

fn luma(rgb: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().map(|&pixel| yurameki::effect::kaleidoscope::luma(pixel)).collect()
}
