//! `yurameki encode` and `yurameki decode`: a photo's luma as a fractal code, and back.

use super::{
    Failure, args,
    output::{FrameRate, Writer, write_file},
    photo,
    progress::Progress,
    stdout::print_line,
};
use crate::{
    effect::kaleidoscope::{
        fractal::{
            Leaf, Options, decode as sweep_all, encode as code,
            file::{Checked, most_bytes, write},
            fill_plane, most_leaves, plane_size, scratch_len,
        },
        luma,
    },
    frame::{FrameRef, Layout, PixelFormat, Size},
};
use std::time::Instant;

/// The largest picture that is coded; larger photos are shrunk. Exhaustive searches take time by the square of the pixels.
const LARGEST: Size = Size::new(4096, 4096);

pub(super) fn encode(args: &args::Encode) -> Result<(), Failure> {
    let bounds = args.size.unwrap_or(LARGEST);
    let photo = photo::load_within(&args.photo, bounds, &photo::Limits::default())?;
    let (rgb, _) = photo.rgb.as_chunks::<3>();
    let level = |i: usize| luma(rgb[i]);
    let plane = plane_size(photo.size, (0, 0));
    let mut levels = vec![0; plane.pixels()];
    fill_plane(photo.size, (0, 0), &mut levels, level);

    let options = Options { search: args.search, tolerance_q4: args.tolerance.to_q4(), ..Options::default() };
    let mut leaves = vec![Leaf::default(); most_leaves(plane)];
    let mut scratch = vec![0; scratch_len(plane, options.search)];
    let progress = Progress::of_work(plane.pixels() as u64, args.quiet);
    let start = Instant::now();
    let code =
        code(&levels, plane, &options, &mut scratch, &mut leaves, |pixels| progress.set(pixels as u64))?;
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);

    let mut file = vec![0; most_bytes(photo.size)];
    let length = write(&code, photo.size, &mut file);
    write_file(&args.out, &file[..length])?;
    let (ranges, error) = (code.leaves().len(), mean_square_error(&code, photo.size, &levels));
    let psnr = 10.0 * (255.0 * 255.0 / error.max(1e-9)).log10();
    let from = if photo.size == photo.source_size {
        String::new()
    } else {
        format!(" (the photo has {})", photo.source_size)
    };
    print_line(format_args!(
        "{}: {} pixels{from}, {ranges} ranges, {length} bytes, {psnr:.2} dB, {seconds:.3} s",
        args.out.display(),
        photo.size
    ))
}

/// Sweeps after which a picture changes no more.
const SETTLED: u32 = 12;

/// How far the decoded picture of `size` is from the coded `levels`.
fn mean_square_error(
    code: &crate::effect::kaleidoscope::fractal::Code<'_>,
    size: Size,
    levels: &[u8],
) -> f64 {
    let plane = code.plane_size();
    let (mut decoded, mut contracted) = (vec![128; plane.pixels()], vec![0; plane.pixels() / 4]);
    sweep_all(code, SETTLED, &mut decoded, &mut contracted);
    let (width, columns) = (plane.width as usize, size.width as usize);
    let rows = decoded.chunks_exact(width).zip(levels.chunks_exact(width)).take(size.height as usize);
    let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    let sum: f64 = rows.flat_map(|(a, b)| a[..columns].iter().zip(&b[..columns])).map(square).sum();
    sum / size.pixels() as f64
}

pub(super) fn decode(args: &args::Decode) -> Result<(), Failure> {
    let refused = |error| Failure::new(format!("{}: {error}", args.file.display()));
    let bytes = photo::read(&args.file, LONGEST_FILE)?;
    let checked = Checked::new(&bytes).map_err(refused)?;
    let size = checked.size();
    let mut leaves = vec![Leaf::default(); checked.leaves()];
    let code = checked.read(&mut leaves);
    let plane = code.plane_size();
    let (mut levels, mut contracted) = (vec![128; plane.pixels()], vec![0; plane.pixels() / 4]);
    sweep_all(&code, args.iterations, &mut levels, &mut contracted);

    let rows = levels.chunks_exact(plane.width as usize).take(size.height as usize);
    let grey: Vec<u8> =
        rows.flat_map(|row| &row[..size.width as usize]).flat_map(|&level| [level; 3]).collect();
    let frame = FrameRef::new(&grey, Layout::new(size, PixelFormat::Bgr888, None)?)?;
    let once = FrameRate::new(1, 1).unwrap_or_else(|| unreachable!("one frame a second is a rate"));
    let mut writer = Writer::create(&args.out, size, once, 1)?;
    writer.write(frame)?;
    Ok(writer.finish()?)
}

/// The most bytes of a file that is read: over those of the largest picture that is coded.
const LONGEST_FILE: u64 = 16 << 20;
