//! A picture, and the frames that are made of it.

use std::{error::Error, hint::black_box};
use yurameki::{
    effect::{
        Effect, Paint, Photo, paint,
        shimmer::{Range, Settings, Shimmer, storage_len},
    },
    frame::{FrameMut, Layout, PixelFormat, Rect, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
};

/// A picture with texture everywhere.
pub(crate) struct Scene {
    pub(crate) size: Size,
    pub(crate) rgb: Vec<u8>,
}

impl Scene {
    pub(crate) fn new(size: Size) -> Self {
        let pixel =
            |i: u32| (i % size.width * 7 + i / size.width * 5) ^ (i.wrapping_mul(2_654_435_761) >> 27);
        let rgb =
            (0..size.pixels() as u32).flat_map(|i| [pixel(i), pixel(i) + 20, pixel(i) / 2].map(|c| c as u8));
        Self { size, rgb: rgb.collect() }
    }

    /// All of it moves.
    pub(crate) fn everything(&self) -> Vec<u8> {
        vec![255; self.size.pixels()]
    }

    /// A fifth of the pixels moves, in ragged spans of 48 pixels among gaps of 192.
    pub(crate) fn a_fifth(&self) -> Vec<u8> {
        let ragged = |i: usize| {
            let (x, y) = (i % self.size.width as usize, i / self.size.width as usize);
            if (x + y * 37) % 240 < 48 { 255 } else { 0 }
        };
        (0..self.size.pixels()).map(ragged).collect()
    }

    pub(crate) fn shimmer(&self, range: Range, mask: &[u8]) -> Result<Shimmer<Vec<u64>>, Box<dyn Error>> {
        let photo = Photo { size: self.size, rgb: &self.rgb, mask };
        let storage = vec![0; storage_len(self.size)];
        Ok(Shimmer::prepare(photo, &Settings { range, ..Settings::default() }, storage)?)
    }
}

/// The moment of a round: no two alike.
fn drive(round: u32) -> Drive {
    let phase = Turns(round.wrapping_mul(214_748_365));
    Drive { amplitude: Factor::ONE / 2, frequency: Factor::ONE, phase, onset: Factor::ONE }
}

/// A shimmer, the one it fades into, if it does, and the frame that they are rendered into.
pub(crate) struct Frame {
    shimmer: Shimmer<Vec<u64>>,
    next: Option<Shimmer<Vec<u64>>>,
    pixels: Vec<u8>,
    layout: Layout,
}

impl Frame {
    pub(crate) fn new(
        scene: &Scene,
        range: Range,
        format: PixelFormat,
        mask: &[u8],
    ) -> Result<Self, Box<dyn Error>> {
        let layout = Layout::new(scene.size, format, None)?;
        let shimmer = scene.shimmer(range, mask)?;
        Ok(Self { shimmer, next: None, pixels: vec![0; layout.len_bytes()], layout })
    }

    /// One of the default range, all moving.
    pub(crate) fn whole(scene: &Scene, format: PixelFormat) -> Result<Self, Box<dyn Error>> {
        Self::new(scene, Range::default(), format, &scene.everything())
    }

    /// Two that fade.
    pub(crate) fn fading(scene: &Scene, format: PixelFormat) -> Result<Self, Box<dyn Error>> {
        let next = scene.shimmer(Range::Full, &scene.everything())?;
        Ok(Self { next: Some(next), ..Self::whole(scene, format)? })
    }

    pub(crate) fn render(&mut self, round: u32) {
        let Ok(mut out) = FrameMut::new(black_box(&mut self.pixels), self.layout) else { return };
        match &mut self.next {
            None => self.shimmer.render(drive(round), Paint::Motion, &mut out),
            Some(next) => {
                let (from, to) = (self.shimmer.at(drive(round)), next.at(drive(round)));
                paint::fade(
                    (&from, &to),
                    Factor::ONE / 3,
                    Rect::whole(self.layout.size),
                    Factor::ONE,
                    &mut out,
                );
            }
        }
    }

    pub(crate) fn size(&self) -> Size {
        self.layout.size
    }

    pub(crate) fn pixels(&self) -> &[u8] {
        &self.pixels
    }
}
