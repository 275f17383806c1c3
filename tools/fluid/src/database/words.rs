//! Words for all patches: the part of indexing that looks at all videos.

use super::frames::FrameFile;
use crate::{
    appearance::{
        self,
        descriptor::{Descriptor, Descriptors, SPACING},
        view::Sizes,
        vocabulary::Vocabulary,
    },
    features::WordMap,
    patch::{PatchRef, STRIDE, Version},
    plane::Plane,
    video,
};
use image::RgbImage;
use rayon::prelude::*;
use std::io;

/// Videos that a vocabulary is trained from, at most.
pub(super) const TRAINING_VIDEOS: usize = 200;

/// Descriptors that it is trained from: two hundred a word.
const TRAINING_DESCRIPTORS: usize = 40_000;

/// The two pictures of a video that its patches are described in: the mean of the frames, and the sharp one.
pub(super) struct Pictures([Plane; 2]);

impl Pictures {
    pub(super) fn read(file: &FrameFile, sharp: u32) -> io::Result<Self> {
        Ok(Self([plane(&file.mean()?), plane(&file.frame(sharp)?)]))
    }

    /// Descriptors to train from, about `count`, evenly spread over the patches of the upright version.
    pub(super) fn samples(&self, patches: &[PatchRef], count: usize) -> Vec<Descriptor> {
        let upright: Vec<&PatchRef> = patches.iter().filter(|patch| patch.version.number() == 0).collect();
        let mut samples = Vec::new();
        for picture in &self.0 {
            let view = Sizes::of(picture).view(Version::all().next().unwrap_or(patches[0].version));
            let descriptors = Descriptors::of(&view);
            // Neighbours share places: those of a patch's first stride are its own.
            let places = upright.iter().flat_map(|patch| {
                let (left, top) = corner(patch, &view);
                let across = STRIDE / SPACING;
                (0..across * across).map(move |place| (left + place % across, top + place / across))
            });
            samples.extend(
                places
                    .map(|(x, y)| descriptors.values[y * descriptors.columns + x])
                    .filter(|sample| *sample != [0; 128]),
            );
        }
        let every = samples.len().div_ceil(count.max(1)).max(1);
        samples.into_iter().step_by(every).collect()
    }

    /// The words of patches, which are of all versions.
    pub(super) fn words(&self, patches: &[PatchRef], vocabulary: &Vocabulary) -> Vec<[WordMap; 2]> {
        let sizes = self.0.each_ref().map(Sizes::of);
        let runs: Vec<&[PatchRef]> = patches.chunk_by(|a, b| a.version == b.version).collect();
        let of_version = |run: &&[PatchRef]| {
            let maps = sizes.each_ref().map(|sizes| {
                let view = sizes.view(run[0].version);
                appearance::describe_at(&view, run.iter().map(|patch| corner(patch, &view)), vocabulary)
            });
            let [mean, sharp] = maps;
            mean.into_iter().zip(sharp).map(|(mean, sharp)| [mean, sharp]).collect::<Vec<_>>()
        };
        runs.par_iter().flat_map(of_version).collect()
    }
}

/// Descriptors that each of `videos` videos gives to the training.
pub(super) fn share(videos: usize) -> usize {
    TRAINING_DESCRIPTORS / videos.clamp(1, TRAINING_VIDEOS)
}

/// The first place of a patch in a view of its version.
fn corner(patch: &PatchRef, view: &Plane) -> (usize, usize) {
    let first = |centre: i16, side: usize| {
        ((side / 2) as isize + isize::from(centre) - STRIDE as isize) as usize / SPACING
    };
    (first(patch.x, view.width), first(patch.y, view.height))
}

fn plane(picture: &RgbImage) -> Plane {
    Plane {
        width: picture.width() as usize,
        height: picture.height() as usize,
        values: video::luma(picture).into_iter().map(f32::from).collect(),
    }
}
