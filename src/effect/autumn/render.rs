//! The frame kernel: one gather a pixel.

use super::{
    Autumn,
    airborne::Sprite,
    mount::Mount,
    plates::{CELLS, Light, STAGES},
    season::Now,
    species::MOST_TWIGS,
    storage::{ADDRESSES, Planes, State},
    sway::{self, OFFSET_BITS, PITCH},
};
use crate::{
    effect,
    frame::{
        Size,
        pack::{Block, WHITE},
        srgb,
    },
    math::{
        Factor, Turns,
        lanes::{LANES, Lanes, Task, on_widest},
        random::scatter,
    },
    noise::drive::Drive,
};
use core::ops::Range;

/// An autumn at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    planes: Planes<'a>,
    mount: Mount,
    bark: [u8; 3],
    /// Whether what is behind the leaves moves with them.
    is_photo: bool,
    sprites: &'a [Sprite],
    /// What can differ from frame to frame: columns and rows.
    moving: [Range<usize>; 2],
}

/// Fills the colour of every address, for the season of `now`: the plates of two neighbouring stages, blended in linear light.
///
/// Leaves of a photo come over it within their first two stages.
pub(super) fn colour(planes: &mut Planes<'_>, now: Now, twigs: usize, is_photo: bool) {
    for (twig, calendar) in planes.calendars[..twigs].iter().enumerate() {
        let stage = now.stage(calendar);
        let (below, share) = ((stage >> 8) as usize, stage & 0xff);
        let above = (below + 1).min(STAGES - 1);
        // The sub-tile of the plate is that of the finest tree symbols.
        let tile = twig % (CELLS / 16) * 16;
        let tile = |plate: usize| &planes.plates[plate * CELLS + tile..][..16];
        let colours = &mut planes.colours[twig * 16..][..16];
        for ((colour, from), to) in colours.iter_mut().zip(tile(below)).zip(tile(above)) {
            *colour = mixed(*from, *to, share);
        }
        let there = if is_photo { (stage / 2).min(255) as u8 } else { now.leaves(calendar) };
        planes.states[twig].there = there;
        planes.states[twig + MOST_TWIGS].there = 255 - there;
    }
}

fn mixed(from: Light, to: Light, share: u32) -> u32 {
    let [red, green, blue] = core::array::from_fn(|i| {
        let light = (u32::from(from[i]) * (256 - share) + u32::from(to[i]) * share) >> 8;
        u32::from(srgb::to_srgb(light as u16))
    });
    red | green << 8 | blue << 16
}

/// How much the leaves of a twig brighten and darken at most while they flutter, of 128.
const FLUTTER: i64 = 18;

/// Sets how bright each twig's leaves are: they turn in the wind, each with a phase of its own.
pub(super) fn flutter(states: &mut [State], twigs: usize, drive: Drive) {
    let strength = i64::from((drive.amplitude * drive.onset).to_bits()) * FLUTTER;
    let twice = Turns(drive.phase.0.wrapping_mul(2));
    for (twig, state) in states[..twigs].iter_mut().enumerate() {
        let phase = Turns((scatter(twig as u64) >> 32) as u32);
        let swing = i64::from(twice.plus(phase).sin().to_bits() >> 12);
        state.gain = (128 + ((strength * swing) >> (2 * Factor::FRAC_NBITS - 12))) as u8;
    }
}

/// A block of pixels on the way from addresses to colours, and the first of the next block. What is fetched pixel by pixel is kept in
/// pairs of bytes, as it is stored; all arithmetic is in lanes.
struct Fetched {
    /// Of the leaf: red, then green.
    red_green: [i16; LANES + 1],
    blue: [i16; LANES + 1],
    /// A texel's shade, then its cover.
    leaf: [i16; LANES + 1],
    /// How bright the wood is, then how much of the pixel it covers.
    wood: [i16; LANES + 1],
    /// How much of the leaf is there, then how bright it is.
    state: [i16; LANES + 1],
    /// How far the place is on its way to the next pixel, Q15.
    share: [i16; LANES],
}

/// What is before the background: its colour times how much it covers, and what it leaves of the background, Q15.
struct Layer<L> {
    colour: [L; 3],
    open: L,
}

/// The 16 numbers from the one numbered `first` on.
#[inline(always)]
fn lanes_at<L: Lanes>(from: &[i16; LANES + 1], first: usize) -> L {
    match from[first..].first_chunk() {
        Some(from) => L::load(from),
        None => L::splat(0),
    }
}

/// The lower and the upper byte.
#[inline(always)]
fn bytes<L: Lanes>(pairs: L) -> [L; 2] {
    let byte = L::splat(0xff);
    [pairs.and(byte), pairs.down::<8>().and(byte)]
}

/// 0..=255 to 0..=1 in Q15, both ends exact to a step.
#[inline(always)]
fn whole<L: Lanes>(share: L) -> L {
    share.up::<7>().or(share.down::<1>())
}

#[inline(always)]
fn between<L: Lanes>(from: L, to: L, share: L) -> L {
    from.plus(to.minus(from).times(share))
}

/// A channel of a leaf, in whole levels, over that of the wood.
#[inline(always)]
fn leaf_over<L: Lanes>(wood: L, level: L, gain: L, white: L, cover: L) -> L {
    between(wood, level.up::<6>().times(gain).at_most(white), cover)
}

impl Fetched {
    /// Leaf over wood, of the pixels from the one numbered `first` on.
    #[inline(always)]
    fn layer<L: Lanes>(&self, first: usize, bark: [u8; 3]) -> Layer<L> {
        let [shade, cover] = bytes(lanes_at::<L>(&self.leaf, first));
        let [lit, wood] = bytes(lanes_at::<L>(&self.wood, first));
        let [there, gain] = bytes(lanes_at::<L>(&self.state, first));
        let [red, green] = bytes(lanes_at::<L>(&self.red_green, first));
        let blue = lanes_at::<L>(&self.blue, first);
        // 128 of either is 1; the product is in Q13.
        let gain = shade.up::<7>().times(gain.up::<7>());
        let cover = whole(cover).times(whole(there));
        let (wood, one) = (whole(wood), L::splat(i16::MAX));
        let lit = lit.up::<7>().times(wood);
        let white = L::splat(WHITE as i16);
        // A closure that stays on its own would be compiled without the instruction set: no `map` here and below.
        let [bark_red, bark_green, bark_blue] = bark;
        let colour = [
            leaf_over(L::splat(i16::from(bark_red) << 4).times(lit), red, gain, white, cover),
            leaf_over(L::splat(i16::from(bark_green) << 4).times(lit), green, gain, white, cover),
            leaf_over(L::splat(i16::from(bark_blue) << 4).times(lit), blue, gain, white, cover),
        ];
        Layer { colour, open: one.minus(wood).times(one.minus(cover)) }
    }
}

impl<L: Lanes> Layer<L> {
    /// Over what is behind it.
    #[inline(always)]
    fn over(&self, behind: [L; 3]) -> [L; 3] {
        let ([red, green, blue], [behind_red, behind_green, behind_blue]) = (self.colour, behind);
        [
            behind_red.times(self.open).plus(red),
            behind_green.times(self.open).plus(green),
            behind_blue.times(self.open).plus(blue),
        ]
    }

    /// Between this one and that a pixel to the right.
    #[inline(always)]
    fn towards(&self, next: &Self, share: L) -> Self {
        Self { colour: blended(self.colour, next.colour, share), open: between(self.open, next.open, share) }
    }
}

#[inline(always)]
fn blended<L: Lanes>(from: [L; 3], to: [L; 3], share: L) -> [L; 3] {
    let ([red, green, blue], [to_red, to_green, to_blue]) = (from, to);
    [between(red, to_red, share), between(green, to_green, share), between(blue, to_blue, share)]
}

impl<'a> Moment<'a> {
    pub(super) fn new<S: AsMut<[u64]>>(autumn: &'a mut Autumn<S>) -> Self {
        let Autumn { mount, bark, is_photo, moving, storage, sprites, .. } = autumn;
        let Ok(planes) = Planes::carve(mount.panel, storage.as_mut()) else {
            unreachable!("the storage was long enough when the tree was prepared")
        };
        Self { planes, mount: *mount, bark: *bark, is_photo: *is_photo, sprites, moving: moving.clone() }
    }

    /// How the cell of the grid that holds pixel (x, y) bends, at that pixel: right and down, in steps of 2^-[`PLACE_BITS`] pixel,
    /// and what is added a pixel.
    #[inline(always)]
    fn bent(&self, x: usize, y: usize) -> [[i32; 2]; 2] {
        let (columns, _) = sway::grid(self.planes.size);
        let corner = y / PITCH * columns + x / PITCH;
        let (right, down) = ((x % PITCH) as i32, (y % PITCH) as i32);
        let side = |at: usize, axis: usize| {
            let offset = |at: usize| i32::from(self.planes.nodes[at].offset[axis]);
            offset(at) * PITCH as i32 + (offset(at + columns) - offset(at)) * down
        };
        [0, 1].map(|axis| {
            let from = side(corner, axis);
            let slope = (side(corner + 1, axis) - from) / PITCH as i32;
            [from + slope * right, slope]
        })
    }

    /// Where the pixels of the block at (x, y) are fetched from, and that to the right of them: to the left of the place by a share of a
    /// pixel, Q15; up and down to the nearest row.
    #[inline(always)]
    pub(super) fn sources(&self, x: usize, y: usize) -> ([u32; LANES + 1], [i16; LANES]) {
        let [[mut right, right_slope], [down, down_slope]] = self.bent(x, y);
        let width = self.planes.size.width as i32;
        let mut down = down + (1 << (PLACE_BITS - 1));
        let start = y as i32 * width + x as i32;
        let (mut sources, mut shares) = ([0; LANES + 1], [0; LANES]);
        for (i, source) in sources.iter_mut().enumerate() {
            *source = (start + i as i32 + (right >> PLACE_BITS) + (down >> PLACE_BITS) * width) as u32;
            if let Some(share) = shares.get_mut(i) {
                *share = ((right & ((1 << PLACE_BITS) - 1)) << (15 - PLACE_BITS)) as i16;
            }
            (right, down) = (right + right_slope, down + down_slope);
        }
        (sources, shares)
    }

    /// Fetches what the block shows: of each pixel its texel, and by its address a colour and a state.
    #[inline(always)]
    fn fetch(&self, sources: &[u32; LANES + 1], share: [i16; LANES]) -> Fetched {
        let none = [0; LANES + 1];
        let mut fetched = Fetched { red_green: none, blue: none, leaf: none, wood: none, state: none, share };
        let (texels, colours) = (&*self.planes.texels, self.planes.colours.first_chunk::<ADDRESSES>());
        let states = self.planes.states.first_chunk::<{ 2 * MOST_TWIGS }>();
        let (Some(colours), Some(states)) = (colours, states) else { return fetched };
        for (i, &source) in sources.iter().enumerate() {
            let Some(texel) = texels.get(source as usize) else { continue };
            let colour = colours[usize::from(texel.address)];
            let State { there, gain } = states[usize::from(texel.depth) % (2 * MOST_TWIGS)];
            (fetched.red_green[i], fetched.blue[i]) = (colour as i16, (colour >> 16) as i16);
            fetched.leaf[i] = i16::from_le_bytes([texel.shade, texel.cover]);
            fetched.wood[i] = i16::from_le_bytes([texel.bark, texel.wood]);
            fetched.state[i] = i16::from_le_bytes([there, gain]);
        }
        fetched
    }

    /// The background of a block, of which what is outside the row may be anything.
    #[inline(always)]
    fn behind<L: Lanes>(&self, start: usize) -> [L; 3] {
        let [red, green, blue] = &self.planes.background;
        [background(red, start), background(green, start), background(blue, start)]
    }

    /// What is behind the leaves of a photo, which moves with them, from the pixel numbered `first` on.
    #[inline(always)]
    fn moved<L: Lanes>(&self, sources: &[u32; LANES + 1], first: usize) -> [L; 3] {
        let [red, green, blue] = &self.planes.background;
        let sources = &sources[first..];
        [gathered(red, sources), gathered(green, sources), gathered(blue, sources)]
    }

    /// A block of the tree, its leaves and what is behind them.
    #[inline(always)]
    fn block<L: Lanes>(&self, x: usize, y: usize) -> [L; 3] {
        let start = y * self.planes.size.width as usize + x;
        let span = self.planes.spans[y];
        if x + LANES <= usize::from(span.start) || x >= usize::from(span.end) {
            return self.behind(start);
        }
        let (sources, share) = self.sources(x, y);
        let fetched = self.fetch(&sources, share);
        let (here, next, share) =
            (fetched.layer::<L>(0, self.bark), fetched.layer::<L>(1, self.bark), L::load(&fetched.share));
        if self.is_photo {
            let (here, next) = (here.over(self.moved(&sources, 0)), next.over(self.moved(&sources, 1)));
            blended(here, next, share)
        } else {
            here.towards(&next, share).over(self.behind(start))
        }
    }

    /// Those of the leaves in the air that reach row `y`, a bit each.
    fn airborne(&self, y: u32) -> u64 {
        let reaches = |sprite: &Sprite| (sprite.rows.0..sprite.rows.1).contains(&(y as i32));
        self.sprites.iter().enumerate().map(|(i, sprite)| u64::from(reaches(sprite)) << i).sum()
    }

    /// Paints `leaves` in the air over the block at (x, y).
    fn paint_airborne(&self, mut leaves: u64, x: usize, y: u32, planes: &mut Block) {
        let (x, y) = (x as i32, y as i32);
        while leaves != 0 {
            let sprite = &self.sprites[leaves.trailing_zeros() as usize];
            leaves &= leaves - 1;
            for column in sprite.columns.0.max(x)..sprite.columns.1.min(x + LANES as i32) {
                let [across, down] = self.mount.pixel(column, y);
                let cell = sprite.lens.cell(self.planes.stencil, across, down);
                if cell.cover == 0 {
                    continue;
                }
                let colour = self.planes.colours[usize::from(sprite.twig) << 4 | usize::from(cell.address)];
                let cover = i32::from(cell.cover) + i32::from(cell.cover >> 7);
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let level = &mut plane[(column - x) as usize];
                    let leaf =
                        (((colour >> (8 * channel) & 0xff) * u32::from(sprite.gain)) >> 3).min(4_080) as i32;
                    *level = (i32::from(*level) + (((leaf - i32::from(*level)) * cover) >> 8)) as i16;
                }
            }
        }
    }
}

/// The block of a plane that begins at `start`.
#[inline(always)]
fn background<L: Lanes>(plane: &[u8], start: usize) -> L {
    if let Some(levels) = plane[start..].first_chunk() {
        return L::load_q7(levels).down::<3>();
    }
    let mut levels = [0; LANES];
    levels.iter_mut().zip(&plane[start..]).for_each(|(to, from)| *to = *from);
    L::load_q7(&levels).down::<3>()
}

/// A block of a plane's levels at `sources`.
#[inline(always)]
fn gathered<L: Lanes>(plane: &[u8], sources: &[u32]) -> L {
    let mut levels = [0; LANES];
    for (level, &source) in levels.iter_mut().zip(sources) {
        *level = plane.get(source as usize).map_or(0, |&level| i16::from(level) << 4);
    }
    L::load(&levels)
}

/// Fractional bits of a place between two nodes.
const PLACE_BITS: u32 = OFFSET_BITS + PITCH.trailing_zeros();

/// Fills `blocks` with what stands and hangs in row `y`, from column `x` on.
struct Run<'a, 'b> {
    moment: &'a Moment<'b>,
    x: usize,
    y: u32,
    blocks: &'a mut [Block],
}

impl Task for Run<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for ([red, green, blue], x) in self.blocks.iter_mut().zip((self.x..).step_by(LANES)) {
            let colours: [L; 3] = self.moment.block(x, self.y as usize);
            colours[0].store(red);
            colours[1].store(green);
            colours[2].store(blue);
        }
    }
}

impl effect::Moment for Moment<'_> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.planes.size
    }

    #[inline(always)]
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let [columns, rows] = &self.moving;
        rows.contains(&(y as usize)).then(|| columns.clone()).into_iter()
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        on_widest(Run { moment: self, x, y, blocks });
        let airborne = self.airborne(y);
        if airborne != 0 {
            for (block, x) in blocks.iter_mut().zip((x..).step_by(LANES)) {
                self.paint_airborne(airborne, x, y, block);
            }
        }
    }
}
