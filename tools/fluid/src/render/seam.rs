//! Every video becomes a loop: the pair of distant frames that are most alike, and a fade from one to the other.
//!
//! Loops of all videos take the same time, or a whole part of it, so that a clip of them is a loop wherever it is cut; patches may start
//! anywhere in theirs, and no moment of the clip is the seam of all.

use crate::plane::Plane;

/// A fade takes this share of a loop, and at most [`LONGEST_FADE`] frames of the video: longer ones show two pictures at once.
const FADE: f32 = 1.0 / 5.0;

/// See [`FADE`].
const LONGEST_FADE: usize = 12;

/// A video's own pace may be bent by this share, so that its loop fits the clip: nobody sees it.
const BEND: f32 = 0.07;

/// Videos with so many frames a second are shown frame by frame: a mean of two frames takes away what changes fastest, and a fountain
/// became slow oil of it (tps 2.1, and 1.6 without). Slower ones would stutter.
const WHOLE: f32 = 20.0;

/// A loop of a video's frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Loop {
    /// The first frame; the fade reads up to [`Self::fade`] frames before it.
    start: usize,
    /// Frames of the video until it begins again.
    length: usize,
    /// Frames of the fade at its end.
    fade: usize,
    /// Rounds in a clip.
    rounds: usize,
    /// How much alike the frames are between which it fades: their correlation.
    alike: f32,
    /// Correlation of successive frames.
    steady: f32,
    /// The last frame that there is.
    last: usize,
    /// Whether frames are shown as they are, and none between them.
    whole: bool,
}

/// Frames of a video worth reading for a clip that lasts `wanted` of them: enough to choose from.
pub(super) fn frames_to_read(wanted: f32) -> u32 {
    (wanted * (1.0 + BEND) * 1.25) as u32 + LONGEST_FADE as u32 + 2
}

/// A frame of a video and how much of it is shown.
pub(super) type Term = (usize, f32);

impl Loop {
    /// The best loop of a video whose changes, made small, are `frames`, for a clip that lasts `wanted` of its frames. With `free`, the
    /// loop may be shorter by a quarter: the clip is going to be as long as it.
    pub(super) fn find(frames: &[Plane], wanted: f32, free: bool) -> Self {
        let last = frames.len().saturating_sub(1);
        if last < 3 {
            return Self {
                start: 0,
                length: last.max(1),
                fade: 0,
                rounds: 1,
                alike: 1.0,
                steady: 1.0,
                last,
                whole: false,
            };
        }
        // A loop and the fade before it must be there.
        let longest = (last as f32 / (1.0 + FADE)).max((last.saturating_sub(LONGEST_FADE)) as f32);
        let rounds = if free { 1.0 } else { (wanted * (1.0 - BEND) / longest).ceil().max(1.0) };
        let ideal = (wanted / rounds).min(longest * (1.0 + BEND));
        let (least, most) = if free { (0.75, 1.0) } else { (1.0 - BEND, 1.0 + BEND) };
        let least = ((ideal * least) as usize).clamp(2, last - 1);
        let most = ((ideal * most).ceil() as usize).clamp(least, last - 1);
        let mut best: Option<(f32, Self)> = None;
        for length in least..=most {
            let fade = ((length as f32 * FADE) as usize).clamp(1, LONGEST_FADE).min(last - length);
            for start in fade..=last - length {
                let (a, b) = (&frames[start - fade / 2], &frames[start + length - fade / 2]);
                // Of two that are equally alike, the one that bends the pace less.
                let cost = distance(a, b) * (1.0 + (length as f32 / ideal - 1.0).abs());
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    let alike = correlation(a, b).max(0.0);
                    best = Some((
                        cost,
                        Self {
                            start,
                            length,
                            fade,
                            rounds: rounds as usize,
                            alike,
                            steady: 1.0,
                            last,
                            whole: false,
                        },
                    ));
                }
            }
        }
        let mut found = best.map_or(
            Self { start: 0, length: last, fade: 0, rounds: 1, alike: 1.0, steady: 1.0, last, whole: false },
            |(_, found)| found,
        );
        found.steady =
            frames.windows(2).map(|pair| correlation(&pair[0], &pair[1])).sum::<f32>() / last as f32;
        found
    }

    /// Frames of the video until it begins again.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// The same for a video of this many frames a second.
    pub(super) fn at_rate(self, rate: f32) -> Self {
        Self { whole: rate >= WHOLE, ..self }
    }

    /// The same, so many times in a clip.
    pub(super) fn repeat(&mut self, rounds: usize) {
        self.rounds = rounds;
    }

    /// What is shown at a moment, 0..1 of the clip: at most four terms, whose weights keep the contrast of one frame.
    pub(super) fn at(&self, moment: f32) -> impl Iterator<Item = Term> {
        let place = (moment * self.rounds as f32).fract() * self.length as f32;
        let left = self.length as f32 - place;
        let share = if self.fade == 0 { 0.0 } else { (1.0 - left / self.fade as f32).clamp(0.0, 1.0) };
        let (rising, falling) = (share * core::f32::consts::FRAC_PI_2).sin_cos();
        let [falling, rising] = of_one_frame([falling, rising], self.alike);
        let place = self.start as f32 + place;
        let both = [(place, falling), (place - self.length as f32, rising)];
        let (steady, last, whole) = (self.steady, self.last, self.whole);
        both.into_iter().filter(|&(_, weight)| weight > 1e-3).flat_map(move |(place, weight)| {
            let place = if whole { place.round() } else { place };
            let frame = place.max(0.0) as usize;
            let part = (place - frame as f32).clamp(0.0, 1.0);
            let between = of_one_frame([1.0 - part, part], steady);
            let terms =
                [(frame.min(last), weight * between[0]), ((frame + 1).min(last), weight * between[1])];
            terms.into_iter().filter(|&(_, weight)| weight > 1e-3)
        })
    }
}

/// Weights of two frames that correlate by `alike`, scaled so that their sum varies as much as one of them.
fn of_one_frame(weights: [f32; 2], alike: f32) -> [f32; 2] {
    let [a, b] = weights;
    let power = (a * a + b * b + 2.0 * a * b * alike).max(1e-6);
    weights.map(|weight| weight / power.sqrt())
}

fn distance(a: &Plane, b: &Plane) -> f32 {
    a.values.iter().zip(&b.values).map(|(a, b)| (a - b) * (a - b)).sum::<f32>()
}

/// The correlation of two planes whose means are about zero; 0 if one of them is empty.
fn correlation(a: &Plane, b: &Plane) -> f32 {
    let product = |a: &Plane, b: &Plane| a.values.iter().zip(&b.values).map(|(a, b)| a * b).sum::<f32>();
    let power = product(a, a) * product(b, b);
    if power > 0.0 { product(a, b) / power.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave that runs to the right, eleven frames a period.
    fn wave(frames: usize) -> Vec<Plane> {
        let phase = |frame: usize, x: usize| (x as f32 / 4.0 - frame as f32 / 11.0) * core::f32::consts::TAU;
        (0..frames)
            .map(|frame| Plane {
                width: 16,
                height: 1,
                values: (0..16).map(|x| phase(frame, x).sin()).collect(),
            })
            .collect()
    }

    fn shown(frames: &[Plane], found: &Loop, moment: f32) -> Vec<f32> {
        let mut sum = vec![0.0; 16];
        for (frame, weight) in found.at(moment) {
            for (sum, value) in sum.iter_mut().zip(&frames[frame].values) {
                *sum += weight * value;
            }
        }
        sum
    }

    #[test]
    fn a_periodic_video_loops_by_whole_periods() {
        let found = Loop::find(&wave(60), 44.0, true);
        assert_eq!(found.length() % 11, 0, "{found:?}");
    }

    #[test]
    fn a_loop_has_no_jump_and_keeps_its_contrast() {
        let frames = wave(60);
        let found = Loop::find(&frames, 44.0, true);
        let steps = found.length();
        for step in 0..steps {
            let (a, b) = (
                shown(&frames, &found, step as f32 / steps as f32),
                shown(&frames, &found, (step + 1) as f32 / steps as f32),
            );
            let jump = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
            assert!(jump < 4.0, "frame {step} of {found:?} jumps by {jump}");
            let power = a.iter().map(|a| a * a).sum::<f32>();
            assert!((6.0..10.0).contains(&power), "frame {step} of {found:?} has a power of {power}");
        }
    }

    #[test]
    fn a_video_that_is_fast_enough_is_shown_frame_by_frame() {
        let found = Loop::find(&wave(60), 44.0, true).at_rate(25.0);
        // Beyond the fade one frame is shown, wherever between two the moment is.
        assert!((10..700).all(|moment| found.at(moment as f32 / 1000.0).count() == 1), "{found:?}");
        let slow = found.at_rate(5.0);
        assert!((10..700).any(|moment| slow.at(moment as f32 / 1000.0).count() == 2), "{slow:?}");
    }

    #[test]
    fn a_short_video_goes_round_more_often() {
        let found = Loop::find(&wave(12), 100.0, false);
        assert!(found.rounds >= 9, "{found:?}");
        assert!(found.at(0.999).all(|(frame, _)| frame < 12));
    }

    #[test]
    fn all_frames_that_are_asked_for_are_there() {
        for count in 1..40 {
            for wanted in [1.0, 7.5, 24.0, 90.0] {
                let found = Loop::find(&wave(count), wanted, false);
                let top = (0..1000)
                    .flat_map(|moment| found.at(moment as f32 / 1000.0))
                    .map(|(frame, _)| frame)
                    .max();
                assert!(
                    top.is_some_and(|top| top < count),
                    "{count} frames for {wanted}: {found:?} asks for {top:?}"
                );
            }
        }
    }
}
