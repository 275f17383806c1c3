//! Runs of pixels that move: what is still costs nothing a frame.

use bytemuck::{Pod, Zeroable};

/// The columns `start..end` of a row; empty where start = end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Span {
    pub(super) start: u16,
    pub(super) end: u16,
}

/// Spans closer than this many pixels are joined: computing a still pixel (its gain is 1) is cheaper than starting another span, and
/// it bounds their number.
const GAP: usize = 32;

/// The most spans that a row of `width` pixels has.
pub(super) const fn most(width: u32) -> usize {
    width as usize / (GAP + 1) + 1
}

/// Finds the spans of a row's mask; those that remain of `spans` are empty.
pub(super) fn find(mask: &[u8], spans: &mut [Span]) {
    spans.fill(Span::default());
    let mut found = 0_usize;
    for x in (0..mask.len()).filter(|&x| mask[x] != 0) {
        match found.checked_sub(1).map(|last| &mut spans[last]) {
            Some(last) if x - usize::from(last.end) < GAP => last.end = x as u16 + 1,
            _ => {
                spans[found] = Span { start: x as u16, end: x as u16 + 1 };
                found += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spans_cover_what_moves_and_fit_their_bound(
            mask in proptest::collection::vec(prop_oneof![20 => Just(0_u8), 1 => 1_u8..], 1..400)
        ) {
            let mut spans = vec![Span::default(); most(mask.len() as u32)];
            find(&mask, &mut spans);
            let inside = |x: usize| spans.iter().any(|s| (usize::from(s.start)..usize::from(s.end)).contains(&x));
            for (x, &moves) in mask.iter().enumerate() {
                prop_assert!(moves == 0 || inside(x));
            }
            for span in spans.iter().filter(|s| s.start < s.end) {
                prop_assert!(mask[usize::from(span.start)] != 0 && mask[usize::from(span.end) - 1] != 0);
            }
        }

        #[test]
        fn the_worst_row_fits(width in 1_usize..500, gap in 30_usize..36) {
            let mask: Vec<u8> = (0..width).map(|x| u8::from(x % (gap + 1) == 0)).collect();
            let mut spans = vec![Span::default(); most(width as u32)];
            find(&mask, &mut spans);
        }
    }
}
