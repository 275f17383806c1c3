//! Autumn: a fractal tree goes through the season.
//!
//! Source: Mochizuki, Horie and Cai, 紅葉のフラクタルシェーディングに関する研究 ("the paper"; equation numbers are its). A tree is the
//! attractor of an IFS that an L-system's rule is turned into, a leaf that of another; together they are a recurrent IFS, and every
//! point has an address: the words of symbols that lead to it. The season does not touch the picture, but the addresses: a shift
//! operator removes leading symbols, one after the other, and the more are gone, the redder is the leaf. Its colours are stolen
//! from seven plates.
//!
//! [`Autumn::prepare`] paints the address of every pixel once, for good. A frame looks up the colour of each address and bends the
//! picture with the wind: it costs the same for ten leaves as for a million.
//!
//! | what | where |
//! |---|---|
//! | the species: L-system, leaf and pigments (eq. 7 to 13) | [`Species`], species/*.tree |
//! | top function and addresses (eq. 3 to 6) | `leaf`, `canvas` |
//! | shift operator, sunlight, the clock (eq. 15) | `season`, `sunlight` |
//! | colour stealing (section 3.3) | `plates` |
//! | wind, falling leaves, scenery: not in the paper | `sway`, `airborne`, `scenery` |
//!
//! X_A scales the wind, θ is the sway. Departures from the paper stand in each of these files; those of the whole are:
//! 1. Depth takes the place of the top function in space.
//! 2. Forks stray from the rule, so that no two boughs are alike.
//! 3. Of a leaf two symbols are kept, of a twig as many as 12 bits hold.

mod airborne;
mod canvas;
mod foliage;
mod grow;
mod leaf;
mod lsystem;
mod mount;
mod noise;
mod plates;
mod render;
mod scenery;
mod season;
mod space;
mod species;
mod storage;
mod sunlight;
mod sway;
#[cfg(test)]
mod tests;
mod text;
mod view;

pub use plates::{CELLS as PLATE_CELLS, SIDE as PLATE_SIDE, STAGES};
pub use render::Moment;
pub use season::{Stage, Turning};
pub use species::{KNOWN, MOST_TWIGS, Species};
pub use storage::storage_len;
pub use text::{Fault, SpeciesError};

use super::{Effect, Photo, StorageTooSmall, shimmer::Light};
use crate::{
    frame::{Rotation, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
};
use airborne::{Airborne, Sprite};
use canvas::{Canvas, Painter};
use core::ops::Range;
use mount::Mount;
use season::{Course, Knots, Now};
use storage::Planes;
use sunlight::Columns;
use view::{TREE_DEPTHS, View};

/// Seven square pictures, one a stage, row by row, sRGB.
pub type Plates = [[[u8; 3]; PLATE_CELLS]; STAGES];

/// What can be chosen of an autumn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// What decides when a leaf turns.
    pub turning: Turning,
    /// How likely a twig turns with its bough, 0..=1; else it goes its own way.
    pub patchiness: Factor,
    /// Where the sun is: leaves in the shade of others turn later. Without it all have as much light.
    pub sun: Option<Light>,
    /// Whether leaves fall.
    pub leaf_fall: bool,
    /// From where the tree is seen, about its trunk.
    pub azimuth: Turns,
    /// How far the picture is turned for its panel; that of a photo comes turned.
    pub rotation: Rotation,
    /// Frames that a leaf takes from the top of the picture to its bottom.
    pub fall_frames: u32,
    /// The tree of the species: another seed, another tree.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            turning: Turning::default(),
            patchiness: Factor::lit("0.95"),
            sun: Some(Light { azimuth: Turns::from_degrees(325), elevation: Turns::from_degrees(25) }),
            leaf_fall: true,
            azimuth: Turns(0),
            rotation: Rotation::None,
            fall_frames: 90,
            seed: 1,
        }
    }
}

/// A tree in autumn, in memory `S`: lent (`&mut [u64]`) or owned (`Vec<u64>`).
#[derive(Debug)]
pub struct Autumn<S> {
    mount: Mount,
    storage: S,
    knots: Knots,
    depth: u32,
    twigs: usize,
    bark: [u8; 3],
    /// Whether leaves are those of a photo, which is behind them.
    is_photo: bool,
    stage: Stage,
    /// The stage that the colours were last made for.
    coloured: Option<Stage>,
    airborne: Option<Airborne>,
    /// The leaves in the air as the latest moment shows them.
    sprites: heapless::Vec<Sprite, { airborne::MOST }>,
    moving: [Range<usize>; 2],
}

/// What grows, and in which colours.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    /// The species.
    pub species: &'a Species,
    /// The colours of its leaves; without them those of the species' pigments.
    pub plates: Option<&'a Plates>,
}

impl<S: AsMut<[u64]>> Autumn<S> {
    /// Grows `tree` for pictures of `size` in `storage`, which must hold [`storage_len`] words. The tree is at stage 0.
    pub fn prepare(
        size: Size,
        tree: Tree<'_>,
        settings: &Settings,
        mut storage: S,
    ) -> Result<Self, StorageTooSmall> {
        let mut planes = Planes::carve(size, storage.as_mut())?;
        let mount = Mount::new(size, settings.rotation);
        let view = View::fit(tree.species, settings.seed, mount.upright(), settings.azimuth);
        let spread = view.length(view.reach);
        scenery::paint(
            planes.background.each_mut().map(|plane| &mut **plane),
            mount,
            tree.species.scene,
            view.root,
            spread,
            settings.seed,
        );
        paint_tree(&mut planes, mount, tree.species, view, settings);
        settle(&mut planes);
        let leaf_fall = settings.leaf_fall && !tree.species.evergreen;
        Ok(Self::start(mount, tree, Settings { leaf_fall, ..*settings }, view.root[1] >> 8, false, storage))
    }

    /// Takes the foliage of `photo` for a tree: what its mask holds and is green goes through the season in the colours of `tree`. The
    /// rest stays as it is, and nothing falls. At stage 0 the picture is the photo.
    ///
    /// # Panics
    /// If `photo.rgb` or `photo.mask` does not have the length that `photo.size` asks for.
    pub fn prepare_photo(
        photo: Photo<'_>,
        tree: Tree<'_>,
        settings: &Settings,
        mut storage: S,
    ) -> Result<Self, StorageTooSmall> {
        let mut planes = Planes::carve(photo.size, storage.as_mut())?;
        for (channel, plane) in planes.background.iter_mut().enumerate() {
            let levels = photo.rgb.iter().skip(channel).step_by(3);
            plane.iter_mut().zip(levels).for_each(|(to, from)| *to = *from);
        }
        assert_eq!(photo.rgb.len(), photo.size.pixels() * 3, "the photo's colours do not have its size");
        assert_eq!(photo.mask.len(), photo.size.pixels(), "the mask does not have the photo's size");
        let mount = Mount::new(photo.size, settings.rotation);
        foliage::fill(planes.texels, photo, mount, tree.species, settings.seed);
        settle(&mut planes);
        planes.sunlight.fill(sunlight::NO_SHADE);
        // Everything is as high as the lower half of a tree.
        let root_y = mount.upright().height as i32 * 2;
        Ok(Self::start(mount, tree, Settings { leaf_fall: false, ..*settings }, root_y, true, storage))
    }

    /// What a tree and a photo have in common once their texels are there.
    fn start(
        mount: Mount,
        tree: Tree<'_>,
        settings: Settings,
        root_y: i32,
        is_photo: bool,
        mut storage: S,
    ) -> Self {
        let Ok(planes) = Planes::carve(mount.panel, storage.as_mut()) else {
            unreachable!("the storage was long enough for the texels")
        };
        let species = tree.species;
        match tree.plates {
            Some(pictures) => plates::fill_from_pictures(planes.plates, pictures),
            None => {
                plates::fill_synthetic(
                    planes.plates,
                    species,
                    settings.seed,
                    settings.turning != Turning::Together,
                );
            }
        }
        let mut knots = [0; _];
        let course = Course::of(&settings);
        let twigs = species.twigs();
        season::fill(&mut planes.calendars[..twigs], planes.sunlight, &mut knots, species, course);
        let second = species.rule.boughs.len().pow(species.depth.saturating_sub(2));
        sway::fill(planes.nodes, mount, planes.texels, root_y, |texel| {
            let on_tree = texel.cover > 0 && usize::from(texel.depth) < MOST_TWIGS;
            on_tree.then_some(usize::from(texel.address >> 4) / second % sway::BOUGHS)
        });
        let moving = moving(&planes, settings.leaf_fall);
        Self {
            mount,
            storage,
            knots,
            depth: species.depth,
            twigs,
            bark: species.bark,
            is_photo,
            stage: Stage::default(),
            coloured: None,
            airborne: settings.leaf_fall.then(|| Airborne::new(settings.fall_frames, settings.seed)),
            sprites: heapless::Vec::new(),
            moving,
        }
    }

    /// From the next frame on, the tree is at `stage` of its season.
    pub fn set_stage(&mut self, stage: Stage) {
        self.stage = stage;
    }

    /// Of every pixel, row by row, whether in still air a leaf on the tree covers most of it.
    pub fn foliage(&mut self) -> impl Iterator<Item = bool> {
        let Ok(planes) = Planes::carve(self.mount.panel, self.storage.as_mut()) else {
            unreachable!("the storage was long enough when the tree was prepared")
        };
        planes.texels.iter().map(|texel| texel.cover >= 128 && usize::from(texel.depth) < MOST_TWIGS)
    }

    /// Gives the memory back.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

/// Paints the tree and its leaves on the ground into the texels.
fn paint_tree(planes: &mut Planes<'_>, mount: Mount, species: &Species, view: View, settings: &Settings) {
    planes.texels.fill(storage::Texel::default());
    let Ok(stencil) = <&mut leaf::Stencil>::try_from(&mut *planes.stencil) else {
        unreachable!("a stencil is as long as its part of the storage")
    };
    leaf::draw(&species.leaf, stencil);
    let columns = settings.sun.map(|sun| {
        let mut columns = Columns::new(planes.colours, species, view, sun);
        grow::grow(species, settings.seed, &mut columns);
        columns.add_up();
        columns
    });
    let canvas = Canvas { mount, texels: planes.texels };
    let (sunlight, spots) = (&mut *planes.sunlight, &mut *planes.spots);
    let mut painter = Painter { canvas, species, view, stencil, columns, sunlight, spots };
    grow::grow(species, settings.seed, &mut painter);
    if settings.leaf_fall && !species.evergreen {
        canvas::strew(&mut painter.canvas, species, &view, stencil, settings.seed);
    }
}

/// From depths to places in the table of states; and the spans of what is not empty.
fn settle(planes: &mut Planes<'_>) {
    let width = planes.size.width as usize;
    // What moves may come to lie this far outside.
    let margin = sway::PITCH;
    for (row, span) in planes.texels.chunks_exact_mut(width).zip(&mut *planes.spans) {
        for texel in row.iter_mut() {
            let ground = texel.cover > 0 && !TREE_DEPTHS.contains(&texel.depth);
            texel.depth = (texel.address >> 4) + if ground { MOST_TWIGS as u16 } else { 0 };
        }
        let is_seen = |texel: &storage::Texel| texel.cover > 0 || texel.wood > 0;
        let start = row.iter().position(is_seen).map_or(width, |start| start.saturating_sub(margin));
        let end = row.iter().rposition(is_seen).map_or(0, |end| (end + 1 + margin).min(width));
        *span = storage::Span { start: start as u16, end: end as u16 };
    }
}

/// The columns and rows that can differ between frames.
fn moving(planes: &Planes<'_>, leaf_fall: bool) -> [Range<usize>; 2] {
    let (width, height) = (planes.size.width as usize, planes.size.height as usize);
    if leaf_fall {
        return [0..width, 0..height];
    }
    let seen = planes.spans.iter().filter(|span| span.start < span.end);
    let start = seen.clone().map(|span| span.start).min().unwrap_or(0);
    let end = seen.map(|span| span.end).max().unwrap_or(0);
    let first = planes.spans.iter().position(|span| span.start < span.end).unwrap_or(0);
    [start.into()..end.into(), first.saturating_sub(sway::PITCH)..height]
}

impl<S: AsMut<[u64]>> Effect for Autumn<S> {
    type Moment<'a>
        = Moment<'a>
    where
        S: 'a;

    fn at(&mut self, drive: Drive) -> Moment<'_> {
        let Ok(mut planes) = Planes::carve(self.mount.panel, self.storage.as_mut()) else {
            unreachable!("the storage was long enough when the tree was prepared")
        };
        let now = Now::new(self.stage, &self.knots, self.depth);
        if self.coloured != Some(self.stage) {
            render::colour(&mut planes, now, self.twigs, self.is_photo);
            for state in &mut planes.states[MOST_TWIGS..] {
                state.gain = 128;
            }
            self.coloured = Some(self.stage);
        }
        render::flutter(planes.states, self.twigs, drive);
        sway::bend(planes.nodes, self.mount, drive);
        if let Some(airborne) = &mut self.airborne {
            let twigs = self.twigs as u64;
            airborne.step(self.mount.upright(), drive, |chance| {
                let twig = (chance % twigs) as usize;
                now.loosens(&planes.calendars[twig]).then(|| (twig as u16, planes.spots[twig]))
            });
            self.sprites = airborne.sprites(self.mount);
        }
        Moment::new(self)
    }
}
