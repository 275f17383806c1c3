//! What the rule looks at: colour, texture and its direction, and the sky, for every cell of the grid.

use super::grid::{BoxFilter, Grid};

/// Planes that [`Features`] keeps.
pub(super) const PLANES: usize = 11;

/// The features of a whole photo, a plane each.
pub(super) struct Features<'a> {
    pub(super) grid: Grid,
    pub(super) red: &'a mut [i32],
    pub(super) green: &'a mut [i32],
    pub(super) blue: &'a mut [i32],
    pub(super) luma: &'a mut [i32],
    pub(super) fine: &'a mut [i32],
    pub(super) coarse: &'a mut [i32],
    pub(super) coherence: &'a mut [i32],
    pub(super) upright: &'a mut [i32],
    pub(super) squareness: &'a mut [i32],
    pub(super) dark: &'a mut [i32],
    pub(super) sky: &'a mut [i32],
}

/// The features of one cell. Colours are levels of 0..=255, shares are in 256ths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) red: i32,
    pub(super) green: i32,
    pub(super) blue: i32,
    pub(super) luma: i32,
    /// Mean distance of the luma from its 3 × 3 mean, in sixteenths of a level: leaf against leaf, ripple against ripple.
    pub(super) fine: i32,
    /// Mean distance of the 3 × 3 from the 11 × 11 mean, in sixteenths of a level: branch against branch, stone against stone.
    pub(super) coarse: i32,
    /// How much the gradients of the neighbourhood share one direction: 0 none, 256 a straight edge.
    pub(super) coherence: i32,
    /// −256 horizontal streaks, 256 upright ones, 0 neither.
    pub(super) upright: i32,
    /// How much the gradients of a wide neighbourhood fall into two directions at right angles: bricks, windows, planks.
    pub(super) squareness: i32,
    /// How much of a window of a third of the picture is dark, or of the whole picture where that is more.
    pub(super) dark: i32,
    /// How much of the nearest neighbourhood is sky.
    pub(super) sky: i32,
    /// How far down the picture: 0 at the upper edge, 256 at the lower.
    pub(super) depth: i32,
}

impl Features<'_> {
    /// The features of cell `i`, row by row.
    pub(super) fn cell(&self, i: usize) -> Cell {
        let level = |plane: &[i32]| (plane[i] + 8) >> 4;
        Cell {
            red: level(self.red),
            green: level(self.green),
            blue: level(self.blue),
            luma: level(self.luma),
            fine: self.fine[i],
            coarse: self.coarse[i],
            coherence: self.coherence[i],
            upright: self.upright[i],
            squareness: self.squareness[i],
            dark: self.dark[i],
            sky: self.sky[i],
            depth: (i / self.grid.width * 256 / self.grid.height) as i32,
        }
    }

    /// Fills every plane from red, green and blue, in sixteenths of a level.
    pub(super) fn measure(&mut self, filter: &mut BoxFilter<'_>, [a, b]: [&mut [i32]; 2]) {
        for (luma, ((r, g), b)) in
            self.luma.iter_mut().zip(self.red.iter().zip(&*self.green).zip(&*self.blue))
        {
            *luma = (77 * r + 150 * g + 29 * b) >> 8;
        }
        self.measure_texture(filter, a, b);
        self.measure_direction(filter, a, b);
        for (dark, luma) in self.dark.iter_mut().zip(&*self.luma) {
            *dark = if *luma < DARK { 256 } else { 0 };
        }
        let night = self.dark.iter().sum::<i32>() / self.dark.len() as i32;
        filter.mean_in_place(self.dark, SURROUND_RADIUS);
        for dark in &mut *self.dark {
            *dark = night.max(*dark);
        }
        self.find_sky(filter);
    }

    fn measure_texture(&mut self, filter: &mut BoxFilter<'_>, near: &mut [i32], far: &mut [i32]) {
        filter.mean(self.luma, 1, near);
        filter.mean(self.luma, 5, far);
        for (i, (near, far)) in near.iter().zip(&*far).enumerate() {
            self.fine[i] = (self.luma[i] - near).abs().min(EDGE_CAP);
            self.coarse[i] = (near - far).abs().min(2 * EDGE_CAP);
        }
        filter.mean_in_place(self.fine, TEXTURE_RADIUS);
        filter.mean_in_place(self.coarse, TEXTURE_RADIUS + 1);
    }

    /// The structure tensor (Förstner and Gülch 1987) for coherence and streaks, and the fourth harmonic of the gradients'
    /// directions for squareness.
    fn measure_direction(&mut self, filter: &mut BoxFilter<'_>, a: &mut [i32], b: &mut [i32]) {
        let grid = filter.grid;
        let doubled = |luma: &[i32], i: usize| {
            let (gx, gy) = gradient(grid, luma, i);
            (gx * gx - gy * gy, 2 * gx * gy, gx * gx + gy * gy)
        };
        let s = &mut *self.squareness;
        for i in 0..grid.cells() {
            (a[i], b[i], s[i]) = doubled(self.luma, i);
        }
        filter.mean_in_place(a, DIRECTION_RADIUS);
        filter.mean_in_place(b, DIRECTION_RADIUS);
        filter.mean_in_place(s, DIRECTION_RADIUS);
        for i in 0..grid.cells() {
            let total = s[i] + FLAT_ENERGY;
            self.coherence[i] = share(length(a[i], b[i]), total);
            self.upright[i] = share(a[i], total);
        }
        for i in 0..grid.cells() {
            let (x, y, energy) = doubled(self.luma, i);
            let weight = (energy as u32).isqrt() as i32;
            let (x, y) = (share(x, energy.max(1)), share(y, energy.max(1)));
            (a[i], b[i], s[i]) = (weight * (x * x - y * y) / 256, weight * (2 * x * y) / 256, weight * 256);
        }
        filter.mean_in_place(a, SQUARE_RADIUS);
        filter.mean_in_place(b, SQUARE_RADIUS);
        filter.mean_in_place(s, SQUARE_RADIUS);
        for i in 0..grid.cells() {
            s[i] = share(length(a[i], b[i]), s[i] + FLAT_WEIGHT);
        }
    }

    /// Grows the sky from the picture's upper edge, and from bright cool cells near it, over smooth cells that are not green.
    fn find_sky(&mut self, filter: &mut BoxFilter<'_>) {
        let grid = filter.grid;
        for i in 0..grid.cells() {
            let c = self.cell(i);
            let pale =
                c.luma > SKY_LUMA && c.blue * 10 >= c.red * 9 && c.green - (c.red + c.blue) / 2 < SKY_GREEN;
            let candidate = pale && c.fine < SKY_FINE && c.upright < SKY_UPRIGHT;
            let bright = c.luma > SKY_SEED_LUMA && c.blue >= c.red && c.depth < SKY_SEED_DEPTH;
            let seed = i < grid.width || bright;
            self.sky[i] = match (candidate, seed) {
                (false, _) => NO_SKY,
                (true, false) => MAY_BE_SKY,
                (true, true) => SKY,
            };
        }
        for _ in 0..SKY_SWEEPS {
            let forward = (1..grid.cells()).fold(false, |grew, i| self.grow_sky(grid, i, false) | grew);
            let backward = (0..grid.cells()).rev().fold(false, |grew, i| self.grow_sky(grid, i, true) | grew);
            if !forward && !backward {
                break;
            }
        }
        for sky in &mut *self.sky {
            *sky = if *sky == SKY { 256 } else { 0 };
        }
        filter.mean_in_place(self.sky, SKY_FRINGE);
    }

    /// How much of the picture's upper quarter is sky.
    pub(super) fn sky_share(&self) -> i32 {
        let upper = &self.sky[..self.grid.width * self.grid.height.div_ceil(4)];
        upper.iter().sum::<i32>() / upper.len() as i32
    }

    /// Makes cell `i` sky if it may be and joins one that is, before it in the sweep.
    fn grow_sky(&mut self, grid: Grid, i: usize, backward: bool) -> bool {
        if self.sky[i] != MAY_BE_SKY {
            return false;
        }
        let (x, y) = (i % grid.width, i / grid.width);
        let (beside, over) = if backward {
            ((x + 1 < grid.width).then(|| i + 1), (y + 1 < grid.height).then(|| i + grid.width))
        } else {
            ((x > 0).then(|| i - 1), (y > 0).then(|| i - grid.width))
        };
        let joins = |from: Option<usize>| {
            from.is_some_and(|from| {
                self.sky[from] == SKY && (self.luma[from] - self.luma[i]).abs() < SKY_STEP
            })
        };
        let grows = joins(beside) || joins(over);
        if grows {
            self.sky[i] = SKY;
        }
        grows
    }
}

/// An isolated edge counts at most 24 levels, in sixteenths, so that one strong outline is no texture.
const EDGE_CAP: i32 = 24 * 16;
/// Texture is a mean over 7 × 7 cells: a leaf and its neighbours, not the whole crown.
const TEXTURE_RADIUS: usize = 3;
/// Direction is a mean over 9 × 9 cells: a few ripples.
const DIRECTION_RADIUS: usize = 4;
/// Squareness is a mean over 25 × 25 cells: a window with its frame, some rows of bricks.
const SQUARE_RADIUS: usize = 12;
/// The surround is a third of the longest side.
const SURROUND_RADIUS: usize = 53;
/// Energy of a gradient of one level a cell: below it a direction is noise.
const FLAT_ENERGY: i32 = 64;
/// The same for the sum of the gradients' lengths.
const FLAT_WEIGHT: i32 = 8 * 256;
/// Luma under which a cell is dark: 48 levels, in sixteenths.
const DARK: i32 = 48 * 16;

const NO_SKY: i32 = 0;
const MAY_BE_SKY: i32 = 1;
const SKY: i32 = 2;

/// Sky is smooth: clouds have a fine texture of 10 to 55, treetops 90 and more.
const SKY_FINE: i32 = 56;
/// Sky is not night.
const SKY_LUMA: i32 = 40;
/// Sky is not green, by so many levels.
const SKY_GREEN: i32 = 8;
/// Sky has no upright streaks: what is white and has them is falling water, or a wall.
const SKY_UPRIGHT: i32 = 70;
/// From cell to cell the sky's luma steps less than 12 levels, in sixteenths: the horizon is a border.
const SKY_STEP: i32 = 12 * 16;
/// Bright cool cells in the upper two fifths are sky even where a branch or a roof of rock closes the upper edge.
const SKY_SEED_LUMA: i32 = 150;
const SKY_SEED_DEPTH: i32 = 100;
/// Sweeps forth and back that the sky's growth may take; a sky winding through more turns than these is cut.
const SKY_SWEEPS: usize = 12;
/// Cells around the sky that count as near it, softly.
const SKY_FRINGE: usize = 3;

/// Central differences of the luma, in quarter levels over two cells, capped.
fn gradient(grid: Grid, luma: &[i32], i: usize) -> (i32, i32) {
    let (x, y) = ((i % grid.width) as isize, (i / grid.width) as isize);
    let cap = EDGE_CAP / 2;
    let gx = (grid.at(luma, x + 1, y) - grid.at(luma, x - 1, y)) / 4;
    let gy = (grid.at(luma, x, y + 1) - grid.at(luma, x, y - 1)) / 4;
    let longest = gx.abs().max(gy.abs());
    if longest > cap { (gx * cap / longest, gy * cap / longest) } else { (gx, gy) }
}

/// `part` of `whole` in 256ths.
fn share(part: i32, whole: i32) -> i32 {
    (i64::from(part) * 256 / i64::from(whole)) as i32
}

fn length(x: i32, y: i32) -> i32 {
    let square = |v: i32| u64::from(v.unsigned_abs()).pow(2);
    (square(x) + square(y)).isqrt() as i32
}
