/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Rect {
    /// The smallest rectangle that holds every pixel that differs between two pictures of `width` pixels a row and `N` bytes a
    /// pixel; `None` if they are equal.
    pub(super) fn changed<const N: usize>(before: &[u8], after: &[u8], width: u32) -> Option<Self> {
        let row_bytes = width as usize * N;
        let rows = || before.chunks_exact(row_bytes).zip(after.chunks_exact(row_bytes));
        let top = rows().position(|(a, b)| a != b)?;
        let bottom = rows().rposition(|(a, b)| a != b)?;
        let (mut left, mut right) = (row_bytes, 0);
        for (a, b) in rows().take(bottom + 1).skip(top) {
            let differs = |(a, b): (&u8, &u8)| a != b;
            // Only what lies outside of the columns found so far can widen them.
            left = a.iter().zip(b).take(left).position(differs).unwrap_or(left);
            right = a.iter().zip(b).skip(right).rposition(differs).map_or(right, |i| i + right + 1);
        }
        let (left, right) = (left / N, right.div_ceil(N));
        Some(Self {
            left: left as u32,
            top: top as u32,
            width: (right - left) as u32,
            height: (bottom + 1 - top) as u32,
        })
    }

    /// The first pixel alone: for formats in which a frame without any change still stores a rectangle.
    pub(super) const fn first_pixel() -> Self {
        Self { left: 0, top: 0, width: 1, height: 1 }
    }

    /// Everything of a picture of that size.
    pub(super) const fn all(size: crate::frame::Size) -> Self {
        Self { left: 0, top: 0, width: size.width, height: size.height }
    }

    /// This rectangle grown to the left and top, where needed, to start in an even column and row.
    pub(super) const fn starting_even(self) -> Self {
        let (odd_x, odd_y) = (self.left % 2, self.top % 2);
        Self {
            left: self.left - odd_x,
            top: self.top - odd_y,
            width: self.width + odd_x,
            height: self.height + odd_y,
        }
    }

    /// The pixels of `picture` within, row after row, into `cut`.
    pub(super) fn cut<const N: usize>(self, picture: &[u8], width: u32, cut: &mut Vec<u8>) {
        cut.clear();
        let rows = picture.chunks_exact(width as usize * N).skip(self.top as usize);
        for row in rows.take(self.height as usize) {
            cut.extend_from_slice(&row[self.left as usize * N..][..self.width as usize * N]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangle_is_the_smallest_that_holds_the_changes() {
        let before = [0_u8; 7 * 5 * 3];
        let mut after = before;
        assert_eq!(Rect::changed::<3>(&before, &after, 7), None);
        for (x, y) in [(4, 1), (2, 3), (5, 2)] {
            after[(y * 7 + x) * 3 + 1] = 1;
        }
        let rect = Rect { left: 2, top: 1, width: 4, height: 3 };
        assert_eq!(Rect::changed::<3>(&before, &after, 7), Some(rect));
        assert_eq!(rect.starting_even(), Rect { left: 2, top: 0, width: 4, height: 4 });
        let mut cut = Vec::new();
        rect.cut::<3>(&after, 7, &mut cut);
        assert_eq!(cut.iter().filter(|b| **b == 1).count(), 3);
        assert_eq!(cut.len(), 4 * 3 * 3);
    }
}
