//! The power spectrum of a stream of samples, and the line through it.
//!
//! Welch's estimate: the mean periodogram of segments of 2^16 samples that overlap by half, each weighted by Hann's window; then
//! its means in ten bins a decade, and the least-squares line through their logarithms.
//!
//! The library's tests hold the noises to their bars with an estimator of their own: no test depends on a tool.

use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// How many samples make a segment, as a power of two.
pub(crate) const LOG2_SEGMENT: u32 = 16;

/// Where lines are fitted, in cycles a frame: at 12 frames a second, periods of 14 minutes to 0.83 s.
pub(crate) const BAND: (f64, f64) = (1e-4, 1e-1);

const BINS_A_DECADE: f64 = 10.;

/// A point of a spectrum: frequency in cycles a frame, and power density in units of the samples' square a (cycle a frame).
pub(crate) type Point = (f64, f64);

/// The one-sided power density of a stream.
pub(crate) struct Spectrum {
    /// Density of frequency i/segment at index i.
    density: Vec<f64>,
    segment: usize,
}

impl Spectrum {
    /// The spectrum of `samples`; none if there is not one whole segment.
    pub(crate) fn of(samples: &[f64], log2_segment: u32) -> Option<Self> {
        let segment = 1 << log2_segment;
        let hann: Vec<f64> =
            (0..segment).map(|i| 0.5 - 0.5 * (TAU * i as f64 / segment as f64).cos()).collect();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(segment);
        let (mut windowed, mut bins) = (transform.make_input_vec(), transform.make_output_vec());
        let mut density = vec![0.; bins.len()];
        let starts = (0..(samples.len() + 1).saturating_sub(segment)).step_by(segment / 2);
        let count = starts.len();
        for start in starts {
            for ((windowed, sample), weight) in windowed.iter_mut().zip(&samples[start..]).zip(&hann) {
                *windowed = sample * weight;
            }
            // Fails only for buffers of another length.
            transform.process(&mut windowed, &mut bins).ok()?;
            density.iter_mut().zip(&bins).for_each(|(sum, bin)| *sum += bin.norm_sqr());
        }
        let weights: f64 = hann.iter().map(|weight| weight * weight).sum();
        density.iter_mut().for_each(|sum| *sum *= 2. / (weights * count as f64));
        (count > 0).then_some(Self { density, segment })
    }

    /// The spectrum as it was estimated, from the first bin that the window keeps free of the mean.
    pub(crate) fn fine(&self) -> impl Iterator<Item = Point> {
        let segment = self.segment as f64;
        self.density.iter().enumerate().skip(3).map(move |(i, &density)| (i as f64 / segment, density))
    }

    /// Its means in ten bins a decade over a band in cycles a frame. Bins without a frequency are left out.
    pub(crate) fn decades(&self, (low, high): (f64, f64)) -> Vec<Point> {
        let count = (BINS_A_DECADE * (high / low).log10()).round() as i32;
        let edge = |i: i32| {
            let bin = low * 10_f64.powf(f64::from(i) / BINS_A_DECADE) * self.segment as f64;
            (bin.ceil() as usize).min(self.density.len())
        };
        let mean = |i: i32| {
            let bins = edge(i)..edge(i + 1);
            let n = bins.len() as f64;
            let frequency = bins.clone().map(|bin| (bin as f64 / self.segment as f64).ln()).sum::<f64>() / n;
            (!bins.is_empty()).then(|| (frequency.exp(), self.density[bins].iter().sum::<f64>() / n))
        };
        (0..count).filter_map(mean).collect()
    }
}

/// The line through a spectrum in double logarithmic scales: density = level / f^slope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// β.
    pub(crate) slope: f64,
    /// The density at one cycle a frame.
    pub(crate) level: f64,
    /// The root mean square distance of the points from the line, in decibels.
    pub(crate) residual: f64,
}

impl Line {
    /// The least-squares line through `points`; none where they hold no power, or are less than two.
    pub(crate) fn through(points: &[Point]) -> Option<Self> {
        if points.len() < 2 || points.iter().any(|&(_, density)| density <= 0.) {
            return None;
        }
        let n = points.len() as f64;
        let logs = points.iter().map(|&(frequency, density)| (frequency.log10(), density.log10()));
        let (x, y) = logs.clone().fold((0., 0.), |(x, y), point| (x + point.0 / n, y + point.1 / n));
        let (covariance, variance) = logs.clone().fold((0., 0.), |(covariance, variance), point| {
            (covariance + (point.0 - x) * (point.1 - y), variance + (point.0 - x) * (point.0 - x))
        });
        let rise = covariance / variance;
        let squares: f64 = logs.map(|point| (point.1 - y - rise * (point.0 - x)).powi(2)).sum();
        Some(Self { slope: -rise, level: 10_f64.powf(y - rise * x), residual: 10. * (squares / n).sqrt() })
    }

    /// The line's density at a frequency in cycles a frame.
    pub(crate) fn at(&self, frequency: f64) -> f64 {
        self.level / frequency.powf(self.slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use realfft::num_complex::Complex;
    use yurameki::{
        math::random::{Stream, stream},
        noise::{Generator, Kind},
    };

    fn white(seed: u64) -> impl FnMut() -> f64 {
        let mut generator = Generator::new(Kind::White, stream(seed, Stream::Amplitude));
        move || generator.step().to_num()
    }

    /// Noise of a known slope: white noise in every bin of a spectrum, weighted, and transformed back (Timmer and König, 1995).
    fn synthetic(slope: f64, log2_len: u32) -> Vec<f64> {
        let transform = RealFftPlanner::<f64>::new().plan_fft_inverse(1 << log2_len);
        let (mut bins, mut samples) = (transform.make_input_vec(), transform.make_output_vec());
        let mut white = white(7);
        let last = bins.len() - 1;
        for (i, bin) in bins.iter_mut().enumerate().skip(1).take(last - 1) {
            *bin = Complex::new(white(), white()) * (i as f64).powf(-slope / 2.);
        }
        transform.process(&mut bins, &mut samples).unwrap();
        samples
    }

    #[test]
    fn the_slope_of_synthetic_noise_is_found() {
        for slope in [0., 1., 2.] {
            let spectrum = Spectrum::of(&synthetic(slope, 18), 14).unwrap();
            let line = Line::through(&spectrum.decades((1e-3, 1e-1))).unwrap();
            assert!((line.slope - slope).abs() < 0.03, "{slope}: {line:?}");
            assert!(line.residual < 1., "{slope}: {line:?}");
        }
    }

    #[test]
    fn white_noise_of_unit_sigma_has_a_density_of_two() {
        let mut white = white(1);
        let samples: Vec<f64> = (0..1 << 18).map(|_| white()).collect();
        let line = Line::through(&Spectrum::of(&samples, 12).unwrap().decades((1e-2, 0.5))).unwrap();
        assert!((line.at(0.1) - 2.).abs() < 0.03, "{line:?}");
    }

    #[test]
    fn what_holds_no_power_or_no_segment_has_no_line() {
        assert!(Spectrum::of(&[1.; 1000], 10).is_none());
        let constant = Spectrum::of(&[0.; 1024], 10).unwrap();
        assert!(Line::through(&constant.decades((1e-2, 0.5))).is_none());
    }

    #[test]
    fn a_line_is_read_back() {
        let points: Vec<Point> = (1..20).map(|i| f64::from(i) / 40.).map(|f| (f, 3. / f.powf(1.5))).collect();
        let line = Line::through(&points).unwrap();
        assert!((line.slope - 1.5).abs() < 1e-9 && (line.level - 3.).abs() < 1e-9 && line.residual < 1e-9);
    }
}
