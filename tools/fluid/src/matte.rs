//! Where a picture's fluid is, when nobody says it.

use crate::{footage::Class, plane::Plane};
use image::RgbImage;
use yurameki::{
    effect::shimmer::automatic_mask::{automatic_mask, scratch_len},
    frame::Size,
};

/// A matte of `picture` for fluid of `class`, 0..=1. A guess: water and smoke are where the shimmer would move the picture and it is no leaf; fire
/// is what is bright and warm. Trees beside a river and red roofs can deceive it; a matte of one's own is better.
pub fn automatic(picture: &RgbImage, class: Class) -> Plane {
    let size = Size::new(picture.width(), picture.height());
    let mut moving = vec![0; size.pixels()];
    if class != Class::Fire {
        automatic_mask(picture.as_raw(), size, &mut vec![0; scratch_len(size)], &mut moving);
    }
    let pixels = picture.pixels().zip(&moving).map(|(pixel, &moving)| {
        let [r, g, b] = pixel.0.map(f32::from);
        match class {
            Class::Fire => ramp(0.6 * r + 0.4 * g - 0.5 * b, 70.0, 130.0),
            // Leaves are greener than they are red or blue.
            Class::Water => f32::from(moving) / 255.0 * (1.0 - ramp(g - r.max(b), 4.0, 20.0)),
            Class::Smoke => f32::from(moving) / 255.0,
        }
    });
    let plane = Plane { width: size.width as usize, height: size.height as usize, values: pixels.collect() };
    soften(&plane)
}

/// 0 below `from`, 1 above `to`.
fn ramp(value: f32, from: f32, to: f32) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

/// A mean over 7 by 7 pixels.
fn soften(plane: &Plane) -> Plane {
    const RADIUS: isize = 3;
    let mean = |plane: &Plane, dx: isize, dy: isize| {
        let value = |index: usize| {
            let (x, y) = ((index % plane.width) as isize, (index / plane.width) as isize);
            let taps = (-RADIUS..=RADIUS).map(|tap| {
                let x = (x + tap * dx).clamp(0, plane.width as isize - 1) as usize;
                let y = (y + tap * dy).clamp(0, plane.height as isize - 1) as usize;
                plane.values[y * plane.width + x]
            });
            taps.sum::<f32>() / (2 * RADIUS + 1) as f32
        };
        Plane { values: (0..plane.values.len()).map(value).collect(), ..*plane }
    };
    mean(&mean(plane, 1, 0), 0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn a_flame_is_found_on_black_and_nothing_else() {
        let picture = RgbImage::from_fn(96, 64, |x, y| match (x, y) {
            (30..60, 20..50) => Rgb([250, 170, 40]),
            (70..90, 20..50) => Rgb([60, 90, 200]),
            _ => Rgb([8, 6, 5]),
        });
        let matte = automatic(&picture, Class::Fire);
        assert_eq!(matte.values[35 * 96 + 45], 1.0);
        assert_eq!(matte.values[35 * 96 + 80], 0.0);
        assert_eq!(matte.values[5 * 96 + 5], 0.0);
    }
}
