//! Which patch of a video is given to which patch of the picture.

use crate::patch::PatchRef;

/// The picture's patches: [`crate::patch::SIDE`] pixels, [`crate::patch::STRIDE`] apart, from the upper left corner on; the last ones may
/// reach beyond the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Patches across.
    pub columns: usize,
    /// Patches down.
    pub rows: usize,
}

/// The patch that each patch of the picture was given, row by row; none where there is no fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelling {
    /// How the picture is cut.
    pub grid: Grid,
    /// One a patch.
    pub patches: Vec<Option<PatchRef>>,
}
