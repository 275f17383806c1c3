//! A kaleidoscope of a photo that moves: a film, or the shimmer of the photo itself (the paper's fig. 8).
//!
//! Every frame of the source is coded anew, by the domains around the ranges ([`Search::None`](super::fractal::Search::None)). Left alone that flickers, so
//! everything holds on to what it was:
//!
//! 1. A level stays while the source is within [`DEAD_BAND`] of it: the noise of a camera is no motion.
//! 2. A leaf stays while it describes its range to 3/2 of the tolerance; once one of a block of 16 pixels does not, the block is coded anew.
//!    The smallest leaves stay until then, as nothing finer could take their place.
//! 3. Tones and windows are those of the first frame, and windows move as ever.
//!
//! A frame touches the blocks that have changed, and, as a pass makes one symbol of an address right, those that did within the last frames. Where
//! nothing has changed for [`HOLD`] frames the source itself comes back, as in the paper; block by block, within half a second.
//!
//! Symbols are those of [`Mode::Tonal`](super::Mode::Tonal), of the source's own levels: the decoded ones would lag behind.

use super::{
    Settings,
    address::{self, ADDRESSES, DEPTH, Tones},
    fractal::{LARGEST, Leaf, Options, contract, follow, most_leaves, plane_size},
    mirrors::Mirrors,
    prepare::TOLERANCE_Q4,
    render::one,
    texture::{self, Reference, TEXELS, Texel},
    windows::Summary,
};
use crate::{
    effect::storage::{take, words},
    effect::{self, Effect, RUN, StorageTooSmall},
    frame::{
        Size,
        pack::{Block, WHITE},
    },
    math::{lanes::LANES, mul_q15, q15},
    noise::drive::Drive,
};
use core::{iter, ops::Range, slice};

/// Levels by which a pixel may differ before it counts as changed: sensors and codecs err by as much.
const DEAD_BAND: u8 = 3;

/// Frames for which a block that has changed is shown in the reference's colours: leaves that stop between two gusts do not blink.
const HOLD: u8 = 12;

/// Frames in which the source comes back after that.
const RETURN: u8 = 8;

/// A kaleidoscope whose source moves, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`).
#[derive(Debug)]
pub struct Moving<S> {
    size: Size,
    depth: u32,
    tones: Tones,
    mirrors: Mirrors,
    storage: S,
}

/// What is kept: 7.3 bytes a pixel, and 544 KB.
#[derive(Debug)]
struct Planes<'a> {
    /// Red, green and blue of the source.
    colours: [&'a mut [u8]; 3],
    /// The luma, as far as it is believed to have changed.
    levels: &'a mut [u8],
    contracted: &'a mut [u8],
    /// Those of a block, 16 places, follow each other.
    leaves: &'a mut [Leaf],
    addresses: &'a mut [u16],
    /// Frames since a block changed.
    ages: &'a mut [u8],
    texels: &'a mut [Texel],
    table: &'a mut [Texel],
    scratch: &'a mut [u64],
}

/// Words of 64 bits that [`Moving::prepare`] needs for frames of `size`: 7.3 bytes a pixel, and 0.8 MB.
pub const fn moving_storage_len(size: Size) -> usize {
    let plane = plane_size(size, (0, 0));
    3 * words::<u8>(size.pixels())
        + words::<u8>(plane.pixels())
        + words::<u8>(plane.pixels() / 4)
        + words::<Leaf>(most_leaves(plane))
        + words::<u16>(plane.pixels())
        + words::<u8>(plane.pixels() / (LARGEST * LARGEST))
        + words::<Texel>(TEXELS)
        + words::<Texel>(ADDRESSES)
        + texture::scratch_len()
}

impl<S: AsMut<[u64]>> Moving<S> {
    /// Prepares a source whose first frame is `first` with the colours of `reference` in `storage`, which must hold [`moving_storage_len`]
    /// words. Of the settings only the depth counts.
    ///
    /// # Panics
    /// If the colours of the reference do not have the length that its size asks for.
    pub fn prepare(
        first: &impl effect::Moment,
        reference: Reference<'_>,
        settings: &Settings,
        mut storage: S,
    ) -> Result<Self, StorageTooSmall> {
        let size = first.size();
        assert_eq!(
            reference.rgb.len(),
            reference.size.pixels() * 3,
            "the reference's colours do not have its size"
        );
        let memory = storage.as_mut();
        let too_small = StorageTooSmall { needed: moving_storage_len(size), got: memory.len() };
        if too_small.got < too_small.needed {
            return Err(too_small);
        }
        let mut planes = Planes::carve(size, memory).ok_or(too_small)?;
        let depth = u32::from(settings.depth).clamp(1, DEPTH);
        texture::fill(reference, depth, planes.texels, planes.scratch)?;
        planes.levels.fill(0);
        planes.leaves.fill(Leaf::default());
        planes.addresses.fill(0);
        planes.take_in(first, 0);
        planes.ages.fill(0);
        let tones = Tones::new(planes.levels);
        for _ in 0..DEPTH {
            planes.code(size, &tones);
        }
        // Nothing has moved yet.
        planes.ages.fill(u8::MAX);
        let mirrors = Mirrors::new(Some((Summary::new(planes.texels), tones)));
        Ok(Self { size, depth, tones, mirrors, storage })
    }

    /// Takes in the next `frame` of the source, of the first one's size. Allocates nothing.
    ///
    /// # Panics
    /// If it has another size.
    pub fn see(&mut self, frame: &impl effect::Moment) {
        assert_eq!(frame.size(), self.size, "the frames of a source have one size");
        let Some(mut planes) = Planes::carve(self.size, self.storage.as_mut()) else {
            unreachable!("{LONG_ENOUGH}")
        };
        planes.ages.iter_mut().for_each(|age| *age = age.saturating_add(1));
        planes.take_in(frame, DEAD_BAND);
        planes.code(self.size, &self.tones);
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

const LONG_ENOUGH: &str = "the storage was long enough when the source was prepared";

impl<'a> Planes<'a> {
    fn carve(size: Size, mut memory: &'a mut [u64]) -> Option<Self> {
        let (memory, plane) = (&mut memory, plane_size(size, (0, 0)));
        let mut colour = || take(memory, size.pixels());
        Some(Self {
            colours: [colour()?, colour()?, colour()?],
            levels: take(memory, plane.pixels())?,
            contracted: take(memory, plane.pixels() / 4)?,
            leaves: take(memory, most_leaves(plane))?,
            addresses: take(memory, plane.pixels())?,
            ages: take(memory, plane.pixels() / (LARGEST * LARGEST))?,
            texels: take(memory, TEXELS)?,
            table: take(memory, ADDRESSES)?,
            scratch: core::mem::take(memory),
        })
    }

    /// Takes the colours and the levels of `frame`; a block of which a level is further off than `dead_band` is of age 0 then.
    fn take_in(&mut self, frame: &impl effect::Moment, dead_band: u8) {
        let (size, plane) = (frame.size(), plane_size(frame.size(), (0, 0)));
        let (columns, width) = (size.width as usize, plane.width as usize);
        let mut blocks = [[[0; LANES]; 3]; RUN];
        for y in 0..size.height as usize {
            for x in (0..columns).step_by(RUN * LANES) {
                let blocks = &mut blocks[..(columns - x).div_ceil(LANES).min(RUN)];
                frame.colours(x, y as u32, blocks);
                let ages = &mut self.ages[y / LARGEST * (width / LARGEST) + x / LARGEST..];
                for ((block, x), age) in blocks.iter_mut().zip((x..).step_by(LANES)).zip(ages) {
                    block.iter_mut().flatten().for_each(|level| *level = (*level).clamp(0, WHITE as i16));
                    let count = LANES.min(columns - x);
                    for (plane, channel) in self.colours.iter_mut().zip(&*block) {
                        let row = &mut plane[y * columns + x..][..count];
                        row.iter_mut().zip(channel).for_each(|(out, &level)| *out = (level >> 4) as u8);
                    }
                    let levels = &mut self.levels[y * width + x..][..count];
                    *age = if hold(levels, &lumas(block), dead_band) { 0 } else { *age };
                }
            }
            let row = &mut self.levels[y * width..][..width];
            let last = row[columns - 1];
            row[columns..].fill(last);
        }
        let last = (size.height as usize - 1) * width;
        for y in size.height as usize..plane.height as usize {
            self.levels.copy_within(last..last + width, y * width);
        }
    }

    /// Codes the blocks that have just changed, and makes a symbol more right of the addresses of those that did of late.
    fn code(&mut self, size: Size, tones: &Tones) {
        let plane = plane_size(size, (0, 0));
        let width = plane.width as usize;
        contract(self.levels, width, self.contracted);
        let options = Options { tolerance_q4: TOLERANCE_Q4, ..Options::default() };
        let blocks =
            self.leaves.as_chunks_mut::<{ LEAVES_OF_A_BLOCK }>().0.iter_mut().zip(&*self.ages).enumerate();
        for (i, (leaves, &age)) in blocks {
            if age == 0 {
                let place = (i % (width / LARGEST) * LARGEST, i / (width / LARGEST) * LARGEST);
                follow(self.levels, self.contracted, plane, &options, place, leaves);
            }
            if u32::from(age) < DEPTH {
                for &leaf in leaves.iter().filter(|leaf| leaf.is_range()) {
                    address::pass(leaf, width, self.addresses, |i| {
                        tones.symbols[usize::from(self.levels[i])]
                    });
                }
            }
        }
    }
}

/// Places for leaves in a block of 16 pixels.
const LEAVES_OF_A_BLOCK: usize = (LARGEST / super::fractal::SMALLEST).pow(2);

/// The lumas of levels with four fractional bits, rounded as [`super::luma`] does.
fn lumas([red, green, blue]: &Block) -> [u8; LANES] {
    core::array::from_fn(|i| {
        let [r, g, b] = [red[i], green[i], blue[i]].map(i32::from);
        ((r * 218 + g * 732 + b * 74 + (512 << 4)) >> 14) as u8
    })
}

/// Takes those of `lumas` that are further than `dead_band` from `levels`, and tells whether there are any.
#[inline(always)]
fn hold(levels: &mut [u8], lumas: &[u8], dead_band: u8) -> bool {
    let mut changed = 0;
    for (level, &luma) in levels.iter_mut().zip(lumas) {
        let kept = if level.abs_diff(luma) > dead_band { luma } else { *level };
        changed |= kept ^ *level;
        *level = kept;
    }
    changed != 0
}

impl<S: AsMut<[u64]>> Effect for Moving<S> {
    type Moment<'a>
        = MovingMoment<'a>
    where
        S: 'a;

    fn at(&mut self, drive: Drive) -> MovingMoment<'_> {
        let Some(planes) = Planes::carve(self.size, self.storage.as_mut()) else {
            unreachable!("{LONG_ENOUGH}")
        };
        self.mirrors.follow(drive);
        self.mirrors.colours(planes.texels, self.depth, planes.table);
        let cut = 4 * (DEPTH - self.depth);
        MovingMoment { size: self.size, planes, cut, onset: q15(drive.onset) }
    }
}

/// A [`Moving`] kaleidoscope at one moment.
#[derive(Debug)]
pub struct MovingMoment<'a> {
    size: Size,
    planes: Planes<'a>,
    /// Bits of an address that the table does not know.
    cut: u32,
    /// Q15.
    onset: i16,
}

impl MovingMoment<'_> {
    /// How far a block of an age has given way to the kaleidoscope, Q15.
    fn share(&self, age: u8) -> i32 {
        let left = (HOLD + RETURN).saturating_sub(age).min(RETURN);
        i32::from(self.onset) * i32::from(left) / i32::from(RETURN)
    }

    /// The shares in the middles of the blocks `from`.. of the image, in row `y`; before the first and behind the last they go on.
    fn shares_of_blocks(&self, from: isize, y: usize, shares: &mut [i32]) {
        let plane = plane_size(self.size, (0, 0));
        let [columns, rows] = [plane.width, plane.height].map(|length| length as isize / LARGEST as isize);
        let (upper, weight) = between(y);
        let [above, below] = [upper, upper + 1]
            .map(|row| &self.planes.ages[(row.clamp(0, rows - 1) * columns) as usize..][..columns as usize]);
        for (share, column) in shares.iter_mut().zip(from..) {
            let [above, below] =
                [above, below].map(|row| self.share(row[column.clamp(0, columns - 1) as usize]));
            *share = above + (below - above) * weight / WEIGHTS;
        }
    }

    /// The shares of the pixels of the blocks of 16 from (x, y) on. They go over from the middle of a block of the image to that of the next: those have no borders that
    /// could be seen.
    fn fill_shares(&self, x: usize, y: usize, shares: &mut [[i16; LANES]]) {
        let first = between(x).0;
        let mut blocks = [0; RUN * LANES / LARGEST + 2];
        self.shares_of_blocks(first, y, &mut blocks);
        for (share, x) in shares.as_flattened_mut().iter_mut().zip(x..) {
            let (block, weight) = between(x);
            let [left, right] = [0, 1].map(|i| blocks[(block - first) as usize + i]);
            *share = (left + (right - left) * weight / WEIGHTS) as i16;
        }
    }
}

/// What the way from the middle of a block to that of the next is divided into.
const WEIGHTS: i32 = 2 * LARGEST as i32;

/// The last block whose middle is before the pixel at a place, −1 where there is none, and how far the pixel is from it to the next.
const fn between(at: usize) -> (isize, i32) {
    let halves = 2 * at as isize + 1 - LARGEST as isize;
    let block = halves.div_euclid(2 * LARGEST as isize);
    (block, (halves - block * 2 * LARGEST as isize) as i32)
}

impl effect::Moment for MovingMoment<'_> {
    fn size(&self) -> Size {
        self.size
    }

    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        iter::once(0..self.size.width as usize)
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        let (y, columns, width) =
            (y as usize, self.size.width as usize, plane_size(self.size, (0, 0)).width as usize);
        let mut shares = [[0; LANES]; RUN];
        let shares = &mut shares[..blocks.len()];
        self.fill_shares(x, y, shares);
        let addresses = &self.planes.addresses[y * width + x..][..columns - x];
        let colours = self.planes.colours.each_ref().map(|plane| &plane[y * columns + x..][..columns - x]);
        let Some((table, _)) = self.planes.table.split_first_chunk::<ADDRESSES>() else { return };
        for (((block, shares), addresses), i) in
            blocks.iter_mut().zip(shares).zip(addresses.chunks(LANES)).zip((0..).step_by(LANES))
        {
            if shares.iter().any(|&share| share != 0) {
                let mut cut = [0; LANES];
                cut.iter_mut().zip(addresses).for_each(|(cut, &address)| *cut = address >> self.cut);
                one(&cut, table, slice::from_mut(block));
            } else {
                *block = [[0; LANES]; 3];
            }
            for (plane, colours) in block.iter_mut().zip(colours) {
                for ((level, &source), &share) in plane.iter_mut().zip(&colours[i..]).zip(&*shares) {
                    let source = i16::from(source) << 4;
                    *level = source + mul_q15(*level - source, share);
                }
            }
        }
    }
}

/// A frame of a film: a picture as it is.
#[derive(Clone, Copy, Debug)]
pub struct Still<'a> {
    /// Width and height in pixels.
    pub size: Size,
    /// Red, green, blue of every pixel, row by row, sRGB.
    pub rgb: &'a [u8],
}

impl effect::Moment for Still<'_> {
    fn size(&self) -> Size {
        self.size
    }

    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        iter::empty()
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        let width = self.size.width as usize;
        let row = &self.rgb.as_chunks::<3>().0[y as usize * width + x..][..width - x];
        for (block, pixels) in blocks.iter_mut().zip(row.chunks(LANES)) {
            for (channel, plane) in block.iter_mut().enumerate() {
                plane.iter_mut().zip(pixels).for_each(|(level, rgb)| *level = i16::from(rgb[channel]) << 4);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Factor, Turns};

    const SIZE: Size = Size::new(150, 83);

    fn scene(at: u32) -> Vec<u8> {
        let pixel = |i: u32| {
            let (x, y) = (i % SIZE.width, i / SIZE.width);
            let inside = (64..80).contains(&x) && (32..48).contains(&y);
            let z = if inside { 90 + x.wrapping_mul(y + at * 37) % 120 } else { (x * 3 + y * 5) % 200 };
            [z as u8, (z / 2) as u8, 40]
        };
        (0..SIZE.pixels() as u32).flat_map(pixel).collect()
    }

    fn moving() -> Moving<Vec<u64>> {
        let rgb = scene(0);
        let storage = vec![0; moving_storage_len(SIZE)];
        let (first, reference) = (Still { size: SIZE, rgb: &rgb }, Reference { size: SIZE, rgb: &rgb });
        Moving::prepare(&first, reference, &Settings::default(), storage).unwrap()
    }

    fn addresses(moving: &mut Moving<Vec<u64>>) -> Vec<u16> {
        Planes::carve(SIZE, &mut moving.storage).unwrap().addresses.to_vec()
    }

    fn frame(moving: &mut Moving<Vec<u64>>) -> Vec<[u8; 3]> {
        use crate::{effect::Paint, frame::*};
        let layout = Layout::new(SIZE, PixelFormat::Bgr888, None).unwrap();
        let mut bytes = vec![0; layout.len_bytes()];
        let drive = Drive {
            amplitude: Factor::ONE / 2,
            frequency: Factor::ONE,
            phase: Turns(1 << 30),
            onset: Factor::ONE,
        };
        moving.render(drive, Paint::Everything, &mut FrameMut::new(&mut bytes, layout).unwrap());
        bytes.as_chunks().0.to_vec()
    }

    #[test]
    fn a_still_source_gives_still_addresses_and_is_shown_as_it_is() {
        let (mut moving, rgb) = (moving(), scene(0));
        let before = addresses(&mut moving);
        assert!(before.iter().any(|&address| address != before[0]));
        for i in 0..40_usize {
            // Noise within the dead band.
            let noisy: Vec<u8> = rgb.iter().map(|&z| z.saturating_add((i % 3) as u8)).collect();
            moving.see(&Still { size: SIZE, rgb: &noisy });
            assert_eq!(addresses(&mut moving), before, "frame {i}");
        }
        moving.see(&Still { size: SIZE, rgb: &rgb });
        assert_eq!(frame(&mut moving).as_flattened(), rgb);
    }

    #[test]
    fn a_region_that_changes_changes_there_alone_and_comes_back_when_it_rests() {
        let mut moving = moving();
        let before = addresses(&mut moving);
        let width = plane_size(SIZE, (0, 0)).width as usize;
        for at in 1..20 {
            moving.see(&Still { size: SIZE, rgb: &scene(at) });
        }
        let after = addresses(&mut moving);
        let inside =
            |i: usize, width: usize| (64..80).contains(&(i % width)) && (32..48).contains(&(i / width));
        let changed = |i: &usize| before[*i] != after[*i];
        assert!((0..after.len()).filter(changed).count() > 50);
        assert!((0..after.len()).filter(changed).all(|i| inside(i, width)));

        let (shown, source) = (frame(&mut moving), scene(19));
        let source = source.as_chunks::<3>().0;
        let differs = |i: &usize| shown[*i] != source[*i];
        assert!((0..shown.len()).filter(differs).count() > 100);
        // It fades out up to the middles of the blocks around.
        let near = |i: usize| {
            (56..88).contains(&(i % SIZE.width as usize)) && (24..56).contains(&(i / SIZE.width as usize))
        };
        assert!((0..shown.len()).filter(differs).all(near));
        let faint = |i: &usize| differs(i) && !inside(*i, SIZE.width as usize);
        assert!((0..shown.len()).filter(faint).count() > 50);
        for _ in 0..HOLD + RETURN {
            moving.see(&Still { size: SIZE, rgb: &scene(19) });
        }
        assert_eq!(frame(&mut moving), source);
    }

    #[test]
    fn an_address_is_right_three_frames_after_the_last_change() {
        let mut moving = moving();
        (1..5).for_each(|at| moving.see(&Still { size: SIZE, rgb: &scene(at) }));
        (0..DEPTH).for_each(|_| moving.see(&Still { size: SIZE, rgb: &scene(4) }));
        let (tones, width) = (moving.tones, plane_size(SIZE, (0, 0)).width as usize);
        let planes = Planes::carve(SIZE, &mut moving.storage).unwrap();
        for &leaf in planes.leaves.iter().filter(|leaf| leaf.is_range()) {
            let (x, y, side) = leaf.range();
            let strides = leaf.strides(width);
            for (u, v) in (0..side).flat_map(|v| (0..side).map(move |u| (u, v))) {
                let i = (y + v) * width + x + u;
                let from =
                    (strides.start + u as isize * strides.right + v as isize * strides.down) as usize * 2;
                let symbol = u16::from(tones.symbols[usize::from(planes.levels[i])]);
                assert_eq!(planes.addresses[i] >> 8, symbol);
                let inside = (64..80).contains(&(x + u)) && (32..48).contains(&(y + v));
                if inside {
                    assert_eq!(planes.addresses[i] & 0xff, planes.addresses[from] >> 4, "pixel {i}");
                }
            }
        }
    }

    #[test]
    fn frames_of_any_size_work_and_too_little_storage_is_refused() {
        for (width, height) in [(1, 1), (1, 5_000), (17, 3), (129, 40)] {
            let size = Size::new(width, height);
            let rgb = vec![77; 3 * size.pixels()];
            let (first, reference) = (Still { size, rgb: &rgb }, Reference { size, rgb: &rgb });
            let needed = moving_storage_len(size);
            let mut moving =
                Moving::prepare(&first, reference, &Settings::default(), vec![0; needed]).unwrap();
            moving.see(&Still { size, rgb: &vec![99; 3 * size.pixels()] });
            let error =
                Moving::prepare(&first, reference, &Settings::default(), vec![0; needed - 1]).unwrap_err();
            assert_eq!((error.needed, error.got), (needed, needed - 1));
        }
    }
}
