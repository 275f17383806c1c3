//! Leaves in the air.
//!
//! They loosen from twigs whose time has come, more of them in gusts, drift with the wind and turn over while they sink. What lies
//! on the ground afterwards follows the season, not them: in a season of months they would fall one in ten minutes.

use super::{
    canvas::{Lens, Pose},
    mount::Mount,
};
use crate::{
    frame::Size,
    math::{Factor, Turns, random::scatter},
    noise::drive::Drive,
};

/// The most leaves in the air.
pub(super) const MOST: usize = 48;

/// A leaf in the air.
#[derive(Clone, Copy, Debug, Default)]
struct Leaf {
    twig: u16,
    /// In steps of 1/256 pixel.
    x: i32,
    y: i32,
    /// Where it will lie.
    ground: i32,
    age: u16,
    key: u64,
}

/// All leaves in the air.
#[derive(Clone, Debug)]
pub(super) struct Airborne {
    leaves: [Option<Leaf>; MOST],
    /// Frames so far.
    frame: u64,
    /// Frames that a leaf takes from the top of the picture to its bottom.
    fall_frames: u32,
    seed: u64,
}

/// A leaf in the air as it is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sprite {
    pub(super) twig: u16,
    pub(super) lens: Lens,
    /// Of the panel.
    pub(super) columns: (i32, i32),
    pub(super) rows: (i32, i32),
    /// How bright it is, 128 being usual.
    pub(super) gain: u8,
}

impl Airborne {
    pub(super) fn new(fall_frames: u32, seed: u64) -> Self {
        Self { leaves: [None; MOST], frame: 0, fall_frames: fall_frames.max(1), seed }
    }

    /// One frame later. `loosen` gives a twig whose leaves fall now, and where it is in pixels.
    pub(super) fn step(&mut self, size: Size, drive: Drive, loosen: impl Fn(u64) -> Option<(u16, [i16; 2])>) {
        self.frame += 1;
        let sink = ((size.height as i32) << 8) / self.fall_frames as i32;
        let wind = ((drive.amplitude.to_bits() >> 18) * sink) >> 10; // as fast as it sinks in the strongest wind
        for slot in &mut self.leaves {
            let Some(leaf) = slot else { continue };
            leaf.age = leaf.age.saturating_add(1);
            let flutter =
                Turns((leaf.key as u32).wrapping_add(u32::from(leaf.age).wrapping_mul(150_000_000)));
            let swing = flutter.sin().to_bits() >> 18;
            leaf.x += wind + ((swing * sink) >> 10);
            // A leaf on its edge sinks faster.
            leaf.y += sink - ((sink * swing.abs()) >> 11);
            if leaf.y > leaf.ground || leaf.x >> 8 > size.width as i32 {
                *slot = None;
            }
        }
        // In the strongest wind a leaf in three frames, else by the square of the wind; one in a while when it is still.
        let chance = scatter(self.seed ^ self.frame ^ 0xa1b0_0000_0000_0000);
        let gust = i64::from((drive.amplitude * drive.amplitude).to_bits() >> 12);
        let loosens = ((chance & 0xffff) as i64) < gust / 3 + 600;
        let free = self.leaves.iter_mut().find(|slot| slot.is_none());
        if let (true, Some(slot), Some((twig, [x, y]))) = (loosens, free, loosen(chance >> 16)) {
            let deep = size.height as i32 * 10 / 256;
            let ground = size.height as i32 * 222 / 256 + (chance >> 40) as i32 % (2 * deep.max(1));
            *slot = Some(Leaf {
                twig,
                x: i32::from(x) << 8,
                y: i32::from(y) << 8,
                ground: ground << 8,
                age: 0,
                key: scatter(chance),
            });
        }
    }

    /// What is seen of the leaves.
    pub(super) fn sprites(&self, mount: Mount) -> heapless::Vec<Sprite, MOST> {
        self.leaves.iter().flatten().map(|leaf| leaf.sprite(mount)).collect()
    }
}

impl Leaf {
    fn sprite(&self, mount: Mount) -> Sprite {
        let size = mount.upright();
        let age = u32::from(self.age);
        let spin =
            |rate: u32, bits: u64| Turns((self.key >> bits) as u32).plus(Turns(age.wrapping_mul(rate)));
        let over = spin(170_000_000, 16).sin();
        let lens = Lens::new(Pose {
            x: self.x,
            y: self.y,
            half: ((size.height as i32) << 8) / 110,
            turn: spin(60_000_000, 0),
            fold: spin(20_000_000, 8),
            width: (over.abs().to_bits() >> (Factor::FRAC_NBITS - 8)).max(40),
        });
        let [columns, rows] = mount.part(lens.extent(size));
        let gain = (128 + (over.to_bits() >> (Factor::FRAC_NBITS - 5))) as u8;
        Sprite {
            twig: self.twig,
            lens,
            columns: (columns.start, columns.end),
            rows: (rows.start, rows.end),
            gain,
        }
    }
}
