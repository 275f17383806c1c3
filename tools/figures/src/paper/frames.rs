//! Fig. 3: a part of two frames half a second apart, magnified, and their difference.

use super::seconds;
use crate::{
    Failure,
    drawing::{self, Area, BELOW, FAINT, LEFT, OVERSAMPLING, TEXT, TITLE, text},
    film::{Film, Showing, Subject},
};
use plotters::prelude::*;
use std::path::Path;
use yurameki::{
    frame::{FrameRef, Rect, Size},
    noise::Kind,
};

/// The two frames: at 5.0 s, when the picture has long come alive, and at 5.5 s.
const FRAMES: [u32; 2] = [60, 66];

/// The part that is shown, at most.
const PART: Size = Size::new(160, 120);

/// How wide the part becomes in the figure, in pixels: four times as wide, or more where the photo is small.
const MAGNIFIED_WIDTH: u32 = 4 * PART.width;

/// The room for the scale of the difference.
const SCALE: u32 = LEFT + 3 * TEXT;

pub(super) fn draw(path: &Path, subject: &Subject) -> Result<(), Failure> {
    let scene = subject.load()?;
    let life = subject.life();
    let mut storage = Film::storage(subject.size);
    let mut film = Film::new(&scene, &life, &mut storage)?;
    let mut drive = life.drive;
    drive.amplitude = subject.look.amplitude.unwrap_or(Kind::Filter);
    drive.frequency = subject.look.frequency.unwrap_or(Kind::Filter);
    let mut showing = Showing::new(&film, drive, subject.seed())?;
    let mut taken = Vec::new();
    for t in 0..=FRAMES[1] {
        let frame = showing.frame(&mut film)?;
        if FRAMES.contains(&t) {
            taken.push(Picture::of(frame));
        }
    }
    let [first, second] = <[Picture; 2]>::try_from(taken).map_err(|_| "two frames were to be taken")?;
    let part = liveliest(&first, &second, PART.within(subject.size));
    figure(path, &first, &second, part)
}

/// A frame, kept.
struct Picture {
    size: Size,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn of(frame: FrameRef<'_>) -> Self {
        let size = frame.layout().size;
        let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        Self { size, rgb: pixels.map(|(x, y)| frame.rgb(x, y)).collect() }
    }

    fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.rgb[(y * self.size.width + x) as usize]
    }

    /// Luma of BT.709, 0 to 255.
    fn luma(&self, x: u32, y: u32) -> f64 {
        let [r, g, b] = self.at(x, y).map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }
}

/// The part of `size` in which two pictures differ most, in steps of eight pixels.
fn liveliest(first: &Picture, second: &Picture, size: Size) -> Rect {
    let whole = first.size;
    let difference = |x, y| (second.luma(x, y) - first.luma(x, y)).abs();
    // Sums over all that lies above and to the left, so that a part's sum takes four of them.
    let columns = whole.width as usize + 1;
    let mut sums = vec![0.; columns * (whole.height as usize + 1)];
    for y in 0..whole.height {
        let mut row = 0.;
        for x in 0..whole.width {
            row += difference(x, y);
            let at = (y as usize + 1) * columns + x as usize + 1;
            sums[at] = sums[at - columns] + row;
        }
    }
    let sum = |x: u32, y: u32| sums[y as usize * columns + x as usize];
    let inside = |x, y| {
        let (right, bottom) = (x + size.width, y + size.height);
        sum(right, bottom) - sum(x, bottom) - sum(right, y) + sum(x, y)
    };
    let places = (0..=whole.height - size.height)
        .step_by(8)
        .flat_map(|y| (0..=whole.width - size.width).step_by(8).map(move |x| (x, y)));
    let (x, y) = places.max_by(|&a, &b| inside(a.0, a.1).total_cmp(&inside(b.0, b.1))).unwrap_or((0, 0));
    Rect { x, y, size }
}

fn figure(path: &Path, first: &Picture, second: &Picture, part: Rect) -> Result<(), Failure> {
    let difference = |x, y| second.luma(x, y) - first.luma(x, y);
    let Rect { x: left, y: top, size: Size { width, height } } = part;
    let pixels = || (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
    // One pixel in 200 may differ by more than the scale shows: else a few edges would leave it to white.
    let mut differences: Vec<f64> = pixels().map(|(x, y)| difference(x, y).abs()).collect();
    differences.sort_by(f64::total_cmp);
    let limit = (differences[differences.len() * 199 / 200].max(1.) / 5.).ceil() * 5.;
    let rgb = |[r, g, b]: [u8; 3]| RGBColor(r, g, b);

    let magnification = MAGNIFIED_WIDTH / width;
    let room = |pixels: u32| pixels * magnification * OVERSAMPLING;
    let panel = (room(width) + LEFT + 2 * TEXT, room(height) + BELOW + TITLE * 2 + TEXT);
    let whole = [2 * panel.0, 2 * panel.1].map(|side| side / OVERSAMPLING);
    drawing::draw(path, whole.into(), |area| {
        let (above, below) = area.split_vertically(panel.1);
        let (a, b) = above.split_horizontally(panel.0);
        let (c, rest) = below.split_horizontally(panel.0);
        let (scale, _) = rest.split_horizontally(SCALE);
        let [at_a, at_b] = FRAMES.map(seconds);
        magnified(&a, &format!("(a) t = {at_a:.1} s"), part, |x, y| rgb(first.at(x, y)))?;
        magnified(&b, &format!("(b) t = {at_b:.1} s"), part, |x, y| rgb(second.at(x, y)))?;
        magnified(&c, "(c) luma of (b) minus (a)", part, |x, y| diverging(difference(x, y) / limit))?;
        colour_scale(&scale, limit)
    })
}

/// One part of a picture, each pixel a square.
fn magnified(
    area: &Area<'_>,
    title: &str,
    part: Rect,
    colour: impl Fn(u32, u32) -> RGBColor,
) -> Result<(), Failure> {
    let Rect { x: left, y: top, size } = part;
    let (right, bottom) = (left + size.width, top + size.height);
    let mut chart = ChartBuilder::on(area)
        .caption(title, text(TITLE))
        .margin(TEXT / 2)
        .margin_right(3 * TEXT / 2)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW)
        .build_cartesian_2d(left..right, bottom..top)?;
    let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
    chart
        .draw_series(pixels.map(|(x, y)| Rectangle::new([(x, y), (x + 1, y + 1)], colour(x, y).filled())))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("x (pixels)")
        .y_desc("y (pixels)")
        .x_labels(6)
        .y_labels(6)
        .label_style(text(TEXT))
        .axis_desc_style(text(TEXT))
        .axis_style(FAINT)
        .draw()?;
    Ok(())
}

/// What the colours of the difference mean.
fn colour_scale(area: &Area<'_>, limit: f64) -> Result<(), Failure> {
    const STEPS: i32 = 100;
    let mut chart = ChartBuilder::on(area)
        .caption(" ", text(TITLE))
        .margin(TEXT / 2)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW)
        .build_cartesian_2d(0. ..1., -limit..limit)?;
    chart.draw_series((-STEPS..STEPS).map(|i| {
        let [from, to] = [i, i + 1].map(|i| f64::from(i) / f64::from(STEPS));
        Rectangle::new([(0., from * limit), (1., to * limit)], diverging((from + to) / 2.).filled())
    }))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .y_desc("difference (levels)")
        .y_labels(5)
        .y_label_formatter(&|y| {
            if *y == 0. { "0".to_owned() } else { format!("{y:+.0}").replace('-', "−") }
        })
        .label_style(text(TEXT))
        .axis_desc_style(text(TEXT))
        .axis_style(FAINT)
        .draw()?;
    Ok(())
}

/// Blue for −1, white for 0, red for 1.
fn diverging(share: f64) -> RGBColor {
    let share = share.clamp(-1., 1.);
    let end: [f64; 3] = if share < 0. { [5., 80., 160.] } else { [180., 20., 30.] };
    let [r, g, b] = end.map(|channel| (255. + (channel - 255.) * share.abs()).round() as u8);
    RGBColor(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_that_differs_most_is_found() {
        let size = Size::new(64, 48);
        let still = Picture { size, rgb: vec![[90; 3]; size.pixels()] };
        let mut moved = Picture { size, rgb: still.rgb.clone() };
        for (x, y) in [(41, 25), (50, 30)] {
            moved.rgb[y * 64 + x] = [0, 200, 90];
        }
        let part = liveliest(&still, &moved, Size::new(16, 16));
        assert!((part.x..part.x + 16).contains(&41) && (part.x..part.x + 16).contains(&50));
        assert!((part.y..part.y + 16).contains(&25) && (part.y..part.y + 16).contains(&30));
    }

    #[test]
    fn differences_are_white_at_zero_and_of_two_colours() {
        assert_eq!(diverging(0.), RGBColor(255, 255, 255));
        let (darker, brighter) = (diverging(-1.), diverging(1.));
        assert!(darker.2 > darker.0 && brighter.0 > brighter.2);
    }
}
