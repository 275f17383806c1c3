//! What a video shows, where nobody says.

use crate::{footage::Class, motion::field::MotionField};
use image::RgbImage;

/// How much more red than blue a flame's moving places have on average, in levels. The fires that this was tried with have 60 to 150;
/// the reddest sunset over water, 35.
const FLAME: f32 = 50.0;

/// Share of the moving places' texture that is in the two finest levels, below which it is smoke: smoke and clouds have soft edges, water
/// glitters.
const SOFT: f32 = 0.2;

/// Guesses from the colour of what moves, and from its texture: red is fire; soft is smoke; all else is water. A guess: of the clips in
/// hand it is right for all fires, and takes busy clouds for water.
pub fn guess(mean: &RgbImage, field: &MotionField) -> Class {
    let (mut warmth, mut fine, mut all, mut count) = (0.0, 0.0, 0.0, 0.0);
    for point in (0..field.fluid.len()).filter(|point| field.fluid[*point]) {
        let (x, y) = (point % field.columns * crate::motion::GRID, point / field.columns * crate::motion::GRID);
        let pixel = mean.get_pixel(x as u32, y as u32);
        warmth += f32::from(pixel[0]) - f32::from(pixel[2]);
        fine += field.texture[point][0] + field.texture[point][1];
        all += field.texture[point].iter().sum::<f32>();
        count += 1.0;
    }
    if warmth > FLAME * count {
        Class::Fire
    } else if fine < SOFT * all {
        Class::Smoke
    } else {
        Class::Water
    }
}
