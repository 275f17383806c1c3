//! What is written on the picture: what the photo is called, which noises drive it, and what they do.
//!
//! It stands in the lower left corner, as a person sees it, on the picture itself made darker: so it can be read on any photo.

mod canvas;
mod text;
mod trace;

pub(super) use trace::Trace;

use crate::{
    effect::paint,
    frame::{FrameMut, Rect, Rotation},
    math::Factor,
    noise::Kind,
};
use canvas::{Canvas, at};
use core::fmt::Write;
use embedded_graphics::{
    geometry::Size as Extent,
    pixelcolor::{Rgb888, RgbColor},
    primitives::Rectangle,
};
use heapless::String;

/// The share of its brightness that the picture keeps behind the text. White on it then has a contrast of at least 7 : 1 (WCAG 2.2).
const SHADE: Factor = Factor::from_bits(Factor::ONE.to_bits() / 10 * 3);

/// Cells around the box, and within it around the text.
const MARGIN: u32 = 6;

/// Cells of a line with a noise and its plot, and between the two.
const NOISE_LINE: u32 = trace::HEIGHT + 4;
const GAP: u32 = 12;

/// A plot of fewer columns tells nothing.
const FEWEST_COLUMNS: u32 = 24;

/// The colours of the amplitude and of the frequency, far from each other for the colour-blind too.
const COLOURS: [Rgb888; 2] = [Rgb888::new(255, 190, 80), Rgb888::new(120, 200, 255)];

/// What is to be written.
pub(super) struct Overlay<'a> {
    /// What the photo is called, a line or several.
    pub(super) caption: Option<&'a str>,
    pub(super) noises: (Kind, Kind),
    pub(super) trace: &'a Trace,
}

/// The name of a noise, with what it drives.
type Label = String<40>;

/// How wide labels are at the least, so that plots keep their place while noises change.
const USUAL_LABEL: &str = "amplitude  constant";

impl<'a> Overlay<'a> {
    /// Writes it into `frame`, of a panel that is mounted by `rotation`, after `darken` has painted the place that it takes anew,
    /// at a share of its brightness. Gives that place; none where there is no room for a line.
    pub(super) fn write(
        &self,
        frame: &mut FrameMut<'_>,
        rotation: Rotation,
        brightness: Factor,
        darken: impl FnOnce(Rect, Factor, &mut FrameMut<'_>),
    ) -> Option<Rect> {
        let canvas = Canvas::new(frame, rotation, brightness);
        let labels = self.labels();
        let plan = Plan::new(self, &labels, canvas.cells())?;
        let place = canvas.pixels(&plan.outer());
        darken(place, brightness * SHADE, frame);
        self.draw(&plan, &labels, &mut Canvas::new(frame, rotation, brightness));
        Some(place)
    }

    fn draw(&self, plan: &Plan, labels: &[Label; 2], canvas: &mut Canvas<'_, '_>) {
        let Plan { x, mut y, inner, .. } = *plan;
        for line in self.caption_lines().take(plan.lines) {
            text::draw(line, x, y, inner.width, Rgb888::WHITE, canvas);
            y += text::LINE;
        }
        let noises = labels.iter().zip(self.trace.curves()).zip(COLOURS);
        for ((label, curve), colour) in noises.take(plan.noises) {
            text::draw(label, x, y + (NOISE_LINE - text::LINE) / 2, inner.width, colour, canvas);
            let (left, top) = (x + plan.label_width + GAP, y + (NOISE_LINE - trace::HEIGHT) / 2);
            if plan.columns > 0 {
                trace::plot(curve, left, top, plan.columns, colour, canvas);
            }
            y += NOISE_LINE;
        }
    }

    fn caption_lines(&self) -> impl Iterator<Item = &'a str> {
        self.caption.into_iter().flat_map(str::lines)
    }

    fn labels(&self) -> [Label; 2] {
        [("amplitude", self.noises.0), ("frequency", self.noises.1)].map(|(driven, kind)| {
            let mut label = Label::new();
            // The longest name of a noise takes half of it.
            let _ = write!(label, "{driven}  {kind}");
            label
        })
    }
}

/// What there is room for, and where it stands, in cells.
struct Plan {
    /// The left end of the first line, and its top.
    x: u32,
    y: u32,
    /// What the lines take.
    inner: Extent,
    /// Lines of the caption.
    lines: usize,
    /// Lines with a noise.
    noises: usize,
    label_width: u32,
    /// Columns of a plot; none where there is no room for enough of them.
    columns: u32,
}

impl Plan {
    fn new(overlay: &Overlay<'_>, labels: &[Label], cells: Extent) -> Option<Self> {
        let room = Extent::new(cells.width.checked_sub(4 * MARGIN)?, cells.height.checked_sub(4 * MARGIN)?);
        let lines = overlay.caption_lines().count().min((room.height / text::LINE) as usize);
        let left = room.height - lines as u32 * text::LINE;
        let noises = labels.len().min((left / NOISE_LINE) as usize);
        let label_width =
            labels.iter().map(|label| text::width(label)).fold(text::width(USUAL_LABEL), u32::max);
        let columns = room.width.saturating_sub(label_width + GAP).min(trace::COLUMNS as u32);
        let columns = if columns < FEWEST_COLUMNS { 0 } else { columns };
        let widest = overlay.caption_lines().map(text::width).fold(label_width + GAP + columns, u32::max);
        let height = left.min(noises as u32 * NOISE_LINE) + lines as u32 * text::LINE;
        let inner = Extent::new(widest.min(room.width), height);
        let y = cells.height - 2 * MARGIN - height;
        (height > 0).then_some(Self { x: 2 * MARGIN, y, inner, lines, noises, label_width, columns })
    }

    /// The box around the lines.
    fn outer(&self) -> Rectangle {
        let size = Extent::new(self.inner.width + 2 * MARGIN, self.inner.height + 2 * MARGIN);
        Rectangle::new(at(self.x - MARGIN, self.y - MARGIN), size)
    }
}

/// Writes the lines of `message` into the middle of `frame`, on black.
pub(super) fn write_alone(message: &str, frame: &mut FrameMut<'_>, rotation: Rotation, brightness: Factor) {
    let whole = Rect::whole(frame.layout().size);
    paint::plain([0; 3], whole, brightness, frame);
    let mut canvas = Canvas::new(frame, rotation, brightness);
    let cells = canvas.cells();
    let room = cells.width.saturating_sub(2 * MARGIN);
    let height = message.lines().count() as u32 * text::LINE;
    let tops = (cells.height.saturating_sub(height) / 2..cells.height.saturating_sub(text::LINE))
        .step_by(text::LINE as usize);
    for (line, y) in message.lines().zip(tops) {
        let x = (cells.width - text::width(line).min(room)) / 2;
        text::draw(line, x, y, room, Rgb888::WHITE, &mut canvas);
    }
}
