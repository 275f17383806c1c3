//! The whole effect: what it must hold for any frame.

use super::{
    grow::{Twig, Visit, grow},
    plates,
    space::ONE,
    *,
};
use crate::{
    effect::{Moment as _, Paint},
    frame::{FrameMut, Layout, PixelFormat},
    math::lanes::LANES,
};

const SIZE: Size = Size::new(331, 203);

fn drive(amplitude: f64, degrees: i32) -> Drive {
    Drive {
        amplitude: Factor::from_num(amplitude),
        frequency: Factor::ONE,
        phase: Turns::from_degrees(degrees),
        onset: Factor::ONE,
    }
}

fn tree(name: &str, settings: Settings) -> Autumn<Vec<u64>> {
    let species = Species::known(name).unwrap();
    let storage = vec![0; storage_len(SIZE)];
    Autumn::prepare(SIZE, Tree { species: &species, plates: None }, &settings, storage).unwrap()
}

fn frame(autumn: &mut Autumn<Vec<u64>>, stage: f64, drive: Drive) -> Vec<[u8; 3]> {
    autumn.set_stage(Stage::new(Factor::from_num(stage)));
    let layout = Layout::new(autumn.mount.panel, PixelFormat::Bgr888, None).unwrap();
    let mut bytes = vec![0; layout.len_bytes()];
    autumn.render(drive, Paint::Everything, &mut FrameMut::new(&mut bytes, layout).unwrap());
    bytes.as_chunks::<3>().0.to_vec()
}

/// x -> m·x + t in f64: the twin of the fixed-point maps.
#[derive(Clone, Copy)]
struct Map {
    columns: [[f64; 3]; 3],
    shift: [f64; 3],
}

impl Map {
    fn of(map: &space::AffineMap) -> Self {
        let float = |vector: space::Vector| vector.map(|x| f64::from(x) / f64::from(ONE));
        Self { columns: map.matrix.0.map(float), shift: float(map.shift) }
    }

    fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| (0..3).map(|k| self.columns[k][i] * v[k]).sum())
    }

    fn after(&self, inner: &Self) -> Self {
        let moved = self.turn(inner.shift);
        Self {
            columns: inner.columns.map(|column| self.turn(column)),
            shift: core::array::from_fn(|i| moved[i] + self.shift[i]),
        }
    }
}

struct Twigs(Vec<Twig>);

impl Visit for Twigs {
    fn twig(&mut self, twig: &Twig) {
        self.0.push(*twig);
    }
}

#[test]
fn every_twig_is_where_its_word_of_maps_puts_it() {
    for name in ["maple", "paper", "birch"] {
        let species = Species { stray: Default::default(), ..Species::known(name).unwrap() };
        let mut twigs = Twigs(Vec::new());
        grow(&species, 1, &mut twigs);
        assert_eq!(twigs.0.len(), species.twigs());
        let boughs: Vec<Map> = species.rule.boughs.iter().map(Map::of).collect();
        for (number, twig) in twigs.0.iter().enumerate() {
            assert_eq!(twig.number, number, "in the order of the words");
            // Eq. 4: w_σ1 ∘ w_σ2 ∘ ... ∘ w_σM (0).
            let word = season::symbols(number, &species).map(|symbol| boughs[usize::from(symbol)]);
            let want = word.reduce(|outer, inner| outer.after(&inner)).unwrap().shift;
            for (got, want) in Map::of(&twig.map).shift.into_iter().zip(want) {
                assert!((got - want).abs() < 1e-5, "{name} {number}: {got} is {want}");
            }
        }
    }
}

#[test]
fn every_pixel_of_foliage_has_the_address_of_a_twig_that_reaches_it() {
    for name in ["maple", "birch", "paper"] {
        let mut autumn = tree(name, Settings { leaf_fall: false, ..Settings::default() });
        let foliage: Vec<bool> = autumn.foliage().collect();
        let planes = Planes::carve(SIZE, &mut autumn.storage).unwrap();
        let seen = foliage.iter().filter(|seen| **seen).count();
        assert!(seen > SIZE.pixels() / 40, "{name}: {seen} pixels of foliage");
        let mut addresses = std::collections::BTreeSet::new();
        for (at, texel) in planes.texels.iter().enumerate().filter(|(at, _)| foliage[*at]) {
            let spot = planes.spots[usize::from(texel.address >> 4)];
            let (dx, dy) =
                (spot[0] - (at % SIZE.width as usize) as i16, spot[1] - (at / SIZE.width as usize) as i16);
            // Twice a twig's length for the leaf's place, and as much as its own size.
            let reach = SIZE.height as i16 / 5;
            assert!(dx.abs() <= reach && dy.abs() <= reach, "{name}: {dx}, {dy} from its twig");
            addresses.insert(texel.address);
        }
        assert!(addresses.len() > 500, "{name}: {} addresses are seen", addresses.len());
    }
}

#[test]
fn in_the_plane_the_smallest_word_is_on_top() {
    // Two boughs over each other: everything that both could show is the first one's.
    let text = "a(s) -> F(s) [ a(s/2) ] [ a(s/2) ]\ndepth 3\nleaves 4\nsize 6\nleaf .5 0 0 .5 -1 0\nleaf .5 0 0 .5 1 0\nleaf .5 0 0 .5 0 1\n";
    let species = Species::parse(text).unwrap();
    let storage = vec![0; storage_len(SIZE)];
    let settings = Settings { leaf_fall: false, ..Settings::default() };
    let mut autumn =
        Autumn::prepare(SIZE, Tree { species: &species, plates: None }, &settings, storage).unwrap();
    let foliage: Vec<bool> = autumn.foliage().collect();
    let planes = Planes::carve(SIZE, &mut autumn.storage).unwrap();
    let mut counts = [0; 8];
    let seen = planes.texels.iter().zip(&foliage).filter(|(_, seen)| **seen);
    seen.for_each(|(texel, _)| counts[usize::from(texel.address >> 4)] += 1);
    assert!(counts[0] > 0 && counts.iter().all(|&count| count <= counts[0]), "{counts:?}");
}

#[test]
fn a_photo_without_wind_is_itself_until_its_leaves_turn() {
    let rgb: Vec<u8> = (0..SIZE.pixels())
        .flat_map(|at| if at / 50 % 2 == 0 { [40, 90, 20] } else { [30, 60, 200] })
        .collect();
    let mask = vec![255; SIZE.pixels()];
    let species = Species::known("maple").unwrap();
    let photo = Photo { size: SIZE, rgb: &rgb, mask: &mask };
    let storage = vec![0; storage_len(SIZE)];
    let mut autumn =
        Autumn::prepare_photo(photo, Tree { species: &species, plates: None }, &Settings::default(), storage)
            .unwrap();
    assert!(frame(&mut autumn, 0., drive(0., 0)).as_flattened() == rgb, "at stage 0 it is not the photo");
    let red = frame(&mut autumn, 6., drive(0., 0));
    for (at, (&[r, g, b], before)) in red.iter().zip(rgb.as_chunks::<3>().0).enumerate() {
        match before {
            [40, 90, 20] => assert!(r > g, "pixel {at} is {r} {g} {b}"),
            sky => assert_eq!([r, g, b], *sky, "pixel {at}"),
        }
    }
}

#[test]
fn nothing_moves_outside_of_what_is_said_to_move() {
    for leaf_fall in [false, true] {
        let mut autumn = tree("maple", Settings { leaf_fall, ..Settings::default() });
        let first = frame(&mut autumn, 3., drive(1., 0));
        for (stage, degrees) in [(3., 90), (4., 200), (6.4, 300)] {
            let other = frame(&mut autumn, stage, drive(1., degrees));
            let moment = autumn.at(drive(1., degrees));
            for y in 0..SIZE.height {
                let moving: Vec<Range<usize>> = moment.moving(y).collect();
                for x in (0..SIZE.width as usize).filter(|x| !moving.iter().any(|span| span.contains(x))) {
                    let at = y as usize * SIZE.width as usize + x;
                    assert_eq!(first[at], other[at], "{x}, {y}");
                }
            }
        }
    }
}

#[test]
fn the_wind_bends_the_tree_and_neither_tears_it_nor_reaches_beyond_the_picture() {
    let mut autumn = tree("maple", Settings::default());
    let width = SIZE.width as usize;
    let mut farthest = 0;
    for degrees in (0..360).step_by(15) {
        let moment = autumn.at(drive(1., degrees));
        let mut row = vec![0; width];
        let mut above: Option<Vec<(i32, i32)>> = None;
        for y in 0..SIZE.height as usize {
            for (block, x) in row.chunks_mut(LANES).zip((0..).step_by(LANES)) {
                let (sources, _) = moment.sources(x, y);
                block.copy_from_slice(&sources[..block.len()]);
            }
            let places: Vec<(i32, i32)> =
                row.iter().map(|&at| ((at as usize % width) as i32, (at as usize / width) as i32)).collect();
            for (x, &(from_x, from_y)) in places.iter().enumerate() {
                let (dx, dy) = (from_x - x as i32, from_y - y as i32);
                assert!(dx.abs() < 8 && dy.abs() < 8, "({x}, {y}) is fetched from ({from_x}, {from_y})");
                farthest = farthest.max(dx.abs());
            }
            let close = |a: (i32, i32), b: (i32, i32)| (a.0 - b.0).abs() <= 2 && (a.1 - b.1).abs() <= 2;
            assert!(places.windows(2).all(|pair| close(pair[0], pair[1])), "row {y} is torn");
            if let Some(above) = above {
                assert!(places.iter().zip(&above).all(|(a, b)| close(*a, *b)), "row {y} is torn off");
            }
            above = Some(places);
        }
    }
    assert!(farthest >= 1, "the tree stands still");
}

#[test]
fn too_little_memory_is_refused_with_what_it_takes() {
    let species = Species::known("paper").unwrap();
    let needed = storage_len(SIZE);
    let refused = Autumn::prepare(
        SIZE,
        Tree { species: &species, plates: None },
        &Settings::default(),
        vec![0_u64; needed - 1],
    );
    assert_eq!(refused.err(), Some(StorageTooSmall { needed, got: needed - 1 }));
}

#[test]
fn plates_of_pictures_give_their_colours() {
    let species = Species::known("maple").unwrap();
    let pictures: Box<Plates> =
        Box::new(core::array::from_fn(|stage| [[30 * stage as u8, 120, 10]; plates::CELLS]));
    let settings = Settings { sun: None, leaf_fall: false, ..Settings::default() };
    let tree = Tree { species: &species, plates: Some(&pictures) };
    let mut autumn = Autumn::prepare(SIZE, tree, &settings, vec![0; storage_len(SIZE)]).unwrap();
    for (stage, red) in [(0., 0), (6., 180)] {
        frame(&mut autumn, stage, drive(0., 0));
        let planes = Planes::carve(SIZE, &mut autumn.storage).unwrap();
        let twigs = autumn.twigs * 16;
        assert!(
            planes.colours[..twigs].iter().all(|&colour| colour == red | 120 << 8 | 10 << 16),
            "stage {stage}"
        );
    }
}

#[test]
fn frames_are_the_same_on_every_machine() {
    let mut hash = 0_u64;
    for name in ["maple", "birch", "paper"] {
        let mut autumn = tree(name, Settings::default());
        for (i, stage) in [0., 2.5, 4., 5.5, 6.5].into_iter().enumerate() {
            for pixel in frame(&mut autumn, stage, drive(0.8, 70 * i as i32)).as_flattened() {
                hash = crate::math::random::scatter(hash ^ u64::from(*pixel));
            }
        }
    }
    assert_eq!(hash, 9_465_774_362_453_544_440, "if the picture was meant to change, this is its new hash");
}

#[test]
fn on_a_panel_that_is_mounted_turned_the_tree_stands_upright_and_the_wind_blows_along() {
    let species = Species::known("maple").unwrap();
    let seen = |rotation: Rotation| {
        let panel = rotation.turned(SIZE);
        let settings = Settings { rotation, ..Settings::default() };
        let storage = vec![0; storage_len(panel)];
        let tree = Tree { species: &species, plates: None };
        let mut autumn = Autumn::prepare(panel, tree, &settings, storage).unwrap();
        // Leaves fall in the last frames.
        let frames = (0..40).map(|degrees| frame(&mut autumn, 6.5, drive(1.0, 9 * degrees)));
        let last = frames.last().unwrap();
        let mut upright = vec![[0; 3]; SIZE.pixels()];
        crate::frame::rotate(rotation.inverse(), &last, panel, &mut upright);
        upright
    };
    let want = seen(Rotation::None);
    for rotation in [Rotation::Quarter, Rotation::Half, Rotation::ThreeQuarter] {
        let got = seen(rotation);
        let same = got.iter().zip(&want).filter(|(got, want)| (0..3).all(|i| got[i].abs_diff(want[i]) <= 24));
        // The grid of the wind lies elsewhere, so that edges may differ.
        let same = same.count();
        assert!(same * 100 > want.len() * 93, "{rotation}: {same} of {} pixels are as upright", want.len());
    }
}
