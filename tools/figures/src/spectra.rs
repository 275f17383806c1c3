//! `spectra`: the power spectrum of every noise, with the line that is fitted to it.

use crate::{
    Failure, Out,
    drawing::{self, Area, BELOW, COLOURS, FAINT, GRID, LEFT, LINE, TEXT, TITLE, text},
    spectrum::{BAND, LOG2_SEGMENT, Line, Point, Spectrum},
};
use plotters::{chart::ChartContext, coord::combinators::LogCoord, prelude::*};
use std::{f64::consts::TAU, iter, ops::Range, path::Path};
use yurameki::{
    math::random::{Stream, stream},
    noise::{
        Generator, Kind,
        brown::{Brown, USUAL_LEAK},
    },
};

/// Arguments of `spectra`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    out: Out,
    /// Estimate from 2^N frames, 16 to 26.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(i64::from(LOG2_SEGMENT)..=26))]
    log2_steps: u32,
    /// The seed of the noises.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

/// A noise and what was measured of it.
struct Measured {
    name: String,
    found: Found,
}

enum Found {
    /// Power in the whole band.
    Noise { spectrum: Spectrum, line: Line },
    /// The same sample again and again from a frame on.
    Still(usize),
}

impl Measured {
    /// Measures what `step` makes.
    fn new(name: &str, log2_steps: u32, mut step: impl FnMut() -> f64) -> Result<Self, Failure> {
        let mut samples: Vec<f64> = (0..1_u64 << log2_steps).map(|_| step()).collect();
        let found = match still_from(&samples) {
            Some(frame) => Found::Still(frame),
            None => {
                // Hann's window lets a mean far from zero leak into the band.
                let mean = samples.iter().sum::<f64>() / samples.len() as f64;
                samples.iter_mut().for_each(|sample| *sample -= mean);
                let spectrum = Spectrum::of(&samples, LOG2_SEGMENT).ok_or("too few frames for a spectrum")?;
                let line = Line::through(&spectrum.decades(BAND));
                let line = line.ok_or_else(|| format!("{name}: no power in the band"))?;
                Found::Noise { spectrum, line }
            }
        };
        Ok(Self { name: name.to_owned(), found })
    }

    fn of_kind(kind: Kind, args: &Args) -> Result<Self, Failure> {
        let mut generator = Generator::new(kind, stream(args.seed, Stream::Amplitude));
        Self::new(kind.name(), args.log2_steps, || generator.step().to_num())
    }

    /// Brown noise with so slow a leak that the whole band lies above it.
    fn of_slow_brown(args: &Args) -> Result<Self, Failure> {
        let mut rng = stream(args.seed, Stream::Amplitude);
        let mut brown = Brown::<15>::new(&mut rng);
        Self::new("brown-leak-15", args.log2_steps, || brown.step(&mut rng).to_num())
    }

    fn row(&self) -> String {
        let rest = match &self.found {
            Found::Noise { line, .. } => format!("{:>7.4} {:>13.2}", line.slope, line.residual),
            Found::Still(frame) => format!("{:>7} {:>13}  still from frame {frame} on", "–", "–"),
        };
        format!("{:<14} {rest}", self.name)
    }
}

/// From where on the samples no longer change, if that is so for at least half of them.
fn still_from(samples: &[f64]) -> Option<usize> {
    let last = samples.last()?;
    let frame = samples.iter().rposition(|sample| sample != last).map_or(0, |changed| changed + 1);
    (frame <= samples.len() / 2).then_some(frame)
}

/// Measures every noise, prints the slopes and draws the spectra.
pub(crate) fn draw(args: &Args) -> Result<(), Failure> {
    let folder = args.out.create()?;
    let mut all = Vec::new();
    println!("{:<14} {:>7} {:>13}", "kind", "slope", "residual (dB)");
    let kinds = Kind::ALL.into_iter().map(|kind| Measured::of_kind(kind, args));
    for measured in kinds.chain(iter::once_with(|| Measured::of_slow_brown(args))) {
        let Measured { name, found } = {
            let measured = measured?;
            println!("{}", measured.row());
            measured
        };
        if let Found::Noise { spectrum, line } = found {
            all.push((name, spectrum, line));
        }
    }
    println!(
        "brown is flat below {:.1e} cycles a frame, for it forgets within 2^{USUAL_LEAK} frames; \
         brown-leak-15 is the same with 2^15",
        1. / (TAU * f64::from(1_u32 << USUAL_LEAK))
    );
    for (name, spectrum, line) in &all {
        draw_one(&folder.join(format!("spectrum-{name}.png")), name, spectrum, line)?;
    }
    draw_all(&folder.join("spectra.png"), &all)
}

/// The frequencies that are shown, in cycles a frame.
const SHOWN: (f64, f64) = (2e-5, 0.5);

fn draw_one(path: &Path, name: &str, spectrum: &Spectrum, line: &Line) -> Result<(), Failure> {
    drawing::draw(path, (1000, 700), |area| {
        let fine: Vec<Point> = spectrum.fine().filter(|point| point.1 > 0.).collect();
        let mut chart = axes(area, name, densities(&fine))?;
        let style = ShapeStyle::from(FAINT.mix(0.5)).stroke_width(1);
        chart.draw_series(LineSeries::new(fine, style))?.label("Welch's estimate").legend(key(style));
        let dots = spectrum.decades(MEANS).into_iter();
        chart
            .draw_series(dots.map(|point| Circle::new(point, 2 * LINE, COLOURS[0].filled())))?
            .label("mean of a tenth of a decade")
            .legend(|(x, y)| Circle::new((x + TEXT as i32, y), 2 * LINE, COLOURS[0].filled()));
        let style = ShapeStyle::from(COLOURS[2]).stroke_width(LINE);
        let ends = [BAND.0, BAND.1].map(|frequency| (frequency, line.at(frequency)));
        chart
            .draw_series(LineSeries::new(ends, style))?
            .label(format!("1/f^β, β = {:.3}; rms {:.2} dB", line.slope, line.residual))
            .legend(key(style));
        legend(&mut chart)
    })
}

fn draw_all(path: &Path, all: &[(String, Spectrum, Line)]) -> Result<(), Failure> {
    drawing::draw(path, (1100, 900), |area| {
        let means: Vec<Vec<Point>> = all.iter().map(|(_, spectrum, _)| spectrum.decades(MEANS)).collect();
        let mut chart = axes(area, "All noises", densities(&means.concat()))?;
        for (((name, _, line), means), colour) in all.iter().zip(means).zip(COLOURS) {
            let style = ShapeStyle::from(colour).stroke_width(LINE);
            let label = format!("{name}, β = {:.3}", line.slope);
            chart.draw_series(LineSeries::new(means, style))?.label(label).legend(key(style));
        }
        legend(&mut chart)
    })
}

/// Where means are shown, in cycles a frame.
const MEANS: (f64, f64) = (1e-4, 0.5);

/// The range of the densities of `points`, with a little room.
fn densities(points: &[Point]) -> Range<f64> {
    let densities = points.iter().map(|point| point.1);
    let (least, most) = densities.fold((f64::MAX, 0_f64), |(a, b), y| (a.min(y), b.max(y)));
    least / 2. ..most * 2.
}

type Chart<'a, 'b> = ChartContext<'a, BitMapBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

fn axes<'a, 'b>(area: &'a Area<'b>, title: &str, densities: Range<f64>) -> Result<Chart<'a, 'b>, Failure> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, text(TITLE))
        .margin(TEXT / 2)
        .margin_right(TEXT)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, BELOW)
        .build_cartesian_2d((SHOWN.0..SHOWN.1).log_scale(), densities.log_scale())?;
    chart
        .configure_mesh()
        .x_desc("frequency f (cycles/frame; × 12 for Hz at 12 frames/s)")
        .y_desc("power density S(f) ((cycles/frame)⁻¹)")
        .x_label_formatter(&|x| power_of_ten(*x))
        .y_label_formatter(&|y| power_of_ten(*y))
        .label_style(text(TEXT))
        .axis_desc_style(text(TEXT))
        .axis_style(FAINT)
        .bold_line_style(GRID)
        .light_line_style(WHITE)
        .draw()?;
    Ok(chart)
}

fn legend<'a, 'b: 'a>(chart: &mut Chart<'a, 'b>) -> Result<(), Failure> {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .legend_area_size(TEXT * 5 / 2)
        .margin(TEXT / 2)
        .label_font(text(TEXT))
        .background_style(WHITE.mix(0.9))
        .border_style(FAINT)
        .draw()?;
    Ok(())
}

/// A short line for the legend.
fn key(style: ShapeStyle) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    move |(x, y)| PathElement::new([(x, y), (x + 2 * TEXT as i32, y)], style)
}

/// A power of ten as it is printed: 10⁻³; nothing for what lies between them.
fn power_of_ten(x: f64) -> String {
    let exponent = x.log10();
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    let digit = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
        other => other,
    };
    iter::once("10".to_owned()).chain([format!("{exponent:.0}").chars().map(digit).collect()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_are_printed_with_superscripts() {
        assert_eq!(power_of_ten(1e-3), "10⁻³");
        assert_eq!(power_of_ten(1e12), "10¹²");
        assert_eq!(power_of_ten(1e40), "10⁴⁰");
        assert_eq!(power_of_ten(2e-3), "");
    }

    #[test]
    fn what_stops_is_told_from_what_goes_on() {
        assert_eq!(still_from(&[1., 1., 1., 1.]), Some(0));
        assert_eq!(still_from(&[2., 1., 1., 1.]), Some(1));
        assert_eq!(still_from(&[2., 1., 2., 1.]), None);
    }

    #[test]
    fn every_kind_is_measured_or_known_to_be_still() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args { out: Out { folder: folder.path().into() }, log2_steps: 16, seed: 1 };
        for kind in Kind::ALL {
            let still = matches!(Measured::of_kind(kind, &args).unwrap().found, Found::Still(_));
            assert_eq!(still, matches!(kind, Kind::Constant | Kind::ChaosLiteral), "{kind}");
        }
    }
}
