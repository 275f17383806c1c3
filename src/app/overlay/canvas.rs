use crate::{
    effect::paint,
    frame::{FrameMut, Rect, Rotation, Size},
    math::Factor,
};
use core::convert::Infallible;
use embedded_graphics::{
    Pixel,
    draw_target::DrawTarget,
    geometry::{Dimensions, OriginDimensions, Point, Size as Extent},
    pixelcolor::{Rgb888, RgbColor},
    primitives::Rectangle,
};

/// A frame as people see it whose panel may be mounted turned: upright, and in cells of several pixels where the panel has many.
pub(super) struct Canvas<'a, 'b> {
    frame: &'a mut FrameMut<'b>,
    rotation: Rotation,
    brightness: Factor,
    scale: u32,
}

impl<'a, 'b> Canvas<'a, 'b> {
    /// Text is made for a panel whose shorter side has so many pixels; others magnify it by the nearest whole number, so that it
    /// takes about the same share of the picture on each.
    const USUAL_SIDE: u32 = 480;

    pub(super) fn new(frame: &'a mut FrameMut<'b>, rotation: Rotation, brightness: Factor) -> Self {
        let size = frame.layout().size;
        let scale = ((size.width.min(size.height) + Self::USUAL_SIDE / 2) / Self::USUAL_SIDE).max(1);
        Self { frame, rotation, brightness, scale }
    }

    /// Its width and height in cells.
    pub(super) fn cells(&self) -> Extent {
        let upright = self.upright();
        Extent::new(upright.width / self.scale, upright.height / self.scale)
    }

    /// The pixels of the frame that `cells`, which are within it, take.
    pub(super) fn pixels(&self, cells: &Rectangle) -> Rect {
        let (at, size, scale) = (cells.top_left, cells.size, self.scale);
        let size = Size::new(size.width * scale, size.height * scale);
        let rect = Rect { x: at.x as u32 * scale, y: at.y as u32 * scale, size };
        self.rotation.turned_rect(rect, self.upright())
    }

    fn upright(&self) -> Size {
        self.rotation.turned(self.frame.layout().size)
    }
}

impl OriginDimensions for Canvas<'_, '_> {
    fn size(&self) -> Extent {
        self.cells()
    }
}

impl DrawTarget for Canvas<'_, '_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let one = Extent::new(1, 1);
        pixels.into_iter().try_for_each(|Pixel(at, colour)| self.fill_solid(&Rectangle::new(at, one), colour))
    }

    fn fill_solid(&mut self, area: &Rectangle, colour: Rgb888) -> Result<(), Infallible> {
        let rect = self.pixels(&area.intersection(&self.bounding_box()));
        paint::plain([colour.r(), colour.g(), colour.b()], rect, self.brightness, self.frame);
        Ok(())
    }
}

/// The point at column `x`, row `y`.
pub(super) const fn at(x: u32, y: u32) -> Point {
    Point::new(x as i32, y as i32)
}
