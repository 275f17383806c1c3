//! The ground: soil and old grass, and blades before each other.

use super::{Backdrop, blend, scaled};
use crate::{effect::autumn::noise::fbm, math::random::scatter};

/// Fractional bits of a place in the picture.
const SPOT: u32 = 8;

/// The shadow of the tree, which lies flat, to the right of it.
#[derive(Clone, Copy)]
pub(super) struct Shadow {
    /// The tree's foot, in steps of 1/256 pixel.
    pub(super) root: [i32; 2],
    /// How wide the tree is, in the same.
    pub(super) spread: i32,
}

impl Shadow {
    /// What is left of the light at a pixel, of 256.
    fn light(self, x: i32, y: i32, height: i32) -> i32 {
        let (dx, dy) = ((x << SPOT) - self.root[0], (y << SPOT) - self.root[1]);
        let x = i64::from(dx - self.spread / 5) * 256 / i64::from(self.spread.max(1));
        let y = i64::from(dy - height) * 256 / i64::from((self.spread / 6).max(1));
        let distance = (x * x + y * y).isqrt().min(256) as i32;
        let inside = 256 - distance;
        256 - inside * inside / 256 * 150 / 256
    }
}

/// How near a row is: 0 at the far end of the ground, 256 at the viewer's feet.
fn nearness(backdrop: &Backdrop<'_>, y: i32) -> i32 {
    let top = backdrop.height * backdrop.scene.shore / 256;
    ((y - top) * 256 / (backdrop.height - top).max(1)).clamp(0, 256)
}

/// Patches of another colour, −2^15..2^15. They lie in perspective: the same at any distance.
fn patches(backdrop: &Backdrop<'_>, x: i32, near: i32) -> i32 {
    let depth = (1 << 24) / (near + 28);
    let across = i64::from(x - backdrop.width / 2) * 1_080 / i64::from(backdrop.height);
    fbm(((across * i64::from(depth)) >> 14) as i32, depth, 4, backdrop.seed ^ 12)
}

pub(super) fn paint(backdrop: &mut Backdrop<'_>, shadow: Shadow) {
    let (width, height) = (backdrop.width, backdrop.height);
    let [far, close] = backdrop.scene.ground;
    for y in height * backdrop.scene.shore / 256..height {
        let near = nearness(backdrop, y);
        let base = blend(far, close, near);
        for x in 0..width {
            let patch = patches(backdrop, x, near);
            let fine = fbm(scaled(x, 230, height), scaled(y, 400, height), 2, backdrop.seed ^ 11);
            let light = 256 + ((patch * 60) >> 15) + ((fine * 34) >> 15);
            let light = (light * shadow.light(x, y, height)) >> 8;
            let dry = (patch >> 9).clamp(-30, 60) * 128;
            backdrop.set(x, y, [base[0] + dry, base[1], base[2]].map(|level| (level * light) >> 8));
        }
    }
    let mut y = height * backdrop.scene.shore / 256 - 1;
    loop {
        let near = nearness(backdrop, y);
        // In a meadow a blade at the viewer's feet is a twentieth of the picture high, in the distance a pixel.
        let tall =
            (height * (5 + near * near / 2_000 + near / 14) * backdrop.scene.tall / (1_080 * 256)).max(1);
        // The roots of the nearest are below the picture.
        if y - tall * 5 / 4 > height {
            return;
        }
        row(backdrop, y, near, tall, shadow);
        y += (tall / 7).max(1);
    }
}

/// Blades whose roots are in a row.
fn row(backdrop: &mut Backdrop<'_>, y: i32, near: i32, tall: i32, shadow: Shadow) {
    let (width, height) = (backdrop.width, backdrop.height);
    // In steps of 1/256 pixel.
    let thick = (height * (40 + near) * 256 / (1_080 * 160)).max(90);
    let pitch = (thick * 2 / 256).max(1);
    for at in 0..=width / pitch {
        let key = scatter(backdrop.seed ^ 0x0b_1ade ^ (y as u64) << 32 ^ at as u64);
        let byte = |shift: u32| (key >> shift & 0xff) as i32;
        let x = at * pitch + byte(0) * pitch / 256;
        // Tufts stand higher, and lean together.
        let tuft = fbm(scaled(x, 14, height), scaled(y, 40, height), 2, backdrop.seed ^ 14);
        let length = tall * (110 + byte(8) / 2 + tuft / 160).max(24) / 256;
        if length < 1 {
            continue;
        }
        let lean = length * (byte(16) - 128 + tuft / 200) / 2; // in steps of 1/256 pixel at the tip
        let patch = patches(backdrop, x, near);
        let [some, dry, deep] = backdrop.scene.blades;
        let kind = byte(24) + patch / 180;
        let colour = match kind {
            ..=90 => deep,
            91..=170 => some,
            _ => dry,
        };
        // Distance takes their colour away.
        let colour = blend(backdrop.scene.ground[0], colour, (96 + near).min(256));
        let light = (shadow.light(x, y, height) * (205 + byte(32) / 3)) >> 8;
        let colour = colour.map(|level| (level * light) >> 8);
        blade(backdrop, [x, y], length, lean, thick, colour);
    }
}

/// Paints a blade from its root up: dark below, where others stand before it.
fn blade(
    backdrop: &mut Backdrop<'_>,
    [x, y]: [i32; 2],
    length: i32,
    lean: i32,
    thick: i32,
    colour: [i32; 3],
) {
    for up in 0..length {
        let row = y - up;
        if row < 0 || row >= backdrop.height {
            continue;
        }
        let share = up * 256 / length;
        let middle = (x << SPOT) + ((((lean * share) >> 8) * share) >> 8);
        let half = ((thick * (276 - share)) >> 9).max(20);
        let light = 140 + share / 2;
        let colour = colour.map(|level| (level * light) >> 8);
        let (left, right) = (middle - half, middle + half);
        for column in (left >> SPOT).max(0)..((right >> SPOT) + 1).min(backdrop.width) {
            let cover = right.min((column + 1) << SPOT) - left.max(column << SPOT);
            backdrop.mix(column, row, colour, cover.clamp(0, 256));
        }
    }
}
