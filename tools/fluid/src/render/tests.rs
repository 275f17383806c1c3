//! Whole animations of small pictures, from footage that is computed.

use super::*;
use crate::footage::Video;
use crate::label::Grid;
use crate::patch::{PatchRef, Version};
use image::Rgb;
use std::io;

/// A video of waves that run upwards, eleven frames a period, and sparkle a little.
pub(super) struct Waves(pub(super) Video);

impl Waves {
    pub(super) fn new(frames: u32) -> Self {
        Self(Video {
            number: 1,
            name: "waves".into(),
            class: Class::Water,
            width: 96,
            height: 96,
            frames,
            rate: 25.0,
        })
    }
}

impl Footage for Waves {
    fn video(&self, number: u32) -> Option<&Video> {
        (number == 1).then_some(&self.0)
    }

    fn frame(&self, _: u32, index: u32) -> io::Result<RgbImage> {
        if index >= self.0.frames {
            return Err(io::Error::other("there is no such frame"));
        }
        Ok(RgbImage::from_fn(self.0.width, self.0.height, |x, y| {
            let wave = (y as f32 / 12.0 + x as f32 / 40.0 + index as f32 / 11.0) * core::f32::consts::TAU;
            let sparkle = (x * 7919 + y * 104_729 + index * 1299) % 17;
            Rgb([(110.0 + 50.0 * wave.sin()) as u8 + sparkle as u8; 3])
        }))
    }

    fn mean(&self, number: u32) -> io::Result<RgbImage> {
        self.frame(number, 0)
    }
}

const WIDTH: usize = 120;
const HEIGHT: usize = 96;

/// A picture of 4 by 3 patches, each of which was given the same part of the video, beside each other.
fn labelling() -> Labelling {
    let grid = Grid { columns: 4, rows: 3 };
    let version = Version::all().next().expect("there is a first version");
    let patch = |index: usize| PatchRef {
        video: 1,
        version,
        x: (index % 2 * 24) as i16 - 12,
        y: (index / 4 * 24) as i16 - 24,
    };
    Labelling { grid, patches: (0..12).map(|index| Some(patch(index))).collect() }
}

fn picture() -> RgbImage {
    let level = |x: u32, y: u32| 100.0 + 40.0 * (x as f32 / 9.0).sin() * (y as f32 / 14.0).cos();
    RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        Rgb([level(x, y) as u8, (level(x, y) * 0.6) as u8, 20])
    })
}

/// Fluid in the middle.
fn matte() -> Plane {
    let inside = |x: usize, y: usize| f32::from(u8::from((20..100).contains(&x) && (20..76).contains(&y)));
    Plane {
        width: WIDTH,
        height: HEIGHT,
        values: (0..WIDTH * HEIGHT).map(|i| inside(i % WIDTH, i / WIDTH)).collect(),
    }
}

fn animated(class: Class, frames: u32) -> Animation {
    animate(&picture(), &matte(), &labelling(), &Waves::new(frames), &Options::new(class), &|_, _, _| ())
        .expect("it can be animated")
}

/// The root of the mean squared difference of two frames.
fn step(a: &RgbImage, b: &RgbImage) -> f64 {
    let sum: f64 =
        a.as_raw().iter().zip(b.as_raw()).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    (sum / a.as_raw().len() as f64).sqrt()
}

#[test]
fn water_moves_and_the_rest_stays() {
    let animation = animated(Class::Water, 80);
    let (first, later) = (animation.frame(0), animation.frame(5));
    let inside = |x: u32, y: u32| matte().row(y as usize)[x as usize] > 0.0;
    let changed = first
        .enumerate_pixels()
        .filter(|(x, y, pixel)| inside(*x, *y) && *pixel != later.get_pixel(*x, *y))
        .count();
    assert!(changed > 2000, "{changed} pixels changed");
    assert!(first.enumerate_pixels().all(|(x, y, pixel)| inside(x, y) || pixel == later.get_pixel(x, y)));
}

#[test]
fn the_loop_has_no_cut() {
    for class in [Class::Water, Class::Fire, Class::Smoke] {
        let animation = animated(class, 80);
        let frames: Vec<_> = (0..animation.frames()).map(|index| animation.frame(index)).collect();
        let steps: Vec<_> = (0..frames.len())
            .map(|index| step(&frames[index], &frames[(index + 1) % frames.len()]))
            .collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let most = steps.iter().copied().fold(0.0, f64::max);
        assert!(mean > 0.5 && most < 2.0 * mean, "{class:?}: a step of {most} where the mean is {mean}");
    }
}

#[test]
fn the_same_is_made_every_time() {
    let (a, b) = (animated(Class::Fire, 60), animated(Class::Fire, 60));
    assert!((0..a.frames()).all(|index| a.frame(index) == b.frame(index)));
}

#[test]
fn a_flame_leaves_its_outline_and_shows_no_grey() {
    let animation = animated(Class::Fire, 60);
    let (base, matte) = (picture(), matte());
    let beyond = |(x, y, pixel): (u32, u32, &Rgb<u8>)| {
        matte.row(y as usize)[x as usize] == 0.0 && pixel.0[0].abs_diff(base.get_pixel(x, y).0[0]) > 8
    };
    assert!(
        (0..animation.frames()).any(|index| animation.frame(index).enumerate_pixels().any(beyond)),
        "it stays inside"
    );
    let frame = animation.frame(7);
    let grey =
        frame.pixels().filter(|pixel| pixel.0[0] > 60 && pixel.0[0] < 220 && pixel.0[2] > pixel.0[0]).count();
    assert_eq!(grey, 0);
}

#[test]
fn the_look_of_the_picture_stays_where_that_is_asked_for() {
    let contrast = |picture: &RgbImage| {
        let luminance = colour::luminance(picture);
        flat::statistics((24..72).flat_map(|y| luminance.row(y)[24..96].to_vec())).1
    };
    let ratio = |look: bool| {
        let options = Options { look, ..Options::new(Class::Water) };
        let made = animate(&picture(), &matte(), &labelling(), &Waves::new(80), &options, &|_, _, _| ());
        contrast(&made.expect("it can be animated").frame(9)) / contrast(&picture())
    };
    let (with, without) = (ratio(true), ratio(false));
    assert!((0.75..1.3).contains(&with), "the contrast is {with} times that of the picture");
    assert!(with < without, "{with} with the match, {without} without");
}

#[test]
fn a_clip_holds_all_frames() {
    let folder = tempfile::tempdir().expect("there is a folder for temporary files");
    for class in [Class::Water, Class::Fire] {
        let (animation, path) = (animated(class, 60), folder.path().join("it.yfl"));
        let written = write_clip(&animation, &path, &|_, _, _| ()).expect("it can be written");
        assert_eq!(written.frames as usize, animation.frames());
        let clip = yurameki::os::clip::open(&path).expect("it can be opened").expect("it is a clip");
        assert_eq!(clip.header().shape.grid, Size::new(WIDTH as u32, HEIGHT as u32));
        assert_eq!(clip.header().frames, written.frames);
    }
}

#[test]
fn a_clip_is_as_long_as_it_is_asked_to_be() {
    let options = Options { seconds: Some(3.0), rate: Some(20.0), ..Options::new(Class::Water) };
    let animation = animate(&picture(), &matte(), &labelling(), &Waves::new(40), &options, &|_, _, _| ())
        .expect("it can be animated");
    assert_eq!((animation.frames(), animation.rate()), (60, 20.0));
}

#[test]
fn what_cannot_be_animated_is_refused_by_name() {
    let refused = |matte: &Plane, labelling: &Labelling, footage: &Waves| {
        animate(&picture(), matte, labelling, footage, &Options::new(Class::Water), &|_, _, _| ())
            .err()
            .map(|error| error.to_string())
    };
    let footage = Waves::new(30);
    let mut none = labelling();
    none.patches.fill(None);
    assert!(refused(&matte(), &none, &footage).is_some_and(|line| line.contains("no part of the picture")));
    assert!(refused(&Plane::new(50, 90), &labelling(), &footage).is_some_and(|line| line.contains("matte")));
    let mut unknown = labelling();
    unknown.patches[3].as_mut().expect("all are given").video = 9;
    assert!(refused(&matte(), &unknown, &footage).is_some_and(|line| line.contains("no video 9")));
    assert!(refused(&matte(), &labelling(), &Waves::new(0)).is_some_and(|line| line.contains("waves")));
}
