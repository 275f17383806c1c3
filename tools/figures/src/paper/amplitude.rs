//! Fig. 4: the amplitude A(t) = A0·X_A(t) over time, for A0 = 127.5.

use super::{HALF_RANGE, axes, seconds};
use crate::{
    Failure,
    drawing::{self, BELOW, COLOURS, FAINT, LINE, TEXT, TITLE, text},
};
use plotters::prelude::*;
use std::path::Path;
use yurameki::noise::{
    Kind,
    drive::{Oscillator, Settings},
};

/// A minute at 12 frames a second: three oscillations of the response's memory would hide what brown noise does.
const FRAMES: u32 = 720;

const PANELS: [(Kind, &str); 4] = [
    (Kind::White, "(a) white noise"),
    (Kind::Filter, "(b) 1/f noise by digital filter"),
    (Kind::Brown, "(c) 1/f² noise (brown)"),
    (Kind::Constant, "(d) no noise"),
];

pub(super) fn draw(path: &Path, seed: u64) -> Result<(), Failure> {
    drawing::draw(path, (1400, 1180), |area| {
        // The last panel has the axis of time below it.
        let (_, height) = area.dim_in_pixel();
        let panel = (height - BELOW + TEXT) / PANELS.len() as u32;
        let mut rest = area.margin(TEXT / 2, 0, 0, 0);
        for (i, (kind, title)) in PANELS.into_iter().enumerate() {
            let is_last = i + 1 == PANELS.len();
            let (this, after) = rest.split_vertically(if is_last { rest.dim_in_pixel().1 } else { panel });
            rest = after;
            let this = this.titled(title, text(TITLE))?;
            let (below, word) = if is_last { (BELOW, "time t (s)") } else { (TEXT * 3 / 2, "") };
            let mut chart = axes(&this, seconds(FRAMES), (0., 150.), (word, "A(t) (levels)"), below)?;
            let whole = [0, FRAMES].map(|t| (seconds(t), HALF_RANGE));
            chart.draw_series(LineSeries::new(whole, FAINT.stroke_width(LINE / 2)))?;
            let line = ShapeStyle::from(COLOURS[1]).stroke_width(LINE);
            chart.draw_series(LineSeries::new(amplitude(kind, seed), line))?;
        }
        Ok(())
    })
}

/// The times in seconds and the amplitudes in luma levels.
fn amplitude(kind: Kind, seed: u64) -> impl Iterator<Item = (f64, f64)> {
    let settings = Settings { amplitude: kind, frequency: Kind::Constant, ..Settings::default() };
    let mut oscillator = Oscillator::new(settings, seed);
    (0..=FRAMES).map(move |t| (seconds(t), HALF_RANGE * oscillator.step().amplitude.to_num::<f64>()))
}
