//! How long a choice takes among patches that are made up: `cargo run --release -p yurameki-fluid --example label_timing [PATCHES]`.
//!
//! Words are spread unevenly, as in nature; the picture is that of 640 × 360 pixels, 364 patches, each like one of the database with a
//! third of its words changed. Motions differ from video to video, and less within one.

use yurameki_fluid::{
    features::{Features, WORDS},
    label::{Grid, Look, Options, Target, Wanted, label},
    patch::{PatchRef, Version},
};

/// A stream of numbers in 0..1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u32 << 24) as f32
    }

    fn word(&mut self) -> u8 {
        (self.next() * self.next() * WORDS as f32) as u8
    }
}

fn database(count: usize) -> Vec<Features> {
    let mut numbers = Numbers(1);
    let versions: Vec<_> = Version::all().collect();
    let mut video = [0.0; 12];
    (0..count)
        .map(|number| {
            if number % 280 == 0 {
                video = core::array::from_fn(|channel| {
                    numbers.next() * if channel < 2 { 4.0 } else { 2.0 } - 1.0
                });
            }
            let within = number % 280;
            Features {
                patch: PatchRef {
                    video: (number / 5040) as u32,
                    version: versions[number / 280 % 18],
                    x: (within % 20 * 24) as i16,
                    y: (within / 20 * 24) as i16,
                },
                words: core::array::from_fn(|_| core::array::from_fn(|_| numbers.word())),
                contrast: 5.0 + numbers.next() * 40.0,
                motion: core::array::from_fn(|_| {
                    core::array::from_fn(|channel| {
                        let value = video[channel] + numbers.next();
                        if channel < 2 { value } else { value.abs() }
                    })
                }),
            }
        })
        .collect()
}

fn main() {
    let count = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(100_000);
    let features = database(count);
    let mut numbers = Numbers(99);
    let grid = Grid::of(640, 360);
    let looks = (0..grid.columns * grid.rows).map(|_| {
        let like = &features[(numbers.next() * count as f32) as usize];
        let mut words = like.words[0];
        for word in &mut words {
            if numbers.next() < 0.33 {
                *word = numbers.word();
            }
        }
        Some(Look { words, contrast: like.contrast, blown: false, wanted: Wanted::default() })
    });
    let target = Target { grid, looks: looks.collect() };
    println!("{count} patches in the database");
    for options in [Options::default(), Options { compare: true, ..Options::default() }] {
        match label(&target, &features, &options) {
            Ok(labelled) => println!("{labelled}"),
            Err(error) => eprintln!("{error}"),
        }
    }
}
