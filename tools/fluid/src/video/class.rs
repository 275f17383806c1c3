//! What a video shows, where nobody says.

use crate::{
    footage::Class,
    motion::{GRID, field::MotionField},
};
use image::RgbImage;

/// How much more red than blue is where a video changes, in levels, weighted by the change. The three fires that this was tried with have
/// 61 to 86; a sunset sky 63; all else under 37.
const WARM: f32 = 45.0;

/// By how much of its brightness fire changes, as a standard deviation. The fires have 0.32 to 0.63, that sky 0.07, and a beach at sunset,
/// the next, 0.25.
const FLICKERS: f32 = 0.28;

/// What is added to the brightness, so that noise in black is no flicker.
const DARK: f32 = 8.0;

/// Share of the moving places' texture that is in the two finest levels, below which it is smoke: smoke and clouds have soft edges, water
/// glitters.
const SOFT: f32 = 0.2;

/// Guesses from the colour of what moves, its flicker and its texture: red that flickers is fire; soft is smoke; all else is water. No more
/// than a guess: of ten clips it took busy clouds for water, and a boiling pot for the steam above it.
pub fn guess(mean: &RgbImage, field: &MotionField) -> Class {
    let (mut warmth, mut change, mut flicker, mut fine, mut all, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for point in (0..field.fluid.len()).filter(|point| field.fluid[*point]) {
        let (x, y) = (point % field.columns * GRID, point / field.columns * GRID);
        let [red, green, blue] = mean.get_pixel(x as u32, y as u32).0.map(f32::from);
        warmth += (red - blue) * field.change[point];
        change += field.change[point];
        flicker += field.change[point] / (0.3 * red + 0.6 * green + 0.1 * blue + DARK);
        fine += field.texture[point][0] + field.texture[point][1];
        all += field.texture[point].iter().sum::<f32>();
        count += 1.0;
    }
    if warmth > WARM * change && flicker > FLICKERS * count {
        Class::Fire
    } else if fine < SOFT * all {
        Class::Smoke
    } else {
        Class::Water
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    /// A picture that is all fluid, of one colour, that changes by so much, with such finest and coarser texture.
    fn guessed(colour: [u8; 3], change: f32, fine: f32, coarse: f32) -> Class {
        let points = 12 * 12;
        let field = MotionField {
            columns: 12,
            rows: 12,
            mean: vec![[0.0; 2]; points],
            bands: vec![[0.0; 6]; points],
            texture: vec![[fine, 0.0, coarse, coarse, coarse]; points],
            change: vec![change; points],
            fluid: vec![true; points],
            noise: 0.3,
        };
        guess(&RgbImage::from_pixel(48, 48, Rgb(colour)), &field)
    }

    #[test]
    fn colour_flicker_and_texture_tell() {
        assert_eq!(guessed([200, 110, 60], 60.0, 1.0, 5.0), Class::Fire);
        assert_eq!(guessed([200, 110, 60], 6.0, 1.0, 5.0), Class::Smoke, "a sunset sky does not flicker");
        assert_eq!(guessed([90, 90, 100], 40.0, 6.0, 5.0), Class::Water);
    }
}
