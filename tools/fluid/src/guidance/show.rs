//! A picture of what was understood.

use super::{Guidance, map::hue};
use crate::{
    patch::{SIDE, STRIDE},
    plane::Plane,
};
use image::{Rgb, RgbImage};

/// How much of a pixel is the hue of its direction, of 256.
const TINT: u16 = 90;

/// From an arrow to the next, in pixels.
const APART: usize = 2 * STRIDE;

/// Frames of motion that an arrow is long.
const FRAMES: f32 = 8.0;

/// Length of an arrow where no speed was asked for, in pixels.
const LENGTH: f32 = 24.0;

/// An arrow's head: its length and half of its width, in pixels.
const HEAD: [f32; 2] = [6.0, 4.0];

pub(super) fn show(guidance: &Guidance, picture: &RgbImage, matte: Option<&Plane>) -> RgbImage {
    let mut out = picture.clone();
    let fluid = |x: u32, y: u32| matte.map_or(1.0, |matte| matte.sample(x as f32, y as f32));
    for (x, y, pixel) in out.enumerate_pixels_mut() {
        let wanted = guidance.wanted(x as f32, y as f32);
        let tint = match (wanted.direction, wanted.speed) {
            (Some(direction), _) => Some(hue(direction)),
            (None, Some(speed)) => Some(Rgb([(speed * 32.0).clamp(0.0, 255.0) as u8; 3])),
            (None, None) => None,
        };
        // What is no fluid is dark.
        let light = 0.25 + 0.75 * fluid(x, y);
        for channel in 0..3 {
            let own = u16::from(pixel.0[channel]);
            let mixed =
                tint.map_or(own, |tint| (own * (256 - TINT) + u16::from(tint.0[channel]) * TINT) / 256);
            pixel.0[channel] = (f32::from(mixed) * light) as u8;
        }
    }
    for y in (SIDE / 2..picture.height() as usize).step_by(APART) {
        for x in (SIDE / 2..picture.width() as usize).step_by(APART) {
            let wanted = guidance.wanted(x as f32, y as f32);
            if let Some(direction) = wanted.direction.filter(|_| fluid(x as u32, y as u32) >= 0.5) {
                let length = wanted.speed.map_or(LENGTH, |speed| speed * FRAMES);
                arrow(&mut out, [x as f32, y as f32], direction, length);
            }
        }
    }
    out
}

/// Draws an arrow about a place: white, with a black shadow so that it is seen on anything.
fn arrow(picture: &mut RgbImage, [x, y]: [f32; 2], [u, v]: [f32; 2], length: f32) {
    let tail = [x - u * length / 2.0, y - v * length / 2.0];
    let tip = [x + u * length / 2.0, y + v * length / 2.0];
    let barb =
        |side: f32| [tip[0] - u * HEAD[0] - v * HEAD[1] * side, tip[1] - v * HEAD[0] + u * HEAD[1] * side];
    for (offset, colour) in [(1.0, Rgb([0; 3])), (0.0, Rgb([255; 3]))] {
        for start in [tail, barb(1.0), barb(-1.0)] {
            line(picture, start.map(|at| at + offset), tip.map(|at| at + offset), colour);
        }
    }
}

/// Draws a line, as far as it is on the picture.
fn line(picture: &mut RgbImage, from: [f32; 2], to: [f32; 2], colour: Rgb<u8>) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let steps = way[0].abs().max(way[1].abs()).ceil().max(1.0);
    for step in 0..=steps as u32 {
        let share = step as f32 / steps;
        let (x, y) = ((from[0] + way[0] * share).round(), (from[1] + way[1] * share).round());
        if x >= 0.0 && y >= 0.0 && x < picture.width() as f32 && y < picture.height() as f32 {
            picture.put_pixel(x as u32, y as u32, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Direction, DirectionField};
    use super::*;

    #[test]
    fn the_arrow_points_along_the_stroke_and_the_rest_is_dark() {
        let strokes = vec![vec![[40.0, 10.0], [40.0, 90.0]]];
        let direction = Some(Direction::Field(DirectionField::new(&strokes, (96, 96))));
        let guidance = Guidance { direction, speed: None };
        let mut matte = Plane::new(96, 96);
        matte.values.iter_mut().enumerate().for_each(|(i, value)| *value = f32::from(i % 96 < 60));
        let picture = RgbImage::from_pixel(96, 96, Rgb([100; 3]));
        let shown = guidance.show(&picture, Some(&matte));
        let white = |x: u32, y: u32| *shown.get_pixel(x, y) == Rgb([255; 3]);
        assert!((13..=35).all(|y| white(24, y)), "the shaft goes down through (24, 24)");
        assert!(white(21, 32) && !white(21, 16), "the head is below");
        assert!((0..96).all(|y| !white(72, y)), "there is none outside of the matte");
        assert!(shown.get_pixel(90, 50).0.iter().all(|&level| level < 50));
    }

    #[test]
    fn nothing_asked_is_the_picture_itself() {
        let picture = RgbImage::from_fn(30, 20, |x, y| Rgb([x as u8, y as u8, 7]));
        assert_eq!(Guidance::default().show(&picture, None), picture);
    }
}
