//! The noises and the drive.

use crate::{logbook, spectrum::Estimator};
use std::collections::HashSet;
use yurameki::{
    math::{
        Factor, Sample, Turns,
        random::{Rng, Stream, stream},
    },
    noise::{
        Generator, Kind,
        brown::Brown,
        drive::{Drive, Oscillator, PhaseForm, Settings},
    },
};

/// The slopes of 20 seeds of a noise, each made by `start`, hold `beta`: their mean within `mean`, each within `each`.
fn holds_slope<F: FnMut() -> Sample>(name: &str, beta: f64, mean: f64, each: f64, start: impl Fn(Rng) -> F) {
    let slopes: Vec<f64> = (0..20)
        .map(|seed| {
            let mut step = start(stream(seed, Stream::Amplitude));
            Estimator::BAND_A.slope(|| step().to_num())
        })
        .collect();
    let (low, high) = slopes.iter().fold((f64::MAX, f64::MIN), |(low, high), s| (low.min(*s), high.max(*s)));
    let average = slopes.iter().sum::<f64>() / slopes.len() as f64;
    println!("{name}: slope {average:.4}, {low:.4} to {high:.4}");
    assert!((average - beta).abs() <= mean, "{name}: mean slope {average}");
    assert!(beta - each <= low && high <= beta + each, "{name}: slopes from {low} to {high}");
}

fn of_kind(kind: Kind) -> impl Fn(Rng) -> Box<dyn FnMut() -> Sample> {
    move |rng| {
        let mut generator = Generator::new(kind, rng);
        Box::new(move || generator.step())
    }
}

#[test]
fn white_noise_is_flat() {
    holds_slope("white", 0., 0.01, 0.03, of_kind(Kind::White));
}

#[test]
fn filtered_noise_has_slope_one() {
    holds_slope("filter", 1., 0.01, 0.03, of_kind(Kind::Filter));
}

#[test]
fn intermittent_chaos_has_slope_one() {
    holds_slope("chaos", 1., 0.02, 0.05, of_kind(Kind::Chaos));
}

#[test]
fn hosodas_ladder_has_the_slope_that_is_claimed() {
    holds_slope("hosoda", 0.956, 0.01, 0.03, of_kind(Kind::Hosoda));
}

#[test]
fn brown_noise_has_slope_two_above_its_leak() {
    holds_slope("brown", 2., 0.01, 0.03, |mut rng| {
        let mut brown = Brown::<15>::new(&mut rng);
        move || brown.step(&mut rng)
    });
}

#[test]
fn the_literal_brown_sum_has_slope_two() {
    holds_slope("brown-literal", 2., 0.01, 0.03, of_kind(Kind::BrownLiteral));
}

#[test]
fn filtered_noise_keeps_its_slope_over_four_decades() {
    let mut generator = Generator::new(Kind::Filter, stream(1, Stream::Amplitude));
    let estimator = Estimator { frames: 1 << 23, segment: 1 << 19, band: (1e-5, 1e-1) };
    let slope = estimator.slope(|| generator.step().to_num());
    println!("filter over four decades: slope {slope:.4}");
    assert!((slope - 1.).abs() <= 0.015, "{slope}");
}

/// A hash of the samples' bits: each is mixed in by a multiplication, and a shift that brings the upper bits back down.
fn hash(samples: impl Iterator<Item = Sample>) -> u64 {
    samples.fold(0, |hash, sample| {
        let product = (hash ^ sample.to_bits() as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        product ^ product >> 32
    })
}

/// No block of 256 frames of `kind` comes again among 2^26 frames. Constant noise repeats by nature, and so does literal chaos
/// once it is dead.
fn never_repeats(kind: Kind) {
    let mut generator = Generator::new(kind, stream(2, Stream::Amplitude));
    let mut blocks = HashSet::new();
    for block in 0..1 << 18 {
        let hash = hash((0..256).map(|_| generator.step()));
        assert!(blocks.insert(hash), "{kind}: block {block} was there before");
    }
}

#[test]
fn white_noise_never_repeats() {
    never_repeats(Kind::White);
}

#[test]
fn intermittent_chaos_never_repeats() {
    never_repeats(Kind::Chaos);
}

#[test]
fn filtered_noise_never_repeats() {
    never_repeats(Kind::Filter);
}

#[test]
fn hosodas_ladder_never_repeats() {
    never_repeats(Kind::Hosoda);
}

#[test]
fn brown_noise_never_repeats() {
    never_repeats(Kind::Brown);
}

#[test]
fn streams_are_the_same_on_every_machine() {
    let mut wrong = Vec::new();
    for (kind, stored) in STREAMS {
        let hashes: [u64; 4] = std::array::from_fn(|seed| {
            let mut generator = Generator::new(kind, stream(seed as u64, Stream::Amplitude));
            hash((0..1 << 22).map(|_| generator.step()))
        });
        if hashes != stored {
            wrong.push(format!("(Kind::{kind:?}, {hashes:#018x?}),"));
        }
    }
    assert!(wrong.is_empty(), "streams that differ from the stored ones:\n{}", wrong.join("\n"));
}

/// [`hash`] of 2^22 samples of the seeds 0 to 3, as x86-64 makes them.
const STREAMS: [(Kind, [u64; 4]); 8] = [
    (
        Kind::Constant,
        [0xb0cf_4a1a_0a70_55f3, 0xb0cf_4a1a_0a70_55f3, 0xb0cf_4a1a_0a70_55f3, 0xb0cf_4a1a_0a70_55f3],
    ),
    (
        Kind::White,
        [0xba20_cd10_1430_24c0, 0x216e_dca3_52de_25bb, 0xe150_7269_c327_b2c4, 0xc944_6208_51b5_61c1],
    ),
    (
        Kind::Chaos,
        [0x7674_362f_6d42_29d1, 0x78d5_fe85_66d3_12fc, 0x346b_36d7_32c1_bc3d, 0x0719_da45_0cc6_4a41],
    ),
    (
        Kind::ChaosLiteral,
        [0xe246_614d_5dbb_9dfb, 0x68ae_7467_4db2_59d4, 0x98a5_6b02_c99b_cd2a, 0xf3be_0df3_cf3e_9d68],
    ),
    (
        Kind::Filter,
        [0xea2a_b474_90bb_d064, 0x25a9_0d5f_a9fd_0274, 0x8854_a072_5cf7_09d9, 0x2614_a335_b0e4_885f],
    ),
    (
        Kind::Hosoda,
        [0xf982_3cfa_6ed9_bc12, 0xf0e3_9cf1_bb6a_0308, 0xef63_9742_aa0f_3291, 0xfa50_f74b_f5b9_23a7],
    ),
    (
        Kind::Brown,
        [0x0216_1e86_9ee7_4dd2, 0xad22_0673_3c04_4734, 0x792e_07b2_140a_fbae, 0xfeed_7812_063e_9e5d],
    ),
    (
        Kind::BrownLiteral,
        [0xc984_c6c9_3dd3_0ddf, 0x65ea_29c4_4269_d6fc, 0x4d7e_3078_25ba_d72b, 0xe5c0_dec3_2b82_a1e7],
    ),
];

#[test]
fn chaos_stays_alive() {
    let (mut below, mut longest) = (0, 0);
    for seed in 0..4 {
        let mut generator = Generator::new(Kind::Chaos, stream(seed, Stream::Frequency));
        for _ in 0..1 << 23 {
            // The samples are the roots of the chaotic value: it is below 1/2 where its root is below √(1/2).
            below = if generator.step() < Sample::FRAC_1_SQRT_2 { below + 1 } else { 0 };
            longest = longest.max(below);
        }
    }
    println!("chaos: at most {longest} frames in a row below 1/2");
    assert!((4096..=8192).contains(&longest), "{longest} frames in a row below 1/2");
}

fn settings(amplitude: Kind, frequency: Kind) -> Settings {
    Settings { amplitude, frequency, ..Settings::default() }
}

#[test]
fn few_frames_are_clamped() {
    for kind in Kind::CHOICES {
        let seeds = 16;
        let frames = 1 << 20;
        let (mut amplitude, mut frequency) = (0, 0);
        for seed in 0..seeds {
            let mut oscillator = Oscillator::new(settings(kind, kind), seed);
            for _ in 0..frames {
                let drive = oscillator.step();
                amplitude += u64::from([Factor::ZERO, Factor::ONE].contains(&drive.amplitude));
                frequency += u64::from([Factor::ZERO, Factor::ONE * 2].contains(&drive.frequency));
            }
        }
        let share = |clamped: u64| clamped as f64 / (frames * seeds) as f64;
        println!(
            "{kind}: X_A {:.3} %, X_f {:.3} % clamped",
            share(amplitude) * 100.,
            share(frequency) * 100.
        );
        match kind {
            Kind::Constant => assert_eq!((amplitude, frequency), (frames * seeds, 0)),
            Kind::Chaos => assert_eq!((amplitude, frequency), (0, 0)),
            _ => {
                assert!(share(amplitude) <= 0.003 && share(frequency) <= 0.003, "{kind} is clamped too often")
            }
        }
    }
}

#[test]
fn amplitude_and_frequency_stay_in_range_with_any_settings() {
    for (i, frequency) in Kind::ALL.into_iter().enumerate() {
        for (period_frames, response_frames, glide_frames) in
            [(0, 0, 0), (1, 1, 1), (u32::MAX, u32::MAX, u32::MAX)]
        {
            let amplitude = Kind::ALL[(i + 3) % 8];
            let phase = PhaseForm::Literal;
            let settings =
                Settings { amplitude, frequency, period_frames, response_frames, glide_frames, phase };
            let mut oscillator = Oscillator::new(settings, 1);
            for frame in 0..20_000 {
                if frame % 100 == 99 {
                    oscillator.set_amplitude(oscillator.amplitude().next());
                    oscillator.set_frequency(oscillator.frequency().next());
                }
                let drive = oscillator.step();
                assert!((Factor::ZERO..=Factor::ONE).contains(&drive.amplitude), "{settings:?}: {drive:?}");
                assert!(
                    (Factor::ZERO..=Factor::ONE * 2).contains(&drive.frequency),
                    "{settings:?}: {drive:?}"
                );
                assert_eq!(drive.onset, Factor::ONE);
            }
        }
    }
}

#[test]
fn without_noise_the_phase_returns_to_the_very_start_each_period() {
    let mut oscillator = Oscillator::new(settings(Kind::Constant, Kind::Constant), 1);
    for frame in 0..1_u64 << 22 {
        let drive = oscillator.step();
        // t/20 turns, rounded to 2^-32.
        let exact = Turns(((((frame % 20) << 32) + 10) / 20) as u32);
        assert_eq!(
            drive,
            Drive { amplitude: Factor::ONE, frequency: Factor::ONE, phase: exact, onset: Factor::ONE }
        );
    }
}

#[test]
fn the_phase_is_the_sum_of_the_frequencies_so_far() {
    for kind in [Kind::White, Kind::Chaos, Kind::Filter, Kind::Brown] {
        let mut oscillator = Oscillator::new(settings(Kind::Brown, kind), 1);
        let mut sum = 0_u128;
        for _ in 0..1 << 20 {
            let drive = oscillator.step();
            // The sum has the fractional bits of a factor; T is 20 frames.
            let exact = ((sum << (32 - Factor::FRAC_NBITS)) / 20) as u32;
            assert!(drive.phase.0.wrapping_sub(exact) <= 1, "{kind}: {:?} for {exact}", drive.phase);
            sum += drive.frequency.to_bits() as u128;
        }
    }
}

#[test]
fn the_literal_phase_is_eq_8_and_jumps_as_stated() {
    use std::f64::consts::TAU;
    for (kind, rms_radians) in [(Kind::White, 184.), (Kind::Filter, 62.), (Kind::Brown, 8.)] {
        let (frame, seeds) = (1200, 512);
        let squares = (0..seeds).map(|seed| {
            let literal = Settings { phase: PhaseForm::Literal, ..settings(Kind::Constant, kind) };
            let mut oscillator = Oscillator::new(literal, seed);
            let turns: Vec<f64> = (0..=frame)
                .map(|t| {
                    let drive = oscillator.step();
                    let cycles = drive.frequency.to_num::<f64>() * f64::from(t) / 20.;
                    let shown = f64::from(drive.phase.0) / 2_f64.powi(32);
                    let off = (cycles - shown).rem_euclid(1.);
                    assert!(off.min(1. - off) < 1e-9, "{kind}, frame {t}: {shown} turns for {cycles}");
                    cycles
                })
                .collect();
            ((turns[frame as usize] - turns[frame as usize - 1]) * TAU).powi(2)
        });
        let rms = (squares.sum::<f64>() / seeds as f64).sqrt();
        println!("{kind}: literal phase jumps by {rms:.1} rad rms at frame {frame}");
        assert!((rms / rms_radians - 1.).abs() < 0.15, "{kind}: {rms} rad");
    }
}

/// An oscillator and its twin that does not glide, both pressed alike: the twin shows what the first one glides to.
struct Pressed {
    gliding: Oscillator,
    jumping: Oscillator,
}

impl Pressed {
    fn new(amplitude: Kind, frequency: Kind) -> Self {
        let settings = settings(amplitude, frequency);
        let jumping = Oscillator::new(Settings { glide_frames: 0, ..settings }, 9);
        Self { gliding: Oscillator::new(settings, 9), jumping }
    }

    fn step(&mut self) -> (Drive, Drive) {
        (self.gliding.step(), self.jumping.step())
    }

    fn press(&mut self, amplitude: Kind, frequency: Kind) {
        for oscillator in [&mut self.gliding, &mut self.jumping] {
            oscillator.set_amplitude(amplitude);
            oscillator.set_frequency(frequency);
        }
    }

    /// Steps through `frames` frames of a glide that started at `from`, and tells where it got.
    fn glide(&mut self, from: Drive, frames: i32) -> Drive {
        (1..=frames).fold(from, |last, frame| {
            let (shown, target) = self.step();
            let x = f64::from(frame) / 6.;
            let share = x * x * (3. - 2. * x);
            let path = |from: Factor, to: Factor| {
                let (from, to) = (from.to_num::<f64>(), to.to_num::<f64>());
                from + (to - from) * share
            };
            let off = |shown: Factor, path: f64| (shown.to_num::<f64>() - path).abs();
            assert!(off(shown.amplitude, path(from.amplitude, target.amplitude)) < 1e-7, "frame {frame}");
            assert!(off(shown.frequency, path(from.frequency, target.frequency)) < 1e-7, "frame {frame}");
            // θ goes on at the speed that was shown.
            let turned = f64::from(shown.phase.0.wrapping_sub(last.phase.0)) / 2_f64.powi(32);
            assert!((turned - last.frequency.to_num::<f64>() / 20.).abs() < 1e-9, "frame {frame}");
            shown
        })
    }
}

#[test]
fn a_press_glides_from_the_old_noise_to_the_new_one() {
    for old in Kind::ALL {
        for new in Kind::ALL.into_iter().filter(|&new| new != old) {
            let mut pressed = Pressed::new(old, old);
            let before = (0..50).map(|_| pressed.step().0).last().unwrap();
            pressed.press(new, new);
            assert_eq!((pressed.gliding.amplitude(), pressed.gliding.frequency()), (new, new));
            pressed.glide(before, 6);
            for _ in 0..50 {
                let (shown, target) = pressed.step();
                assert_eq!((shown.amplitude, shown.frequency), (target.amplitude, target.frequency));
            }
        }
    }
}

#[test]
fn a_press_in_mid_glide_goes_on_from_where_the_glide_is() {
    let mut pressed = Pressed::new(Kind::Constant, Kind::Brown);
    let mut last = pressed.step().0;
    for kind in Kind::CHOICES.into_iter().cycle().skip(1).take(20) {
        pressed.press(kind, kind.next());
        last = pressed.glide(last, 3);
    }
    pressed.glide(last, 0);
}

#[test]
fn pressing_one_noise_leaves_the_other_alone() {
    let mut pressed = Oscillator::new(Settings::default(), 4);
    let mut untouched = pressed.clone();
    for frame in 0..1000 {
        if frame % 10 == 0 {
            pressed.set_amplitude(pressed.amplitude().next());
            pressed.set_frequency(Kind::Brown);
        }
        let (a, b) = (pressed.step(), untouched.step());
        assert_eq!((a.frequency, a.phase), (b.frequency, b.phase));
    }
}

#[test]
fn two_noises_of_one_kind_have_nothing_in_common_however_often_pressed() {
    let plain = Settings { response_frames: 0, glide_frames: 0, ..settings(Kind::White, Kind::White) };
    let mut oscillator = Oscillator::new(plain, 1);
    let mut seen = HashSet::new();
    let (mut product, mut count) = (0., 0.);
    for _ in 0..64 {
        for _ in 0..256 {
            let drive = oscillator.step();
            // Both are affine in the noise, with a sigma of 1/6 and of 1/3.
            let (a, f) = (drive.amplitude.to_num::<f64>(), drive.frequency.to_num::<f64>());
            product += (a - 0.5) * 6. * (f - 1.) * 3.;
            count += 1.;
            // A replay would show the same pair of numbers again.
            seen.insert((drive.amplitude, drive.frequency));
        }
        for kind in [Kind::Constant, Kind::White] {
            oscillator.set_amplitude(kind);
            oscillator.set_frequency(kind);
        }
    }
    let correlation: f64 = product / count;
    assert!(correlation.abs() < 4. / count.sqrt(), "correlation {correlation}");
    assert!(seen.len() as f64 > count - 4., "{} different frames of {count}", seen.len());
}

#[test]
fn literal_chaos_dies_and_says_so_once() {
    let _ = logbook::lines();
    let mut oscillator = Oscillator::new(settings(Kind::ChaosLiteral, Kind::Constant), 1);
    let dead = (0..200_000).map(|_| oscillator.step().amplitude).last();
    assert_eq!(dead, Some(Factor::ZERO));
    let lines = logbook::lines();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("literal intermittent chaos has died"), "{lines:?}");
}

#[test]
fn an_oscillator_is_small() {
    let bytes = size_of::<Oscillator>();
    println!("an oscillator takes {bytes} bytes");
    assert!(bytes <= 4608, "{bytes} bytes");
}

#[test]
fn drives_are_the_same_on_every_machine() {
    let mut wrong = Vec::new();
    for (amplitude, frequency, stored) in DRIVES {
        for (phase, stored) in [PhaseForm::Integrated, PhaseForm::Literal].into_iter().zip(stored) {
            let mut oscillator = Oscillator::new(Settings { phase, ..settings(amplitude, frequency) }, 0);
            let fields = (0..1 << 18).flat_map(|_| {
                let drive = oscillator.step();
                [drive.amplitude.to_bits().into(), drive.frequency.to_bits().into(), drive.phase.0.into()]
            });
            let hash = hash(fields.map(Sample::from_bits));
            if hash != stored {
                wrong.push(format!("{amplitude}, {frequency}, {phase:?}: {hash:#018x}"));
            }
        }
    }
    assert!(wrong.is_empty(), "drives that differ from the stored ones:\n{}", wrong.join("\n"));
}

/// [`hash`] of 2^18 drives of seed 0 with integrated and with literal phase, as x86-64 makes them.
const DRIVES: [(Kind, Kind, [u64; 2]); 4] = [
    (Kind::Brown, Kind::Brown, [0x2eef_53e7_50e7_bbdc, 0x1ade_7885_48e1_a126]),
    (Kind::Filter, Kind::Chaos, [0x6636_92ed_7f85_e884, 0x22f5_fb61_dd15_4625]),
    (Kind::White, Kind::Hosoda, [0x01d4_9f1d_87c1_f3b7, 0x9159_4761_6a4e_70b8]),
    (Kind::Chaos, Kind::White, [0x161b_842e_eee4_36d0, 0xc8df_6175_1213_057e]),
];
