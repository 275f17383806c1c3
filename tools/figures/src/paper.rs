//! `paper`: the figures of the paper's section 4.2.

mod amplitude;
mod frames;
mod height;

use crate::{
    Failure, Out,
    drawing::{Area, FAINT, GRID, LEFT, TEXT, text},
    film::Subject,
};
use plotters::{chart::ChartContext, coord::types::RangedCoordf64, prelude::*};
use yurameki::config::DEFAULT_FRAMES_PER_SECOND;

/// Arguments of `paper`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    out: Out,
    #[command(flatten)]
    subject: Subject,
}

/// A0 of Fig. 4, and the centre C of the full range, in luma levels.
const HALF_RANGE: f64 = 127.5;

/// Draws Fig. 3, 4 and 5.
pub(crate) fn draw(args: &Args) -> Result<(), Failure> {
    let folder = args.out.create()?;
    let seed = args.subject.seed();
    frames::draw(&folder.join("fig3-frames.png"), &args.subject)?;
    amplitude::draw(&folder.join("fig4-amplitude.png"), seed)?;
    height::draw(&folder.join("fig5-height.png"), seed)
}

/// The time of a frame in seconds.
fn seconds(frame: u32) -> f64 {
    f64::from(frame) / f64::from(DEFAULT_FRAMES_PER_SECOND)
}

type Chart<'a, 'b> = ChartContext<'a, BitMapBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Axes of time from 0 to `end` seconds and of luma levels; `below` is the room for the words at the axis of time.
fn axes<'a, 'b>(
    area: &'a Area<'b>,
    end: f64,
    levels: (f64, f64),
    words: (&str, &str),
    below: u32,
) -> Result<Chart<'a, 'b>, Failure> {
    let mut chart = ChartBuilder::on(area)
        .margin(TEXT / 2)
        .margin_right(TEXT)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, below)
        .build_cartesian_2d(0. ..end, levels.0..levels.1)?;
    chart
        .configure_mesh()
        .x_desc(words.0)
        .y_desc(words.1)
        .x_labels(13)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style(text(TEXT))
        .axis_desc_style(text(TEXT))
        .axis_style(FAINT)
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .draw()?;
    Ok(chart)
}
