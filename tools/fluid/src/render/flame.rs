//! Fluids whose outline moves, in colour: the fluid, what is behind it, and its light on the surroundings.

use super::colour::{Palette, luminance_of};
use super::inpaint::fill;
use super::outline::Outlines;
use super::pyramid::blurred;
use crate::plane::Plane;
use image::{Rgb, RgbImage};
use rayon::prelude::*;

/// How far firelight reaches: a blur of as many halvings, about 50 pixels of the working size.
const REACH: usize = 6;

/// Surroundings take so much of the fire's own flicker where its light is full.
const LIGHT: f32 = 0.8;

/// A pixel keeps what it has beyond the palette while its luminance changes by less than about so many levels.
const OWN: f32 = 25.0;

/// Where less of the light is the fluid's, surroundings stay as they are.
const DARK: f32 = 0.03;

/// Where the outline moves over more than the inverse of this, the base is the mean of the frames alone.
const SETTLES: f32 = 4.0;

/// The mean is that of every such frame.
const FRAMES_OF_A_MEAN: usize = 3;

/// Three channels.
type Colours = [Plane; 3];

/// A flame, or smoke, over what is behind it.
pub(super) struct Flame {
    fluid: Colours,
    behind: Colours,
    palette: Palette,
    outlines: Outlines,
    /// The share of the fluid's light in that of a place.
    lit: Option<Plane>,
    /// The fluid's brightness in every frame, as a share of its mean.
    brightness: Vec<f32>,
}

impl Flame {
    /// That of a picture at the working size; what is behind is `background`, or is made up. `glows` if it lights its surroundings.
    pub(super) fn new(picture: &RgbImage, matte: &Plane, background: Option<&RgbImage>, glows: bool) -> Self {
        let solid = Plane { values: matte.values.iter().map(|alpha| alpha * alpha).collect(), ..*matte };
        let open =
            Plane { values: matte.values.iter().map(|alpha| (1.0 - alpha).powi(4)).collect(), ..*matte };
        let channels = channels(picture);
        let behind = background
            .map_or_else(|| channels.each_ref().map(|channel| fill(channel, &open)), self::channels);
        Self {
            fluid: channels.each_ref().map(|channel| fill(channel, &solid)),
            behind,
            palette: Palette::of(picture, matte),
            outlines: Outlines::default(),
            lit: glows.then(|| light(matte)),
            brightness: Vec::new(),
        }
    }

    /// The luminance of the fluid, beyond the matte too.
    pub(super) fn luminance(&self) -> Plane {
        let [red, green, blue] = &self.fluid;
        let colours = red.values.iter().zip(&green.values).zip(&blue.values);
        Plane {
            values: colours.map(|((&red, &green), &blue)| luminance_of([red, green, blue])).collect(),
            ..*red
        }
    }

    /// Sets it in motion.
    pub(super) fn move_with(&mut self, matte: &Plane, changes: &[Plane], tau: f32) {
        let luminance = self.luminance();
        self.outlines = Outlines::of(matte, &luminance, changes, tau);
        let brightness = |(index, change): (usize, &Plane)| {
            let mut sum = 0.0;
            for y in (0..change.height).step_by(2) {
                for x in (0..change.width).step_by(2) {
                    let place = y * change.width + x;
                    sum += self.outlines.at(index, x, y)
                        * (luminance.values[place] + change.values[place]).clamp(0.0, 255.0);
                }
            }
            sum
        };
        let sums: Vec<f32> = changes.par_iter().enumerate().map(brightness).collect();
        let mean = (sums.iter().sum::<f32>() / sums.len().max(1) as f32).max(1.0);
        self.brightness = sums.into_iter().map(|sum| sum / mean).collect();
    }

    /// The colours of a frame at a pixel.
    pub(super) fn colour(&self, index: usize, change: f32, x: usize, y: usize) -> [f32; 3] {
        let place = y * self.fluid[0].width + x;
        let fluid = self.fluid.each_ref().map(|channel| channel.values[place]);
        let share = self.outlines.at(index, x, y);
        let light = self
            .lit
            .as_ref()
            .map_or(1.0, |lit| 1.0 + LIGHT * lit.values[place] * (self.brightness[index] - 1.0));
        let own = luminance_of(fluid);
        let behind = [0, 1, 2].map(|channel| self.behind[channel].values[place] * light);
        // A thin flame is a darker one, of a darker flame's colour: mixed like paint it would be grey.
        let bright = (own + change).clamp(0.0, 255.0);
        let (thin, solid) = if self.glows() {
            (luminance_of(behind) * (1.0 - share) + bright * share, 1.0 - (1.0 - share).powi(3))
        } else {
            (bright, share)
        };
        let (before, after) = (self.palette.at(own), self.palette.at(thin));
        let stays = (-(thin - own).abs() / OWN).exp();
        core::array::from_fn(|channel| {
            let moving = (after[channel] + (fluid[channel] - before[channel]) * stays).clamp(0.0, 255.0);
            behind[channel] + (moving - behind[channel]) * solid
        })
    }

    fn glows(&self) -> bool {
        self.lit.is_some()
    }

    /// What a clip of it rests on: where the outline moves, `base` and `small`, the same picture at the working size, become the mean of the
    /// frames, since what does not change would be seen through them. The matte that is given back says where anything changes.
    pub(super) fn settle(&self, base: &mut RgbImage, small: &mut RgbImage, changes: &[Plane]) -> Vec<u8> {
        let [least, most] = self.outlines.extremes();
        let (width, pixels) = (small.width() as usize, self.fluid[0].values.len());
        let place = |place: usize| (place % width, place / width);
        let half = |plane: &Plane, (x, y): (usize, usize)| plane.sample(x as f32 / 2.0, y as f32 / 2.0);
        let settled = |at: usize| {
            let (x, y) = place(at);
            let levels = small.as_raw()[3 * at..][..3].iter().map(|&level| f32::from(level));
            let share = (SETTLES * (half(&most, (x, y)) - half(&least, (x, y)))).min(1.0);
            if share < 0.01 {
                return [0.0; 3];
            }
            let shown = (0..changes.len())
                .step_by(FRAMES_OF_A_MEAN)
                .map(|index| self.colour(index, changes[index].values[at], x, y));
            let count = changes.len().div_ceil(FRAMES_OF_A_MEAN) as f32;
            let sum = shown.fold([0.0; 3], |sum: [f32; 3], colour| {
                core::array::from_fn(|channel| sum[channel] + colour[channel])
            });
            let mut out = [0.0; 3];
            levels
                .zip(sum)
                .zip(&mut out)
                .for_each(|((level, sum), out)| *out = share * (sum / count - level));
            out
        };
        let added: Vec<[f32; 3]> = (0..pixels).into_par_iter().map(settled).collect();
        let matte = |at: usize| {
            let lit = self.lit.as_ref().is_some_and(|lit| lit.values[at] > DARK);
            if lit || half(&most, place(at)) > 0.004 { 255 } else { 0 }
        };
        let matte = (0..pixels).map(matte).collect();
        add(small, &added, width);
        add(base, &added, width);
        matte
    }
}

/// Adds colours, which are `columns` wide, to a picture of any size.
fn add(picture: &mut RgbImage, added: &[[f32; 3]], columns: usize) {
    let (width, height) = picture.dimensions();
    let rows = added.len() / columns;
    let channels = [0, 1, 2].map(|channel| Plane {
        width: columns,
        height: rows,
        values: added.iter().map(|colour| colour[channel]).collect(),
    });
    let (right, down) = (columns as f32 / width as f32, rows as f32 / height as f32);
    let rows = picture.as_mut().par_chunks_exact_mut(3 * width as usize).enumerate();
    rows.for_each(|(y, row)| {
        let y = (y as f32 + 0.5) * down - 0.5;
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let x = (x as f32 + 0.5) * right - 0.5;
            for (level, channel) in pixel.iter_mut().zip(&channels) {
                *level = (f32::from(*level) + channel.sample(x, y)).round().clamp(0.0, 255.0) as u8;
            }
        }
    });
}

fn channels(picture: &RgbImage) -> Colours {
    [0, 1, 2].map(|channel| {
        let values = picture.pixels().map(|Rgb(levels)| f32::from(levels[channel])).collect();
        Plane { width: picture.width() as usize, height: picture.height() as usize, values }
    })
}

/// The fluid's share of the light at every place, 1 where it is most.
fn light(matte: &Plane) -> Plane {
    let mut out = blurred(matte, REACH);
    let peak = out.values.iter().copied().fold(1e-3, f32::max);
    out.values.iter_mut().for_each(|value| *value /= peak);
    out
}
