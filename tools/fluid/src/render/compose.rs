//! The detail of every frame: what the patches change, blended.
//!
//! The paper, section 6: D_i = F_i − A, where A is the mean of the frames. Departures: 1) a patch's own brightness is taken out of D unless
//! its neighbours continue it, since blobs as large as a patch would come and go; 2) D is scaled to the contrast of the picture there;
//! 3) where patches overlap, their sum is divided by its expected contrast, since a mean of strangers is paler than each.

use super::flat::{continued, is_flat, statistics, under};
use super::plan::{self, LEVELS, Laid};
use super::pyramid::{Laplacian, blurred};
use super::reel::{Reel, Taps};
use super::{Ask, RenderError};
use crate::footage::{Class, Footage, Video};
use crate::label::{Grid, Labelling};
use crate::patch::{SIDE, STRIDE};
use crate::plane::Plane;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Contrasts are compared after this many levels were added, so that noise is not made into motion.
const CALM: f32 = 4.0;

/// A change is scaled by no less and no more than this.
const GAINS: (f32, f32) = (0.4, 1.6);

/// What water and fire are multiplied by besides: what is lost to edges, to evenness and to strangers that overlap. Of clips that were kept
/// out, the medians of the amplitude's log ratio and of tps: water −.25, .61 without and −.11, .56 with it (1.8: .00, .67), fire −.34, .75 and
/// −.21, .61. Clouds only got worse.
const LOST: f32 = 1.4;

/// The share of changes as broad as a patch that is taken from water, which sparkles and does not glow: they look like blobs that pop up.
/// Flames and smoke need them.
const BROAD: f32 = 0.7;

/// Halvings of a blur that only such changes outlast.
const BREADTH: usize = 4;

/// The changes of all frames, and how many a second they are.
pub(super) struct Detail {
    /// One a frame, as large as the picture at the working size, in levels of luminance.
    pub(super) frames: Vec<Plane>,
    /// Frames a second.
    pub(super) rate: f32,
}

/// A patch that is ready to be added to frames.
struct Ready<'a> {
    laid: &'a Laid,
    taps: Taps,
    mean: Vec<f32>,
    gain: f32,
}

/// Moments at which a patch is looked at.
const MOMENTS: [f32; 4] = [0.125, 0.375, 0.625, 0.875];

/// Composes the detail for a picture of this luminance.
pub(super) fn compose(
    ask: &Ask<'_>,
    labelling: &Labelling,
    picture: &Plane,
    footage: &dyn Footage,
) -> Result<Detail, RenderError> {
    let laid = plan::plan(&continued(labelling, picture, footage));
    let mut used: BTreeMap<u32, Vec<&Laid>> = BTreeMap::new();
    for one in &laid {
        used.entry(one.patch.video).or_default().push(one);
    }
    // The one that is used most sets the pace, and its loop the length.
    let mut order: Vec<_> = used.into_iter().collect();
    order.sort_by_key(|(number, laid)| (core::cmp::Reverse(laid.len()), *number));
    let mut clip: Option<(f32, Vec<Laplacian>)> = None;
    let count = order.len();
    let lost = if ask.options.class == Class::Smoke { 1.0 } else { LOST };
    for (done, (number, mut laid)) in order.into_iter().enumerate() {
        (ask.progress)(super::Stage::Detail, done, count);
        let video = footage.video(number).ok_or(RenderError::UnknownVideo(number))?;
        let reel;
        (reel, clip) = match clip {
            Some((rate, frames)) => {
                (Reel::load(footage, video, frames.len() as f32 / rate, false)?, Some((rate, frames)))
            }
            None => {
                let (reel, rate, frames) = first(ask, video, footage, labelling.grid)?;
                (reel, Some((rate, frames)))
            }
        };
        laid.sort_by(|a, b| b.patch.version.scale().total_cmp(&a.patch.version.scale()));
        if let Some((_, frames)) = &mut clip {
            add(reel, &laid, picture, lost, frames);
        }
    }
    let (rate, frames) = clip.ok_or(RenderError::NoFluid)?;
    (ask.progress)(super::Stage::Detail, count, count);
    let share = if ask.options.class == Class::Water { BROAD } else { 0.0 };
    let joined = frames.into_par_iter().map(|pyramid| {
        let mut frame = cropped(&pyramid.join(), picture.width, picture.height);
        let broad = blurred(&frame, BREADTH);
        frame.values.iter_mut().zip(&broad.values).for_each(|(value, broad)| *value -= share * broad);
        frame
    });
    Ok(Detail { frames: joined.collect(), rate })
}

/// The first reel, the clip's rate, and empty frames as many as its loop has.
fn first(
    ask: &Ask<'_>,
    video: &Video,
    footage: &dyn Footage,
    grid: Grid,
) -> Result<(Reel, f32, Vec<Laplacian>), RenderError> {
    let (wanted, free) = ask.options.seconds.map_or((super::SECONDS, true), |seconds| (seconds, false));
    let mut reel = Reel::load(footage, video, wanted, free)?;
    let mut seconds = wanted;
    if free {
        // A loop that is short goes round until other videos find room beside it.
        let once = reel.round().length() as f32 / video.rate;
        let rounds = (super::SHORTEST / once).ceil().max(1.0);
        reel.repeat(rounds as usize);
        seconds = once * rounds;
    }
    let rate =
        ask.options.rate.unwrap_or(video.rate.max(super::SMOOTH)).clamp(super::RATES.0, super::RATES.1);
    let count = ((seconds * rate).round() as usize).clamp(2, super::MOST_FRAMES);
    let (width, height) = ((grid.columns + 1) * STRIDE, (grid.rows + 1) * STRIDE);
    Ok((reel, rate, (0..count).map(|_| Laplacian::new(width, height, LEVELS)).collect()))
}

/// Adds the patches of one video, which come in descending size, to all frames.
fn add(mut reel: Reel, laid: &[&Laid], picture: &Plane, lost: f32, frames: &mut [Laplacian]) {
    let count = frames.len();
    for same in laid.chunk_by(|a, b| a.patch.version.scale() == b.patch.version.scale()) {
        reel.smoothed(same[0].patch.version);
        let ready: Vec<_> = same.par_iter().map(|laid| Ready::new(laid, &reel, picture, lost)).collect();
        frames.par_iter_mut().enumerate().for_each(|(index, frame)| {
            let mut patch = Laplacian::new(SIDE, SIDE, LEVELS);
            for ready in &ready {
                let moment = (index as f32 / count as f32 + ready.laid.start).fract();
                ready.change(&reel, moment, &mut patch.levels[0].values);
                patch.split();
                blend(&patch, ready, frame);
            }
        });
    }
}

/// Adds a patch's pyramid to a frame's.
fn blend(patch: &Laplacian, ready: &Ready<'_>, frame: &mut Laplacian) {
    let (column, row) = ready.laid.place;
    for (level, ((patch, frame), weights)) in
        patch.levels.iter().zip(&mut frame.levels).zip(&ready.laid.weights).enumerate()
    {
        let stride = STRIDE >> level;
        for (y, (values, weights)) in
            patch.values.chunks_exact(patch.width).zip(weights.chunks_exact(patch.width)).enumerate()
        {
            let out = &mut frame.values[(row * stride + y) * frame.width + column * stride..][..patch.width];
            for ((out, value), weight) in out.iter_mut().zip(values).zip(weights) {
                *out += value * weight;
            }
        }
    }
}

impl<'a> Ready<'a> {
    fn new(laid: &'a Laid, reel: &Reel, picture: &Plane, lost: f32) -> Self {
        let taps = reel.taps(&laid.patch);
        let mean = reel.mean(&taps);
        let mut shown = vec![0.0; SIDE * SIDE];
        let contrasts = MOMENTS.map(|moment| {
            shown.fill(0.0);
            if let Some((frame, _)) = reel.round().at(moment).next() {
                reel.add(&taps, (frame, 1.0), &mut shown);
            }
            statistics(shown.iter().copied()).1
        });
        let theirs = contrasts.iter().sum::<f32>() / contrasts.len() as f32;
        let (mean_of_ours, ours) = under(picture, laid.place);
        let gain = if is_flat(mean_of_ours, ours) {
            1.0
        } else {
            ((ours + CALM) / (theirs + CALM)).clamp(GAINS.0, GAINS.1)
        };
        Self { laid, taps, mean, gain: gain * lost }
    }

    /// The change of the patch at a moment of its loop.
    fn change(&self, reel: &Reel, moment: f32, out: &mut [f32]) {
        out.fill(0.0);
        let mut total = 0.0;
        for term in reel.round().at(moment) {
            total += term.1;
            reel.add(&self.taps, term, out);
        }
        let mut whole = 0.0;
        for (value, mean) in out.iter_mut().zip(&self.mean) {
            *value -= total * mean;
            whole += *value;
        }
        let blob = whole / out.len() as f32 * (1.0 - self.laid.company);
        for value in out {
            *value = (*value - blob) * self.gain;
        }
    }
}

/// The upper left part of a plane, filled up with zeros.
fn cropped(plane: &Plane, width: usize, height: usize) -> Plane {
    let mut out = Plane::new(width, height);
    let shared = width.min(plane.width);
    for (to, from) in out.values.chunks_exact_mut(width).zip(plane.values.chunks_exact(plane.width)) {
        to[..shared].copy_from_slice(&from[..shared]);
    }
    out
}
