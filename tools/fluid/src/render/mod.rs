//! # The animation
//!
//! What the patches change is laid over the picture, and written as a clip (the paper, section 6).
//!
//! ```text
//! footage ──> reel, loop ──┐
//! labelling ──> plan ──────┴─> compose ──> look ──┬─> luma of water ──────────────┬─> clip
//!                                                 └─> outline, flame: fire, smoke ┘
//! ```

mod colour;
mod compose;
mod edges;
mod flame;
mod flat;
mod inpaint;
mod look;
mod outline;
mod plan;
mod pyramid;
mod reel;
mod seam;
mod write;

pub use write::write_clip;

use crate::footage::{Class, Footage};
use crate::label::Labelling;
use crate::plane::Plane;
use colour::Palette;
use flame::Flame;
use image::RgbImage;
use image::imageops::{FilterType, resize};
use look::Look;
use rayon::prelude::*;
use std::fmt;
use yurameki::effect::fluid::Tint;
use yurameki::frame::Size;

/// The largest base picture.
const LARGEST_BASE: Size = Size::new(1920, 1080);

/// A clip is about as long if the video that is used most has as many.
const SECONDS: f32 = 5.0;

/// A clip is no shorter than this unless it is asked to be, in seconds.
const SHORTEST: f32 = 2.4;

/// Frames a second that a clip may have.
const RATES: (f32, f32) = (1.0, 60.0);

/// Frames a second of a clip of which nobody asked for fewer, though its videos have fewer: slower ones stutter.
const SMOOTH: f32 = 25.0;

/// More frames would not fit into the memory of a small computer at the working size: a gigabyte.
const MOST_FRAMES: usize = 600;

/// What may be asked of an animation.
#[derive(Clone, Debug)]
pub struct Options {
    /// What the picture's fluid is: water keeps its outline; fire and smoke move theirs; fire lights its surroundings.
    pub class: Class,
    /// How long the clip is; without it, as long as the best loop of the video that is used most, and 5 s at the most.
    pub seconds: Option<f32>,
    /// Frames a second, 1..=60; without it, those of the video that is used most, and 25 at the least.
    pub rate: Option<f32>,
    /// How strongly the outline of fire and smoke follows the motion, 0..1: τ of the paper.
    pub tau: f32,
    /// Whether frames are matched to the look of the picture, as in the paper. Not by default: the photo is a frame itself, so that what
    /// moves is in it once and in the change again, and the match takes a third of the motion (medians of tps without and with it, of
    /// clips that were kept out: water .77 and .83, fire .75 and .98, clouds .70 and .75).
    pub look: bool,
    /// What is behind fire and smoke, of any size; without it, it is made up from what is around them.
    pub background: Option<RgbImage>,
}

impl Options {
    /// The usual ones for a fluid.
    pub fn new(class: Class) -> Self {
        let tau = match class {
            Class::Water => 0.0,
            Class::Fire => 0.78,
            Class::Smoke => 0.9,
        };
        Self { class, seconds: None, rate: None, tau, look: false, background: None }
    }
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Videos are read and their patches blended; counts videos.
    Detail,
    /// Frames are matched to the picture; counts frames.
    Look,
    /// Outlines are moved; counts nothing in between.
    Outline,
    /// The clip is written; counts frames.
    Write,
}

/// Hears how far it is: what is being done, how much of it is done, and of how much.
pub type Progress<'a> = dyn Fn(Stage, usize, usize) + Sync + 'a;

/// What an animation is made from, apart from its picture.
struct Ask<'a> {
    options: &'a Options,
    progress: &'a Progress<'a>,
}

/// Why there is no animation.
#[derive(Debug)]
pub enum RenderError {
    /// The labelling names a video that the database does not have.
    UnknownVideo(u32),
    /// A video without frames.
    EmptyVideo(String),
    /// A frame that cannot be read.
    Frame(String, u32, std::io::Error),
    /// No patch of the picture was given one of a video.
    NoFluid,
    /// The matte is too small, or not shaped like the picture.
    Matte,
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownVideo(number) => {
                write!(f, "the database has no video {number}: label the picture again")
            }
            Self::EmptyVideo(name) => write!(f, "{name}: the database has no frames of it: index it again"),
            Self::Frame(name, index, error) => {
                write!(f, "{name}: frame {index}: {error}; see what `check` says of the database")
            }
            Self::NoFluid => write!(
                f,
                "no part of the picture is a fluid that the database knows: give another matte or class"
            ),
            Self::Matte => {
                write!(f, "the matte has another shape than the picture: give one of the same size")
            }
        }
    }
}

impl std::error::Error for RenderError {}

/// A picture that moves. Its frames are a loop.
pub struct Animation {
    /// At most 1920 by 1080 pixels.
    base: RgbImage,
    /// The same at the working size.
    small: RgbImage,
    /// Where anything changes, and how much of the change is shown, at the working size.
    matte: Vec<u8>,
    changes: Vec<Plane>,
    rate: f32,
    paint: Paint,
}

/// How a change of luminance becomes one of colour.
enum Paint {
    Luma(Box<Tint>),
    Colour(Box<Flame>),
}

/// Makes the animation of a picture of any size.
///
/// `matte` says where the fluid is, 0..=1; its size is the working size, at which the picture was labelled, and must be shaped like the
/// picture to within a pixel. `progress` is told of every step.
///
/// # Errors
/// Footage that is not there or cannot be read, a matte of another shape, or no fluid at all.
pub fn animate(
    picture: &RgbImage,
    matte: &Plane,
    labelling: &Labelling,
    footage: &dyn Footage,
    options: &Options,
    progress: &Progress<'_>,
) -> Result<Animation, RenderError> {
    check(picture, matte)?;
    let bounded = Size::new(picture.width(), picture.height()).within(LARGEST_BASE);
    let mut base = resize(picture, bounded.width, bounded.height, FilterType::Triangle);
    let mut small = resize(&base, matte.width as u32, matte.height as u32, FilterType::Triangle);
    let ask = Ask { options, progress };
    let luminance = colour::luminance(&small);
    let mut detail = compose::compose(&ask, labelling, &luminance, footage)?;
    edges::settle(&luminance, &mut detail.frames);
    if options.class == Class::Water {
        match_look(&ask, &luminance, matte, &mut detail.frames);
        let tint = Palette::of(&small, matte).tint();
        let matte = matte.values.iter().map(|alpha| (alpha * 255.0).round() as u8).collect();
        return Ok(Animation {
            base,
            small,
            matte,
            changes: detail.frames,
            rate: detail.rate,
            paint: Paint::Luma(Box::new(tint)),
        });
    }
    let background = options
        .background
        .as_ref()
        .map(|background| resize(background, small.width(), small.height(), FilterType::Triangle));
    let mut flame = Flame::new(&small, matte, background.as_ref(), options.class == Class::Fire);
    match_look(&ask, &flame.luminance(), matte, &mut detail.frames);
    progress(Stage::Outline, 0, 1);
    flame.move_with(matte, &detail.frames, options.tau);
    progress(Stage::Outline, 1, 1);
    let matte = flame.settle(&mut base, &mut small, &detail.frames);
    Ok(Animation {
        base,
        small,
        matte,
        changes: detail.frames,
        rate: detail.rate,
        paint: Paint::Colour(Box::new(flame)),
    })
}

fn check(picture: &RgbImage, matte: &Plane) -> Result<(), RenderError> {
    let (width, height) = (f64::from(picture.width()), f64::from(picture.height()));
    let expected = matte.width as f64 * height / width;
    let alike = matte.width >= 8 && matte.height >= 8 && (expected - matte.height as f64).abs() <= 2.0;
    if alike { Ok(()) } else { Err(RenderError::Matte) }
}

/// Gives all frames the look of the picture.
fn match_look(ask: &Ask<'_>, picture: &Plane, matte: &Plane, changes: &mut [Plane]) {
    if !ask.options.look {
        return;
    }
    let count = changes.len();
    (ask.progress)(Stage::Look, 0, count);
    let look = Look::learn(picture, matte, changes);
    changes.par_iter_mut().for_each(|change| look.give(picture, change));
    (ask.progress)(Stage::Look, count, count);
}

impl Animation {
    /// Frames of the loop.
    pub fn frames(&self) -> usize {
        self.changes.len()
    }

    /// Frames a second.
    pub fn rate(&self) -> f32 {
        self.rate
    }

    /// The picture below, at most 1920 by 1080 pixels.
    pub fn base(&self) -> &RgbImage {
        &self.base
    }

    /// The change of frame `index` from the base: one plane of luminance, or red, green and blue one after the other, at the working size.
    pub fn change(&self, index: usize) -> Vec<f32> {
        let change = &self.changes[index];
        let Paint::Colour(flame) = &self.paint else { return change.values.clone() };
        let pixels = change.values.len();
        let mut out = vec![0.0; 3 * pixels];
        for (place, &change) in change.values.iter().enumerate() {
            if self.matte[place] > 0 {
                let (x, y) = (place % self.small.width() as usize, place / self.small.width() as usize);
                let colour = flame.colour(index, change, x, y);
                let base = self.small.get_pixel(x as u32, y as u32).0;
                (0..3).for_each(|channel| {
                    out[channel * pixels + place] = colour[channel] - f32::from(base[channel])
                });
            }
        }
        out
    }

    /// Frame `index` as it is shown at the working size, at full strength.
    pub fn frame(&self, index: usize) -> RgbImage {
        let change = self.change(index);
        let mut out = self.small.clone();
        for (place, pixel) in out.pixels_mut().enumerate() {
            let share = f32::from(self.matte[place]) / 255.0;
            let luma = colour::luminance_of(pixel.0.map(f32::from)).round() as usize;
            for channel in 0..3 {
                let change = match &self.paint {
                    Paint::Luma(tint) => {
                        change[place] * f32::from(tint.0[luma][channel]) / f32::from(Tint::ONE)
                    }
                    Paint::Colour(_) => change[channel * self.matte.len() + place],
                };
                pixel.0[channel] =
                    (f32::from(pixel.0[channel]) + share * change).round().clamp(0.0, 255.0) as u8;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests;
