//! How a pair of photos looks in every mode, and how it moves.

use super::{
    Picture,
    likeness::{border_ratio, ssim},
    luma,
};
use crate::Failure;
use yurameki::{
    effect::{
        Effect, Paint, Photo,
        kaleidoscope::{
            Kaleidoscope, Mode, Reference, Settings, TOLERANCE_Q4,
            fractal::{Leaf, Options, encode, fill_plane, most_leaves, plane_size, scratch_len},
            storage_len,
        },
    },
    frame::{FrameMut, Layout, PixelFormat},
    noise::drive::{self, Oscillator},
};

/// Frames in which the change is measured; windows are chosen anew ten times.
const FRAMES: usize = 120;

/// The frame that is compared with the photo: windows have been chosen anew.
const COMPARED: usize = 13;

/// Prints how the pair looks and moves, a line a mode; gives the frames that were compared.
pub(super) fn table(photo: &Picture, reference: &Picture) -> Result<Vec<Picture>, Failure> {
    let mut compared = Vec::new();
    let (source, width) = (photo.luma(), photo.size.width as usize);
    let ranges = ranges(photo, &source)?;
    let own = border_ratio(&source, width, &ranges);
    println!(
        "{} in the colours of {}: mode, SSIM, border ratio (the photo's own: {own:.2}), mean and largest change a frame",
        photo.name, reference.name
    );
    for &(name, mode) in Mode::NAMES {
        let settings = Settings { mode, ..Settings::default() };
        let mask = vec![255; photo.size.pixels()];
        let prepared = Photo { size: photo.size, rgb: &photo.rgb, mask: &mask };
        let colours = Reference { size: reference.size, rgb: &reference.rgb };
        let storage = vec![0; storage_len(photo.size, &settings)];
        let mut kaleidoscope = Kaleidoscope::prepare(prepared, colours, &settings, storage, |_| ())?;
        let layout = Layout::new(photo.size, PixelFormat::Bgr888, None)?;
        let mut oscillator = Oscillator::new(drive::Settings::default(), 7);
        let (mut before, mut frame) = (Vec::new(), vec![0; layout.len_bytes()]);
        let (mut likeness, mut borders, mut changes) = (0.0, 0.0, Vec::new());
        for i in 0..FRAMES {
            let mut out = FrameMut::new(&mut frame, layout)?;
            kaleidoscope.render(oscillator.step(), Paint::Everything, &mut out);
            if i > 0 {
                changes.push(mean_difference(&before, &frame));
            }
            if i == COMPARED {
                let shown = luma(&frame);
                compared.push(Picture { name: name.into(), size: photo.size, rgb: frame.clone() });
                (likeness, borders) = (ssim(&source, &shown, width), border_ratio(&shown, width, &ranges));
            }
            before.clone_from(&frame);
        }
        let mean = changes.iter().sum::<f64>() / changes.len() as f64;
        let most = changes.iter().copied().fold(0.0, f64::max);
        println!("  {name:12} {likeness:6.3} {borders:6.2} {mean:6.2} {most:6.2}");
    }
    Ok(compared)
}

/// The ranges that the kaleidoscope cuts the photo into.
fn ranges(photo: &Picture, luma: &[u8]) -> Result<Vec<(usize, usize, usize)>, Failure> {
    let plane = plane_size(photo.size, (0, 0));
    let mut levels = vec![0; plane.pixels()];
    fill_plane(photo.size, (0, 0), &mut levels, |i| luma[i]);
    let search = Settings::default().search;
    let options = Options { search, tolerance_q4: TOLERANCE_Q4, ..Options::default() };
    let mut leaves = vec![Leaf::default(); most_leaves(plane)];
    let mut scratch = vec![0; scratch_len(plane, search)];
    let code = encode(&levels, plane, &options, &mut scratch, &mut leaves, |_| ())?;
    Ok(code.leaves().iter().map(|leaf| leaf.range()).collect())
}

fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}
