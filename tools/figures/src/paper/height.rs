//! Fig. 5: the height H(t) = C + A·sin(θ(t) + α) of one pixel (eq. 1 and 7) with constant amplitude and 1/f noise on the
//! frequency; the full range, A = C = 127.5, and α = 0.

use super::{HALF_RANGE, axes, seconds};
use crate::{
    Failure,
    drawing::{self, BELOW, COLOURS, FAINT, LINE},
};
use plotters::prelude::*;
use std::path::Path;
use yurameki::noise::{
    Kind,
    drive::{Oscillator, Settings},
};

/// 30 s at 12 frames a second: 18 oscillations without noise, few enough to be told apart.
const FRAMES: u32 = 360;

pub(super) fn draw(path: &Path, seed: u64) -> Result<(), Failure> {
    drawing::draw(path, (1400, 460), |area| {
        let lines = [
            (Kind::Constant, "no noise", FAINT.stroke_width(LINE / 2)),
            (Kind::Filter, "1/f noise by digital filter", COLOURS[1].stroke_width(LINE)),
        ];
        let below = drawing::legend_row(area, lines.map(|(_, words, style)| (words.to_owned(), style)))?;
        let levels = (0., 2. * HALF_RANGE);
        let mut chart = axes(&below, seconds(FRAMES), levels, ("time t (s)", "H(t) (levels)"), BELOW)?;
        for (kind, _, style) in lines {
            chart.draw_series(LineSeries::new(height(kind, seed), style))?;
        }
        Ok(())
    })
}

/// The times in seconds and the heights in luma levels.
fn height(kind: Kind, seed: u64) -> impl Iterator<Item = (f64, f64)> {
    let settings = Settings { amplitude: Kind::Constant, frequency: kind, ..Settings::default() };
    let mut oscillator = Oscillator::new(settings, seed);
    (0..=FRAMES).map(move |t| {
        let drive = oscillator.step();
        let swing = drive.amplitude.to_num::<f64>() * drive.phase.sin().to_num::<f64>();
        (seconds(t), HALF_RANGE * (1. + swing))
    })
}
