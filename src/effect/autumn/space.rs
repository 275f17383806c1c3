//! Affine maps of space and plane in fixed point: what L-systems and leaves are made of.

use crate::math::Turns;

/// Fractional bits of lengths and of the entries of matrices: steps of 6e-8, and room for lengths of up to 127 trunks.
pub(super) const BITS: u32 = 24;

/// One.
pub(super) const ONE: i32 = 1 << BITS;

/// The product of two numbers with [`BITS`] fractional bits.
pub(super) const fn times(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64 + (1 << (BITS - 1))) >> BITS) as i32
}

/// Right, up, towards the viewer.
pub(super) type Vector = [i32; 3];

/// An orientation times a scale; a column an axis: right, up (the heading), towards the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Matrix(pub(super) [Vector; 3]);

/// The axis of a rotation, as the turtle sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// Pitch: about its right; tips the heading towards the viewer.
    Right,
    /// Roll: about its heading.
    Heading,
    /// Turn: about what points to the viewer; tips the heading to the left.
    Viewer,
}

impl Matrix {
    /// Upright, of scale 1.
    pub(super) const IDENTITY: Self = Self([[ONE, 0, 0], [0, ONE, 0], [0, 0, ONE]]);

    /// The rotation by `angle` about `axis`.
    pub(super) fn rotation(axis: Axis, angle: Turns) -> Self {
        let (sin, cos) = (angle.sin().to_bits() >> 4, angle.cos().to_bits() >> 4);
        Self(match axis {
            Axis::Right => [[ONE, 0, 0], [0, cos, sin], [0, -sin, cos]],
            Axis::Heading => [[cos, 0, -sin], [0, ONE, 0], [sin, 0, cos]],
            Axis::Viewer => [[cos, sin, 0], [-sin, cos, 0], [0, 0, ONE]],
        })
    }

    /// This matrix with all lengths times `scale`.
    pub(super) fn scaled(self, scale: i32) -> Self {
        Self(self.0.map(|column| column.map(|entry| times(entry, scale))))
    }

    /// What becomes of `vector`.
    pub(super) fn apply(&self, vector: Vector) -> Vector {
        let [right, up, viewer] = self.0;
        core::array::from_fn(|i| {
            times(right[i], vector[0]) + times(up[i], vector[1]) + times(viewer[i], vector[2])
        })
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self(inner.0.map(|column| self.apply(column)))
    }
}

/// x -> matrix·x + shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AffineMap {
    pub(super) matrix: Matrix,
    pub(super) shift: Vector,
}

impl AffineMap {
    /// Changes nothing.
    pub(super) const IDENTITY: Self = Self { matrix: Matrix::IDENTITY, shift: [0; 3] };

    /// Where `point` comes to lie.
    pub(super) fn apply(&self, point: Vector) -> Vector {
        plus(self.matrix.apply(point), self.shift)
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self { matrix: self.matrix.after(&inner.matrix), shift: self.apply(inner.shift) }
    }
}

/// The sum of two vectors.
pub(super) fn plus(a: Vector, b: Vector) -> Vector {
    core::array::from_fn(|i| a[i] + b[i])
}

/// x -> a·x + b·y + e, y -> c·x + d·y + f: a map of the plane, in the order in which leaves are written down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PlaneMap {
    pub(super) a: i32,
    pub(super) b: i32,
    pub(super) c: i32,
    pub(super) d: i32,
    pub(super) e: i32,
    pub(super) f: i32,
}

impl PlaneMap {
    /// Changes nothing.
    pub(super) const IDENTITY: Self = Self { a: ONE, b: 0, c: 0, d: ONE, e: 0, f: 0 };

    /// Where the point (x, y) comes to lie.
    pub(super) const fn apply(&self, x: i32, y: i32) -> (i32, i32) {
        (times(self.a, x) + times(self.b, y) + self.e, times(self.c, x) + times(self.d, y) + self.f)
    }

    /// First `inner`, then this.
    pub(super) const fn after(&self, inner: &Self) -> Self {
        let (a, c) = (
            times(self.a, inner.a) + times(self.b, inner.c),
            times(self.c, inner.a) + times(self.d, inner.c),
        );
        let (b, d) = (
            times(self.a, inner.b) + times(self.b, inner.d),
            times(self.c, inner.b) + times(self.d, inner.d),
        );
        let (e, f) = self.apply(inner.e, inner.f);
        Self { a, b, c, d, e, f }
    }

    /// Whether all distances shrink: the larger singular value is below 1. With T the sum of the squares of the entries and D the
    /// determinant, that is T < 1 + D² and D² < 1.
    pub(super) fn is_contracting(&self) -> bool {
        let square = |entry: i32| i128::from(entry) * i128::from(entry);
        let sum = square(self.a) + square(self.b) + square(self.c) + square(self.d);
        let determinant = i128::from(self.a) * i128::from(self.d) - i128::from(self.b) * i128::from(self.c);
        let one = 1_i128 << (2 * BITS);
        determinant.abs() < one && (sum - one) * one < determinant * determinant
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rotations_turn_the_way_they_say() {
        let up = [0, ONE, 0];
        let quarter = |axis, vector| Matrix::rotation(axis, Turns::QUARTER).apply(vector);
        assert_eq!(quarter(Axis::Right, up), [0, 0, ONE]);
        assert_eq!(quarter(Axis::Heading, up), up);
        assert_eq!(quarter(Axis::Viewer, up), [-ONE, 0, 0]);
        assert_eq!(quarter(Axis::Heading, [0, 0, ONE]), [ONE, 0, 0]);
    }

    /// The larger singular value in f64.
    fn stretch(map: &PlaneMap) -> f64 {
        let [a, b, c, d] = [map.a, map.b, map.c, map.d].map(|entry| f64::from(entry) / f64::from(ONE));
        let (sum, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
        ((sum + (sum * sum - 4. * determinant * determinant).max(0.).sqrt()) / 2.).sqrt()
    }

    proptest! {
        #[test]
        fn contraction_is_told_as_the_singular_value_tells_it(entries: [i32; 4]) {
            let [a, b, c, d] = entries.map(|entry| entry >> 6);
            let map = PlaneMap { a, b, c, d, e: 0, f: 0 };
            let exact = stretch(&map);
            prop_assume!((exact - 1.).abs() > 1e-9);
            prop_assert_eq!(map.is_contracting(), exact < 1.);
        }

        #[test]
        fn maps_in_a_row_are_one_map(x in -ONE..ONE, y in -ONE..ONE, entries: [i32; 4]) {
            let [a, b, c, d] = entries.map(|entry| entry >> 8);
            let map = PlaneMap { a, b, c, d, e: c, f: b };
            let (first_x, first_y) = map.apply(x, y);
            let (want, got) = (map.apply(first_x, first_y), map.after(&map).apply(x, y));
            prop_assert!(want.0.abs_diff(got.0) < 16 && want.1.abs_diff(got.1) < 16);
        }
    }
}
