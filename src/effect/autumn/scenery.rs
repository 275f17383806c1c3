//! What is behind the tree: sky, hills, a wood, water, and the ground that it stands on. Not in the paper.

mod ground;
mod scene;
mod wood;

pub(super) use scene::Scene;

use super::{mount::Mount, noise::fbm};
use crate::{frame::Size, math::random::scatter};
use ground::Shadow;
use scene::Hill;

/// The picture behind the tree while it is painted. Colours are in steps of 1/256 level.
struct Backdrop<'a> {
    /// Red, green and blue.
    planes: [&'a mut [u8]; 3],
    mount: Mount,
    scene: &'static Scene,
    width: i32,
    height: i32,
    seed: u64,
}

impl Backdrop<'_> {
    fn set(&mut self, x: i32, y: i32, colour: [i32; 3]) {
        // Half a level of noise, so that the sky has no bands.
        let grain = (scatter((y as u64) << 32 | x as u64) >> 56) as i32;
        let at = self.mount.index(x, y);
        for (plane, level) in self.planes.iter_mut().zip(colour) {
            plane[at] = ((level + grain) >> 8).clamp(0, 255) as u8;
        }
    }

    /// Covers `share` of 256 of a pixel.
    fn mix(&mut self, x: i32, y: i32, colour: [i32; 3], share: i32) {
        let at = self.mount.index(x, y);
        for (plane, level) in self.planes.iter_mut().zip(colour) {
            let behind = i32::from(plane[at]) << 8;
            let level = behind + (((level - behind) * share) >> 8);
            plane[at] = ((level + 128) >> 8).clamp(0, 255) as u8;
        }
    }

    fn get(&self, x: i32, y: i32) -> [i32; 3] {
        let at = self.mount.index(x, y);
        self.planes.each_ref().map(|plane| i32::from(plane[at]) << 8)
    }
}

/// Paints the background for a tree of this `root` and `spread`, in steps of 1/256 pixel.
pub(super) fn paint(
    planes: [&mut [u8]; 3],
    mount: Mount,
    scene: &'static Scene,
    root: [i32; 2],
    spread: i32,
    seed: u64,
) {
    let Size { width, height } = mount.upright();
    let (width, height) = (width as i32, height as i32);
    let mut backdrop = Backdrop { planes, mount, scene, width, height, seed };
    for y in 0..height * scene.horizon / 256 + 1 {
        for x in 0..width {
            backdrop.set(x, y, above(&backdrop, x, y));
        }
    }
    if let Some(wood) = &scene.wood {
        wood::paint(&mut backdrop, wood);
    }
    paint_water(&mut backdrop);
    ground::paint(&mut backdrop, Shadow { root, spread });
}

/// `from` to `to` by `share` of 256, in steps of 1/256 level.
fn blend(from: [i32; 3], to: [i32; 3], share: i32) -> [i32; 3] {
    core::array::from_fn(|i| from[i] * 256 + (to[i] - from[i]) * share)
}

/// [`blend`] of colours that are in steps of 1/256 level.
fn mixed(from: [i32; 3], to: [i32; 3], share: i32) -> [i32; 3] {
    core::array::from_fn(|i| from[i] + (((to[i] - from[i]) * share) >> 8))
}

/// A place of the picture for noise whose lattice points are `cells` to a picture's height.
fn scaled(at: i32, cells: i32, height: i32) -> i32 {
    (i64::from(at) * i64::from(cells) * (1 << 16) / i64::from(height)) as i32
}

fn above(backdrop: &Backdrop<'_>, x: i32, y: i32) -> [i32; 3] {
    let &Backdrop { scene, height, seed, .. } = backdrop;
    let horizon = height * scene.horizon / 256;
    // Nothing reaches higher than half of the sky.
    let hills = scene.hills.iter().enumerate().rev().filter(|_| y > horizon / 3);
    for (number, hill) in hills {
        let line = ridge(hill, x, horizon, height, seed ^ (number as u64 + 77));
        if y > line {
            return slope(backdrop, hill, [x, y], line);
        }
    }
    sky(backdrop, x, y, horizon)
}

/// Where a line of hills ends against the sky.
fn ridge(hill: &Hill, x: i32, horizon: i32, height: i32, seed: u64) -> i32 {
    let rise = height * hill.rise / 256;
    if hill.peaks {
        let noise = fbm(scaled(x, hill.rough, height) / 4, 0, 6, seed);
        // Sharp where the noise crosses zero.
        return horizon - rise
            + ((i64::from((noise.abs() * 2).min(1 << 15)) * i64::from(rise) * 3 / 4) >> 15) as i32;
    }
    let line = fbm(scaled(x, hill.rough / 4 + 1, height), 0, 3, seed);
    // The tops of trees.
    let trees = fbm(scaled(x, hill.rough * 12, height), 0, 3, seed ^ 99);
    let trees = (i64::from(trees) * i64::from(height * hill.rough / 1_400)) >> 15;
    horizon - rise - ((i64::from(line) * i64::from(rise)) >> 16) as i32 - trees as i32
}

/// The side of a hill, `line` being its top in this column.
fn slope(backdrop: &Backdrop<'_>, hill: &Hill, [x, y]: [i32; 2], line: i32) -> [i32; 3] {
    let &Backdrop { scene, height, seed, .. } = backdrop;
    let rise = (height * hill.rise / 256).max(1);
    let below = y - line;
    let mut colour = hill.colour;
    if hill.peaks {
        let rock = fbm(scaled(x + below / 2, 24, height), scaled(y, 12, height), 4, seed ^ 31);
        // Snow down to a third of the mountain, farther in gullies; what faces the light is warm.
        let foot = height * scene.horizon / 256 - rise * 5 / 8;
        if y < foot + ((rock * (rise / 4)) >> 14) {
            colour = if rock > -3_000 { [238, 226, 226] } else { [176, 182, 206] };
        }
        colour = colour.map(|level| level * (256 + rock / 420) / 256);
    }
    // Mist lies in the valleys.
    let mist = (below * 256 / rise).min(if hill.peaks { 190 } else { 165 });
    blend(colour, scene.mist, mist)
}

fn sky(backdrop: &Backdrop<'_>, x: i32, y: i32, horizon: i32) -> [i32; 3] {
    let &Backdrop { scene, width, height, seed, .. } = backdrop;
    let at = y * 256 / horizon.max(1);
    let after = scene.sky.iter().position(|&(place, _)| place > at).unwrap_or(scene.sky.len() - 1).max(1);
    let ((low, from), (high, to)) = (scene.sky[after - 1], scene.sky[after]);
    let sky = blend(from, to, (at - low) * 256 / (high - low));
    let (light, most) = scene.glow;
    // Around a sun that is just out of sight, wider than high.
    let (dx, dy) =
        (i64::from(x - width / 6) * 256 / i64::from(width), i64::from(y - horizon) * 330 / i64::from(height));
    let near = (200 - (dx * dx + dy * dy).isqrt()).max(0) as i32;
    let sky = mixed(sky, light.map(|level| level * 256), near * near / 200 * most / 256);
    // Thin clouds, wide and flat, lit from below by a low sun.
    let cloud = fbm(scaled(x, 2, height), scaled(y, 7, height), 5, seed ^ 5);
    let share = (((cloud - 2_000).max(0) >> 6).min(scene.clouds) * (280 - at / 2)) >> 8;
    let lit = blend([244, 244, 244], light, at.min(256));
    mixed(sky, lit, share.min(256))
}

/// Water between the horizon and the shore: all that is above it, upside down, torn by ripples.
fn paint_water(backdrop: &mut Backdrop<'_>) {
    let (width, height) = (backdrop.width, backdrop.height);
    let (top, shore) = (height * backdrop.scene.horizon / 256, height * backdrop.scene.shore / 256);
    let deep = (shore - top).max(1);
    for y in top..shore {
        let down = y - top;
        for x in 0..width {
            let ripple = fbm(
                scaled(x, 10, height),
                scaled(y, 260, height) / (1 + down * 2 / deep),
                3,
                backdrop.seed ^ 41,
            );
            // Seen aslant, more of the sky is in it the nearer it is.
            let up = 1 + down * 2 + down * down / deep + ((ripple * (2 + down / 2)) >> 14);
            let from = (top - up).clamp(0, top - 1);
            let mirrored = backdrop.get(x, from);
            let light = 232 + ((ripple * 26) >> 15);
            let water = mixed(mirrored, [104 << 8, 124 << 8, 144 << 8], 50).map(|level| (level * light) >> 8);
            backdrop.set(x, y, water);
        }
    }
}
