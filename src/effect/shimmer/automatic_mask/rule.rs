//! The rule: how a cell's features become the likelihood that it moves.
//!
//! Each thing that moves is a product of soft conditions, and the likeliest thing wins. Every number was set by looking at
//! masks of some sixty photos, at thresholds shared by many of them; none was fitted by a machine.

use super::features::Cell;

/// A soft condition: none up to the first value, full from the second on, straight between. The first may be the larger.
#[derive(Clone, Copy, Debug)]
struct Ramp(i32, i32);

// Conditions that several things share.

/// Gradients along two directions at right angles over a wide neighbourhood: bricks reach 45, shutters 150, leaves 25.
const LOOSE: Ramp = Ramp(60, 35);
/// Gradients of one direction: a wire, a sleeve, a rim. Leaves and grass stay under 130.
const TANGLED: Ramp = Ramp(180, 130);
/// Fine over coarse texture in 256ths: cloth is all thread and no branch.
const UNWOVEN: Ramp = Ramp(560, 420);
/// Not the sky itself.
const OPEN: Ramp = Ramp(256, 128);
/// Red over blue, in levels: water and spray are no warmer than grey; skin, sand and most stone are.
const COOL: Ramp = Ramp(20, 0);

// Foliage and grass.

/// Excess green (Woebbecke and others 1995), (2g − r − b) / (r + g + b): grey-green stone has 14, dull leaves 40.
const GREEN: Ramp = Ramp(12, 30);
/// Green over red: keeps out yellow wax, brass and lamplight.
const GREEN_OVER_RED: Ramp = Ramp(215, 245);
const LEAF_TEXTURE: Ramp = Ramp(16, 56);
/// Strong green needs no texture for [`SMOOTH_GREEN_SHARE`] of the score: lawns and leaves out of focus.
const STRONG_GREEN: Ramp = Ramp(30, 60);
const SMOOTH_GREEN_SHARE: i32 = 102;
/// Squareness less greenness: green shutters stay, a green hedge may be clipped.
const GREEN_LOOSE: Ramp = Ramp(50, 20);
/// Luma less twice the greenness: a bright cloud with a green cast stays.
const GREEN_DEPTH: Ramp = Ramp(180, 150);

// Dry grass, olive leaves, bare twigs, fur.

/// (r + g − 2b) / (r + g + b): brown rock has 60, a face 55, dry grass and olive leaves 85 to 150.
const YELLOW: Ramp = Ramp(54, 80);
const STRAW_TEXTURE: Ramp = Ramp(60, 110);

// Autumn leaves.

const RED_OVER_GREEN: Ramp = Ramp(0, 16);
const GREEN_OVER_BLUE: Ramp = Ramp(-20, 0);
const AUTUMN_SATURATION: Ramp = Ramp(90, 150);
const AUTUMN_TEXTURE: Ramp = Ramp(56, 96);

// Water.

/// (b − r) over the largest channel; the darkest colours are discounted by [`DARK_HUE`].
const BLUE: Ramp = Ramp(12, 40);
/// Levels added to the largest channel: below them a hue is noise.
const DARK_HUE: i32 = 24;
const RIPPLE_TEXTURE: Ramp = Ramp(12, 36);
/// Coherence that is not horizontal: an outline against blue is no ripple.
const RIPPLE_COHERENCE: Ramp = Ramp(190, 140);
/// Horizontal streaks make water of grey, too.
const STREAKS: Ramp = Ramp(35, 80);
const STREAK_TEXTURE: Ramp = Ramp(16, 50);
const WATER_LOOSE: Ramp = Ramp(150, 110);
const WATER_OFF_SKY: Ramp = Ramp(96, 0);
/// Share of the upper quarter that is sky, from which on water is looked for in the lower half only ([`LOW`]): blue above is
/// a far mountain.
const SKY_ABOVE: Ramp = Ramp(4, 24);
const LOW: Ramp = Ramp(120, 156);

// Falls, fountains, spray.

const PALE: Ramp = Ramp(90, 50);
const FALL_BLUE: Ramp = Ramp(20, 60);
const FALL_LUMA: Ramp = Ramp(80, 130);
const FALL_TEXTURE: Ramp = Ramp(12, 32);
/// Upright streaks.
const UPRIGHT: Ramp = Ramp(24, 72);
const FALL_LOOSE: Ramp = Ramp(120, 70);
const FALL_OFF_SKY: Ramp = Ramp(160, 32);
/// Under a whole sky, upright white is a cloud.
const FALL_UNDER_SKY: Ramp = Ramp(200, 110);

// Flames.

const FLAME_RED: Ramp = Ramp(50, 110);
/// Skin has 90 to 105, and a smooth face by lamplight must stay.
const FLAME_SATURATION: Ramp = Ramp(100, 145);
/// The core is white.
const FLAME_CORE_LUMA: Ramp = Ramp(200, 235);
/// How much around, or of the whole picture, is dark.
const FLAME_DARK: Ramp = Ramp(80, 120);
const FLAME_TEXTURE: Ramp = Ramp(24, 60);
const FLAME_GREEN_OVER_BLUE: Ramp = Ramp(-7, -6);
const FLAME_RED_OVER_GREEN: Ramp = Ramp(-1, 0);

impl Ramp {
    /// 0..=256.
    fn of(self, value: i32) -> i32 {
        let Self(none, full) = self;
        if none < full {
            (value - none).clamp(0, full - none) * 256 / (full - none)
        } else {
            (none - value).clamp(0, none - full) * 256 / (none - full)
        }
    }
}

/// The product of shares in 256ths.
fn all<const N: usize>(shares: [i32; N]) -> i32 {
    shares.into_iter().fold(256, |product, share| product * share / 256)
}

/// Colour measures of a cell, in 256ths but for those in levels.
struct Hue {
    saturation: i32,
    greenness: i32,
    yellowness: i32,
    blueness: i32,
    red_over_green: i32,
    green_over_blue: i32,
    red_over_blue: i32,
}

impl Hue {
    fn of(c: &Cell) -> Self {
        let total = c.red + c.green + c.blue + 1;
        let peak = c.red.max(c.green).max(c.blue);
        Self {
            saturation: (peak - c.red.min(c.green).min(c.blue)) * 256 / (peak + 1),
            greenness: (2 * c.green - c.red - c.blue) * 256 / total,
            yellowness: (c.red + c.green - 2 * c.blue) * 256 / total,
            blueness: (c.blue - c.red) * 256 / (peak + DARK_HUE),
            red_over_green: c.red - c.green,
            green_over_blue: c.green - c.blue,
            red_over_blue: c.red - c.blue,
        }
    }
}

/// How likely `cell` moves, 0..=256, in a photo whose upper quarter is sky to `sky_share` 256ths.
pub(super) fn likelihood(cell: &Cell, sky_share: i32) -> i32 {
    let hue = Hue::of(cell);
    foliage(cell, &hue)
        .max(straw(cell, &hue))
        .max(autumn(cell, &hue))
        .max(water(cell, &hue, sky_share))
        .max(fall(cell, &hue, sky_share))
        .max(flame(cell, &hue))
}

fn foliage(c: &Cell, hue: &Hue) -> i32 {
    all([
        GREEN.of(hue.greenness),
        GREEN_OVER_RED.of(c.green * 256 / (c.red + 1)),
        LEAF_TEXTURE.of(c.fine).max(STRONG_GREEN.of(hue.greenness) * SMOOTH_GREEN_SHARE / 256),
        GREEN_LOOSE.of(c.squareness - hue.greenness),
        GREEN_DEPTH.of(c.luma - 2 * hue.greenness),
        OPEN.of(c.sky),
    ])
}

/// What dry plants and fur share: a tangle, neither built nor woven.
fn tangle(c: &Cell) -> i32 {
    all([
        LOOSE.of(c.squareness),
        TANGLED.of(c.coherence),
        UNWOVEN.of(c.fine * 256 / (c.coarse + 1)),
        OPEN.of(c.sky),
    ])
}

fn straw(c: &Cell, hue: &Hue) -> i32 {
    all([YELLOW.of(hue.yellowness), STRAW_TEXTURE.of(c.fine + c.coarse / 8), tangle(c)])
}

fn autumn(c: &Cell, hue: &Hue) -> i32 {
    all([
        RED_OVER_GREEN.of(hue.red_over_green),
        GREEN_OVER_BLUE.of(hue.green_over_blue),
        AUTUMN_SATURATION.of(hue.saturation),
        AUTUMN_TEXTURE.of(c.fine + c.coarse / 8),
        tangle(c),
    ])
}

fn water(c: &Cell, hue: &Hue, sky_share: i32) -> i32 {
    let blue = all([
        BLUE.of(hue.blueness),
        RIPPLE_TEXTURE.of(c.fine + c.coarse / 2),
        RIPPLE_COHERENCE.of(c.coherence + c.upright.min(0)),
    ]);
    let grey = all([STREAKS.of(-c.upright), STREAK_TEXTURE.of(c.fine), COOL.of(hue.red_over_blue)]);
    let placed = 256 - SKY_ABOVE.of(sky_share) * (256 - LOW.of(c.depth)) / 256;
    all([blue.max(grey), WATER_LOOSE.of(c.squareness), WATER_OFF_SKY.of(c.sky), placed])
}

fn fall(c: &Cell, hue: &Hue, sky_share: i32) -> i32 {
    all([
        PALE.of(hue.saturation).max(FALL_BLUE.of(hue.blueness)),
        FALL_LUMA.of(c.luma),
        FALL_TEXTURE.of(c.fine + c.coarse / 2),
        UPRIGHT.of(c.upright),
        COOL.of(hue.red_over_blue),
        FALL_LOOSE.of(c.squareness),
        FALL_OFF_SKY.of(c.sky),
        FALL_UNDER_SKY.of(sky_share),
    ])
}

fn flame(c: &Cell, hue: &Hue) -> i32 {
    all([
        FLAME_RED.of(c.red),
        FLAME_RED_OVER_GREEN.of(hue.red_over_green),
        FLAME_GREEN_OVER_BLUE.of(hue.green_over_blue),
        FLAME_SATURATION.of(hue.saturation).max(FLAME_CORE_LUMA.of(c.luma)),
        FLAME_DARK.of(c.dark),
        FLAME_TEXTURE.of(c.fine + c.coarse / 2),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_runs_either_way_and_stops_at_its_ends() {
        assert_eq!([9, 10, 15, 20, 21].map(|v| Ramp(10, 20).of(v)), [0, 0, 128, 256, 256]);
        assert_eq!([9, 10, 15, 20, 21].map(|v| Ramp(20, 10).of(v)), [256, 256, 128, 0, 0]);
    }

    #[test]
    fn what_lacks_one_condition_stays() {
        let leaf = Cell {
            red: 70,
            green: 100,
            blue: 50,
            luma: 86,
            fine: 120,
            coarse: 140,
            coherence: 60,
            upright: 0,
            squareness: 15,
            dark: 20,
            sky: 0,
            depth: 128,
        };
        assert_eq!(likelihood(&leaf, 0), 256);
        assert_eq!(likelihood(&Cell { red: 100, blue: 100, ..leaf }, 0), 0, "grey stone");
        assert_eq!(likelihood(&Cell { squareness: 150, ..leaf }, 0), 0, "green shutters");
        assert_eq!(likelihood(&Cell { sky: 256, ..leaf }, 0), 0, "sky");
    }
}
