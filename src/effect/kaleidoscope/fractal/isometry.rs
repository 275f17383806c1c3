//! The eight isometries of the square, numbered as in the paper's table 1.

/// An isometry j: the range's place is M_j times the domain's, both seen from the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Isometry(u8);

/// M_j, row by row.
const MATRICES: [[i8; 4]; 8] = [
    [1, 0, 0, 1],
    [-1, 0, 0, 1],
    [1, 0, 0, -1],
    [-1, 0, 0, -1],
    [0, 1, 1, 0],
    [0, 1, -1, 0],
    [0, -1, 1, 0],
    [0, -1, -1, 0],
];

/// How the pixels of a range read the contracted plane: pixel (u, v) reads `start + u·right + v·down`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Strides {
    pub(in super::super) start: isize,
    pub(in super::super) right: isize,
    pub(in super::super) down: isize,
}

impl Isometry {
    pub(super) const COUNT: u8 = 8;

    pub(super) const fn from_index(index: u8) -> Self {
        Self(index % Self::COUNT)
    }

    pub(super) const fn index(self) -> u8 {
        self.0
    }

    /// First `self`, then `next`.
    pub(super) fn then(self, next: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (next.matrix(), self.matrix());
        Self::of([a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h])
    }

    pub(super) fn inverse(self) -> Self {
        let [a, b, c, d] = self.matrix();
        Self::of([a, c, b, d])
    }

    pub(super) const fn matrix(self) -> [i8; 4] {
        MATRICES[self.0 as usize]
    }

    pub(super) fn of(matrix: [i8; 4]) -> Self {
        let found = MATRICES.iter().position(|&other| other == matrix);
        Self(found.unwrap_or_else(|| unreachable!("isometries are a group")) as u8)
    }

    /// How a range of `side` reads its domain, whose upper left corner is at `corner` in a plane of `width`.
    pub(super) const fn strides(self, corner: usize, width: usize, side: usize) -> Strides {
        // The domain's place is the inverse, which is the transpose, times the range's.
        let [a, b, c, d] = self.matrix();
        let (width, last) = (width as isize, side as isize - 1);
        // A row of the inverse sums to −1 where the range's first corner reads the domain's far end.
        let (x, y) = ((1 - (a + c) as isize) / 2 * last, (1 - (b + d) as isize) / 2 * last);
        Strides {
            start: corner as isize + y * width + x,
            right: a as isize + b as isize * width,
            down: c as isize + d as isize * width,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_isometry_reads_every_pixel_of_the_domain_once_and_where_the_paper_says() {
        let (side, width, corner) = (4_usize, 11_usize, 25_usize);
        for j in 0..8 {
            let strides = Isometry::from_index(j).strides(corner, width, side);
            let [a, b, c, d] = MATRICES[usize::from(j)].map(isize::from);
            let mut read = Vec::new();
            for (u, v) in (0..4_isize).flat_map(|v| (0..4).map(move |u| (u, v))) {
                let at = (strides.start + u * strides.right + v * strides.down) as usize;
                let (x, y) = ((at % width - corner % width) as isize, (at / width - corner / width) as isize);
                // Twice the place seen from the middle.
                let (x2, y2) = (2 * x - 3, 2 * y - 3);
                assert_eq!((2 * u - 3, 2 * v - 3), (a * x2 + b * y2, c * x2 + d * y2), "j {j}");
                read.push(at);
            }
            read.sort_unstable();
            read.dedup();
            assert_eq!(read.len(), 16, "j {j}");
        }
    }

    #[test]
    fn an_isometry_and_its_inverse_are_the_identity() {
        for j in (0..8).map(Isometry::from_index) {
            assert_eq!(j.then(j.inverse()), Isometry(0));
            assert_eq!(j.inverse().then(j), Isometry(0));
        }
    }
}
