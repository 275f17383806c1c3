//! `autumn-figures`: the figures of Mochizuki, Horie and Cai's paper (see the library's `effect::autumn`), and its measures of section 4.

use crate::{
    Failure, Out,
    autumn_measures::{Class, Colour, Palette, dimension},
    drawing::{COLOURS, GRID, LEFT, LINE, TEXT, draw, legend_row, text},
};
use plotters::prelude::*;
use std::path::{Path, PathBuf};
use yurameki::{
    effect::{
        Effect, Paint,
        autumn::{Autumn, PLATE_CELLS, Plates, STAGES, Settings, Species, Stage, Tree, Turning, storage_len},
    },
    frame::{FrameMut, FrameRef, Layout, PixelFormat, Size},
    math::{Factor, Turns},
    noise::drive::Drive,
    os::{
        autumn,
        output::{FrameRate, Target, Writer},
        photo,
    },
};

/// Arguments of `autumn-figures`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    out: Out,
    /// The tree: a species by name, or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "maple")]
    tree: autumn::TreeChoice,
    /// Photos of a real tree through the season, in the order of their names, to be measured in the same way.
    #[arg(long, value_name = "DIR")]
    photos: Option<PathBuf>,
}

/// What is measured: the paper's pictures are no larger.
const MEASURED: Size = Size::new(1280, 960);
/// A picture of a sheet.
const CELL: Size = Size::new(640, 480);

/// Pictures with their foliage told apart.
struct Series {
    name: &'static str,
    width: usize,
    pictures: Vec<Vec<Colour>>,
    foliage: Vec<Vec<bool>>,
}

/// The measures of a series, a number a picture.
struct Measures {
    name: &'static str,
    entropy: Vec<f64>,
    /// By [`Class::ALL`].
    dimensions: [Vec<f64>; 3],
}

/// Draws the figures, and prints the table with what must hold.
pub(crate) fn draw_figures(args: &Args) -> Result<(), Failure> {
    let folder = args.out.create()?;
    let species = autumn::species(&args.tree).map_err(|error| error.to_string())?;
    pictures(folder, &species)?;
    let shifts = measure(&season(&species, "this method", Turning::Shifts)?);
    let together = measure(&season(&species, "uniform change", Turning::Together)?);
    let mut all = vec![shifts, together];
    if let Some(photos) = &args.photos {
        all.push(measure(&photographed(photos)?));
    }
    plot(&folder.join("fig14-entropy.png"), "entropy H", (0., 5.), &all, |m| &m.entropy)?;
    for (i, class) in Class::ALL.into_iter().enumerate() {
        let path = folder.join(format!("fig{}-{}.png", 15 + i, class.name()));
        plot(&path, &format!("fractal dimension, {}", class.name()), (0., 2.), &all, |m| &m.dimensions[i])?;
    }
    table(&all);
    verdicts(&all[0], &all[1])
}

/// The frame of a tree at a stage, in still air.
fn frame(autumn: &mut Autumn<Vec<u64>>, size: Size, stage: Factor) -> Result<Vec<Colour>, Failure> {
    autumn.set_stage(Stage::new(stage));
    let layout = Layout::new(size, PixelFormat::Bgr888, None)?;
    let mut bytes = vec![0; layout.len_bytes()];
    let still =
        Drive { amplitude: Factor::ZERO, frequency: Factor::ONE, phase: Turns(0), onset: Factor::ONE };
    autumn.render(still, Paint::Everything, &mut FrameMut::new(&mut bytes, layout)?);
    Ok(bytes.as_chunks::<3>().0.to_vec())
}

fn grown(
    species: &Species,
    plates: Option<&Plates>,
    settings: &Settings,
    size: Size,
) -> Result<Autumn<Vec<u64>>, Failure> {
    Ok(Autumn::prepare(size, Tree { species, plates }, settings, vec![0; storage_len(size)])?)
}

/// The seven stages of a tree that drops nothing: the paper leaves the fall out.
fn season(species: &Species, name: &'static str, turning: Turning) -> Result<Series, Failure> {
    let settings = Settings { turning, leaf_fall: false, ..Settings::default() };
    let mut autumn = grown(species, None, &settings, MEASURED)?;
    let foliage: Vec<bool> = autumn.foliage().collect();
    let stages = (0..STAGES).map(|stage| frame(&mut autumn, MEASURED, Factor::from_num(stage as i32)));
    let pictures: Vec<Vec<Colour>> = stages.collect::<Result<_, _>>()?;
    Ok(Series { name, width: MEASURED.width as usize, foliage: vec![foliage; pictures.len()], pictures })
}

/// Photos of one tree. Foliage is what has the hue of leaves and is no grey.
fn photographed(folder: &Path) -> Result<Series, Failure> {
    let paths = photo::list([folder])?;
    if paths.is_empty() {
        return Err(format!("{}: no photo is here; name a folder of photos", folder.display()).into());
    }
    let load = |path: &PathBuf| {
        photo::load(path, &photo::Options { fit: photo::Fit::Fill, ..photo::Options::new(MEASURED) })
    };
    let photos = paths.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    let pictures: Vec<Vec<Colour>> =
        photos.iter().map(|photo| photo.rgb.as_chunks::<3>().0.to_vec()).collect();
    let is_leaf = |colour: &Colour| {
        let (most, least) = (colour.iter().max().copied(), colour.iter().min().copied());
        let spread = most.zip(least).map_or(0, |(most, least)| most - least);
        spread > 24 && Class::of(*colour).is_some()
    };
    let foliage = pictures.iter().map(|picture| picture.iter().map(is_leaf).collect()).collect();
    Ok(Series { name: "photos", width: MEASURED.width as usize, pictures, foliage })
}

/// One pixel in so many goes into the sample that the palette is found on.
const SAMPLED: usize = 97;

fn measure(series: &Series) -> Measures {
    let leaves: Vec<Vec<Colour>> = series
        .pictures
        .iter()
        .zip(&series.foliage)
        .map(|(picture, foliage)| {
            picture.iter().zip(foliage).filter(|(_, leaf)| **leaf).map(|(colour, _)| *colour).collect()
        })
        .collect();
    let sample: Vec<Colour> = leaves.iter().flatten().step_by(SAMPLED).copied().collect();
    let palette = Palette::of(&sample);
    let dimension_of = |class: Class| {
        let pictures = series.pictures.iter().zip(&series.foliage);
        let is_class = |(colour, leaf): (&Colour, &bool)| *leaf && Class::of(*colour) == Some(class);
        pictures
            .map(|(picture, foliage)| {
                dimension(&picture.iter().zip(foliage).map(is_class).collect::<Vec<_>>(), series.width)
            })
            .collect()
    };
    Measures {
        name: series.name,
        entropy: leaves.iter().map(|leaves| palette.entropy(leaves)).collect(),
        dimensions: Class::ALL.map(dimension_of),
    }
}

fn table(all: &[Measures]) {
    for measures in all {
        let row = |what: &str, values: &[f64]| {
            let values: Vec<String> = values.iter().map(|value| format!("{value:5.2}")).collect();
            println!("{:<15} {what:<9} {}", measures.name, values.join(" "));
        };
        row("H", &measures.entropy);
        for (class, values) in Class::ALL.into_iter().zip(&measures.dimensions) {
            row(&format!("D {}", class.name()), values);
        }
    }
}

/// What must hold of the paper's figures 14 to 17, as far as it makes sense for the colour that the leaves of this tree end in.
fn verdicts(shifts: &Measures, together: &Measures) -> Result<(), Failure> {
    let h = &shifts.entropy;
    let [green, yellow, red] = &shifts.dimensions;
    let largest =
        |values: &[f64]| values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i);
    let spread = |values: &[f64]| {
        values.iter().copied().fold(f64::MIN, f64::max) - values.iter().copied().fold(f64::MAX, f64::min)
    };
    let peak = largest(h);
    let uniform = ("H of uniform change differs by 0.5 at the most", spread(&together.entropy) <= 0.5);
    let last = last_colour(together);
    println!("its leaves end {}", last.name());
    let mut rows = match last {
        Class::Green => {
            vec![("H and D of green stay as they are", spread(h) <= 0.05 && spread(green) <= 0.05)]
        }
        Class::Yellow | Class::Red => vec![
            ("H is largest at stage 3 or 4", (3..=4).contains(&peak)),
            ("and there at least 1.0 above both ends", h[peak] - h[0].max(h[STAGES - 1]) >= 1.),
            ("D of green falls from stage to stage", green.windows(2).all(|pair| pair[0] > pair[1])),
        ],
    };
    rows.push(uniform);
    if last == Class::Red {
        rows.push(("D of yellow is largest at stage 2 to 4", (2..=4).contains(&largest(yellow))));
        rows.push(("D of red rises by 0.15 or more from stage 3 to 5", red[5] - red[3] >= 0.15));
    }
    for (words, holds) in &rows {
        println!("{} {words}", if *holds { "holds:" } else { "FAILS:" });
    }
    match rows.iter().all(|(_, holds)| *holds) {
        true => Ok(()),
        false => Err("not all that must hold of an autumn holds".into()),
    }
}

/// The colour that leaves of one colour have at the last stage: that of their pigments, whatever makes them turn.
fn last_colour(together: &Measures) -> Class {
    let last =
        Class::ALL.into_iter().zip(&together.dimensions).map(|(class, values)| (class, values[STAGES - 1]));
    last.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(Class::Green, |(class, _)| class)
}

fn plot(
    path: &Path,
    what: &str,
    range: (f64, f64),
    all: &[Measures],
    of: impl Fn(&Measures) -> &Vec<f64>,
) -> Result<(), Failure> {
    draw(path, (900, 600), |area| {
        let entries =
            all.iter().zip(COLOURS).map(|(m, colour)| (m.name.to_owned(), colour.stroke_width(LINE)));
        let below = legend_row(area, entries)?;
        let mut chart = ChartBuilder::on(&below)
            .margin(TEXT)
            .set_label_area_size(LabelAreaPosition::Left, LEFT)
            .set_label_area_size(LabelAreaPosition::Bottom, LEFT)
            .build_cartesian_2d(0. ..6_f64, range.0..range.1)?;
        chart
            .configure_mesh()
            .x_desc("stage")
            .y_desc(what)
            .x_labels(7)
            .label_style(text(TEXT))
            .bold_line_style(GRID)
            .light_line_style(WHITE)
            .draw()?;
        for (measures, colour) in all.iter().zip(COLOURS) {
            let values = of(measures);
            // However many pictures there are, they span the season.
            let step = 6. / (values.len().max(2) - 1) as f64;
            let points = values.iter().enumerate().map(|(i, &value)| (i as f64 * step, value));
            chart.draw_series(LineSeries::new(points, colour.stroke_width(LINE)))?;
        }
        Ok(())
    })
}

/// Figures 5, 6, 8, 11 and 13.
fn pictures(folder: &Path, species: &Species) -> Result<(), Failure> {
    let still = Settings { leaf_fall: false, ..Settings::default() };
    let turning = |turning| Settings { turning, ..still };
    let stages = |settings: Settings, stages: &[i32]| {
        let mut autumn = grown(species, None, &settings, CELL)?;
        stages
            .iter()
            .map(|&stage| frame(&mut autumn, CELL, Factor::from_num(stage)))
            .collect::<Result<Vec<_>, Failure>>()
    };
    // Of the mask, the later a leaf turns the darker it is: plates of grey show when.
    let greys: Box<Plates> = Box::new(std::array::from_fn(|stage| [[(stage * 42) as u8; 3]; PLATE_CELLS]));
    let mut mask = grown(species, Some(&greys), &turning(Turning::Sunlight), CELL)?;
    let mut fifth = vec![frame(&mut mask, CELL, Factor::from_num(4))?];
    fifth.extend(stages(turning(Turning::Sunlight), &[4])?);
    sheet(&folder.join("fig5-sunlight.png"), 2, &fifth)?;

    let unlit = stages(Settings { sun: None, ..still }, &[1, 2, 3, 4, 5])?;
    let lit = stages(still, &[1, 2, 3, 4, 5])?;
    let sixth: Vec<Vec<Colour>> =
        unlit.into_iter().zip(lit).flat_map(|(left, right)| [left, right]).collect();
    sheet(&folder.join("fig6-shifts.png"), 2, &sixth)?;

    sheet(&folder.join("fig8-leaf.png"), 4, &leaf(species)?)?;
    sheet(&folder.join("fig11-season.png"), 4, &stages(still, &[0, 1, 2, 3, 4, 5, 6])?)?;
    sheet(&folder.join("fig13-uniform.png"), 4, &stages(turning(Turning::Together), &[0, 1, 2, 3, 4, 5, 6])?)
}

/// One leaf in the seven stages.
fn leaf(species: &Species) -> Result<Vec<Vec<Colour>>, Failure> {
    let alone = species.one_leaf();
    let mut autumn =
        grown(&alone, None, &Settings { sun: None, leaf_fall: false, ..Settings::default() }, CELL)?;
    (0..STAGES).map(|stage| frame(&mut autumn, CELL, Factor::from_num(stage as i32))).collect()
}

/// Writes pictures of [`CELL`] side by side, `columns` a row.
fn sheet(path: &Path, columns: usize, pictures: &[Vec<Colour>]) -> Result<(), Failure> {
    let rows = pictures.len().div_ceil(columns);
    let (width, height) = (CELL.width as usize, CELL.height as usize);
    let mut all = vec![[255; 3]; columns * width * rows * height];
    for (i, picture) in pictures.iter().enumerate() {
        let (left, top) = (i % columns * width, i / columns * height);
        for (y, row) in picture.chunks_exact(width).enumerate() {
            all[(top + y) * columns * width + left..][..width].copy_from_slice(row);
        }
    }
    let size = Size::new((columns * width) as u32, (rows * height) as u32);
    let once = FrameRate::new(1, 1).ok_or("one frame a second is no rate")?;
    let mut writer = Writer::create(&Target::parse(path.as_os_str())?, size, once, 1)?;
    writer.write(FrameRef::new(all.as_flattened(), Layout::new(size, PixelFormat::Bgr888, None)?)?)?;
    writer.finish()?;
    println!("{}", path.display());
    Ok(())
}
