//! Fluid: water, fire and smoke move as in a film.
//!
//! Source: "creating fluid animation from a single picture with a video database" ("the paper"), section 6: what moves is the difference of a film's frames
//! from their mean, laid over a picture that stands still. A tool of the PC makes a **clip** of it, once; this plays it. A clip ([`Clip`]) has a
//! base picture, a matte that says where it moves, and frames of signed changes D, which are coarser than the picture:
//!
//! ```text
//! shown(x, t) = base(x) + onset·s(t)·matte(x)·tint(luma(base(x)))·D(x, t),   s = m·(1 + r·(X_A(t) − 1/2))
//! ```
//!
//! m the strength. Between pixels D is interpolated bilinearly, between frames such that its contrast stays. θ turns the play position: by
//! the frames of 5/3 seconds a turn, so that with the default oscillation and X_f = 1 the film runs as it was taken, and X_f bends its speed. Amplitude
//! and speed wander, so no round of the clip is like another. r is 1 for luma: in a lull half of the change is left, as water that stands still looks
//! broken. It is 1/2 for colour, where more than what was recorded makes flames with black rims, and less makes them a haze.
//!
//! The paper's moving outline of fire and smoke (section 6) has no place of its own here: what the tool makes of outline, flame and what comes out
//! from behind is a change of colour as any other, in [`Kind::Colour`]. That keeps one kernel for all, and the frame needs to know nothing of mattes that move.
//!
//! Files: [`clip`] their layout, [`code`] how a frame is packed; `yurameki::os::clip` writes and opens them.

pub mod clip;
pub mod code;
mod huffman;
mod prepare;
mod render;
mod storage;
mod view;

#[cfg(test)]
mod reference;

pub use clip::{Clip, ClipError, Header, Kind, Shape, Source, Tint};
pub use render::Moment;
pub use view::View;

use super::{Effect, StorageTooSmall};
use crate::{
    frame::{Rotation, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
};
use core::fmt;
use render::{Shares, fetch, mix, spread};
use storage::{Measures, Memory};
use view::Axis;

/// A clip's base as the panel shows it.
#[derive(Clone, Copy, Debug)]
pub struct Base<'a> {
    /// Width and height in pixels: those of the panel as it is mounted.
    pub size: Size,
    /// Red, green, blue of every pixel, row by row, sRGB: 3 bytes a pixel.
    pub rgb: &'a [u8],
    /// Where on it the base lies.
    pub view: View,
}

/// Why a clip cannot be prepared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrepareError {
    /// There is too little memory for it.
    Storage(StorageTooSmall),
    /// Its matte or its tint is damaged.
    Clip(ClipError),
}

impl From<StorageTooSmall> for PrepareError {
    fn from(error: StorageTooSmall) -> Self {
        Self::Storage(error)
    }
}

impl From<ClipError> for PrepareError {
    fn from(error: ClipError) -> Self {
        Self::Clip(error)
    }
}

impl fmt::Display for PrepareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Storage(error) => error.fmt(f),
            Self::Clip(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PrepareError {}

/// Words of 64 bits that [`Fluid::prepare`] needs for a clip with this `header` on a panel of `size`, mounted so.
///
/// For a panel of p pixels and a grid of g, with one plane of luma, 8 p + 5 g bytes and the longest frame; with three of colour 12 p + 15 g.
pub const fn storage_len(header: &Header, size: Size, rotation: Rotation) -> usize {
    Measures::new(header, size, !matches!(rotation, Rotation::None)).storage_len()
}

/// A clip that plays, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`), from the source `C`.
#[derive(Debug)]
pub struct Fluid<S, C> {
    clip: Clip<C>,
    measures: Measures,
    rotation: Rotation,
    rows: Axis,
    strength: Factor,
    position: Position,
    /// The numbers of the two frames that are decoded.
    slots: [Option<u32>; 2],
    storage: S,
}

impl<S: AsMut<[u64]>, C: Source> Fluid<S, C> {
    /// Prepares `clip` with its `base` in `storage`, which must hold [`storage_len`] words. The `strength` of 0..=4 is 1 for changes that are, in the mean
    /// over time, as large as they were recorded.
    ///
    /// # Errors
    /// If there is less memory, or the matte or the tint is damaged.
    ///
    /// # Panics
    /// If `base.rgb` does not have the length that `base.size` asks for.
    pub fn prepare(
        clip: Clip<C>,
        base: Base<'_>,
        strength: Factor,
        mut storage: S,
    ) -> Result<Self, PrepareError> {
        assert_eq!(base.rgb.len(), base.size.pixels() * 3, "the base has another size");
        let header = clip.header();
        let rotation = base.view.rotation;
        let measures = Measures::new(header, base.size, rotation != Rotation::None);
        let axes = base.view.axes(&header.shape, base.size);
        let mut memory = Memory::carve(&measures, storage.as_mut())?;
        let tint = match header.shape.kind {
            Kind::Luma => clip.read_tint()?,
            Kind::Colour => Tint::GREY,
        };
        clip.read_matte(memory.packed, memory.residuals, memory.extents, memory.frames[0])?;
        prepare::fill(&mut memory, &measures, base.rgb.as_chunks().0, &tint, rotation, &axes);
        let position = Position::new(header);
        let strength = strength.clamp(Factor::ZERO, Factor::from_num(4));
        let [_, rows] = axes;
        Ok(Self { clip, measures, rotation, rows, strength, position, slots: [None; 2], storage })
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

impl<S: AsMut<[u64]>, C: Source> Effect for Fluid<S, C> {
    type Moment<'a>
        = Moment<'a>
    where
        S: 'a,
        C: 'a;

    fn at(&mut self, drive: Drive) -> Moment<'_> {
        let Ok(mut memory) = Memory::carve(&self.measures, self.storage.as_mut()) else {
            unreachable!("the storage was long enough when the clip was prepared")
        };
        self.position.follow(drive.phase);
        let (wanted, between) = self.position.frames();
        let mut chosen = [0; 2];
        for (i, number) in wanted.into_iter().enumerate() {
            let held = self.slots.iter().position(|&slot| slot == Some(number));
            chosen[i] = held.unwrap_or_else(|| {
                let kept = |slot: Option<u32>| slot.is_some_and(|number| wanted.contains(&number));
                let free = usize::from(kept(self.slots[0]));
                fetch(&self.clip, number, &mut memory, free);
                self.slots[free] = Some(number);
                free
            });
        }
        let Header { shape, correlation, .. } = self.clip.header();
        let range = match shape.kind {
            Kind::Luma => Factor::ONE,
            Kind::Colour => Factor::ONE / 2,
        };
        let wander = Factor::ONE + range * (drive.amplitude - Factor::ONE / 2);
        let strength = drive.onset * self.strength * wander;
        let shares = Shares::new(between, *correlation, strength, shape.step);
        mix(&mut memory, chosen, shares, &self.measures, self.rotation);
        spread(&mut memory, &self.measures, self.rotation, &self.rows);
        Moment::new(memory, &self.measures)
    }
}

/// Where in a clip is played.
#[derive(Clone, Copy, Debug)]
struct Position {
    /// In frames, Q32.
    at: i64,
    frames: u32,
    millihertz: u32,
    /// θ of the frame before.
    phase: Option<Turns>,
    /// How far the last step went, in frames, Q32. A pause is no step: the picture would change.
    step: i64,
}

impl Position {
    const fn new(header: &Header) -> Self {
        Self { at: 0, frames: header.frames, millihertz: header.shape.millihertz, phase: None, step: 0 }
    }

    /// Goes on as far as θ has turned: at the most half a turn, forwards or back.
    fn follow(&mut self, phase: Turns) {
        let before = self.phase.replace(phase).unwrap_or(phase);
        let turned = phase.0.wrapping_sub(before.0) as i32;
        // 5/3 seconds a turn: 20 frames at 12 a second, the default oscillation.
        if turned == 0 {
            return;
        }
        self.step = i64::from(turned) * i64::from(self.millihertz) * 5 / 3_000;
        self.at = (self.at + self.step).rem_euclid(i64::from(self.frames) << 32);
    }

    /// The two frames around the position, and how far the picture is from the first to the second, Q16.
    ///
    /// A film that runs as fast as it is shown, or faster, is shown frame by frame: a mean of two flames is a ghost. One that creeps would
    /// jerk: up to half a frame of it a frame of the show, one goes over into the next all the time; beyond, ever more briefly.
    fn frames(&self) -> ([u32; 2], u32) {
        let first = (self.at >> 32) as u32;
        let haste = (4 * (self.step.unsigned_abs() >> 16)).clamp(2 << 16, 64 << 16) as i64 - (1 << 16);
        let off_middle = ((self.at as u32) >> 16) as i64 - (1 << 15);
        let between = ((off_middle * haste) >> 16) + (1 << 15);
        ([first, (first + 1) % self.frames], between.clamp(0, 1 << 16) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::{
        reference::{Film, base, colours, drive},
        *,
    };
    use crate::effect::Moment as _;
    use core::cell::Cell;

    const GRID: Size = Size::new(20, 9);
    const PANEL: Size = Size::new(61, 40);

    /// A film prepared for a panel, and its base.
    fn prepared<C: Source>(source: C) -> (Fluid<Vec<u64>, C>, Vec<u8>) {
        let (clip, rgb) = (Clip::open(source).unwrap(), base(PANEL));
        let storage = vec![0; storage_len(clip.header(), PANEL, Rotation::None)];
        let base = Base { size: PANEL, rgb: &rgb, view: View::whole(PANEL) };
        (Fluid::prepare(clip, base, Factor::ONE, storage).unwrap(), rgb)
    }

    /// Bytes that count the frames that they are told to be damaged.
    struct Counted<'a>(&'a [u8], &'a Cell<u32>);

    impl Source for Counted<'_> {
        fn len(&self) -> u64 {
            Source::len(&self.0)
        }

        fn read(&self, at: u64, into: &mut [u8]) -> bool {
            self.0.read(at, into)
        }

        fn damaged(&self, _: u32) {
            self.1.set(self.1.get() + 1);
        }
    }

    #[test]
    fn what_does_not_move_is_the_base_to_the_bit_and_said_to_be_still() {
        for kind in [Kind::Luma, Kind::Colour] {
            let file = Film::drawn(kind, GRID, 5, 0).file();
            let (mut fluid, rgb) = prepared(&file[..]);
            let (mut moved, mut still) = (0, 0);
            for step in 0..20 {
                let moment = fluid.at(drive(step * 99_999_999, 0.8));
                let got = colours(&moment);
                for y in 0..PANEL.height {
                    let spans: Vec<_> = moment.moving(y).collect();
                    for x in 0..PANEL.width as usize {
                        let at = y as usize * PANEL.width as usize + x;
                        let own: [u16; 3] = core::array::from_fn(|c| u16::from(rgb[3 * at + c]) << 4);
                        if spans.iter().any(|span| span.contains(&x)) {
                            moved += u32::from(got[at] != own);
                        } else {
                            still += 1;
                            assert_eq!(got[at], own, "{x}, {y}");
                        }
                    }
                }
            }
            assert!(moved > 1_000 && still > 1_000, "{moved} pixels moved, {still} did not");
        }
    }

    #[test]
    fn a_turn_plays_as_many_seconds_as_it_lasts_by_default() {
        let film = Film::drawn(Kind::Luma, GRID, 1, 0);
        let mut header = *Clip::open(&film.file()[..]).unwrap().header();
        header.frames = 1_000;
        let mut position = Position::new(&header);
        // Ten turns, of twenty frames each.
        for frame in 0..=200_u64 {
            position.follow(Turns(((frame << 32) / 20) as u32));
        }
        let seconds = (position.at as f64 / 4_294_967_296.0) / 25.0;
        assert!((seconds - 10.0 * 20.0 / 12.0).abs() < 1e-6, "{seconds} seconds");
        for _ in 0..1_000 {
            position.follow(Turns(position.phase.unwrap().0.wrapping_sub(1 << 30)));
            assert!((0..1_000_i64 << 32).contains(&position.at), "it runs backwards through the start");
        }
    }

    #[test]
    fn a_film_that_creeps_goes_over_and_one_that_runs_is_shown_frame_by_frame() {
        let film = Film::drawn(Kind::Luma, GRID, 1, 0);
        let header = *Clip::open(&film.file()[..]).unwrap().header();
        let shares = |step: i64| -> Vec<u32> {
            let at = |sixteenths: i64| Position { at: sixteenths << 28, step, ..Position::new(&header) };
            (0..16).map(|sixteenths| at(sixteenths).frames().1).collect()
        };
        let whole = 1_i64 << 32;
        assert_eq!(shares(whole / 10), (0..16).map(|i| i << 12).collect::<Vec<_>>());
        let mixed = |step| shares(step).iter().filter(|share| !matches!(share, 0 | 65_536)).count();
        assert_eq!([whole, 2 * whole, 20 * whole].map(mixed), [5, 3, 1]);
    }

    #[test]
    fn between_frames_the_contrast_stays() {
        for correlation in [0_u16, 10_000, 32_768] {
            for between in (0..=65_536).step_by(4_096) {
                let [a, b] =
                    Shares::new(between, correlation, Factor::ONE, 1).of.map(|s| f64::from(s) / 65_536.0);
                let contrast = a * a + b * b + 2.0 * a * b * f64::from(correlation) / 32_768.0;
                assert!((contrast - 1.0).abs() < 1e-3, "{correlation}, {between}: {contrast}");
            }
        }
    }

    #[test]
    fn a_damaged_frame_is_told_and_the_one_before_it_stays() {
        let film = Film::drawn(Kind::Luma, GRID, 3, 0);
        let good = film.file();
        let damaged = Cell::new(0);
        let mut bad = good.clone();
        let index = bad.len() - 4 * clip::ENTRY;
        // A byte in the middle of frame 2.
        let start = u64::from_le_bytes(bad[index + 2 * clip::ENTRY..][..8].try_into().unwrap()) as usize;
        bad[start + 20] ^= 1;
        let (mut fluid, _) = prepared(Counted(&bad, &damaged));
        let (mut whole, _) = prepared(&good[..]);
        // A turn plays 5/3 seconds, of 25 frames each.
        let drive = |frames: f64| drive((frames / 41.666_667 * 4_294_967_296.0) as u32, 0.5);
        for at in [0.0, 1.02] {
            assert_eq!(colours(&fluid.at(drive(at))), colours(&whole.at(drive(at))));
        }
        assert_eq!(damaged.get(), 1, "told when it is first needed");
        assert_eq!(colours(&fluid.at(drive(2.02))), colours(&whole.at(drive(1.02))));
        assert_eq!(damaged.get(), 1, "told once");
        assert_ne!(colours(&fluid.at(drive(3.02))), colours(&whole.at(drive(1.02))), "it goes on");
    }

    #[test]
    fn every_cut_and_every_flipped_bit_of_the_header_and_the_index_is_refused() {
        let file = Film::drawn(Kind::Colour, GRID, 9, 2).file();
        for length in 0..file.len() {
            assert!(Clip::open(&file[..length]).is_err(), "cut to {length} bytes");
        }
        assert_eq!(Clip::open(&[&file[..], &[0]].concat()[..]).unwrap_err(), ClipError::Longer);
        let index = file.len() - 4 * clip::ENTRY..file.len();
        for at in (0..clip::HEADER).chain(index) {
            for bit in 0..8 {
                let mut bad = file.clone();
                bad[at] ^= 1 << bit;
                assert!(Clip::open(&bad[..]).is_err(), "bit {bit} of byte {at}");
            }
        }
    }

    #[test]
    fn a_flipped_bit_of_tint_and_matte_is_refused_before_it_plays() {
        let file = Film::drawn(Kind::Luma, GRID, 9, 2).file();
        let header = *Clip::open(&file[..]).unwrap().header();
        let rgb = base(PANEL);
        for at in header.tint_place().start..header.matte_place().end {
            let mut bad = file.clone();
            bad[at as usize] ^= 1;
            let base = Base { size: PANEL, rgb: &rgb, view: View::whole(PANEL) };
            let storage = vec![0; storage_len(&header, PANEL, Rotation::None)];
            let refused = Fluid::prepare(Clip::open(&bad[..]).unwrap(), base, Factor::ONE, storage);
            assert!(matches!(refused, Err(PrepareError::Clip(ClipError::Checksum(_)))), "byte {at}");
        }
    }

    #[test]
    fn measures_out_of_bounds_are_refused_by_name_though_the_checksum_is_right() {
        let file = Film::drawn(Kind::Luma, GRID, 9, 2).file();
        let with = |at: usize, bytes: &[u8]| {
            let mut bad = file.clone();
            bad[at..at + bytes.len()].copy_from_slice(bytes);
            clip::seal(&mut bad);
            Clip::open(&bad[..]).unwrap_err()
        };
        assert_eq!(with(0, b"JPG"), ClipError::NotAClip);
        assert_eq!(with(3, &[2]), ClipError::Version(2));
        assert_eq!(with(4, &[7]), ClipError::Kind(7));
        assert_eq!(with(5, &[0]), ClipError::Step(0));
        assert_eq!(with(8, &[0; 4]), ClipError::Rate(0));
        assert_eq!(with(12, &[1, 0, 0, 0]), ClipError::Frames(1));
        assert_eq!(with(12, &[255; 4]), ClipError::Frames(u32::MAX));
        assert_eq!(with(16, &[0; 4]), ClipError::Base(Size::new(0, 0)));
        assert_eq!(with(20, &[255; 4]), ClipError::Grid(Size::new(65_535, 65_535)));
        assert!(matches!(with(24, &[255; 2]), ClipError::Rectangle(_)));
        for length in [32, 36, 40, 44] {
            assert!(
                matches!(with(length, &[255; 4]), ClipError::Layout | ClipError::Cut),
                "length at {length}"
            );
        }
    }

    #[test]
    fn memory_that_is_too_small_is_told() {
        let file = Film::drawn(Kind::Luma, GRID, 9, 2).file();
        let clip = Clip::open(&file[..]).unwrap();
        let (rgb, needed) = (base(PANEL), storage_len(clip.header(), PANEL, Rotation::None));
        let base = Base { size: PANEL, rgb: &rgb, view: View::whole(PANEL) };
        let error = Fluid::prepare(clip, base, Factor::ONE, vec![0; needed - 1]).unwrap_err();
        assert_eq!(error, PrepareError::Storage(StorageTooSmall { needed, got: needed - 1 }));
    }
}
