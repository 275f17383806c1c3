//! Luminance, and the colours that a fluid has at each.
//!
//! The same change of red, green and blue turns a flame grey: what gets brighter must go through the flame's own colours.

use crate::plane::Plane;
use image::RgbImage;
use yurameki::effect::fluid::Tint;

/// Luminance of sRGB levels, with the weights of BT.709.
pub(super) fn luminance_of([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// The luminance of a picture.
pub(super) fn luminance(picture: &RgbImage) -> Plane {
    let values = picture.pixels().map(|pixel| luminance_of(pixel.0.map(f32::from))).collect();
    Plane { width: picture.width() as usize, height: picture.height() as usize, values }
}

/// Colours of neighbouring levels count with this standard deviation, in levels.
const BREADTH: f32 = 6.0;

/// A colour's slope is taken over so many levels.
const RUN: usize = 24;

/// The mean colour of a fluid at every luminance.
#[derive(Clone, Debug)]
pub(super) struct Palette([[f32; 3]; 256]);

impl Palette {
    /// That of the picture where the matte covers it.
    pub(super) fn of(picture: &RgbImage, matte: &Plane) -> Self {
        let mut sums = [[0.0_f32; 4]; 256];
        for (pixel, &weight) in picture.pixels().zip(&matte.values) {
            let colour = pixel.0.map(f32::from);
            let sum = &mut sums[luminance_of(colour).round() as usize];
            for (sum, value) in sum.iter_mut().zip([colour[0], colour[1], colour[2], 1.0]) {
                *sum += weight * value;
            }
        }
        Self(core::array::from_fn(|level| {
            let mut total = [1e-3; 4];
            for (other, sum) in sums.iter().enumerate() {
                let distance = (other as f32 - level as f32) / BREADTH;
                // The tail is long on purpose: levels that the picture does not have take the nearest that it has.
                let share = (-0.5 * distance * distance).exp()
                    + 1e-5 / (1.0 + distance * distance * distance * distance);
                total.iter_mut().zip(sum).for_each(|(total, sum)| *total += share * sum);
            }
            of_luminance([total[0], total[1], total[2]].map(|sum| sum / total[3]), level as f32)
        }))
    }

    /// The colour at a luminance.
    pub(super) fn at(&self, luminance: f32) -> [f32; 3] {
        let luminance = luminance.clamp(0.0, 254.99);
        let (level, part) = (luminance as usize, luminance.fract());
        core::array::from_fn(|channel| {
            self.0[level][channel] + (self.0[level + 1][channel] - self.0[level][channel]) * part
        })
    }

    /// Its slope at every luminance, as a clip wants it.
    pub(super) fn tint(&self) -> Tint {
        Tint(core::array::from_fn(|level| {
            let (low, high) = (level.saturating_sub(RUN / 2), (level + RUN / 2).min(255));
            let slope = |channel: usize| (self.0[high][channel] - self.0[low][channel]) / (high - low) as f32;
            core::array::from_fn(|channel| {
                (slope(channel) * f32::from(Tint::ONE)).round().clamp(0.0, 128.0) as u8
            })
        }))
    }
}

/// The colour with its luminance made `wanted`: darker by scaling it, brighter by mixing white to it where a channel would overflow.
fn of_luminance(colour: [f32; 3], wanted: f32) -> [f32; 3] {
    let scale = wanted / luminance_of(colour).max(0.5);
    let scaled = colour.map(|value| value * scale);
    let most = scaled.iter().copied().fold(0.0, f32::max);
    if most <= 255.0 {
        return scaled;
    }
    // Saturated until a channel is full; from there to white.
    let full = scaled.map(|value| value * 255.0 / most);
    let light = luminance_of(full);
    let white = ((wanted - light) / (255.0 - light).max(0.5)).clamp(0.0, 1.0);
    full.map(|value| value + (255.0 - value) * white)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    fn flame() -> Palette {
        let picture = RgbImage::from_fn(64, 4, |x, _| Rgb([(x * 4) as u8, (x * 2) as u8, 10]));
        Palette::of(&picture, &Plane { width: 64, height: 4, values: vec![1.0; 256] })
    }

    #[test]
    fn a_palette_has_the_luminance_that_is_asked_for() {
        for level in 1..=255 {
            let luminance = luminance_of(flame().at(level as f32));
            assert!((luminance - level as f32).abs() < 1.5, "{luminance} for {level}");
        }
    }

    #[test]
    fn a_flame_that_dims_stays_red() {
        let [red, green, _] = flame().at(60.0);
        assert!(red > 1.5 * green, "{red}, {green}");
    }

    #[test]
    fn a_grey_picture_changes_in_grey() {
        let picture = RgbImage::from_fn(256, 1, |x, _| Rgb([x as u8; 3]));
        let tint = Palette::of(&picture, &Plane { width: 256, height: 1, values: vec![1.0; 256] }).tint();
        for level in 40..200 {
            assert!(
                tint.0[level].iter().all(|slope| slope.abs_diff(Tint::ONE) < 4),
                "{:?} at {level}",
                tint.0[level]
            );
        }
    }
}
