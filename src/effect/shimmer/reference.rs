//! The slow twin of the shimmer: float64, written from the equations, and the tests that hold the fixed-point one to it.

use super::{Branch, Range, Settings};
use crate::{effect::Photo, math::Turns};

/// A plane of float64.
struct Plane {
    width: usize,
    values: Vec<f64>,
}

impl Plane {
    fn from(width: usize, height: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..width * height).map(|i| value(i % width, i / width)).collect();
        Self { width, values }
    }

    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    fn at(&self, x: isize, y: isize) -> f64 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        self.values[y.clamp(0, self.height() as isize - 1) as usize * self.width + x]
    }

    fn map(&self, value: impl Fn(isize, isize) -> f64) -> Self {
        Self::from(self.width, self.height(), |x, y| value(x as isize, y as isize))
    }

    fn minus(&self, other: &Self) -> Self {
        self.map(|x, y| self.at(x, y) - other.at(x, y))
    }

    /// The values of the window around (x, y) that lie in the picture.
    fn window(&self, x: isize, y: isize, radius: isize) -> impl Iterator<Item = f64> {
        let inside = |at: isize, end: usize| (at - radius).max(0)..(at + radius + 1).min(end as isize);
        let columns = inside(x, self.width);
        inside(y, self.height()).flat_map(move |y| columns.clone().map(move |x| self.at(x, y)))
    }

    /// A box of `radius`, twice in each direction, edges repeated.
    fn blurred(&self, radius: isize) -> Self {
        let side = 2 * radius + 1;
        let weigh = |at: &dyn Fn(isize) -> f64| {
            let sum = (1 - side..side).map(|d| (side - d.abs()) as f64 * at(d)).sum::<f64>();
            sum / (side * side) as f64
        };
        let columns = self.map(|x, y| weigh(&|d| self.at(x, y + d)));
        columns.map(|x, y| weigh(&|d| columns.at(x + d, y)))
    }

    fn sobel(&self, x: isize, y: isize) -> [f64; 2] {
        let across = [(-1, 1.0), (0, 2.0), (1, 1.0)];
        let difference = |at: &dyn Fn(isize, isize) -> f64| {
            across.iter().map(|&(k, weight)| weight * (at(1, k) - at(-1, k))).sum::<f64>() / 8.0
        };
        [difference(&|d, k| self.at(x + d, y + k)), difference(&|d, k| self.at(x + k, y + d))]
    }
}

fn radians(angle: Turns) -> f64 {
    f64::from(angle.0) / 2_f64.powi(32) * core::f64::consts::TAU
}

/// The heights P, Q and C of the photo (eq. 2, 3; `bands` for travelling).
fn heights(photo: Photo<'_>, settings: &Settings) -> [Plane; 3] {
    let (width, height) = (photo.size.width as usize, photo.size.height as usize);
    let scale = (f64::from(photo.size.width.min(photo.size.height)) / 480.0).max(1.0);
    let luma = Plane::from(width, height, |x, y| {
        let rgb = &photo.rgb[(y * width + x) * 3..];
        (218.0 * f64::from(rgb[0]) + 732.0 * f64::from(rgb[1]) + 74.0 * f64::from(rgb[2])) / 1024.0
    });
    let (centre, amplitude) = match settings.range {
        Range::Full => (luma.map(|_, _| 127.5), luma.map(|_, _| 127.5)),
        Range::Neighbourhood => {
            let radius = (4.0 * scale) as isize;
            let extreme =
                |pick: fn(f64, f64) -> f64| luma.map(|x, y| luma.window(x, y, radius).reduce(pick).unwrap());
            let (max, min) = (extreme(f64::max), extreme(f64::min));
            (
                max.map(|x, y| (max.at(x, y) + min.at(x, y)) / 2.0),
                max.map(|x, y| (max.at(x, y) - min.at(x, y)) / 2.0),
            )
        }
        Range::Travelling => {
            let [riesz, band] = local_phase(&luma, scale, settings.wind);
            let even = luma.map(|x, y| 24.0 / (riesz.at(x, y).hypot(band.at(x, y)) + 12.0));
            let quadrature = luma.map(|x, y| band.at(x, y) * even.at(x, y));
            let centre =
                luma.map(|x, y| (luma.at(x, y) - quadrature.at(x, y)).clamp(-256.0, 32_767.0 / 128.0));
            return [luma.map(|x, y| riesz.at(x, y) * even.at(x, y)), quadrature, centre];
        }
    };
    let quadrature = luma.minus(&centre);
    let sign = if settings.branch == Branch::Falling { -1.0 } else { 1.0 };
    let in_phase = luma.map(|x, y| {
        let (a, q) = (amplitude.at(x, y), quadrature.at(x, y));
        sign * (a * a - q * q).max(0.0).sqrt()
    });
    [in_phase, quadrature, centre]
}

/// R_w B by the derivatives of two octave bands, and B, before the swing is evened.
fn local_phase(luma: &Plane, scale: f64, wind: Turns) -> [Plane; 2] {
    let radii = [1.0, 2.0, 4.0].map(|r| (r * scale).round() as isize);
    let blurs = radii.map(|radius| luma.blurred(radius));
    let wind = radians(wind);
    let octave = |narrow: usize| {
        let wave = blurs[narrow].minus(&blurs[narrow + 1]);
        let r = radii[narrow] as f64;
        let per_omega = (2.0 / 3.0 * r * (r + 1.0)).sqrt() / 0.961;
        wave.map(|x, y| {
            let (dx, dy) = (wave.at(x + 1, y) - wave.at(x - 1, y), wave.at(x, y + 1) - wave.at(x, y - 1));
            -per_omega * (dx * wind.sin() - dy * wind.cos()) / 2.0
        })
    };
    let [fine, coarse] = [0, 1].map(octave);
    [luma.map(|x, y| fine.at(x, y) + coarse.at(x, y)), blurs[0].minus(&blurs[2])]
}

/// The slopes of a pixel, from P, Q and C, flattened to 54.6°.
type Slopes = [[f64; 2]; 3];

/// A photo that shimmers, in float64.
pub(super) struct Twin {
    colours: Vec<u8>,
    slopes: Vec<Slopes>,
    light: [f64; 3],
    strength: f64,
}

impl Twin {
    pub(super) fn prepare(photo: Photo<'_>, settings: &Settings) -> Self {
        let scale = (f64::from(photo.size.width.min(photo.size.height)) / 480.0).max(1.0);
        let steepness =
            settings.relief.to_num::<f64>() * scale / f64::from(settings.range.luma_for_45_degrees());
        let steepest = 1440.0 / 1024.0;
        let heights = heights(photo, settings);
        let slopes = (0..photo.size.pixels()).map(|i| {
            let (x, y) = ((i % heights[0].width) as isize, (i / heights[0].width) as isize);
            let [p, q, c] = heights.each_ref().map(|plane| plane.sobel(x, y).map(|g| g * steepness.min(0.5)));
            let swing = (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]).sqrt();
            let flatten = (steepest / (swing + c[0].hypot(c[1]))).min(1.0);
            let mask = f64::from(photo.mask[i]) / 255.0;
            [(p, mask), (q, mask), (c, 1.0)].map(|(slope, mask)| slope.map(|s| s * flatten * mask))
        });
        let (azimuth, elevation) = (radians(settings.light.azimuth), radians(settings.light.elevation));
        let flat = elevation.cos();
        Self {
            colours: photo.rgb.to_vec(),
            slopes: slopes.collect(),
            light: [flat * azimuth.sin(), -flat * azimuth.cos(), elevation.sin()],
            strength: settings.strength.to_num(),
        }
    }

    fn shade(&self, i: usize, sine: f64, cosine: f64) -> f64 {
        let [p, q, c] = self.slopes[i];
        let [x, y] = [0, 1].map(|k| sine * p[k] + cosine * q[k] + c[k]);
        let lambert = self.light[2] - self.light[0] * x - self.light[1] * y;
        (lambert / (1.0 + x * x + y * y).sqrt()).max(0.0)
    }

    /// The colour of pixel i, 0..=255 a channel, at amplitude X_A and phase θ in radians, with onset 1.
    pub(super) fn pixel(&self, i: usize, amplitude: f64, phase: f64) -> [f64; 3] {
        let typical = (0.25_f64 + 1.0 / 36.0).sqrt();
        let mean = [(typical, 0.0), (0.0, typical), (-typical, 0.0), (0.0, -typical)];
        let mean = mean.map(|(sine, cosine)| self.shade(i, sine, cosine)).iter().sum::<f64>() / 4.0;
        let shade = self.shade(i, amplitude * phase.sin(), amplitude * phase.cos());
        let gain = (1.0 + self.strength * (shade - mean) / self.light[2]).max(0.0);
        [0, 1, 2].map(|k| (f64::from(self.colours[i * 3 + k]) * gain).min(255.0))
    }
}

mod tests {
    use super::*;
    use crate::{
        effect::{
            Effect, Paint,
            shimmer::{Light, Shimmer, storage_len},
        },
        frame::{FrameMut, FrameRef, Layout, PixelFormat, Size},
        math::Factor,
        noise::drive::Drive,
    };
    use proptest::prelude::*;

    /// A picture with smooth shading, texture and hard edges.
    fn picture(size: Size, seed: u64) -> Vec<u8> {
        let mut state = seed | 1;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 33) as i32
        };
        let (kind, wave) = (random() % 4, 3 + random() % 9);
        let pixel = |x: i32, y: i32, noise: i32| match kind {
            0 => [noise % 256, (noise >> 8) % 256, (noise >> 16) % 256],
            1 => [(x * 255 / wave) % 256, (x + y) * 7 % 256, 128 + noise % 20],
            2 => {
                if (x / wave + y / wave) % 2 == 0 {
                    [0, 0, 0]
                } else {
                    [255, 255, 255]
                }
            }
            _ => {
                let sine = (f64::from(x * 3 + y) / f64::from(wave)).sin();
                [(127.0 + 100.0 * sine) as i32, 90 + noise % 7, 200]
            }
        };
        let places = (0..size.height as i32).flat_map(|y| (0..size.width as i32).map(move |x| (x, y)));
        places.flat_map(|(x, y)| pixel(x, y, random()).map(|c| c as u8)).collect()
    }

    fn settings() -> impl Strategy<Value = Settings> {
        let range = prop_oneof![Just(Range::Full), Just(Range::Neighbourhood), Just(Range::Travelling)];
        let branch = prop_oneof![Just(Branch::Rising), Just(Branch::Falling)];
        (range, branch, 0..360, 20..90, 0..360, 1..20_i32, 1..13_i32).prop_map(
            |(range, branch, azimuth, elevation, wind, relief, strength)| Settings {
                range,
                branch,
                light: Light {
                    azimuth: Turns::from_degrees(azimuth),
                    elevation: Turns::from_degrees(elevation),
                },
                relief: Factor::from_num(f64::from(relief) / 10.0),
                strength: Factor::from_num(f64::from(strength) / 10.0),
                wind: Turns::from_degrees(wind),
            },
        )
    }

    /// Largest and root mean square difference in levels of 8 bits over `frames` frames.
    fn difference(
        size: Size,
        rgb: &[u8],
        mask: &[u8],
        settings: &Settings,
        frames: u32,
        padding: usize,
    ) -> [f64; 2] {
        let photo = Photo { size, rgb, mask };
        let twin = Twin::prepare(photo, settings);
        let mut storage = vec![0; storage_len(size)];
        let mut shimmer = Shimmer::prepare(photo, settings, &mut storage).unwrap();
        let stride = size.width as usize * 4 + padding;
        let layout = Layout::new(size, PixelFormat::Xrgb8888, Some(stride)).unwrap();
        let mut pixels = vec![0; layout.len_bytes()];
        let (mut worst, mut squares) = (0_f64, 0.0);
        for frame in 0..frames {
            let phase = Turns(frame.wrapping_mul(214_748_365 + 7_919));
            let amplitude = Factor::from_bits((((frame * 37) % 101) << 28).wrapping_div(100) as i32);
            let amplitude = amplitude.clamp(Factor::ZERO, Factor::ONE);
            let drive = Drive { amplitude, frequency: Factor::ONE, phase, onset: Factor::ONE };
            let paint = if frame == 0 { Paint::Everything } else { Paint::Motion };
            shimmer.render(drive, paint, &mut FrameMut::new(&mut pixels, layout).unwrap());
            let shown = FrameRef::new(&pixels, layout).unwrap();
            for i in 0..size.pixels() {
                let (x, y) = (i as u32 % size.width, i as u32 / size.width);
                let want = twin.pixel(i, amplitude.to_num(), radians(phase));
                for (got, want) in shown.rgb(x, y).into_iter().zip(want) {
                    let error = f64::from(got) - want;
                    worst = worst.max(error.abs());
                    squares += error * error;
                }
            }
        }
        [worst, (squares / f64::from(frames) / (size.pixels() * 3) as f64).sqrt()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn fixed_point_stays_within_two_levels_of_the_twin(
            width in 1_u32..34, height in 1_u32..18, padding in 0_usize..9, seed: u64, settings in settings()
        ) {
            let size = Size::new(width, height);
            let rgb = picture(size, seed);
            let mask: Vec<u8> = (0..size.pixels()).map(|i| (seed >> (i % 56)) as u8).collect();
            let [worst, _] = difference(size, &rgb, &mask, &settings, 8, padding);
            prop_assert!(worst <= 2.0, "worst {}", worst);
        }
    }

    #[test]
    fn a_thousand_frames_stay_within_half_a_level_rms_of_the_twin() {
        let size = Size::new(96, 64);
        for range in [Range::Full, Range::Neighbourhood, Range::Travelling] {
            let rgb = picture(size, 3);
            let settings = Settings { range, ..Settings::default() };
            let [worst, rms] = difference(size, &rgb, &vec![255; size.pixels()], &settings, 1_000, 0);
            eprintln!("{range}: worst {worst:.3}, rms {rms:.3} levels");
            assert!(worst <= 2.0 && rms <= 0.5, "{range}: worst {worst}, rms {rms}");
        }
    }

    /// A real square plane times `transfer(u, v)` (purely imaginary and odd, here its imaginary part) in the frequency domain, by the
    /// definition of the Fourier transform, direction by direction.
    fn filtered(plane: &Plane, transfer: impl Fn(f64, f64) -> f64) -> Plane {
        let n = plane.width;
        let angle = |k: usize| core::f64::consts::TAU * (k % n) as f64 / n as f64;
        // Rows, then columns; `sign` −1 forwards, +1 backwards.
        let along_rows = |re: &[f64], im: &[f64], sign: f64| -> [Vec<f64>; 2] {
            let sum = |i: usize, part: fn(f64, f64, f64, f64) -> f64| {
                let (y, k) = (i / n, i % n);
                (0..n)
                    .map(|x| {
                        part(re[y * n + x], im[y * n + x], angle(k * x).cos(), sign * angle(k * x).sin())
                    })
                    .sum()
            };
            let real = |re: f64, im: f64, cos: f64, sin: f64| re * cos - im * sin;
            let imaginary = |re: f64, im: f64, cos: f64, sin: f64| re * sin + im * cos;
            [(0..n * n).map(|i| sum(i, real)).collect(), (0..n * n).map(|i| sum(i, imaginary)).collect()]
        };
        let turned = |v: &[f64]| -> Vec<f64> { (0..n * n).map(|i| v[i % n * n + i / n]).collect() };
        let both = |re: &[f64], im: &[f64], sign: f64| {
            let [re, im] = along_rows(re, im, sign);
            let [re, im] = along_rows(&turned(&re), &turned(&im), sign);
            [turned(&re), turned(&im)]
        };
        let [mut re, mut im] = both(&plane.values, &vec![0.0; n * n], -1.0);
        let frequency = |k: usize| if k <= n / 2 { k as f64 } else { k as f64 - n as f64 };
        for i in 0..n * n {
            let factor = transfer(frequency(i % n), frequency(i / n));
            (re[i], im[i]) = (-im[i] * factor, re[i] * factor);
        }
        let [re, _] = both(&re, &im, 1.0);
        Plane { width: n, values: re.iter().map(|v| v / (n * n) as f64).collect() }
    }

    #[test]
    fn the_bands_derivative_is_close_to_the_riesz_transform() {
        let n = 64;
        // A texture that repeats, with all wavelengths: blurred noise plus noise.
        let rgb = picture(Size::new(n as u32, n as u32), 4);
        let noise = Plane::from(n, n, |x, y| f64::from(rgb[(y * n + x) * 3]));
        let tiled = Plane::from(3 * n, 3 * n, |x, y| noise.at((x % n) as isize, (y % n) as isize));
        let smooth = tiled.blurred(3);
        let texture = tiled.map(|x, y| tiled.at(x, y) / 4.0 + smooth.at(x, y));
        let wind = Turns::from_degrees(90);
        let [riesz, band] = local_phase(&texture, 1.0, wind);
        let centre = |plane: &Plane| Plane::from(n, n, |x, y| plane.at((x + n) as isize, (y + n) as isize));
        let (got, band) = (centre(&riesz), centre(&band));
        // R_w: −i·(w·k)/|k|.
        let exact = filtered(&band, |u, v| if u == 0.0 && v == 0.0 { 0.0 } else { -u / u.hypot(v) });
        let dot = |a: &Plane, b: &Plane| a.values.iter().zip(&b.values).map(|(a, b)| a * b).sum::<f64>();
        let correlation = dot(&got, &exact) / (dot(&got, &got) * dot(&exact, &exact)).sqrt();
        let amplitude = (dot(&got, &got) / dot(&exact, &exact)).sqrt();
        eprintln!("correlation {correlation:.4}, amplitude {amplitude:.3}");
        assert!(correlation > 0.96 && (0.9..1.1).contains(&amplitude), "{correlation} {amplitude}");
    }
}
