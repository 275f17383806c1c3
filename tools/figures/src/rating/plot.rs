//! The mean scores with their intervals, as a plot.

use super::summary::{Opinion, Summary};
use crate::{
    Failure,
    drawing::{self, Area, BELOW, COLOURS, FAINT, GRID, LEFT, LINE, TEXT, text},
};
use plotters::prelude::*;
use yurameki::noise::Kind;

/// Width and height in pixels.
pub(super) const SIZE: (u32, u32) = (1300, 640);

/// How far apart the five noises of the frequency stand within one of the amplitude, whose middles are 1 apart.
const STEP: f64 = 0.14;

/// Where intervals are cut: just beyond the scores 1 and 5.
const LOWEST: f64 = 0.8;
const HIGHEST: f64 = 5.2;

/// Draws a group of five for every noise of the amplitude, one colour a noise of the frequency.
pub(super) fn draw(area: &Area<'_>, summary: &Summary) -> Result<(), Failure> {
    let style = |colour: RGBColor| colour.stroke_width(LINE);
    let words = Kind::CHOICES.map(|kind| format!("frequency: {kind}"));
    let below = drawing::legend_row(area, words.into_iter().zip(COLOURS.map(style)))?;
    let mut chart = ChartBuilder::on(&below)
        .margin(TEXT / 2)
        .margin_right(TEXT)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW)
        .build_cartesian_2d(-0.5..4.5, LOWEST..HIGHEST)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(6)
        .y_labels(6)
        .x_desc("noise of the amplitude")
        .y_desc("mean score, 95 % interval")
        .x_label_formatter(&|x: &f64| {
            Kind::CHOICES.get(x.round() as usize).map_or("", |kind| kind.name()).to_owned()
        })
        .y_label_formatter(&|y: &f64| format!("{y:.0}"))
        .label_style(text(TEXT))
        .axis_desc_style(text(TEXT))
        .axis_style(FAINT)
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .draw()?;
    // 3: neither is more natural.
    let equal = [(-0.5, 3.), (4.5, 3.)];
    chart.draw_series(LineSeries::new(equal, FAINT.stroke_width(LINE)))?;
    for (column, colour) in COLOURS.into_iter().enumerate().take(Kind::CHOICES.len()) {
        let place = |row: usize| row as f64 + (column as f64 - 2.) * STEP;
        let opinions = summary.rows().enumerate();
        let opinions: Vec<(f64, Opinion)> =
            opinions.filter_map(|(row, (_, opinions))| Some((place(row), opinions[column]?))).collect();
        chart.draw_series(opinions.iter().filter_map(|&(x, Opinion { mean, half_width, .. })| {
            let half = half_width?;
            // No score lies beyond the scale, though an interval from few may.
            let (low, high) = ((mean - half).max(LOWEST), (mean + half).min(HIGHEST));
            Some(ErrorBar::new_vertical(x, low, mean, high, style(colour), 3 * LINE))
        }))?;
        let dots = opinions.iter().map(|&(x, opinion)| (x, opinion.mean));
        chart.draw_series(dots.map(|dot| Circle::new(dot, 2 * LINE, colour.filled())))?;
    }
    Ok(())
}
