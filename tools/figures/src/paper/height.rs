//! Fig. 5: the height H(t) = C + A·sin(θ(t) + α) of one pixel (eq. 1 and 7) with constant amplitude and 1/f noise on the
//! frequency; the full range, A = C = 127.5, and α = 0.

use super::{HALF_RANGE, axes, seconds};
use crate::{
    Failure,
    drawing::{self, BELOW, COLOURS, FAINT, LINE, TEXT, text},
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
        // Room for the legend above the curve.
        let levels = (0., 330.);
        let mut chart = axes(area, seconds(FRAMES), levels, ("time t (s)", "H(t) (levels)"), BELOW)?;
        let lines = [
            (Kind::Constant, "no noise", ShapeStyle::from(FAINT).stroke_width(LINE / 2)),
            (Kind::Filter, "1/f noise by digital filter", ShapeStyle::from(COLOURS[1]).stroke_width(LINE)),
        ];
        for (kind, label, line) in lines {
            chart
                .draw_series(LineSeries::new(height(kind, seed), line))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + TEXT as i32 * 2, y)], line));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(TEXT * 5 / 2)
            .margin(TEXT / 4)
            .label_font(text(TEXT))
            .background_style(WHITE.mix(0.9))
            .border_style(FAINT)
            .draw()?;
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
