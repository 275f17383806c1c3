//! Plots as PNG files: the font, the colours, and the way from a drawing to a file.

use crate::Failure;
use plotters::{coord::Shift, prelude::*, style::register_font};
use std::path::Path;
use yurameki::{
    frame::{FrameRef, Layout, PixelFormat, Size},
    os::output::{FrameRate, Target, Writer},
};

/// Where a figure is drawn.
pub(crate) type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Every figure is drawn so many times larger in each direction and then shrunk: thick lines get smooth edges that way, which the
/// bitmap backend draws without. Lengths in pixels are multiplied by it.
pub(crate) const OVERSAMPLING: u32 = 2;

/// The height of the text at axes and in legends.
pub(crate) const TEXT: u32 = 20 * OVERSAMPLING;
/// The height of titles.
pub(crate) const TITLE: u32 = 23 * OVERSAMPLING;
/// The width of lines that show something measured.
pub(crate) const LINE: u32 = OVERSAMPLING * 3 / 2;
/// The room for numbers and words at the left of a chart.
pub(crate) const LEFT: u32 = 92 * OVERSAMPLING;
/// The room for numbers and words below a chart.
pub(crate) const BELOW: u32 = 66 * OVERSAMPLING;

/// Colours that people with any colour vision tell apart (Okabe and Ito, 2008), darkest first.
pub(crate) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];
/// Grid lines.
pub(crate) const GRID: RGBColor = RGBColor(215, 215, 215);
/// Lines that only guide the eye.
pub(crate) const FAINT: RGBColor = RGBColor(150, 150, 150);

/// Text of `height`, as plotters asks for it.
pub(crate) const fn text(height: u32) -> (&'static str, u32) {
    ("sans-serif", height)
}

/// Writes in a row what lines mean, each with a piece of its line, and returns the area below.
pub(crate) fn legend_row<'a>(
    area: &Area<'a>,
    entries: impl IntoIterator<Item = (String, ShapeStyle)>,
) -> Result<Area<'a>, Failure> {
    let gap = TEXT as i32;
    let (row, below) = area.split_vertically(2 * TEXT);
    let mut x = LEFT as i32;
    for (words, style) in entries {
        row.draw(&PathElement::new([(x, gap), (x + 2 * gap, gap)], style))?;
        x += 5 * gap / 2;
        // The letters stand above the middle of their box.
        row.draw(&Text::new(words.clone(), (x, gap * 7 / 10), text(TEXT)))?;
        let (width, _) = row.estimate_text_size(&words, &TextStyle::from(text(TEXT)))?;
        x += width as i32 + 2 * gap;
    }
    Ok(below)
}

/// Draws a figure of `width` × `height` pixels on white, by `paint`, and writes it to the PNG file at `path`.
pub(crate) fn draw(
    path: &Path,
    (width, height): (u32, u32),
    paint: impl FnOnce(&Area<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| "the built-in font cannot be read")?;
    let (wide, high) = (width * OVERSAMPLING, height * OVERSAMPLING);
    let mut large = vec![255; (wide * high * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut large, (wide, high)).into_drawing_area();
        paint(&area)?;
        area.present()?;
    }
    let rgb = shrink(&large, wide as usize);
    let size = Size::new(width, height);
    let target = Target::parse(path.as_os_str())?;
    let once = FrameRate::new(1, 1).ok_or("one frame a second is no rate")?;
    let mut writer = Writer::create(&target, size, once, 1)?;
    writer.write(FrameRef::new(&rgb, Layout::new(size, PixelFormat::Bgr888, None)?)?)?;
    writer.finish()?;
    println!("{}", path.display());
    Ok(())
}

/// The mean of every block of [`OVERSAMPLING`] × [`OVERSAMPLING`] pixels of a picture that is `wide` pixels wide.
fn shrink(large: &[u8], wide: usize) -> Vec<u8> {
    const N: usize = OVERSAMPLING as usize;
    let mean = |rows: &[u8], x: usize, channel: usize| {
        let block = (0..N).flat_map(|dy| (0..N).map(move |dx| (dy * wide + x * N + dx) * 3 + channel));
        let sum: usize = block.map(|at| usize::from(rows[at])).sum();
        ((sum + N * N / 2) / (N * N)) as u8
    };
    large
        .chunks_exact(wide * 3 * N)
        .flat_map(|rows| (0..wide / N).flat_map(move |x| (0..3).map(move |channel| mean(rows, x, channel))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_takes_the_mean_of_blocks() {
        let rows = [[0, 0, 0, 4, 4, 4, 9, 8, 7, 9, 8, 7], [8, 8, 8, 4, 4, 4, 9, 8, 7, 9, 8, 7]];
        assert_eq!(shrink(rows.as_flattened(), 4), [4, 4, 4, 9, 8, 7]);
    }

    #[test]
    fn a_figure_with_text_becomes_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("figure.png");
        draw(&path, (60, 40), |area| {
            area.draw(&Text::new("β", (4, 4), text(60)))?;
            Ok(())
        })
        .unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"\x89PNG"));
    }
}
