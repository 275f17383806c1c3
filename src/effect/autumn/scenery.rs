//! What is behind the tree: an autumn sky, misty hills, a meadow.

use super::{mount::Mount, noise::fbm};
use crate::{frame::Size, math::random::scatter};

/// Colours down the sky, from the zenith to the horizon, sRGB, and where each is, of 256.
const SKY: [(i32, [i32; 3]); 4] =
    [(0, [112, 148, 186]), (110, [168, 188, 204]), (190, [226, 214, 196]), (256, [246, 222, 184])];

/// Hills, the farthest first: how high they rise, of 256 of the picture, and their colour.
const HILLS: [(i32, i32, [i32; 3]); 3] =
    [(34, 5, [196, 196, 190]), (22, 8, [168, 172, 160]), (11, 14, [132, 138, 116])];

/// The meadow at the horizon and at the viewer's feet.
const MEADOW: [[i32; 3]; 2] = [[146, 148, 100], [72, 84, 40]];

/// Where the horizon is, of 256.
pub(super) const HORIZON: i32 = 212;

/// Paints the background.
pub(super) fn paint(background: &mut [[u8; 3]], mount: Mount, root: [i32; 2], spread: i32, seed: u64) {
    let Size { width, height } = mount.upright();
    let (width, height) = (width as i32, height as i32);
    let horizon = height * HORIZON / 256;
    for y in 0..height {
        for x in 0..width {
            let colour = if y < horizon {
                above(x, y, horizon, height, seed)
            } else {
                let shadow = shadow([(x << 8) - root[0], (y << 8) - root[1]], spread, height);
                meadow(x, y, horizon, height, seed).map(|level| (level * (256 - shadow)) >> 8)
            };
            // Half a level of noise, so that the sky has no bands.
            let grain = (scatter((y as u64) << 32 | x as u64) >> 56) as i32;
            background[mount.index(x, y)] = colour.map(|level| ((level + grain) >> 8).clamp(0, 255) as u8);
        }
    }
}

/// `from` to `to` by `share` of 256, in steps of 1/256 level.
fn blend(from: [i32; 3], to: [i32; 3], share: i32) -> [i32; 3] {
    core::array::from_fn(|i| from[i] * 256 + (to[i] - from[i]) * share)
}

/// A place of the picture for noise whose lattice points are `cells` to a picture's height.
fn scaled(at: i32, cells: i32, height: i32) -> i32 {
    (i64::from(at) * i64::from(cells) * (1 << 16) / i64::from(height)) as i32
}

fn above(x: i32, y: i32, horizon: i32, height: i32, seed: u64) -> [i32; 3] {
    for (hill, &(rise, rough, colour)) in HILLS.iter().enumerate().rev() {
        let line = fbm(scaled(x, rough / 4 + 1, height), 0, 3, seed ^ (hill as u64 + 77));
        // The tops of trees, the finer the farther.
        let trees = fbm(scaled(x, rough * 8, height), 0, 3, seed ^ (hill as u64 + 99));
        let line = horizon - height * rise / 256 - ((line * height / 256 * rise) >> 16);
        if y > line - ((trees * height / 256 * rough / 8) >> 15) {
            // Mist lies in the valleys.
            let mist = ((y - line).max(0) * 256 * 8 / (height * rise / 32).max(1)).min(150);
            return blend(colour, [222, 212, 192], mist);
        }
    }
    let at = y * 256 / horizon;
    let after = SKY.iter().position(|&(place, _)| place > at).unwrap_or(SKY.len() - 1).max(1);
    let ((low, from), (high, to)) = (SKY[after - 1], SKY[after]);
    let sky = blend(from, to, (at - low) * 256 / (high - low));
    // Thin clouds, wide and flat.
    let cloud = fbm(scaled(x, 2, height), scaled(y, 7, height), 5, seed ^ 5);
    let share = (((cloud - 2_000).max(0) >> 6).min(130) * (256 - at / 2)) >> 8;
    core::array::from_fn(|i| sky[i] + ((250 - i as i32 * 3) * 256 - sky[i]) * share / 256)
}

fn meadow(x: i32, y: i32, horizon: i32, height: i32, seed: u64) -> [i32; 3] {
    let near = (y - horizon) * 256 / (height - horizon).max(1);
    let base = blend(MEADOW[0], MEADOW[1], near);
    // Far grass is fine and short, near grass coarse, longer, and leans to either side; one goes over into the other.
    let lean = fbm(scaled(x, 24, height), scaled(y, 36, height), 3, seed ^ 14) >> 5;
    let blades = |cells: i32, tall: i32, lean: i32, seed| {
        fbm(scaled(x, cells, height) + lean * cells, scaled(y, cells / tall, height), 3, seed)
    };
    let (far, close) = (blades(260, 1, 0, seed ^ 11), blades(130, 2, lean, seed ^ 13));
    let blades = (far * (256 - near) + close * near) >> 8;
    // Patches lie in perspective: the same at any distance.
    let depth = (1 << 24) / (near + 28);
    let ground = |across: i64| ((across * i64::from(depth)) >> 14) as i32;
    let patches = fbm(ground(i64::from(x) * 1_080 / i64::from(height)), depth, 4, seed ^ 12);
    let light = 256 + ((blades * (44 + near / 3)) >> 15) + ((patches * 60) >> 15);
    let dry = (patches >> 9).clamp(-30, 60);
    [base[0] + dry * 256 / 2, base[1], base[2]].map(|level| (level * light) >> 8)
}

/// How dark the ground is under the tree, of 256.
fn shadow([dx, dy]: [i32; 2], spread: i32, height: i32) -> i32 {
    // The shadow lies flat, to the right of the tree.
    let x = i64::from(dx - spread / 5) * 256 / i64::from(spread.max(1));
    let y = i64::from(dy - height) * 256 / i64::from((spread / 6).max(1));
    let distance = (x * x + y * y).isqrt().min(256) as i32;
    let inside = 256 - distance;
    inside * inside / 256 * 120 / 256
}
