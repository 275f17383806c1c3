//! The whole choice, on a database that is made up.

use super::*;
use crate::{
    features::{CELLS, CHANNELS, PLACES, WORDS},
    footage::Class,
    patch::Version,
};

/// A stream of numbers for tests.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u32 << 24) as f32
    }

    fn words(&mut self, from: u8, to: u8) -> [u8; PLACES] {
        core::array::from_fn(|_| from + (self.next() * f32::from(to - from)) as u8)
    }
}

/// Videos of 8 by 8 patches; each flows its own way, and has its own words.
fn database(videos: u32) -> Vec<Features> {
    let mut numbers = Numbers(77);
    let mut features = Vec::new();
    for video in 0..videos {
        let angle = video as f32 * 2.4;
        let first = (video * 13 % 150) as u8;
        for number in 0..64 {
            let (x, y) = (number % 8 * 24, number / 8 * 24);
            let motion = core::array::from_fn(|_| {
                core::array::from_fn(|channel| match channel {
                    0 => angle.cos() * 2.0 + numbers.next() * 0.2,
                    1 => angle.sin() * 2.0 + numbers.next() * 0.2,
                    _ => numbers.next() + video as f32 * 0.1,
                })
            });
            features.push(Features {
                patch: PatchRef { video, version: Version::all().next().unwrap(), x, y },
                words: [numbers.words(first, first + 30), numbers.words(first, first + 30)],
                contrast: 10.0 + numbers.next() * 20.0,
                motion,
            });
        }
    }
    features
}

/// A picture that looks like one video, patch by patch as it lies there, with some words changed.
fn target(features: &[Features], video: usize, grid: Grid) -> Target {
    let mut numbers = Numbers(5);
    let look = |number: usize| {
        let (x, y) = (number % grid.columns % 8, number / grid.columns % 8);
        let patch = &features[video * 64 + y * 8 + x];
        let mut words = patch.words[1];
        words.iter_mut().for_each(|word| {
            if numbers.next() < 0.3 {
                *word = (numbers.next() * WORDS as f32) as u8;
            }
        });
        Some(Look { words, contrast: patch.contrast, blown: false, wanted: Wanted::default() })
    };
    let mut look = look;
    Target { grid, looks: (0..grid.columns * grid.rows).map(&mut look).collect() }
}

const GRID: Grid = Grid { columns: 6, rows: 5 };

#[test]
fn a_picture_of_a_video_is_given_that_video() {
    let features = database(12);
    let labelled = label(&target(&features, 3, GRID), &features, &Options::default()).unwrap();
    let right = labelled.labelling.patches.iter().flatten().filter(|patch| patch.video == 3).count();
    assert!(right >= 28, "{right} of 30");
    assert!(labelled.bound.unwrap() <= labelled.energies[1].1 + 1e-3);
}

#[test]
fn the_solvers_are_compared_and_none_is_worse_than_greedy() {
    let features = database(12);
    let options = Options { compare: true, candidates: 20, ..Options::default() };
    for pairwise in [Pairwise::Relative, Pairwise::Literal] {
        let labelled =
            label(&target(&features, 3, GRID), &features, &Options { pairwise, ..options.clone() }).unwrap();
        let solvers: Vec<_> = labelled.energies.iter().map(|&(solver, _)| solver).collect();
        assert_eq!(solvers, Solver::ALL);
        let greedy = labelled.energies[0].1;
        for &(solver, energy) in &labelled.energies {
            assert!(energy <= greedy + 1e-9, "{}: {energy} over {greedy}", solver.name());
            assert!(labelled.bound.unwrap() <= energy + 1e-3);
        }
        assert!(labelled.amplitude_ratio > 0.0 && labelled.truncated.is_some());
    }
}

#[test]
fn the_choice_does_not_depend_on_the_threads() {
    let features = database(300);
    let target = target(&features, 3, GRID);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut labelled = pool.install(|| label(&target, &features, &Options::default())).unwrap();
        labelled.seconds.clear();
        labelled
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn the_scan_finds_the_cheapest_of_all() {
    let features = database(150);
    let target = target(&features, 3, GRID);
    for both in [false, true] {
        let lists = Search::new(&features, both).scan(&target, 40);
        for (list, look) in lists.iter().zip(&target.looks) {
            let look = look.as_ref().unwrap();
            let words = histogram::Sparse::of(&look.words);
            let alike = |patch: &Features| {
                let maps = &patch.words[..1 + usize::from(both)];
                maps.iter().map(|map| histogram::intersection(&words, map)).max().unwrap()
            };
            let cost = |patch: &Features| {
                1.0 - f32::from(alike(patch)) / 162.0 + 0.1 * (patch.contrast / look.contrast).ln().abs()
            };
            let mut costs: Vec<_> = features.iter().map(cost).collect();
            costs.sort_by(f32::total_cmp);
            assert_eq!(list.len(), 40);
            for (candidate, expected) in list.iter().zip(costs) {
                assert!((candidate.cost - expected).abs() < 1e-5);
                assert!((cost(&features[candidate.patch as usize]) - candidate.cost).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn shifts_of_the_neighbours_best_are_added() {
    let features = database(12);
    let target = target(&features, 3, GRID);
    let search = Search::new(&features, true);
    let before = search.scan(&target, 4);
    let mut lists = before.clone();
    search.add_shifts(&target, &mut lists);
    assert!(lists.iter().zip(&before).all(|(list, before)| list[..4] == before[..4]), "nothing is displaced");
    let best = features[before[7].first().unwrap().patch as usize].patch;
    let right = PatchRef { x: best.x + 24, ..best };
    let there = features.iter().any(|features| features.patch == right);
    let added = lists[8].iter().any(|candidate| features[candidate.patch as usize].patch == right);
    assert_eq!(there, added);
    let mut known: Vec<_> = lists[8].iter().map(|candidate| candidate.patch).collect();
    known.sort_unstable();
    known.dedup();
    assert_eq!(known.len(), lists[8].len(), "none is there twice");
}

#[test]
fn a_motion_that_was_asked_for_is_kept_to() {
    let features = database(12);
    let mut target = target(&features, 3, GRID);
    // Video 5 flows this way; the picture looks like video 3.
    let direction = [(5.0f32 * 2.4).cos(), (5.0f32 * 2.4).sin()];
    target.ask(|_, _| Wanted { direction: Some(direction), speed: None });
    let labelled = label(&target, &features, &Options::default()).unwrap();
    assert_eq!(labelled.unguided, 0);
    for motion in labelled.motions.iter().flatten() {
        let along = motion.mean[0] * direction[0] + motion.mean[1] * direction[1];
        assert!(along > 0.7 * motion.mean[0].hypot(motion.mean[1]));
    }
    target.ask(|_, _| Wanted { direction: None, speed: Some(500.0) });
    let labelled = label(&target, &features, &Options::default()).unwrap();
    assert_eq!(labelled.unguided, 30, "nothing is so fast, and that is said");
}

#[test]
fn blown_patches_move_as_their_neighbours() {
    let features = database(12);
    let mut target = target(&features, 3, GRID);
    for number in [7, 8, 13, 14] {
        let look = target.looks[number].as_mut().unwrap();
        look.blown = true;
        look.words = [200; PLACES];
    }
    let labelled = label(&target, &features, &Options::default()).unwrap();
    for number in [7, 8, 13, 14] {
        assert_eq!(labelled.labelling.patches[number].unwrap().video, 3, "patch {number}");
    }
    target.looks.iter_mut().flatten().for_each(|look| look.blown = true);
    let labelled = label(&target, &features, &Options::default()).unwrap();
    assert!(
        labelled.labelling.patches.iter().all(Option::is_some),
        "with nothing around, it is taken as it looks"
    );
}

#[test]
fn what_is_not_fluid_is_given_nothing() {
    let features = database(2);
    let mut target = target(&features, 1, GRID);
    target.looks[4] = None;
    let labelled = label(&target, &features, &Options::default()).unwrap();
    assert!(labelled.labelling.patches.iter().enumerate().all(|(n, patch)| patch.is_none() == (n == 4)));
    target.looks.fill(None);
    assert_eq!(label(&target, &features, &Options::default()), Err(LabelError::NoFluid));
    assert_eq!(label(&target, &[], &Options::default()), Err(LabelError::NoPatches));
}

#[test]
fn tables_of_pairs_agree_with_the_formula() {
    let features = database(3);
    let lists: Vec<Vec<Candidate>> =
        [0u32..37, 60..97].map(|range| range.map(|patch| Candidate { cost: 0.0, patch }).collect()).to_vec();
    let comparison = Comparison::new(&features, Pairwise::Relative, &lists);
    // Every part of an overlap has a variance of 1.
    let parts = [0..2usize, 2..8, 8..CHANNELS];
    let used = || lists.iter().flatten().flat_map(|candidate| &features[candidate.patch as usize].motion);
    let scale = |channel: usize| {
        let part = parts.iter().find(|part| part.contains(&channel)).unwrap();
        let variance = |c: usize| {
            let mean = used().map(|cell| f64::from(cell[c])).sum::<f64>() / used().count() as f64;
            used().map(|cell| (f64::from(cell[c]) - mean).powi(2)).sum::<f64>() / used().count() as f64
        };
        1.0 / (8.0 * part.clone().map(variance).sum::<f64>()).sqrt()
    };
    let scales: Vec<f64> = (0..CHANNELS).map(scale).collect();
    for side in [Side::Right, Side::Below] {
        let table = comparison.table(&lists[0], &lists[1], side);
        for (row, first) in lists[0].iter().enumerate() {
            for (column, second) in lists[1].iter().enumerate() {
                let (a, b) =
                    (&features[first.patch as usize].motion, &features[second.patch as usize].motion);
                let (mut difference, mut own) = (0.0, 0.05);
                for (y, x) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (y, x))) {
                    // The cell of the second that lies on this one of the first.
                    let (other_x, other_y) =
                        if side == Side::Right { (x.wrapping_sub(2), y) } else { (x, y.wrapping_sub(2)) };
                    if other_x >= CELLS || other_y >= CELLS {
                        continue;
                    }
                    for c in 0..CHANNELS {
                        let a = f64::from(a[y * CELLS + x][c]) * scales[c];
                        let b = f64::from(b[other_y * CELLS + other_x][c]) * scales[c];
                        difference += (a - b) * (a - b);
                        own += a * a + b * b;
                    }
                }
                let found = f64::from(table[row * 37 + column]);
                assert!((found - difference / own).abs() < 1e-4, "{found} is not {}", difference / own);
            }
        }
    }
}

#[test]
fn a_scene_is_what_its_likes_are() {
    let features = database(12);
    // Fire is rare, and found all the same.
    let class = |video: u32| Some(if video == 3 { Class::Fire } else { Class::Water });
    assert_eq!(scene_class(&target(&features, 3, GRID), &features, class), Some(Class::Fire));
    assert_eq!(scene_class(&target(&features, 8, GRID), &features, class), Some(Class::Water));
    assert_eq!(scene_class(&target(&features, 8, GRID), &features, |_| None), None);
}
