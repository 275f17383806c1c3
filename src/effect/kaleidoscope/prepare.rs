//! From two photos to addresses and a texture, in lent memory.

use super::{
    Kaleidoscope, Mode, Settings,
    address::{self, ADDRESSES, DEPTH, Literal, Symbols, Tones},
    fractal::{self, Leaf, Options, most_leaves, plane_size},
    luma,
    mirrors::Mirrors,
    texture::{self, Reference, TEXELS, Texel},
    windows::Summary,
};
use crate::{
    effect::storage::{take, words},
    effect::{Photo, StorageTooSmall},
    frame::{Rotation, Size},
};

/// What is kept of a photo and its reference: 5 bytes a pixel, or 11 in [`Mode::Watercolour`], and 544 KB.
#[derive(Debug)]
pub(super) struct Planes<'a> {
    pub(super) rgb: &'a mut [[u8; 3]],
    /// The addresses of all pixels, once for each code; shifted down to the depth of the table.
    pub(super) addresses: &'a mut [u16],
    pub(super) texels: &'a mut [Texel],
    pub(super) table: &'a mut [Texel],
    /// Memory of preparation.
    scratch: &'a mut [u64],
}

/// Words of 64 bits that [`Kaleidoscope::prepare`] needs for a photo of `size`: 5 bytes a pixel (11 in [`Mode::Watercolour`]) and 544 KB that are kept,
/// and up to 12 bytes a pixel of scratch.
pub const fn storage_len(size: Size, settings: &Settings) -> usize {
    let pixels = size.pixels();
    let kept = words::<[u8; 3]>(pixels)
        + words::<u16>(pixels * settings.mode.shifts().len())
        + words::<Texel>(TEXELS)
        + words::<Texel>(ADDRESSES);
    kept + scratch_len(size, settings)
}

const fn scratch_len(size: Size, settings: &Settings) -> usize {
    let (mut most, mut i) = (texture::scratch_len(), 0);
    while i < settings.mode.shifts().len() {
        let plane = plane_size(settings.rotation.turned(size), settings.mode.shifts()[i]);
        let pixels = plane.pixels();
        let coding = words::<u8>(pixels)
            + words::<u8>(pixels / 4)
            + words::<Leaf>(most_leaves(plane))
            + larger(fractal::scratch_len(plane, settings.search), words::<u16>(pixels));
        most = larger(most, coding);
        i += 1;
    }
    most
}

const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

impl<'a> Planes<'a> {
    pub(super) fn carve(size: Size, mode: Mode, mut memory: &'a mut [u64]) -> Option<Self> {
        let (memory, pixels) = (&mut memory, size.pixels());
        Some(Self {
            rgb: take(memory, pixels)?,
            addresses: take(memory, pixels * mode.shifts().len())?,
            texels: take(memory, TEXELS)?,
            table: take(memory, ADDRESSES)?,
            scratch: core::mem::take(memory),
        })
    }
}

/// Sweeps of the decoder: from grey, photos are settled to within a level.
const SWEEPS: u32 = 6;

/// How far a range may be off, in levels, Q4: half of what coders are compared at. Compression is not the aim, and borders of ranges are seen first where the
/// picture is smooth.
pub const TOLERANCE_Q4: u16 = 4 << 4;

pub(super) fn prepare<S: AsMut<[u64]>>(
    photo: Photo<'_>,
    reference: Reference<'_>,
    settings: &Settings,
    mut storage: S,
    mut progress: impl FnMut(u8),
) -> Result<Kaleidoscope<S>, StorageTooSmall> {
    let Settings { mode, .. } = *settings;
    assert_eq!(photo.rgb.len(), photo.size.pixels() * 3, "the photo's colours do not have its size");
    assert_eq!(
        reference.rgb.len(),
        reference.size.pixels() * 3,
        "the reference's colours do not have its size"
    );
    let memory = storage.as_mut();
    let too_small = StorageTooSmall { needed: storage_len(photo.size, settings), got: memory.len() };
    if too_small.got < too_small.needed {
        return Err(too_small);
    }
    let planes = Planes::carve(photo.size, mode, memory).ok_or(too_small)?;
    let depth = u32::from(settings.depth).clamp(1, DEPTH);
    texture::fill(reference, depth, planes.texels, planes.scratch)?;
    planes.rgb.copy_from_slice(photo.rgb.as_chunks().0);
    let upright =
        Upright { rgb: planes.rgb, size: settings.rotation.turned(photo.size), rotation: settings.rotation };
    let layers = planes.addresses.chunks_exact_mut(photo.size.pixels().max(1));
    let mut tones = None;
    for (i, (&shift, layer)) in mode.shifts().iter().zip(layers).enumerate() {
        let whole = plane_size(upright.size, shift).pixels() * mode.shifts().len();
        let progress =
            |pixels: usize| progress(((pixels + i * whole / mode.shifts().len()) * 100 / whole) as u8);
        fill_addresses(&upright, shift, settings, &mut tones, planes.scratch, layer, progress)
            .ok_or(too_small)?;
    }
    let tonal = tones.map(|tones| (Summary::new(planes.texels), tones));
    Ok(Kaleidoscope { size: photo.size, mode, depth, mirrors: Mirrors::new(tonal), storage })
}

/// A photo of a panel that is mounted turned.
struct Upright<'a> {
    /// As the panel shows it.
    rgb: &'a [[u8; 3]],
    /// As a person sees it.
    size: Size,
    rotation: Rotation,
}

/// Codes the photo with its corner at `shift` and fills the addresses of its pixels. `tones` are those of the first code. `progress` is told
/// how many pixels are coded.
fn fill_addresses(
    upright: &Upright<'_>,
    shift: (u32, u32),
    settings: &Settings,
    tones: &mut Option<Tones>,
    mut scratch: &mut [u64],
    layer: &mut [u16],
    progress: impl FnMut(usize),
) -> Option<()> {
    let (size, rotation) = (upright.size, upright.rotation);
    let plane = plane_size(size, shift);
    let memory = &mut scratch;
    let levels = take::<u8>(memory, plane.pixels())?;
    let contracted = take::<u8>(memory, plane.pixels() / 4)?;
    let leaves = take::<Leaf>(memory, most_leaves(plane))?;
    fractal::fill_plane(size, shift, levels, |i| {
        let place = (i % size.width as usize, i / size.width as usize);
        luma(upright.rgb[rotation.turned_place(place, size)])
    });
    let options = Options { search: settings.search, tolerance_q4: TOLERANCE_Q4, ..Options::default() };
    let code = fractal::encode(levels, plane, &options, memory, leaves, progress).ok()?;
    fractal::decode(&code, SWEEPS, levels, contracted);

    let addresses = take::<u16>(memory, plane.pixels())?;
    let literal;
    let symbols = if settings.mode == Mode::Literal {
        literal = Literal::new(&code);
        Symbols::Literal(&literal)
    } else {
        Symbols::Tonal(tones.get_or_insert_with(|| Tones::new(levels)))
    };
    address::fill(&code, &symbols, levels, addresses);
    let (width, columns) = (plane.width as usize, size.width as usize);
    let cut = 4 * (DEPTH - u32::from(settings.depth).clamp(1, DEPTH));
    let rows = addresses.chunks_exact(width).skip(shift.1 as usize).take(size.height as usize);
    for (y, row) in rows.enumerate() {
        for (x, &address) in row[shift.0 as usize..][..columns].iter().enumerate() {
            layer[rotation.turned_place((x, y), size)] = address >> cut;
        }
    }
    Some(())
}
