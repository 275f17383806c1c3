//! The wood at the horizon: a few rows of crowns, the farther ones in the mist.

use super::{Backdrop, blend, scaled, scene::Wood};
use crate::{effect::autumn::noise::fbm, math::random::scatter};

/// Rows of trees.
const ROWS: i32 = 3;

/// How much mist is before the rows, of 256, the farthest first.
const MIST: [i32; ROWS as usize] = [150, 95, 45];

/// A tree that is far away.
struct Crown {
    /// Its middle, and where it stands.
    x: i32,
    foot: i32,
    high: i32,
    half: i32,
    colour: [i32; 3],
    mist: i32,
}

pub(super) fn paint(backdrop: &mut Backdrop<'_>, wood: &Wood) {
    let (width, height) = (backdrop.width, backdrop.height);
    let foot = height * backdrop.scene.horizon / 256 + 1;
    let usual = (height * wood.rise / 256).max(4);
    let pitch = if wood.conifers { usual * 2 / 5 } else { usual * 3 / 5 }.max(2);
    for row in 0..ROWS {
        for at in -1..=width / pitch + 1 {
            let key = scatter(backdrop.seed ^ 0x30_0d00 ^ (row as u64) << 32 ^ at as u64);
            let byte = |shift: u32| (key >> shift & 0xff) as i32;
            // The edge of the wood goes up and down along the horizon, and is open in places.
            let grove = fbm(scaled(at * pitch, 3, height), row << 16, 3, backdrop.seed ^ 0x6701) + (12 << 10);
            let high =
                usual * (190 + byte(0) * 3 / 4 - row * 45) / 256 * (256 + grove / 96).clamp(90, 330) / 256;
            let half = high * (if wood.conifers { 56 } else { 110 } + byte(8) / 8) / 256;
            let colour = wood.crowns[(key >> 16 & 3) as usize];
            let light = 232 + byte(24) / 5;
            paint_crown(
                backdrop,
                wood.conifers,
                &Crown {
                    x: at * pitch + byte(32) * pitch / 256,
                    foot,
                    high,
                    half: half.max(1),
                    colour: colour.map(|level| level * light / 256),
                    mist: MIST[row as usize],
                },
            );
        }
    }
}

fn paint_crown(backdrop: &mut Backdrop<'_>, conifer: bool, crown: &Crown) {
    let (height, seed) = (backdrop.height, backdrop.seed);
    let leaves = |x: i32, y: i32, cells: i32| {
        fbm(scaled(x, cells, height), scaled(y, cells, height), 2, seed ^ 0x1eaf)
    };
    let mist = backdrop.scene.mist;
    for y in (crown.foot - crown.high * 9 / 8).max(0)..crown.foot {
        let down = (y - (crown.foot - crown.high)) * 256 / crown.high.max(1);
        for x in (crown.x - crown.half * 5 / 4).max(0)..(crown.x + crown.half * 5 / 4).min(backdrop.width) {
            let aside = (x - crown.x) * 256 / crown.half;
            let rough = leaves(x, y, 170);
            // How deep within the crown this is, of 256.
            let inside = if conifer {
                // Storeys of boughs, each wider below.
                let storey = ((down * 7) & 0xff) / 4;
                down * 3 / 4 + storey - 20 - aside.abs() + rough / 320
            } else {
                // Broad below, round above, and full of bumps.
                let low = (down - 130) * if down < 130 { 2 } else { 1 };
                ((1 << 16) - aside * aside - low * low) / 256 + rough / 200 + leaves(x, y, 50) / 220
            };
            if inside <= 0 {
                continue;
            }
            // Lit from the upper left.
            let light = 226 - aside / 5 - (down - 110) / 3 + leaves(x, y, 320) / 330;
            let colour = crown.colour.map(|level| level * light / 256);
            let misty = blend(colour, mist, (crown.mist + down / 4).min(230));
            backdrop.mix(x, y, misty, (inside * 12).min(256));
        }
    }
}
