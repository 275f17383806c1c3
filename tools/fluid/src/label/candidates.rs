//! The labels of every patch of the picture: the patches of the database that look most like it.

use super::{
    Grid,
    histogram::{BLOCK, Block, MOST, Sparse, intersection},
    target::{Look, Motion, Target},
};
use crate::{
    features::Features,
    patch::{PatchRef, STRIDE},
};
use rayon::prelude::*;
use std::{cmp::Ordering, collections::HashMap};

/// Weight of the contrast: a patch of e times the contrast costs as much as a tenth of the likeness.
const CONTRAST: f32 = 0.1;

/// Patches that one thread takes at a time: a multiple of [`BLOCK`].
const CHUNK: usize = 128 * BLOCK;

/// So many of a neighbour's best are shifted: with four neighbours at most 32 more labels.
const SHIFTED: usize = 8;

/// What a patch that moves 1/e as much as the usual candidate costs. Without it neighbours agree best where nothing happens: choices had .47
/// to .68 of greedy's amplitude on five of six videos of water, and with it .6 to 1.2.
const CALM: f32 = 0.2;

/// Below this amplitude, in pixels a frame, a patch is as good as still.
const STILL: f32 = 0.05;

/// What a motion that was not asked for adds to the cost, so that it comes after all that was.
const UNWANTED: f32 = 100.0;

/// A label: a patch of the database and its cost V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) cost: f32,
    /// Its place in the list of features.
    pub(super) patch: u32,
}

impl Candidate {
    /// Cheaper first; the first of the list among equals: the same order on every run.
    fn order(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.patch.cmp(&other.patch))
    }
}

/// The cheapest so far, at most twice as many as are kept in the end.
struct Best {
    found: Vec<Candidate>,
    count: usize,
    /// What costs this or more is not among them.
    limit: f32,
}

impl Best {
    fn new(count: usize) -> Self {
        Self { found: Vec::with_capacity(2 * count), count, limit: f32::INFINITY }
    }

    fn push(&mut self, candidate: Candidate) {
        if candidate.cost < self.limit {
            self.found.push(candidate);
            if self.found.len() == 2 * self.count {
                self.trim();
            }
        }
    }

    fn trim(&mut self) {
        if self.found.len() > self.count {
            let (_, last, _) = self.found.select_nth_unstable_by(self.count - 1, Candidate::order);
            self.limit = last.cost;
            self.found.truncate(self.count);
        }
    }
}

/// A patch of the picture as the scan wants it.
struct Sought<'a> {
    look: &'a Look,
    words: Sparse,
    contrast: f32,
}

/// The patches of a database, ready to be searched.
pub(super) struct Search<'a> {
    features: &'a [Features],
    contrasts: Vec<f32>,
    motions: Vec<Motion>,
    /// How many of the two word maps count: the mean's alone, or the sharp frame's too.
    maps: usize,
}

impl<'a> Search<'a> {
    pub(super) fn new(features: &'a [Features], both_maps: bool) -> Self {
        let contrasts = features.par_iter().map(|patch| logarithm(patch.contrast)).collect();
        let motions = features.par_iter().map(Motion::of).collect();
        Self { features, contrasts, motions, maps: 1 + usize::from(both_maps) }
    }

    pub(super) fn motion(&self, patch: u32) -> &Motion {
        &self.motions[patch as usize]
    }

    /// The `count` cheapest of every fluid patch, cheapest first; none for the others.
    ///
    /// 350 patches against 100,000 take about 10¹⁰ comparisons of bytes.
    pub(super) fn scan(&self, target: &Target, count: usize) -> Vec<Vec<Candidate>> {
        let sought: Vec<_> = target.looks.iter().map(|look| look.as_ref().map(Sought::of)).collect();
        let chunks: Vec<_> = (0..self.features.len()).step_by(CHUNK).collect();
        let parts: Vec<_> = chunks.par_iter().map(|&start| self.scan_chunk(&sought, start, count)).collect();
        let merge = |number: usize| {
            let mut best: Vec<_> = parts.iter().flat_map(|part| &part[number].found).copied().collect();
            best.sort_unstable_by(Candidate::order);
            best.truncate(count);
            best
        };
        (0..sought.len()).into_par_iter().map(merge).collect()
    }

    fn scan_chunk(&self, sought: &[Option<Sought>], start: usize, count: usize) -> Vec<Best> {
        let mut best: Vec<_> = sought.iter().map(|_| Best::new(count)).collect();
        let mut blocks = [Block::new(), Block::new()];
        let end = (start + CHUNK).min(self.features.len());
        for first in (start..end).step_by(BLOCK) {
            let patches = &self.features[first..end.min(first + BLOCK)];
            for (map, block) in blocks.iter_mut().enumerate().take(self.maps) {
                block.fill(patches.iter().map(|patch| &patch.words[map]));
            }
            for (sought, best) in sought.iter().zip(&mut best) {
                if let Some(sought) = sought {
                    self.scan_block(&blocks[..self.maps], sought, first..first + patches.len(), best);
                }
            }
        }
        best.iter_mut().for_each(Best::trim);
        best
    }

    fn scan_block(
        &self,
        blocks: &[Block],
        sought: &Sought,
        patches: std::ops::Range<usize>,
        best: &mut Best,
    ) {
        let mut alike = [0u8; BLOCK];
        for block in blocks {
            let sums = block.intersect(&sought.words);
            alike.iter_mut().zip(sums).for_each(|(alike, sum)| *alike = sum.max(*alike));
        }
        let mut costs = [f32::INFINITY; BLOCK];
        for ((cost, &alike), &contrast) in costs.iter_mut().zip(&alike).zip(&self.contrasts[patches.clone()])
        {
            *cost = cost_of(alike, contrast - sought.contrast);
        }
        for (cost, patch) in costs.into_iter().zip(patches) {
            // The motion can only add to it.
            if cost < best.limit {
                let missed = sought.look.wanted.missed(&self.motions[patch]);
                best.push(Candidate { cost: cost + UNWANTED * missed, patch: patch as u32 });
            }
        }
    }

    /// The cost of one patch.
    fn cost(&self, sought: &Sought, patch: u32) -> f32 {
        let features = &self.features[patch as usize];
        let maps = features.words[..self.maps].iter();
        let alike = maps.map(|words| intersection(&sought.words, words)).max().unwrap_or(0);
        let cost = cost_of(alike, self.contrasts[patch as usize] - sought.contrast);
        cost + UNWANTED * sought.look.wanted.missed(self.motion(patch))
    }

    /// Adds to every fluid patch the best of its neighbours, each moved as the patch is from the neighbour, where the database has it: the
    /// two then move as one piece of the video.
    pub(super) fn add_shifts(&self, target: &Target, lists: &mut [Vec<Candidate>]) {
        let places = self.places();
        let added: Vec<Vec<Candidate>> = (0..lists.len())
            .into_par_iter()
            .map(|number| {
                let Some(look) = target.looks[number].as_ref().filter(|look| !look.blown) else {
                    return Vec::new();
                };
                let sought = Sought::of(look);
                let mut new = Vec::new();
                for (neighbour, step) in neighbours(target.grid, number) {
                    for candidate in lists[neighbour].iter().take(SHIFTED) {
                        let Some(patch) = self.shifted(&places, candidate.patch, step) else { continue };
                        let known = lists[number].iter().chain(&new).any(|known| known.patch == patch);
                        if !known {
                            new.push(Candidate { cost: self.cost(&sought, patch), patch });
                        }
                    }
                }
                new
            })
            .collect();
        lists.iter_mut().zip(added).for_each(|(list, added)| list.extend(added));
    }

    /// Gives over-exposed patches the labels of their neighbours, shifted where the database has the shift, all at no cost: only the
    /// neighbours' choice decides. From the border of such an area inwards.
    pub(super) fn spread(&self, target: &Target, lists: &mut [Vec<Candidate>], count: usize) {
        let blown = |number: usize| target.looks[number].as_ref().is_some_and(|look| look.blown);
        let mut open: Vec<usize> = (0..lists.len()).filter(|&number| blown(number)).collect();
        let seen = open.iter().flat_map(|&number| neighbours(target.grid, number));
        if !seen.into_iter().any(|(other, _)| target.looks[other].is_some() && !blown(other)) {
            // There is nothing to learn from: it is taken as it looks.
            return;
        }
        open.iter().for_each(|&number| lists[number].clear());
        let places = self.places();
        loop {
            let spread: Vec<_> = open
                .iter()
                .map(|&number| (number, self.inherited(&places, target.grid, lists, number, count)))
                .collect();
            let before = open.len();
            for (number, list) in spread {
                lists[number] = list;
            }
            open.retain(|&number| lists[number].is_empty());
            if open.is_empty() || open.len() == before {
                break;
            }
        }
        // Areas that touch no other fluid.
        let alone = Target {
            grid: target.grid,
            looks: (0..lists.len()).map(|n| target.looks[n].clone().filter(|_| open.contains(&n))).collect(),
        };
        if !open.is_empty() {
            let scanned = self.scan(&alone, count);
            open.iter().for_each(|&number| lists[number].clone_from(&scanned[number]));
        }
    }

    /// Makes calm patches dearer than those that move as the first `count` of their list usually do. Goes beyond the paper.
    pub(super) fn enliven(&self, lists: &mut [Vec<Candidate>], count: usize) {
        let level = |candidate: &Candidate| (self.motion(candidate.patch).amplitude + STILL).ln();
        for list in lists.iter_mut().filter(|list| !list.is_empty()) {
            let first = &list[..list.len().min(count)];
            let usual = first.iter().map(level).sum::<f32>() / first.len() as f32;
            list.iter_mut()
                .for_each(|candidate| candidate.cost += CALM * (usual - level(candidate)).max(0.0));
            list.sort_by(Candidate::order);
        }
    }

    fn inherited(
        &self,
        places: &HashMap<PatchRef, u32>,
        grid: Grid,
        lists: &[Vec<Candidate>],
        number: usize,
        count: usize,
    ) -> Vec<Candidate> {
        let around = neighbours(grid, number);
        let mut list: Vec<Candidate> = Vec::new();
        // Rank by rank, so that every neighbour has its share.
        for rank in 0..count {
            for &(neighbour, step) in &around {
                let Some(candidate) = lists[neighbour].get(rank) else { continue };
                let patch = self.shifted(places, candidate.patch, step).unwrap_or(candidate.patch);
                if list.len() < count && !list.iter().any(|known| known.patch == patch) {
                    list.push(Candidate { cost: 0.0, patch });
                }
            }
        }
        list
    }

    fn places(&self) -> HashMap<PatchRef, u32> {
        self.features.iter().zip(0..).map(|(features, number)| (features.patch, number)).collect()
    }

    /// The patch that lies `step` patches beside this one in the same version, if there is one.
    fn shifted(&self, places: &HashMap<PatchRef, u32>, patch: u32, step: [i16; 2]) -> Option<u32> {
        let mut place = self.features[patch as usize].patch;
        place.x = place.x.checked_add(step[0] * STRIDE as i16)?;
        place.y = place.y.checked_add(step[1] * STRIDE as i16)?;
        places.get(&place).copied()
    }
}

/// Drops the labels whose motion was not asked for. Returns how many patches have no other: those keep what comes nearest.
pub(super) fn drop_unwanted(lists: &mut [Vec<Candidate>]) -> usize {
    let mut missed = 0;
    for list in lists.iter_mut() {
        let wanted = |candidate: &Candidate| candidate.cost < UNWANTED;
        if list.iter().any(wanted) {
            list.retain(wanted);
        } else if !list.is_empty() {
            missed += 1;
            // The penalty is the same mistake for all labels of the patch, and must not drown the pairs in `λ`.
            list.iter_mut().for_each(|candidate| candidate.cost /= UNWANTED);
        }
    }
    missed
}

/// V: the paper's eq. 5 turned round, as what is minimised must be small where patches are alike; and the contrast, to which words are
/// blind.
fn cost_of(alike: u8, contrast: f32) -> f32 {
    (MOST - alike) as f32 * (1.0 / MOST as f32) + CONTRAST * contrast.abs()
}

/// The logarithm of a contrast; under one level there is nothing but rounding.
fn logarithm(contrast: f32) -> f32 {
    contrast.max(1.0).ln()
}

impl<'a> Sought<'a> {
    fn of(look: &'a Look) -> Self {
        Self { look, words: Sparse::of(&look.words), contrast: logarithm(look.contrast) }
    }
}

/// The patches beside one, and the step from each of them to it.
fn neighbours(grid: Grid, number: usize) -> Vec<(usize, [i16; 2])> {
    let (x, y) = (number % grid.columns, number / grid.columns);
    let mut around = Vec::with_capacity(4);
    if x > 0 {
        around.push((number - 1, [1, 0]));
    }
    if x + 1 < grid.columns {
        around.push((number + 1, [-1, 0]));
    }
    if y > 0 {
        around.push((number - grid.columns, [0, 1]));
    }
    if y + 1 < grid.rows {
        around.push((number + grid.columns, [0, -1]));
    }
    around
}
