//! Where on the panel a photo goes.

use crate::frame::{Rect, Size, resample::Axis};
use std::{fmt, str::FromStr};

/// How a photo is fitted to a panel of another shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Fit {
    /// The whole photo, as large as fits; the rest is filled by a blurred, darkened enlargement of it. A photo whose
    /// borders would be thinner than 1/64 of the panel is cut as by `Fill` instead.
    #[default]
    Blurred,
    /// The photo covers the panel; what sticks out is cut off evenly on both sides.
    Fill,
    /// The whole photo, as large as fits, on the background colour.
    Plain,
}

impl Fit {
    /// Every fit, in the order in which they are listed to people.
    pub const ALL: [Self; 3] = [Self::Blurred, Self::Fill, Self::Plain];

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Blurred => "blurred",
            Self::Fill => "fill",
            Self::Plain => "plain",
        }
    }
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that names no [`Fit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownFit;

impl fmt::Display for UnknownFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown fit; the known ones are {}", Fit::ALL.map(Fit::name).join(", "))
    }
}

impl std::error::Error for UnknownFit {}

impl FromStr for Fit {
    type Err = UnknownFit;

    fn from_str(word: &str) -> Result<Self, UnknownFit> {
        Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(word)).ok_or(UnknownFit)
    }
}

/// Borders thinner than this share of the panel are avoided: they look like a defect.
const THIN: u64 = 64;

/// Which part of a photo goes where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Placement {
    /// Where on the panel the photo lies.
    pub(super) picture: Rect,
    /// The share of the photo's width that is shown, as a fraction.
    width: (u64, u64),
    /// The share of the photo's height that is shown, as a fraction.
    height: (u64, u64),
}

impl Placement {
    /// The place of a photo of `source` pixels on a panel of `size`.
    pub(super) fn new(source: Size, size: Size, fit: Fit) -> Self {
        let [w, h, panel_w, panel_h] = [source.width, source.height, size.width, size.height].map(u64::from);
        // The photo's shape against the panel's: w / h against panel_w / panel_h.
        let (photo, panel) = (w * panel_h, h * panel_w);
        let whole = (1, 1);
        let thin = photo.abs_diff(panel) * THIN <= photo.max(panel) * 2;
        if fit == Fit::Fill || (fit == Fit::Blurred && thin) {
            let picture = Rect { x: 0, y: 0, size };
            return if photo > panel {
                Self { picture, width: (panel, photo), height: whole }
            } else {
                Self { picture, width: whole, height: (photo, panel) }
            };
        }
        let rounded = |value: u64, by: u64| ((value + by / 2) / by).max(1) as u32;
        let inside = if photo > panel {
            Size::new(size.width, rounded(h * panel_w, w))
        } else {
            Size::new(rounded(w * panel_h, h), size.height)
        };
        let picture =
            Rect { x: (size.width - inside.width) / 2, y: (size.height - inside.height) / 2, size: inside };
        Self { picture, width: whole, height: whole }
    }

    /// The shares of the photo's width and height that are shown, as fractions.
    pub(super) const fn shown(&self) -> [(u64, u64); 2] {
        [self.width, self.height]
    }

    /// The size that the whole photo has at the scale in which it is shown, rounded up.
    pub(super) fn whole(&self) -> Size {
        let side = |shown: u32, (part, whole): (u64, u64)| {
            u32::try_from((u64::from(shown) * whole).div_ceil(part)).unwrap_or(u32::MAX)
        };
        Size::new(side(self.picture.size.width, self.width), side(self.picture.size.height, self.height))
    }

    /// How the columns and rows of a picture of `stored` pixels, which is shown turned, are resampled.
    pub(super) fn axes(&self, stored: Size, turn: Turn) -> (Axis, Axis) {
        let out = turn.undo(self.picture.size);
        let (width, height) =
            if turn.transposed { (self.height, self.width) } else { (self.width, self.height) };
        (Axis::centred(stored.width, width, out.width), Axis::centred(stored.height, height, out.height))
    }
}

/// How stored pixels are turned to be shown: first mirrored, then rows become columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    mirror_x: bool,
    mirror_y: bool,
    transposed: bool,
}

impl Turn {
    /// The turn of an EXIF orientation, 1 to 8; anything else is none.
    pub(super) const fn from_exif(orientation: u8) -> Self {
        let (mirror_x, mirror_y, transposed) = match orientation {
            2 => (true, false, false),
            3 => (true, true, false),
            4 => (false, true, false),
            5 => (false, false, true),
            6 => (false, true, true),
            7 => (true, true, true),
            8 => (true, false, true),
            _ => (false, false, false),
        };
        Self { mirror_x, mirror_y, transposed }
    }

    /// The shown size of a picture of the stored `size`, or the stored of the shown.
    pub(super) const fn undo(self, size: Size) -> Size {
        if self.transposed { size.transposed() } else { size }
    }

    /// The index on a panel of `size` of the stored pixel `x`, `y` of a picture that is shown in `rect`.
    pub(super) const fn index(self, rect: Rect, size: Size, x: u32, y: u32) -> usize {
        let stored = self.undo(rect.size);
        let x = if self.mirror_x { stored.width - 1 - x } else { x };
        let y = if self.mirror_y { stored.height - 1 - y } else { y };
        let (x, y) = if self.transposed { (y, x) } else { (x, y) };
        (rect.y + y) as usize * size.width as usize + (rect.x + x) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_wide_photo_lies_in_the_middle_of_the_panel() {
        let placement = Placement::new(Size::new(400, 100), Size::new(200, 100), Fit::Blurred);
        assert_eq!(placement.picture, Rect { x: 0, y: 25, size: Size::new(200, 50) });
    }

    #[test]
    fn a_nearly_fitting_photo_gets_no_thin_border() {
        let panel = Size::new(1920, 1080);
        assert_eq!(Placement::new(Size::new(1920, 1070), panel, Fit::Blurred).picture.size, panel);
        assert_ne!(Placement::new(Size::new(1920, 1070), panel, Fit::Plain).picture.size, panel);
        assert_ne!(Placement::new(Size::new(1920, 1000), panel, Fit::Blurred).picture.size, panel);
    }

    proptest! {
        #[test]
        fn the_picture_is_on_the_panel_and_keeps_its_shape(
            w in 1_u32..=65_535, h in 1_u32..=65_535, panel_w in 1_u32..=16_384, panel_h in 1_u32..=16_384,
        ) {
            for fit in Fit::ALL {
                let placement = Placement::new(Size::new(w, h), Size::new(panel_w, panel_h), fit);
                let Rect { x, y, size } = placement.picture;
                prop_assert!(size.width > 0 && x + size.width <= panel_w);
                prop_assert!(size.height > 0 && y + size.height <= panel_h);
                prop_assert!(size.width == panel_w || size.height == panel_h);
                let shown = |side: u32, share: (u64, u64)| f64::from(side) * share.0 as f64 / share.1 as f64;
                let (shown_w, shown_h) = (shown(w, placement.width), shown(h, placement.height));
                prop_assert!(shown_w <= f64::from(w) && shown_h <= f64::from(h));
                // One scale for both sides, but for the rounding to whole pixels, of which there is one at least.
                let scale = (f64::from(panel_w) / shown_w).min(f64::from(panel_h) / shown_h);
                let near = |got: u32, exact: f64| (f64::from(got) - exact.max(1.0)).abs() <= 0.500_001;
                prop_assert!(near(size.width, shown_w * scale), "{:?} for {}", size, shown_w * scale);
                prop_assert!(near(size.height, shown_h * scale), "{:?} for {}", size, shown_h * scale);
            }
        }
    }
}
