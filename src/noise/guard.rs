//! The guard against strobes: how fast a drive may change what a picture shows.
//!
//! ITU-R BT.1702 and WCAG 2.3 limit flashes for people with photosensitive epilepsy. Kept here, in linear light:
//! 1. the mean of the picture changes by at most [`MEAN_STEP`] of full white from frame to frame;
//! 2. no component of 3 to 30 Hz has a modulation above [`MODULATION`] on more than a quarter of the picture.
//!
//! What a picture shows depends on v = X_A·(sin θ, cos θ). Its [`Sensitivity`] says how much luminance changes at the most for a
//! unit of v's path, so both rules are a bound on the path of one frame. For the second: what changes by at most s a second has
//! a component of frequency f of at most 2·s/(π²·f), that of a triangular wave. The step of the amplitude gets half of the path, that of
//! the phase √3/2 of it; they are at right angles. A third is left for the onset, which changes the picture too, and
//! bounds the amplitude.
//!
//! Where the bound does not bite the drive is what it was, to the bit. The photo that follows another at once, what is written on
//! the picture and the panel's brightness are not the drive's, and are not guarded.

use super::drive::Drive;
use crate::math::{Factor, Turns};

/// Share of full white that the mean may change by in a frame.
pub const MEAN_STEP: Factor = Factor::lit("0.02");

/// Half of the swing by the mean, of a component from [`FLASHES_FROM_HERTZ`] up.
pub const MODULATION: Factor = Factor::lit("0.1");

/// The slowest flashes that harm.
pub const FLASHES_FROM_HERTZ: u32 = 3;

/// How much of what a picture shows depends on the drive, in linear light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sensitivity {
    /// By which share of full white the mean of the picture changes for a unit of path.
    pub mean: Factor,
    /// By which share of its own luminance a part of the picture changes for a unit of path. A quarter of the parts may have more.
    pub local: Factor,
}

impl Default for Sensitivity {
    /// Of a picture that was not measured: a guess of middling texture, about that of the demo photo when all of it shimmers
    /// (0.011 and 0.156). It binds the drive, but is no bound on what such a picture shows.
    fn default() -> Self {
        Self { mean: Factor::lit("0.015"), local: Factor::lit("0.15") }
    }
}

impl Sensitivity {
    /// Of a picture that stands still.
    pub const NONE: Self = Self { mean: Factor::ZERO, local: Factor::ZERO };

    /// The greater of each: for two pictures that fade into each other.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self { mean: self.mean.max(other.mean), local: self.local.max(other.local) }
    }
}

/// Limits drives, one a frame.
#[derive(Clone, Debug)]
pub struct Guard {
    bounds: Bounds,
    /// The last drive as it came, and as it went.
    last: Option<(Drive, Drive)>,
}

/// In units of 2^-28.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bounds {
    /// The path of a frame.
    path: i64,
    amplitude: i64,
}

const ONE: i64 = 1 << Factor::FRAC_NBITS;

/// No path of a frame is longer: from one side of the unit circle to the other.
const LONGEST: i64 = 2 * ONE;

/// The onset is a [smoothstep](crate::math) of a second, whose steepest slope is 3/2 a second.
const ONSET_SLOPE: (i64, i64) = (3, 2);

impl Default for Guard {
    fn default() -> Self {
        Self { bounds: Bounds { path: LONGEST, amplitude: ONE }, last: None }
    }
}

impl Guard {
    /// From the next frame on the picture has this sensitivity, and so many frames are shown a second.
    pub fn set(&mut self, sensitivity: Sensitivity, frames_per_second: u32) {
        let fps = i64::from(frames_per_second.max(1));
        let [mean, local] =
            [sensitivity.mean, sensitivity.local].map(|share| i64::from(share.to_bits()).max(1));
        let per_frame = i64::from(MEAN_STEP.to_bits()) * ONE / mean;
        // π²/2·f·MODULATION a second.
        let slope = i64::from((MODULATION * Factor::lit("4.9348")).to_bits()) * i64::from(FLASHES_FROM_HERTZ);
        let per_second = slope * ONE / local;
        let whole = per_frame.min(per_second / fps);
        let (rise, run) = ONSET_SLOPE;
        self.bounds = Bounds {
            path: (whole / 3 * 2).clamp(1, LONGEST),
            amplitude: (whole / 3 * fps * run / rise).clamp(1, ONE),
        };
    }

    /// The drive that is shown for `wanted`.
    pub fn limit(&mut self, wanted: Drive) -> Drive {
        let Bounds { path, amplitude: most } = self.bounds;
        let target = i64::from(wanted.amplitude.to_bits()).min(most);
        let shown = match self.last {
            None => Drive { amplitude: Factor::from_bits(target as i32), ..wanted },
            Some((before, last)) => {
                let from = i64::from(last.amplitude.to_bits());
                let amplitude = target.clamp(from - path / 2, from + path / 2);
                // By the larger of both ends, so that the arc is no longer than it may be.
                let turn = arc(path, amplitude.max(from));
                let step = i64::from(wanted.phase.0.wrapping_sub(before.phase.0) as i32);
                let phase = Turns(last.phase.0.wrapping_add(step.clamp(-turn, turn) as u32));
                Drive { amplitude: Factor::from_bits(amplitude as i32), phase, ..wanted }
            }
        };
        self.last = Some((wanted, shown));
        shown
    }
}

/// The angle whose arc at a radius of `amplitude` has √3/2 of the length `path`, in units of 2^-32 turn; at most half a turn.
fn arc(path: i64, amplitude: i64) -> i64 {
    // √3/2 / 2π in units of 2^-32 turn.
    const PER_UNIT: i128 = 591_990_100;
    let half = 1 << 31;
    (i128::from(path) * PER_UNIT / i128::from(amplitude.max(1))).min(half) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{
        Kind,
        drive::{Oscillator, PhaseForm, Settings},
    };
    use core::f64::consts::{PI, TAU};

    fn place(drive: Drive) -> (f64, f64) {
        let (angle, radius) =
            (f64::from(drive.phase.0) / 2_f64.powi(32) * TAU, drive.amplitude.to_num::<f64>());
        (radius * angle.sin(), radius * angle.cos())
    }

    /// Everything that flickers: phases that jump by more each frame, white amplitudes without inertia, short periods.
    fn wildest() -> impl Iterator<Item = Settings> {
        let forms = [PhaseForm::Integrated, PhaseForm::Literal];
        forms.into_iter().flat_map(|phase| {
            [1, 3, 20].map(|period_frames| Settings {
                amplitude: Kind::White,
                frequency: Kind::White,
                period_frames,
                response_frames: 0,
                glide_frames: 0,
                phase,
            })
        })
    }

    fn path(sensitivity: Sensitivity, fps: u32, settings: Settings) -> Vec<(f64, f64)> {
        let (mut guard, mut oscillator) = (Guard::default(), Oscillator::new(settings, 5));
        guard.set(sensitivity, fps);
        (0..2_000).map(|_| place(guard.limit(oscillator.step()))).collect()
    }

    #[test]
    fn the_mean_never_steps_further_than_it_may() {
        let sensitivity = Sensitivity { mean: Factor::lit("0.1"), local: Factor::lit("0.01") };
        for fps in [12, 25, 60] {
            for settings in wildest() {
                let path = path(sensitivity, fps, settings);
                let longest =
                    path.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).fold(0., f64::max);
                let reach = path.iter().map(|p| p.0.hypot(p.1)).fold(0., f64::max);
                // With the onset's share: it rises by 3/2 a second.
                let step = 0.1 * (longest + reach * 1.5 / f64::from(fps));
                assert!(step <= 0.02 + 1e-6, "{settings:?}: {step}");
                assert!(longest > 0.01, "it moves");
            }
        }
    }

    #[test]
    fn no_component_from_3_hertz_up_is_over_the_modulation() {
        let sensitivity = Sensitivity { mean: Factor::lit("0.001"), local: Factor::lit("0.5") };
        for fps in [12_u32, 30, 60] {
            for settings in wildest() {
                let path = path(sensitivity, fps, settings);
                for second in path.chunks_exact(fps as usize) {
                    for hertz in 3..=(fps / 2).min(30) {
                        let turn = |i: usize| TAU * f64::from(hertz) * i as f64 / f64::from(fps);
                        let (mut re, mut im) = (0., 0.);
                        for (i, p) in second.iter().enumerate() {
                            re += p.0 * turn(i).cos();
                            im += p.0 * turn(i).sin();
                        }
                        let modulation = 0.5 * 2. * re.hypot(im) / f64::from(fps);
                        // A window of a second has ends that do not meet: a jump's share of a component, at most 2/(2π·3).
                        let jump =
                            0.5 * (second[0].0 - second[second.len() - 1].0).abs() / (PI * f64::from(hertz));
                        assert!(modulation <= 0.1 + jump, "{settings:?}: {modulation} at {hertz} Hz");
                    }
                }
            }
        }
    }

    #[test]
    fn a_calm_drive_passes_untouched() {
        let mut guard = Guard::default();
        guard.set(Sensitivity { mean: Factor::lit("0.005"), local: Factor::lit("0.05") }, 12);
        let mut oscillator = Oscillator::new(Settings::default(), 7);
        for _ in 0..10_000 {
            let drive = oscillator.step();
            assert_eq!(guard.limit(drive), drive);
        }
    }

    #[test]
    fn a_picture_that_would_flash_as_it_comes_alive_gets_less_amplitude() {
        let mut guard = Guard::default();
        guard.set(Sensitivity { mean: Factor::ONE, local: Factor::ONE }, 12);
        let mut oscillator =
            Oscillator::new(Settings { amplitude: Kind::Constant, ..Settings::default() }, 7);
        for _ in 0..500 {
            assert!(guard.limit(oscillator.step()).amplitude < Factor::lit("0.06"));
        }
    }
}
