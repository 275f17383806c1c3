//! The power spectrum of a stream of samples, and its slope.

use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Over what a slope is fitted.
pub(crate) struct Estimator {
    /// How many samples are looked at.
    pub(crate) frames: usize,
    /// How long Welch's segments are; they overlap by half.
    pub(crate) segment: usize,
    /// From where to where the line is fitted, in cycles a frame.
    pub(crate) band: (f64, f64),
}

impl Estimator {
    /// 2^20 frames in segments of 2^16, three decades up to a tenth of the frame rate: at 12 frames a second, 14 minutes to 0.83 s.
    pub(crate) const BAND_A: Self = Self { frames: 1 << 20, segment: 1 << 16, band: (1e-4, 1e-1) };

    /// β, where the spectrum of the samples is 1/f^β: the slope of the least-squares line through ten logarithmic means a decade.
    pub(crate) fn slope(&self, mut sample: impl FnMut() -> f64) -> f64 {
        let samples: Vec<f64> = (0..self.frames).map(|_| sample()).collect();
        -line(&self.decades(&welch(&samples, self.segment)))
    }

    /// The logarithms of frequency and power density, ten points a decade.
    fn decades(&self, density: &[f64]) -> Vec<(f64, f64)> {
        let (low, high) = self.band;
        let points = (10. * (high / low).log10()).round() as i32;
        let edge = |i: i32| (low * 10_f64.powf(f64::from(i) / 10.) * self.segment as f64).ceil() as usize;
        (0..points)
            .map(|i| {
                let bins = edge(i)..edge(i + 1);
                let n = bins.len() as f64;
                let frequency =
                    bins.clone().map(|bin| (bin as f64 / self.segment as f64).log10()).sum::<f64>();
                (frequency / n, (density[bins].iter().sum::<f64>() / n).log10())
            })
            .collect()
    }
}

/// Welch's estimate of the power density, up to a constant factor: the mean periodogram of Hann-windowed segments.
fn welch(samples: &[f64], segment: usize) -> Vec<f64> {
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(segment);
    let (mut windowed, mut spectrum) = (transform.make_input_vec(), transform.make_output_vec());
    let hann: Vec<f64> = (0..segment).map(|i| 0.5 - 0.5 * (TAU * i as f64 / segment as f64).cos()).collect();
    let mut density = vec![0.; spectrum.len()];
    for start in (0..=samples.len() - segment).step_by(segment / 2) {
        for ((windowed, sample), weight) in windowed.iter_mut().zip(&samples[start..]).zip(&hann) {
            *windowed = sample * weight;
        }
        transform.process(&mut windowed, &mut spectrum).expect("the buffers are the planner's own");
        for (sum, bin) in density.iter_mut().zip(&spectrum) {
            *sum += bin.norm_sqr();
        }
    }
    density
}

/// The slope of the least-squares line through `points`.
fn line(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mean_x, mean_y) = points.iter().fold((0., 0.), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let (covariance, variance) = points.iter().fold((0., 0.), |(c, v), point| {
        (c + (point.0 - mean_x) * (point.1 - mean_y), v + (point.0 - mean_x) * (point.0 - mean_x))
    });
    covariance / variance
}

#[test]
fn the_estimator_finds_the_slope_of_sums_and_differences() {
    // A linear congruential generator is white enough to tell the estimator's own error.
    let mut state = 1_u64;
    let mut white = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as f64 / 2_f64.powi(32) - 0.5
    };
    assert!(Estimator::BAND_A.slope(&mut white).abs() < 0.03);
    let mut sum = 0.;
    let slope = Estimator::BAND_A.slope(|| {
        sum += white();
        sum
    });
    assert!((slope - 2.).abs() < 0.03, "{slope}");
}
