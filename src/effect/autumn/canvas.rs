//! Painting wood and leaves into the address buffer.
//!
//! In the plane the fractal top function decides what is in front: the smallest word. In space the depth takes its place.

use super::{
    grow::{Branch, Leaf, Twig, Visit, sway_of},
    leaf::{self, Stencil},
    mount::Mount,
    noise::fbm,
    space::ONE,
    species::Species,
    storage::Texel,
    sunlight::{Columns, NO_SHADE},
    view::{SPOT_BITS, Spot, TREE_DEPTHS, View},
};
use crate::{
    frame::Size,
    math::{Turns, random::scatter},
};

/// How much farther the round ends of a piece of wood lie than the piece that goes on there.
const CAP_BEHIND: u16 = 60;

/// Half a pixel.
const HALF: i32 = 1 << (SPOT_BITS - 1);

/// What a leaf's picture is made from, whether on the tree, on the ground or in the air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// Its centre, in steps of 1/256 pixel.
    pub(super) x: i32,
    pub(super) y: i32,
    /// Half the side of its stencil, in steps of 1/256 pixel.
    pub(super) half: i32,
    /// How it is turned in the picture; at zero its tip is up.
    pub(super) turn: Turns,
    /// Across what direction it is seen from aside,
    pub(super) fold: Turns,
    /// and how wide it is there, of 256.
    pub(super) width: i32,
}

/// From pixels to cells of a stencil.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    pose: Pose,
    /// Columns and rows of the stencil a pixel, in steps of 2^-16.
    across: [i64; 2],
    down: [i64; 2],
}

impl Lens {
    pub(super) fn new(pose: Pose) -> Self {
        let unit =
            |angle: Turns| (i64::from(angle.sin().to_bits() >> 12), i64::from(angle.cos().to_bits() >> 12));
        let ((ts, tc), (fs, fc)) = (unit(pose.turn), unit(pose.fold));
        let stretch = (1 << 24) / i64::from(pose.width.max(32)); // 1/width, of 2^16
        // The inverse of: turn, then squeeze by `width` along `fold`.
        let squeeze = |x: i64, y: i64| {
            let along = (((fc * x + fs * y) >> 16) * stretch) >> 16;
            let aside = (fc * y - fs * x) >> 16;
            let (x, y) = ((fc * along - fs * aside) >> 16, (fs * along + fc * aside) >> 16);
            ((tc * x + ts * y) >> 16, (tc * y - ts * x) >> 16)
        };
        let scale = |(x, y): (i64, i64)| {
            let cells = (leaf::SIDE as i64 / 2) << SPOT_BITS;
            [x * cells / i64::from(pose.half.max(1)), y * cells / i64::from(pose.half.max(1))]
        };
        Self { pose, across: scale(squeeze(1 << 16, 0)), down: scale(squeeze(0, 1 << 16)) }
    }

    /// The cell of the stencil that the middle of pixel (x, y) shows.
    #[inline]
    pub(super) fn cell(&self, stencil: &[leaf::Cell], x: i32, y: i32) -> leaf::Cell {
        let (x, y) = ((x << SPOT_BITS) + HALF - self.pose.x, (y << SPOT_BITS) + HALF - self.pose.y);
        let at = |i: usize| {
            let cells = self.across[i] * i64::from(x) + self.down[i] * i64::from(y);
            (cells >> (16 + SPOT_BITS)) + leaf::SIDE as i64 / 2
        };
        let (column, row) = (at(0), at(1));
        let inside = 0..leaf::SIDE as i64;
        if !inside.contains(&column) || !inside.contains(&row) {
            return leaf::Cell::default();
        }
        stencil[row as usize * leaf::SIDE + column as usize]
    }

    /// The columns and the rows that the leaf can reach, of a picture of `size`.
    pub(super) fn extent(&self, size: Size) -> [core::ops::Range<i32>; 2] {
        // A square's corner is √2 away.
        let reach = self.pose.half * 3 / 2;
        let range = |at: i32, most: u32| {
            let (low, high) = ((at - reach) >> SPOT_BITS, ((at + reach) >> SPOT_BITS) + 1);
            low.clamp(0, most as i32)..high.clamp(0, most as i32)
        };
        [range(self.pose.x, size.width), range(self.pose.y, size.height)]
    }
}

/// What is painted on.
#[derive(Debug)]
pub(super) struct Canvas<'a> {
    pub(super) mount: Mount,
    pub(super) texels: &'a mut [Texel],
}

impl Canvas<'_> {
    /// Paints a leaf of `twig`. Of two leaves that cover most of a pixel, the nearer is seen there.
    pub(super) fn leaf(&mut self, stencil: &Stencil, pose: Pose, twig: usize, depth: u16, shade: u8) {
        let lens = Lens::new(pose);
        let [columns, rows] = lens.extent(self.mount.upright());
        for y in rows {
            for x in columns.clone() {
                let cell = lens.cell(stencil, x, y);
                let texel = &mut self.texels[self.mount.index(x, y)];
                let shows = if cell.cover >= 128 {
                    depth >= texel.depth || (texel.cover < 128 && texel.wood < 128)
                } else {
                    cell.cover > texel.cover && depth >= texel.depth
                };
                if shows && cell.cover > 0 {
                    texel.address = ((twig as u16) << 4) | u16::from(cell.address);
                    texel.depth = depth;
                    texel.shade = shade;
                }
                // Two leaves that share a pixel cover it together.
                if shows || texel.cover > 0 {
                    texel.cover = texel.cover.max(cell.cover);
                }
            }
        }
    }

    /// Paints a straight piece of wood.
    fn stick(&mut self, ends: [Spot; 2], radii: [i32; 2], look: &Bark) {
        let [a, b] = ends;
        let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
        let square = (dx * dx + dy * dy).max(1);
        let length = square.isqrt().max(1);
        let thick = radii[0].max(radii[1]) + HALF;
        let range = |p: i32, q: i32, most: u32| {
            let (low, high) = ((p.min(q) - thick) >> SPOT_BITS, ((p.max(q) + thick) >> SPOT_BITS) + 1);
            low.clamp(0, most as i32)..high.clamp(0, most as i32)
        };
        let size = self.mount.upright();
        for y in range(a.y, b.y, size.height) {
            for x in range(a.x, b.x, size.width) {
                let (px, py) = ((x << SPOT_BITS) + HALF - a.x, (y << SPOT_BITS) + HALF - a.y);
                let (px, py) = (i64::from(px), i64::from(py));
                let along = (((px * dx + py * dy) << 12) / square).clamp(0, 4_096) as i32;
                let (fx, fy) = (px - ((dx * i64::from(along)) >> 12), py - ((dy * i64::from(along)) >> 12));
                let distance = (fx * fx + fy * fy).isqrt() as i32;
                let radius = radii[0] + (((radii[1] - radii[0]) * along) >> 12);
                let cover = (radius - distance + HALF).clamp(0, 255);
                // Wood thinner than a pixel covers what it covers.
                let cover = cover.min(2 * radius.max(20)) as u8;
                let texel = &mut self.texels[self.mount.index(x, y)];
                let depth = i32::from(a.depth) + (((i32::from(b.depth) - i32::from(a.depth)) * along) >> 12);
                let depth = depth.clamp((*TREE_DEPTHS.start()).into(), (*TREE_DEPTHS.end()).into()) as u16;
                // Beyond its ends a piece only fills what the next leaves open.
                let is_within = along > 0 && along < 4_096;
                if cover == 0 || (y << SPOT_BITS) > look.ground(x) {
                    continue;
                }
                let depth = if is_within { depth } else { depth.saturating_sub(CAP_BEHIND) };
                let shows =
                    if cover >= 128 { depth >= texel.depth || texel.wood < 128 } else { cover > texel.wood };
                texel.wood = texel.wood.max(cover);
                if !shows {
                    continue;
                }
                // Across the wood, −256..256 from its left edge, seen along its growth, to its right.
                let across =
                    ((px * dy - py * dx) / length * 256 / i64::from(radius.max(1))).clamp(-256, 256) as i32;
                texel.bark = look.level(across, along, [dx, dy], length, radius);
                texel.depth = depth;
            }
        }
    }
}

/// How a piece of wood looks.
struct Bark {
    seed: u64,
    marks: bool,
    /// Where the ground is: wood below it is hidden by grass. In steps of 1/256 pixel.
    ground: i32,
    /// Where along the branch the piece begins, in steps of 1/256 pixel.
    start: i64,
    /// How wide a pixel is beside the picture: 2^16 / its height.
    grain: i64,
}

impl Bark {
    /// How far down the wood is seen in column `x`: to the blades of grass before it.
    fn ground(&self, x: i32) -> i32 {
        let blades = (i64::from(x) * self.grain * 220) as i32;
        let tall = (1 << 16) * 8 / self.grain.max(1) as i32 / 5;
        self.ground - ((i64::from(tall) * i64::from(fbm(blades, 0, 3, 3))) >> 16) as i32
    }

    /// The brightness of the bark at a place of a piece of wood.
    fn level(&self, across: i32, along: i32, [dx, dy]: [i64; 2], length: i64, radius: i32) -> u8 {
        // The light comes from the upper left and from the front; the normal of a cylinder.
        let front = i64::from(((1 << 16) - across * across).max(0) as u32).isqrt();
        let side = (-140 * dy / length) + (-120 * dx / length);
        let lit = ((i64::from(across) * side + front * 165) >> 8).max(0);
        // Round the cylinder the bark lies closer together towards the edges.
        let place = i64::from(across) * i64::from(across).abs() / 1_024 + i64::from(across);
        let around = (((place * i64::from(radius)) >> 8) * self.grain * 3) >> 2;
        let up = ((self.start + ((length * i64::from(along)) >> 12)) * self.grain) >> 2;
        let rough = i64::from(fbm(around as i32, (up / 2) as i32, 4, self.seed));
        let mut level = ((58 + lit * 3 / 4) * ((1 << 15) + rough).max(1 << 13)) >> 15;
        if self.marks {
            let mark = fbm((around / 4) as i32, up as i32, 2, self.seed ^ 1);
            level = if mark > 12_000 { level / 4 } else { level * 5 / 4 + 20 };
        }
        level.clamp(1, 255) as u8
    }
}

/// Paints the tree.
pub(super) struct Painter<'a> {
    pub(super) canvas: Canvas<'a>,
    pub(super) species: &'a Species,
    pub(super) view: View,
    pub(super) stencil: &'a Stencil,
    pub(super) columns: Option<Columns<'a>>,
    pub(super) sunlight: &'a mut [u8],
    pub(super) spots: &'a mut [[i16; 2]],
}

impl Painter<'_> {
    fn light(&self, place: super::space::Vector) -> u8 {
        self.columns.as_ref().map_or(NO_SHADE, |columns| columns.light(place))
    }

    fn paint_leaf(&mut self, twig: &Twig, leaf: &Leaf) -> u8 {
        let Leaf { place, half, key } = *leaf;
        let spot = self.view.spot(place);
        let light = self.light(place);
        let depth = match self.species.rule.is_flat {
            false => spot.depth,
            true => TREE_DEPTHS.end() - (twig.number as u16),
        };
        let near = u32::from(depth - TREE_DEPTHS.start());
        // 0.78 + 0.22 z, with z from −1 to 1; and the shade of the leaves above, and every leaf's own slope.
        let far_shade = 143 + 113 * near / u32::from(TREE_DEPTHS.end() - TREE_DEPTHS.start());
        let sun_shade = 150 + 106 * u32::from(light) / 255;
        let slope = (256 + sway_of(key >> 24, 44)) as u32;
        let shade = (((((far_shade * sun_shade) >> 8) * slope) >> 8) * 140) >> 8;
        let loose = ONE - (self.species.droop.to_bits() << 8).min(ONE);
        let hang = (i64::from(sway_of(key, loose)) << 7) as u32;
        let base = if loose == ONE { 0 } else { 1 << 31 };
        let pose = Pose {
            x: spot.x,
            y: spot.y,
            half: self.view.length(half),
            turn: Turns(hang.wrapping_add(base)),
            fold: Turns((key >> 32) as u32),
            width: 130 + (key >> 16 & 127) as i32,
        };
        self.canvas.leaf(self.stencil, pose, twig.number, depth, shade.min(255) as u8);
        light
    }
}

impl Visit for Painter<'_> {
    fn branch(&mut self, branch: &Branch) {
        let steps: i32 = if branch.order < 3 { 8 } else { 2 };
        let radius_at = |t: i32| branch.radii[0] + (branch.radii[1] - branch.radii[0]) * t / steps;
        let at = |t: i32| {
            let between = core::array::from_fn(|i| {
                let line = i64::from(branch.from[i])
                    + i64::from(branch.to[i] - branch.from[i]) * i64::from(t) / i64::from(steps);
                let bow =
                    i64::from(branch.bend[i]) * i64::from(4 * t * (steps - t)) / i64::from(steps * steps);
                (line + bow) as i32
            });
            self.view.spot(between)
        };
        // The trunk spreads into its roots.
        let flare = |t: i32| match branch.order == 0 && branch.from == [0; 3] {
            true => 256 + 260 * (steps - t).pow(3) / steps.pow(3),
            false => 256,
        };
        let mut start = i64::from(self.view.length(branch.start));
        for t in 0..steps {
            let ends = [at(t), at(t + 1)];
            let radii = [t, t + 1]
                .map(|t| ((i64::from(self.view.length(radius_at(t))) * i64::from(flare(t))) >> 8) as i32);
            let grain = (1 << 16) / i64::from(self.canvas.mount.upright().height);
            let look = Bark {
                seed: branch.key,
                marks: self.species.bark_marks && branch.order < 3,
                ground: self.view.root[1],
                start,
                grain,
            };
            self.canvas.stick(ends, radii, &look);
            let [dx, dy] = [ends[1].x - ends[0].x, ends[1].y - ends[0].y].map(i64::from);
            start += (dx * dx + dy * dy).isqrt();
        }
    }

    fn twig(&mut self, twig: &Twig) {
        let mut light = 0;
        for leaf in twig.leaves(self.species) {
            light += u32::from(self.paint_leaf(twig, &leaf));
        }
        self.sunlight[twig.number] = (light / self.species.leaves) as u8;
        let spot = self.view.spot(twig.map.shift);
        self.spots[twig.number] = [spot.x, spot.y].map(|at| (at >> SPOT_BITS) as i16);
    }
}

/// Strews the leaves of the tree on the ground around its root.
pub(super) fn strew(canvas: &mut Canvas<'_>, species: &Species, view: &View, stencil: &Stencil, seed: u64) {
    let Size { width, height } = canvas.mount.upright();
    let (width, height) = (width as i32, height as i32);
    let [root_x, root_y] = view.root;
    let twigs = species.twigs();
    // As many as the tree bears would hide the grass.
    let count = (twigs * 3 / 2).min(6_000);
    for leaf in 0..count {
        let twig = leaf * twigs / count;
        let key = scatter(seed ^ 0x9_0000_0000 ^ leaf as u64);
        // Around the trunk, by a bell of either coordinate, −1..=1 of 2^16; what is behind lies closer together in the picture.
        let bell = |bits: u64| {
            let draws = (0..3).scan(bits, |bits, _| {
                *bits = scatter(*bits);
                Some(i64::from(sway_of(*bits, 1 << 16)))
            });
            draws.sum::<i64>() / 2
        };
        let (front, aside) = (bell(key), bell(!key));
        let foot = i64::from(root_y) + (i64::from(height) << SPOT_BITS) / 80;
        let horizon = (i64::from(height) << SPOT_BITS) * i64::from(species.scene.ground_top() + 1) / 256;
        let reach =
            if front < 0 { foot - horizon } else { ((i64::from(height) << SPOT_BITS) - foot) * 5 / 4 };
        let y = (foot + ((front * reach) >> 16)).max(horizon);
        let x = i64::from(root_x) + (i64::from(width) << SPOT_BITS) * aside * 26 / 100 / (1 << 16);
        // What is nearer is larger.
        let near = (256 + front.clamp(-(1 << 16), 1 << 16) * 110 / (1 << 16)) as i32;
        let leaf_size = ((height << SPOT_BITS) / 120 * near) >> 8;
        let pose = Pose {
            x: x as i32,
            y: y as i32,
            half: (leaf_size * (200 + (key >> 56) as i32 / 3)) >> 8,
            turn: Turns(scatter(key) as u32),
            // Lying: squeezed from top to bottom.
            fold: Turns(Turns::QUARTER.0.wrapping_add((sway_of(key >> 32, 1 << 28)) as u32)),
            width: 80 + (key >> 48 & 63) as i32,
        };
        let rows = (y >> SPOT_BITS).clamp(0, i64::from(height)) as u32;
        let rank = rows * u32::from(*TREE_DEPTHS.start()) / (height as u32 + 1);
        let depth =
            if y > i64::from(root_y) { u32::from(*TREE_DEPTHS.end()) + 1 + rank.min(16_000) } else { rank };
        let shade = 66 + ((key >> 40) & 31) as u8;
        canvas.leaf(stencil, pose, twig, depth as u16, shade);
    }
}
