//! How a cell's features become the likelihood that it moves.

use super::features::Cell;

/// How much a cell looks like each thing that moves, 0..=256.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likeness {
    pub(super) foliage: i32,
    pub(super) autumn: i32,
    pub(super) water: i32,
    pub(super) fall: i32,
    pub(super) flame: i32,
    pub(super) fur: i32,
}

impl Likeness {
    pub(super) fn of(c: Cell) -> Self {
        let total = c.red + c.green + c.blue + 1;
        let peak = c.red.max(c.green).max(c.blue);
        let low = c.red.min(c.green).min(c.blue);
        let saturation = (peak - low) * 256 / (peak + 1);
        let greenness = (2 * c.green - c.red - c.blue) * 256 / total;
        let open = 256 - c.sky;
        let texture = c.fine * 4 / 16 + c.coarse * 2 / 16; // Quarter levels.
        let round = 256 - ramp(c.squareness, 70, 130);

        // Foliage
        let green = ramp(greenness, 4, 26);
        let textured = ramp(c.fine, 16, 56).max(ramp(greenness, 30, 60) / 2);
        let foliage = all([green, textured, open]);

        // Autumn: red over green over blue.
        let warm = if c.red >= c.green && c.green + 10 >= c.blue { 256 } else { 0 };
        let vivid = ramp(saturation, 80, 150);
        let autumn = all([warm, vivid, ramp(c.fine, 50, 100), round, open]);

        // Water
        let blueness = (c.blue.max(c.green) - c.red) * 256 / (peak + 1);
        let flat_streaks = ramp(-c.upright, 40, 120);
        let water = all([ramp(blueness, 10, 60), ramp(texture, 4, 16), open]).max(all([
            flat_streaks,
            ramp(c.fine, 16, 50),
            256 - ramp(c.red - c.blue, 10, 40),
            open,
        ]));

        let pale = 256 - ramp(saturation, 40, 80);
        let fall = all([pale, ramp(c.luma, 130, 190), ramp(c.fine, 16, 48), ramp(c.upright, 0, 80), open]);

        let hot = all([
            ramp(c.red, 110, 190),
            if c.red >= c.green && c.green >= c.blue { 256 } else { 0 },
            256 - ramp(c.surround, 50, 90),
            ramp(c.red - c.surround, 60, 120),
        ]);
        let flame = hot;

        let fur = all([
            ramp(c.fine, 90, 150),
            256 - ramp(c.squareness, 50, 90),
            ramp(c.fine * 256 / (c.coarse + 1), 130, 220),
            open,
        ]);
        Self { foliage, autumn, water, fall, flame, fur }
    }

    pub(super) fn best(self) -> i32 {
        [self.autumn, self.water, self.fall, self.flame, self.fur].into_iter().fold(self.foliage, i32::max)
    }
}

/// 0 up to `low`, 256 from `high` on, straight between.
fn ramp(value: i32, low: i32, high: i32) -> i32 {
    (value - low).clamp(0, high - low) * 256 / (high - low)
}

/// The product of shares in 256ths.
fn all<const N: usize>(shares: [i32; N]) -> i32 {
    shares.into_iter().fold(256, |product, share| product * share / 256)
}
