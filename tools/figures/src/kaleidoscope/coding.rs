//! What the coder makes of a picture: time, ranges, bytes and PSNR of every search.

use super::Picture;
use crate::Failure;
use std::time::{Duration, Instant};
use yurameki::effect::kaleidoscope::fractal::{
    Leaf, Options, Search, decode, encode,
    file::{most_bytes, write},
    fill_plane, most_leaves, plane_size, scratch_len,
};

/// The shortest of so many times is told: others use the machine too.
const TRIES: u32 = 5;

/// Sweeps of the decoder: it has settled.
const SWEEPS: u32 = 12;

pub(super) fn table(picture: &Picture) -> Result<(), Failure> {
    println!("{} {}: search, seconds, ranges, bytes, PSNR in dB", picture.name, picture.size);
    let plane = plane_size(picture.size, (0, 0));
    let (luma, mut levels) = (picture.luma(), vec![0; plane.pixels()]);
    fill_plane(picture.size, (0, 0), &mut levels, |i| luma[i]);
    for &(name, search) in Search::NAMES {
        let options = Options { search, ..Options::default() };
        let mut leaves = vec![Leaf::default(); most_leaves(plane)];
        let mut scratch = vec![0; scratch_len(plane, search)];
        let mut shortest = Duration::MAX;
        for _ in 1..TRIES {
            let start = Instant::now();
            encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ())?;
            shortest = shortest.min(start.elapsed());
        }
        let code = encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ())?;
        let bytes = write(&code, picture.size, &mut vec![0; most_bytes(picture.size)]);
        let mut decoded = vec![128; plane.pixels()];
        decode(&code, SWEEPS, &mut decoded, &mut vec![0; plane.pixels() / 4]);
        let psnr = psnr(&decoded, &levels, plane.width as usize, picture);
        println!("  {name:10} {:8.4} {:6} {bytes:6} {psnr:6.2}", shortest.as_secs_f64(), code.leaves().len());
    }
    Ok(())
}

/// Of the picture's part of a plane of `width`.
fn psnr(decoded: &[u8], levels: &[u8], width: usize, picture: &Picture) -> f64 {
    let columns = picture.size.width as usize;
    let rows = decoded.chunks_exact(width).zip(levels.chunks_exact(width)).take(picture.size.height as usize);
    let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    let sum: f64 = rows.flat_map(|(a, b)| a[..columns].iter().zip(&b[..columns])).map(square).sum();
    10.0 * (255.0 * 255.0 * picture.size.pixels() as f64 / sum.max(1e-9)).log10()
}
