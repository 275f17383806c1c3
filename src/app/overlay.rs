//! What is written on the picture: the photo's name and the noises.

use crate::{
    frame::{
        FrameMut,
        pack::{Level, Levels, pack},
    },
    noise::Kind,
};
use core::{convert::Infallible, fmt::Write};
use embedded_graphics::{
    Drawable, Pixel,
    draw_target::DrawTarget,
    geometry::{OriginDimensions, Point, Size},
    mono_font::{MonoFont, MonoTextStyleBuilder, iso_8859_1::FONT_10X20},
    pixelcolor::{Gray8, GrayColor},
    text::{Baseline, Text},
};
use heapless::String;

const FONT: MonoFont<'_> = FONT_10X20;

/// The longest line, in bytes; what is longer is cut.
const LINE: usize = 48;

/// Writes the noises, and the photo's name where there is one, into the lower left corner. Tells whether there was room.
pub(super) fn write(frame: &mut FrameMut<'_>, name: Option<&str>, noises: (Kind, Kind)) -> bool {
    let mut text = String::<{ 3 * LINE }>::new();
    // `text` holds three lines, and no name of a noise is long: these writes fit.
    if let Some(name) = name {
        let cut = name.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|&end| end < LINE).last();
        let _ = writeln!(text, "{}", &name[..cut.unwrap_or(0)]);
    }
    let _ = write!(text, "amplitude  {}\nfrequency  {}", noises.0, noises.1);
    let columns = text.lines().map(|line| line.chars().count()).max().unwrap_or(0) as u32;
    let rows = text.lines().count() as u32;

    let size = frame.layout().size;
    let scale = (size.width.min(size.height) / 480).max(1);
    let cell = FONT.character_size;
    // One cell of margin inside the box, and as much around it.
    let inner = Size::new((columns + 2) * cell.width, (rows + 1) * cell.height);
    let outer = (inner + cell) * scale;
    if outer.width > size.width || outer.height > size.height {
        return false;
    }
    let corner = (cell.width * scale, size.height - outer.height);
    let mut canvas = Canvas { frame, corner, scale, inner };
    let style = MonoTextStyleBuilder::new()
        .font(&FONT)
        .text_color(Gray8::WHITE)
        .background_color(Gray8::new(24))
        .build();
    let Ok(()) = canvas.clear(Gray8::new(24));
    let start = Point::new(cell.width as i32, cell.height as i32 / 2);
    let Ok(_) = Text::with_baseline(&text, start, style, Baseline::Top).draw(&mut canvas);
    true
}

/// A part of the frame, magnified.
struct Canvas<'a, 'b> {
    frame: &'a mut FrameMut<'b>,
    corner: (u32, u32),
    scale: u32,
    inner: Size,
}

impl OriginDimensions for Canvas<'_, '_> {
    fn size(&self) -> Size {
        self.inner
    }
}

impl DrawTarget for Canvas<'_, '_> {
    type Color = Gray8;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Gray8>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let (format, scale) = (self.frame.layout().format, self.scale);
        let bytes = format.bytes_per_pixel();
        for Pixel(at, colour) in pixels {
            if at.x < 0 || at.y < 0 || at.x as u32 >= self.inner.width || at.y as u32 >= self.inner.height {
                continue;
            }
            let mut planes = [[Level::from(colour.luma()) << 4]; 3];
            let [red, green, blue] = planes.each_mut();
            let colour = Levels { red, green, blue };
            let (left, top) = (self.corner.0 + at.x as u32 * scale, self.corner.1 + at.y as u32 * scale);
            for (x, y) in (top..top + scale).flat_map(|y| (left..left + scale).map(move |x| (x, y))) {
                let start = x as usize * bytes;
                let out = &mut self.frame.row(y)[start..start + bytes];
                pack(format, &colour, x, y, out);
            }
        }
        Ok(())
    }
}
