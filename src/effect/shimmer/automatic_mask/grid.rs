//! The reduced grid that the rule is decided on, and box means over it.

use crate::frame::Size;

/// Cells along the longest side. At 1080p a cell is 6 × 6 pixels: leaves and ripples are still texture, the grain of the
/// sensor is averaged away, and the cost no longer depends on the panel.
pub(super) const LONGEST_SIDE: u32 = 320;

/// The reduced grid of a photo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Grid {
    /// The grid of a photo of `size`: its shape, the longest side at most [`LONGEST_SIDE`] cells, each side at least one.
    pub(super) const fn of(size: Size) -> Self {
        let longest = if size.width > size.height { size.width } else { size.height };
        if longest <= LONGEST_SIDE {
            return Self { width: size.width as usize, height: size.height as usize };
        }
        Self { width: cells(size.width, longest), height: cells(size.height, longest) }
    }

    pub(super) const fn cells(self) -> usize {
        self.width * self.height
    }

    /// The value of `plane` at a cell, the edge repeated outside.
    pub(super) fn at(self, plane: &[i32], x: isize, y: isize) -> i32 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        plane[y * self.width + x]
    }
}

const fn cells(side: u32, longest: u32) -> usize {
    let rounded = (side as u64 * LONGEST_SIDE as u64 + longest as u64 / 2) / longest as u64;
    if rounded == 0 { 1 } else { rounded as usize }
}

/// Averages the photo's pixels over the grid's cells into the planes of red, green and blue, in sixteenths of a level.
pub(super) fn reduce(rgb: &[u8], size: Size, grid: Grid, [red, green, blue]: [&mut [i32]; 3]) {
    let (width, height) = (size.width as usize, size.height as usize);
    for gy in 0..grid.height {
        let cells = gy * grid.width..(gy + 1) * grid.width;
        let (red, green, blue) = (&mut red[cells.clone()], &mut green[cells.clone()], &mut blue[cells]);
        red.fill(0);
        green.fill(0);
        blue.fill(0);
        let rows = gy * height / grid.height..(gy + 1) * height / grid.height;
        for y in rows.clone() {
            let row = &rgb[y * width * 3..][..width * 3];
            for gx in 0..grid.width {
                let columns = gx * width / grid.width..(gx + 1) * width / grid.width;
                for &[r, g, b] in row[columns.start * 3..columns.end * 3].as_chunks::<3>().0 {
                    red[gx] += i32::from(r);
                    green[gx] += i32::from(g);
                    blue[gx] += i32::from(b);
                }
            }
        }
        for gx in 0..grid.width {
            let columns = (gx + 1) * width / grid.width - gx * width / grid.width;
            let count = (rows.len() * columns) as i32;
            for plane in [&mut *red, &mut *green, &mut *blue] {
                plane[gx] = (plane[gx] * 16 + count / 2) / count;
            }
        }
    }
}

/// Memory for [`Self::mean`].
pub(super) struct BoxFilter<'a> {
    pub(super) grid: Grid,
    /// One value a cell.
    pub(super) rows: &'a mut [i32],
    /// One value a column.
    pub(super) columns: &'a mut [i32],
}

impl BoxFilter<'_> {
    /// Writes to `out` the mean of `plane` over a square of 2·`radius` + 1 cells a side, cut at the picture's edge. Running
    /// sums (Crow 1984; McDonnell 1981): the cost does not depend on the radius. Values times cells must stay within 32 bits.
    pub(super) fn mean(&mut self, plane: &[i32], radius: usize, out: &mut [i32]) {
        out.copy_from_slice(plane);
        self.mean_in_place(out, radius);
    }

    /// The same, in place.
    pub(super) fn mean_in_place(&mut self, plane: &mut [i32], radius: usize) {
        let Grid { width, height } = self.grid;
        for (row, sums) in plane.chunks_exact(width).zip(self.rows.chunks_exact_mut(width)) {
            let mut sum: i32 = row[..radius.min(width)].iter().sum();
            for x in 0..width {
                if x + radius < width {
                    sum += row[x + radius];
                }
                if x > radius {
                    sum -= row[x - radius - 1];
                }
                sums[x] = sum;
            }
        }
        self.columns.fill(0);
        for row in self.rows.chunks_exact(width).take(radius) {
            add(self.columns, row, 1);
        }
        for y in 0..height {
            if y + radius < height {
                add(self.columns, &self.rows[(y + radius) * width..][..width], 1);
            }
            if y > radius {
                add(self.columns, &self.rows[(y - radius - 1) * width..][..width], -1);
            }
            let rows = reach(y, radius, height);
            for (x, out) in plane[y * width..][..width].iter_mut().enumerate() {
                *out = self.columns[x] / (rows * reach(x, radius, width)) as i32;
            }
        }
    }
}

/// How many of `count` places lie within `radius` of `at`.
fn reach(at: usize, radius: usize, count: usize) -> usize {
    (at + radius + 1).min(count) - at.saturating_sub(radius)
}

fn add(sums: &mut [i32], row: &[i32], sign: i32) {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += sign * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean cell by cell, as a twin.
    fn mean_of_cells(grid: Grid, plane: &[i32], radius: usize, x: usize, y: usize) -> i32 {
        let near = |at: usize, side: usize| at.saturating_sub(radius)..(at + radius + 1).min(side);
        let cells =
            near(y, grid.height).flat_map(|y| near(x, grid.width).map(move |x| plane[y * grid.width + x]));
        let (sum, count) = cells.fold((0, 0), |(sum, count), value| (sum + value, count + 1));
        sum / count
    }

    proptest::proptest! {
        #[test]
        fn running_sums_give_the_mean_of_the_cells(
            width in 1_usize..34, height in 1_usize..18, radius in 0_usize..40, seed in 0_i32..1000,
        ) {
            let grid = Grid { width, height };
            let plane: Vec<i32> = (0..grid.cells() as i32).map(|i| (i * 7919 + seed * 31) % 4081 - 2040).collect();
            let (mut rows, mut columns, mut out) = (vec![9; grid.cells()], vec![9; width], vec![9; grid.cells()]);
            BoxFilter { grid, rows: &mut rows, columns: &mut columns }.mean(&plane, radius, &mut out);
            for (i, &mean) in out.iter().enumerate() {
                proptest::prop_assert_eq!(mean, mean_of_cells(grid, &plane, radius, i % width, i / width));
            }
        }
    }

    #[test]
    fn the_grid_keeps_the_shape_of_the_photo() {
        let grid = |width, height| Grid::of(Size::new(width, height));
        assert_eq!(grid(3840, 2160), Grid { width: 320, height: 180 });
        assert_eq!(grid(480, 640), Grid { width: 240, height: 320 });
        assert_eq!(grid(33, 17), Grid { width: 33, height: 17 });
        assert_eq!(grid(1, 5000), Grid { width: 1, height: 320 });
    }

    #[test]
    fn every_pixel_counts_once_in_the_reduction() {
        let size = Size::new(641, 323);
        let grid = Grid::of(size);
        let rgb = vec![[40_u8, 90, 200]; size.pixels()].concat();
        let (mut r, mut g, mut b) = (vec![0; grid.cells()], vec![0; grid.cells()], vec![0; grid.cells()]);
        reduce(&rgb, size, grid, [&mut r, &mut g, &mut b]);
        assert!(r.iter().all(|&v| v == 640) && g.iter().all(|&v| v == 1440) && b.iter().all(|&v| v == 3200));
    }
}
