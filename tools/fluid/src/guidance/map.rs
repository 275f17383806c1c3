//! Motion as pictures that a paint program can change: the speed as grey, the direction as hue.

use super::GuidanceError;
use crate::{
    label::{Grid, Motion},
    patch::{SIDE, STRIDE},
    plane::Plane,
};
use image::{DynamicImage, GrayImage, ImageReader, Luma, Rgb, RgbImage};
use std::path::Path;

/// Levels of grey for one pixel a frame: white is 8 pixels a frame, which at 25 frames a second crosses a picture of 640 in 3 seconds.
const LEVELS: f32 = 32.0;

/// Colours paler than this share of their brightness have no direction.
const PALE: f32 = 0.1;

/// Two numbers at each pixel of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Map([Plane; 2]);

impl Map {
    /// Reads a picture of speeds, of the picture's size.
    pub fn speeds(file: &Path, size: (usize, usize)) -> Result<Self, GuidanceError> {
        let grey = open(file, size)?.into_luma8();
        let values = grey.pixels().map(|pixel| f32::from(pixel.0[0]) / LEVELS).collect();
        Ok(Self([Plane { width: size.0, height: size.1, values }, Plane::new(size.0, size.1)]))
    }

    /// Reads a picture of directions, of the picture's size.
    pub fn directions(file: &Path, size: (usize, usize)) -> Result<Self, GuidanceError> {
        let picture = open(file, size)?.into_rgb8();
        let mut map = Self([Plane::new(size.0, size.1), Plane::new(size.0, size.1)]);
        for (index, pixel) in picture.pixels().enumerate() {
            if let Some(direction) = direction_of(*pixel) {
                (map.0[0].values[index], map.0[1].values[index]) = (direction[0], direction[1]);
            }
        }
        Ok(map)
    }

    /// The mean speed around a place, in pixels a frame.
    pub(super) fn speed(&self, x: f32, y: f32) -> f32 {
        around(&self.0[0], x, y)
    }

    /// The mean direction around a place, of length 1.
    pub(super) fn direction(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let [x, y] = [around(&self.0[0], x, y), around(&self.0[1], x, y)];
        let length = x.hypot(y);
        (length > PALE).then(|| [x / length, y / length])
    }
}

/// Opens a picture that must have a size.
pub(super) fn open(file: &Path, (width, height): (usize, usize)) -> Result<DynamicImage, GuidanceError> {
    let fault = |fault: String| GuidanceError::new(file, fault);
    let reader = || ImageReader::open(file).and_then(ImageReader::with_guessed_format);
    // The size first, so that a picture of another one is never unpacked.
    let found = reader().map_err(|error| fault(error.to_string()))?.into_dimensions();
    let (wide, high) = found.map_err(|error| fault(error.to_string()))?;
    if (wide as usize, high as usize) != (width, height) {
        return Err(fault(format!(
            "it is {wide} × {high} pixels, and must be as large as the picture: {width} × {height}"
        )));
    }
    reader().map_err(|error| fault(error.to_string()))?.decode().map_err(|error| fault(error.to_string()))
}

/// The speeds of a labelling as a grey picture, which [`Map::speeds`] reads.
pub fn speed_picture(grid: Grid, motions: &[Option<Motion>], (width, height): (usize, usize)) -> GrayImage {
    let value = |motion: &Motion| [motion.speed * LEVELS, 0.0];
    GrayImage::from_fn(width as u32, height as u32, |x, y| {
        let [level, _] = between(grid, motions, x, y, value);
        Luma([level.round().clamp(0.0, 255.0) as u8])
    })
}

/// The directions of a labelling as hues, which [`Map::directions`] reads: red to the right, then by yellow-green down, cyan to the left,
/// violet up; white where nothing gets on.
pub fn direction_picture(
    grid: Grid,
    motions: &[Option<Motion>],
    (width, height): (usize, usize),
) -> RgbImage {
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let [u, v] = between(grid, motions, x, y, |motion| motion.mean);
        if u.hypot(v) < 1e-3 { Rgb([255; 3]) } else { hue([u, v]) }
    })
}

/// The bright colour of a direction.
pub(super) fn hue([u, v]: [f32; 2]) -> Rgb<u8> {
    let sixth = v.atan2(u).rem_euclid(core::f32::consts::TAU) / core::f32::consts::TAU * 6.0;
    let level = |offset: f32| {
        let place = (sixth + offset).rem_euclid(6.0);
        (place.min(4.0 - place).clamp(0.0, 1.0) * 255.0).round() as u8
    };
    Rgb([level(2.0), level(0.0), level(4.0)])
}

/// The direction of a colour; none if it is grey.
fn direction_of(Rgb(levels): Rgb<u8>) -> Option<[f32; 2]> {
    let [r, g, b] = levels.map(f32::from);
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let spread = most - least;
    if spread <= PALE * most || most == 0.0 {
        return None;
    }
    let sixth = if most == r {
        (g - b) / spread
    } else if most == g {
        (b - r) / spread + 2.0
    } else {
        (r - g) / spread + 4.0
    };
    let (sine, cosine) = (sixth / 6.0 * core::f32::consts::TAU).sin_cos();
    Some([cosine, sine])
}

/// The mean of the middle of a patch.
fn around(plane: &Plane, x: f32, y: f32) -> f32 {
    /// A sample every 8 pixels.
    const PLACES: [f32; 3] = [-8.0, 0.0, 8.0];
    let places = PLACES.iter().flat_map(|dy| PLACES.iter().map(move |dx| (dx, dy)));
    places.map(|(dx, dy)| plane.sample(x + dx, y + dy)).sum::<f32>() / 9.0
}

/// What the motions of the patches around a pixel are between their centres; nothing counts where there is no fluid.
fn between<F: Fn(&Motion) -> [f32; 2]>(
    grid: Grid,
    motions: &[Option<Motion>],
    x: u32,
    y: u32,
    value: F,
) -> [f32; 2] {
    let place = |pixel: u32, patches: usize| {
        let place = (pixel as f32 - (SIDE as f32 - 1.0) / 2.0) / STRIDE as f32;
        let place = place.clamp(0.0, patches as f32 - 1.0);
        let first = place as usize;
        [(first, first as f32 + 1.0 - place), ((first + 1).min(patches - 1), place - first as f32)]
    };
    let (mut sum, mut total) = ([0.0; 2], 0.0);
    for (row, down) in place(y, grid.rows) {
        for (column, across) in place(x, grid.columns) {
            if let Some(motion) = &motions[row * grid.columns + column] {
                let value = value(motion);
                let weight = down * across;
                sum = [sum[0] + value[0] * weight, sum[1] + value[1] * weight];
                total += weight;
            }
        }
    }
    if total > 0.0 { sum.map(|value| value / total) } else { [0.0; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_comes_back_from_its_hue() {
        for step in 0..360 {
            let angle = (step as f32).to_radians();
            let direction = [angle.cos(), angle.sin()];
            let found = direction_of(hue(direction)).unwrap();
            assert!(found[0] * direction[0] + found[1] * direction[1] > 0.9999, "{step}");
        }
        assert_eq!(hue([1.0, 0.0]), Rgb([255, 0, 0]));
        assert_eq!(direction_of(Rgb([200, 200, 200])), None);
        assert_eq!(direction_of(Rgb([0, 0, 0])), None);
    }

    #[test]
    fn the_maps_of_a_labelling_are_read_back() {
        let grid = Grid { columns: 4, rows: 3 };
        let motion = |column: usize| Motion { mean: [-1.0, 0.5], speed: 1.0 + column as f32, amplitude: 0.0 };
        let motions: Vec<_> = (0..12).map(|n| (n != 5).then(|| motion(n % 4))).collect();
        let folder = tempfile::tempdir().unwrap();
        let (speed, direction) = (folder.path().join("speed.png"), folder.path().join("direction.png"));
        speed_picture(grid, &motions, (120, 96)).save(&speed).unwrap();
        direction_picture(grid, &motions, (120, 96)).save(&direction).unwrap();
        let speeds = Map::speeds(&speed, (120, 96)).unwrap();
        assert!((speeds.speed(23.5, 23.5) - 1.0).abs() < 0.2, "{}", speeds.speed(23.5, 23.5));
        assert!((speeds.speed(71.5, 71.5) - 3.0).abs() < 0.1, "{}", speeds.speed(71.5, 71.5));
        let [x, y] = Map::directions(&direction, (120, 96)).unwrap().direction(60.0, 40.0).unwrap();
        assert!((x + 2.0 * y).abs() < 0.03 && x < 0.0, "{x}, {y}");
        assert!(Map::speeds(&speed, (121, 96)).unwrap_err().to_string().contains("120 × 96"));
    }
}
