//! The generators and the response in f64, fed with the same random words: what the integers are measured against.

use crate::math::random::Rng;
use rand::Rng as _;

/// The sum of twelve uniforms in [0, 1) of 16 bits less its mean (paper, section 3.3.1), scaled to unit sigma.
pub(crate) fn white(rng: &mut Rng) -> f64 {
    let sum: u64 =
        (0..3).map(|_| rng.next_u64()).flat_map(|word| [0, 16, 32, 48].map(|s| word >> s & 65_535)).sum();
    (sum as f64 - 6. * 65_535.) / 65_536.
}

/// A linear filter of white noise.
pub(crate) trait Linear<const N: usize>: Default {
    /// Its output for one more input.
    fn step(&mut self, white: f64) -> f64;

    /// Its state after that step.
    fn state(&self) -> [f64; N];
}

/// [`super::filter`]; by default with the weights of the fit before they are rounded.
pub(crate) struct Filter {
    pub(crate) direct: [f64; 2],
    pub(crate) weights: [f64; 8],
    pub(crate) sums: [f64; 8],
    pub(crate) last: f64,
}

impl Default for Filter {
    fn default() -> Self {
        // The second divisor is the sigma of the fit's output for white noise of unit sigma.
        let unit = |weight: f64| weight / 4096. / 6.879_007_974_5;
        Self {
            direct: [5695., 1628.].map(unit),
            weights: [4096., 1269., 907., 302., 220., 83., 55., 40.].map(unit),
            sums: [0.; 8],
            last: 0.,
        }
    }
}

impl Linear<8> for Filter {
    fn step(&mut self, white: f64) -> f64 {
        for (i, sum) in self.sums.iter_mut().enumerate() {
            *sum += self.weights[i] * white - *sum * 0.25_f64.powi(i as i32 + 1);
        }
        let direct = self.direct[0] * white + self.direct[1] * self.last;
        self.last = white;
        direct + self.sums.iter().sum::<f64>()
    }

    fn state(&self) -> [f64; 8] {
        self.sums
    }
}

/// Hosoda's ladder, in his words and with the division by its sigma.
#[derive(Default)]
pub(crate) struct Hosoda {
    pub(crate) z: [f64; 8],
    pub(crate) t: f64,
}

impl Hosoda {
    /// The sigma of the ladder's output for white noise of unit sigma.
    pub(crate) const SIGMA: f64 = 0.009_787_202_621;
}

impl Linear<9> for Hosoda {
    fn step(&mut self, white: f64) -> f64 {
        let mut q = white / Self::SIGMA;
        for (i, z) in self.z.iter_mut().enumerate() {
            let k = 0.5 * 0.25_f64.powi(7 - i as i32);
            *z = k * q + (1. - k) * *z;
            q = (q + *z) / 2.;
        }
        self.t = 0.75 * q + 0.25 * self.t;
        self.t
    }

    fn state(&self) -> [f64; 9] {
        core::array::from_fn(|i| if i < 8 { self.z[i] } else { self.t })
    }
}

/// Brown noise that forgets by 2^-LEAK a frame.
#[derive(Default)]
pub(crate) struct Brown<const LEAK: i32> {
    pub(crate) sum: f64,
}

impl<const LEAK: i32> Linear<1> for Brown<LEAK> {
    fn step(&mut self, white: f64) -> f64 {
        self.sum += 2_f64.powf((1. - f64::from(LEAK)) / 2.) * white - self.sum * 2_f64.powi(-LEAK);
        self.sum
    }

    fn state(&self) -> [f64; 1] {
        [self.sum]
    }
}

/// u·x^z, the growth of intermittent chaos below 1/2 (paper, eq. 9), with z = 1.99.
pub(crate) fn growth(x: f64, u: f64) -> f64 {
    u * x.powf(1.99)
}

/// The sum of eq. 5 over the last n + 1 samples, newest last, with P of eq. 6.
pub(crate) fn response(samples: &[f64], time_constant: f64) -> f64 {
    let decay = |age: usize| if age == 0 { 1. } else { (-(age as f64) / time_constant).exp() };
    samples.iter().rev().enumerate().map(|(age, sample)| sample * decay(age)).sum()
}

/// The covariance of a filter's state for white noise of unit sigma, from its impulse response. 2^20 frames hold all of the
/// slowest memory of 2^16.
pub(crate) fn covariance<F: Linear<N>, const N: usize>() -> [[f64; N]; N] {
    let (mut filter, mut covariance) = (F::default(), [[0.; N]; N]);
    for frame in 0..1 << 20 {
        filter.step(if frame == 0 { 1. } else { 0. });
        let state = filter.state();
        for (row, a) in covariance.iter_mut().zip(state) {
            for (sum, b) in row.iter_mut().zip(state) {
                *sum += a * b;
            }
        }
    }
    covariance
}

/// Sigma of a filter's output for white noise of unit sigma.
pub(crate) fn sigma<F: Linear<N>, const N: usize>() -> f64 {
    spread::<F, N>(&[0])[0]
}

/// The rows of the lower Cholesky factor of `matrix`, diagonal included, one after the other.
pub(crate) fn cholesky<const N: usize>(matrix: [[f64; N]; N]) -> Vec<f64> {
    let mut factor = [[0.; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let rest = matrix[i][j] - (0..j).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
            factor[i][j] = if i == j { rest.sqrt() } else { rest / factor[j][j] };
        }
    }
    (0..N).flat_map(|i| factor[i][..=i].to_vec()).collect()
}

/// Sigma of S/G (eq. 5, 6) for each time constant, for a filter of white noise of unit sigma, from its impulse response.
pub(crate) fn spread<F: Linear<N>, const N: usize>(time_constants: &[u32]) -> Vec<f64> {
    let mut filter = F::default();
    let impulse: Vec<f64> = (0..1 << 20).map(|t| filter.step(if t == 0 { 1. } else { 0. })).collect();
    let spread = |time_constant: u32| {
        let (r, n) = ((-1. / f64::from(time_constant)).exp(), 5 * time_constant as usize);
        let tail = r.powi(n as i32 + 1);
        let (mut sum, mut squares) = (0., 0.);
        for (t, h) in impulse.iter().enumerate() {
            sum = r * sum + h - if t > n { tail * impulse[t - n - 1] } else { 0. };
            squares += sum * sum;
        }
        f64::sqrt(squares) * (1. - r) / (1. - tail)
    };
    time_constants.iter().map(|&time_constant| spread(time_constant)).collect()
}

/// White noise itself, as a filter.
#[derive(Default)]
pub(crate) struct White(f64);

impl Linear<1> for White {
    fn step(&mut self, white: f64) -> f64 {
        self.0 = white;
        white
    }

    fn state(&self) -> [f64; 1] {
        [self.0]
    }
}

/// How far integers are from their twin: the ratio of the twin's power to that of the difference, in decibels, and the mean
/// difference.
#[derive(Default)]
pub(crate) struct Comparison {
    power: f64,
    error_power: f64,
    error: f64,
    count: f64,
}

impl Comparison {
    pub(crate) fn add(&mut self, integer: crate::math::Sample, twin: f64) {
        let error = integer.to_num::<f64>() - twin;
        self.power += twin * twin;
        self.error_power += error * error;
        self.error += error;
        self.count += 1.;
    }

    /// Fails unless the ratio is at least 150 dB and the mean difference at most 1e-6 (the noises have a sigma of 0.3 to 1).
    pub(crate) fn check(&self, name: &str) {
        let decibels = 10. * (self.power / self.error_power).log10();
        let bias = self.error / self.count;
        println!("{name}: {decibels:.1} dB, bias {bias:.1e}");
        assert!(decibels >= 150., "{name}: {decibels} dB");
        assert!(bias.abs() <= 3e-7, "{name}: bias {bias}");
    }
}

/// Fails unless each entry of an integer table is the exact value times 2^`bits`, rounded; `slack` is what f64 may err by.
pub(crate) fn check_table(
    table: impl IntoIterator<Item = i64>,
    exact: impl IntoIterator<Item = f64>,
    bits: i32,
    slack: f64,
) {
    let (table, exact): (Vec<_>, Vec<_>) = (table.into_iter().collect(), exact.into_iter().collect());
    assert_eq!(table.len(), exact.len());
    for (i, (entry, exact)) in table.into_iter().zip(exact).enumerate() {
        let exact = exact * 2_f64.powi(bits);
        assert!((entry as f64 - exact).abs() <= 0.5 + slack, "entry {i} is {entry}, exactly {exact}");
    }
}
