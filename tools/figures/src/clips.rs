//! `clips`: the films that people compared in the paper's section 4.3.
//!
//! Every combination of an amplitude's and a frequency's noise, but the noiseless one, against the noiseless film, in the order
//! of Fig. 6: noiseless for 10 s, grey for 3 s, noisy for 10 s, grey for 3 s; all that twice.

use crate::{
    Failure, Out,
    film::{Film, Showing, Subject},
};
use clap::{ValueEnum, error::ErrorKind};
use std::path::Path;
use yurameki::{
    config::{DEFAULT_FRAMES_PER_SECOND, Life},
    frame::{FrameRef, Layout, PixelFormat, Size},
    noise::{Kind, drive},
    os::{
        interrupt::Interrupt,
        output::{FrameRate, Target, Writer},
        progress::Progress,
    },
};

/// Arguments of `clips`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    out: Out,
    /// The kind of file.
    #[arg(long, value_name = "FORMAT", default_value = "gif")]
    format: Format,
    /// Make one combination only, like brown/brown. --amplitude and --frequency alone choose a row or a column of Table 2.
    #[arg(long, value_name = "AMPLITUDE/FREQUENCY", value_parser = cell, conflicts_with_all = ["amplitude", "frequency"])]
    only: Option<Cell>,
    /// Both at once, noiseless on the left and noisy on the right, instead of one after the other.
    #[arg(long)]
    side_by_side: bool,
    /// How long each showing lasts.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=600))]
    seconds: u32,
    #[command(flatten)]
    subject: Subject,
}

impl Args {
    /// The combinations asked for.
    ///
    /// # Errors
    /// None is left: a [`clap::Error`].
    fn cells(&self) -> Result<Vec<Cell>, clap::Error> {
        if let Some(cell) = self.only {
            return Ok(vec![cell]);
        }
        let look = &self.subject.look;
        let wanted = |kind: Option<Kind>| kind.map_or_else(|| Kind::CHOICES.to_vec(), |kind| vec![kind]);
        let cells = product(&wanted(look.amplitude), &wanted(look.frequency));
        if cells.is_empty() {
            Err(clap::Error::raw(ErrorKind::ValueValidation, IS_NOISELESS))
        } else {
            Ok(cells)
        }
    }
}

/// The kinds of file that hold a whole clip.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// GIF: 256 colours, dithered; about 60 MB a clip of the built-in photo.
    Gif,
    /// Lossless WebP: exact; about 250 MB.
    Webp,
    /// APNG: exact; about 280 MB.
    Apng,
    /// Y4M: raw YCbCr 4:4:4 for video encoders; about 510 MB.
    Y4m,
}

impl Format {
    const fn extension(self) -> &'static str {
        match self {
            Self::Webp => "webp",
            Self::Gif => "gif",
            Self::Apng => "apng",
            Self::Y4m => "y4m",
        }
    }
}

/// A cell of Table 2: the noises of the amplitude and of the frequency.
type Cell = (Kind, Kind);

/// The cell in which nothing is noisy: what all others are compared with.
const NOISELESS: Cell = (Kind::Constant, Kind::Constant);

const IS_NOISELESS: &str = "constant/constant is the noiseless film itself; name another combination\n";

/// The cells that were judged, row by row: all 25 but the noiseless one.
pub(crate) fn cells() -> Vec<Cell> {
    product(&Kind::CHOICES, &Kind::CHOICES)
}

/// All cells in these rows and columns but the noiseless one.
fn product(amplitudes: &[Kind], frequencies: &[Kind]) -> Vec<Cell> {
    let row = |&amplitude: &Kind| frequencies.iter().map(move |&frequency| (amplitude, frequency));
    amplitudes.iter().flat_map(row).filter(|&cell| cell != NOISELESS).collect()
}

fn cell(words: &str) -> Result<Cell, String> {
    let (amplitude, frequency) =
        words.split_once('/').ok_or("a combination is AMPLITUDE/FREQUENCY, like brown/brown")?;
    let kind = |word: &str| word.parse().map_err(|error| format!("{word}: {error}"));
    let cell = (kind(amplitude)?, kind(frequency)?);
    if cell == NOISELESS { Err(IS_NOISELESS.into()) } else { Ok(cell) }
}

/// What is seen in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// The photo, driven by the noises of a cell.
    Film(Cell),
    /// Nothing.
    Grey,
    /// The noiseless film on the left, that of a cell on the right.
    Both(Cell),
}

/// How long the eye rests.
const GREY_SECONDS: u32 = 3;

/// The grey that is shown then, of every channel: the middle of the sRGB scale.
const GREY: u8 = 128;

/// The columns of grey between two films that run side by side.
const GAP: u32 = 16;

/// The parts of a clip, with their seconds.
fn parts(cell: Cell, args: &Args) -> Vec<(Part, u32)> {
    if args.side_by_side {
        return vec![(Part::Both(cell), args.seconds)];
    }
    let grey = (Part::Grey, GREY_SECONDS);
    [(Part::Film(NOISELESS), args.seconds), grey, (Part::Film(cell), args.seconds), grey].repeat(2)
}

/// Makes the clips.
pub(crate) fn make(args: &Args) -> Result<(), Failure> {
    let interrupt = Interrupt::install()?;
    let folder = args.out.create()?;
    let scene = args.subject.load()?;
    let life = args.subject.life();
    let mut storage = Film::storage(args.subject.size);
    let mut film = Film::new(&scene, &life, &mut storage)?;
    let cells = args.cells()?;
    let frames = |cell| parts(cell, args).iter().map(|part| part.1).sum::<u32>() * DEFAULT_FRAMES_PER_SECOND;
    let progress = Progress::new(cells.iter().map(|&cell| frames(cell)).sum(), false);
    for cell in cells {
        let name = format!("{}-{}.{}", cell.0, cell.1, args.format.extension());
        let path = folder.join(name);
        let mut clip = Clip::create(&path, &film, &life, frames(cell), args)?;
        for (part, seconds) in parts(cell, args) {
            clip.play(&mut film, part, seconds * DEFAULT_FRAMES_PER_SECOND, || {
                progress.frame_done();
                interrupt.requested()
            })?;
        }
        clip.writer.finish()?;
        println!("{}", path.display());
    }
    Ok(())
}

/// A clip being written.
struct Clip {
    writer: Writer,
    drive: drive::Settings,
    seed: u64,
    layout: Layout,
    /// A frame being put together.
    rgb: Vec<u8>,
}

impl Clip {
    fn create(path: &Path, film: &Film<'_>, life: &Life, frames: u32, args: &Args) -> Result<Self, Failure> {
        let mut size = film.layout().size;
        if args.side_by_side {
            size = Size::new(2 * size.width + GAP, size.height);
        }
        let layout = Layout::new(size, PixelFormat::Bgr888, None)?;
        let rate = FrameRate::new(DEFAULT_FRAMES_PER_SECOND, 1).ok_or("12 frames a second is no rate")?;
        let writer = Writer::create(&Target::parse(path.as_os_str())?, size, rate, frames)?;
        let rgb = vec![GREY; layout.len_bytes()];
        Ok(Self { writer, drive: life.drive, seed: args.subject.seed(), layout, rgb })
    }

    /// Writes the frames of a part; `done` is told of each, and says whether to stop.
    fn play(
        &mut self,
        film: &mut Film<'_>,
        part: Part,
        frames: u32,
        mut done: impl FnMut() -> bool,
    ) -> Result<(), Failure> {
        let cells = match part {
            Part::Grey => vec![],
            Part::Film(cell) => vec![cell],
            Part::Both(cell) => vec![NOISELESS, cell],
        };
        let showing = |(amplitude, frequency)| {
            Showing::new(film, drive::Settings { amplitude, frequency, ..self.drive }, self.seed)
        };
        let mut showings = cells.into_iter().map(showing).collect::<Result<Vec<_>, _>>()?;
        self.rgb.fill(GREY);
        for _ in 0..frames {
            for (i, showing) in showings.iter_mut().enumerate() {
                let frame = showing.frame(film)?;
                let left = i * (frame.layout().size.width + GAP) as usize * 3;
                for (row, into) in frame.rows().zip(self.rgb.chunks_exact_mut(self.layout.stride_bytes)) {
                    into[left..left + row.len()].copy_from_slice(row);
                }
            }
            self.writer.write(FrameRef::new(&self.rgb, self.layout)?)?;
            if done() {
                return Err("stopped; of the clip being written nothing was kept".into());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Words {
        #[command(flatten)]
        args: Args,
    }

    fn args(words: &[&str]) -> Result<Args, clap::Error> {
        let words = ["clips", "--out", "unused"].into_iter().chain(words.iter().copied());
        Words::try_parse_from(words).map(|words| words.args)
    }

    #[test]
    fn table_2_has_24_cells() {
        assert_eq!(cells().len(), 24);
        assert_eq!(cells()[0], (Kind::Constant, Kind::White));
    }

    #[test]
    fn a_clip_has_the_order_of_figure_6() {
        let cell = (Kind::Brown, Kind::Brown);
        let (still, grey, noisy) = ((Part::Film(NOISELESS), 10), (Part::Grey, 3), (Part::Film(cell), 10));
        let order = [still, grey, noisy, grey, still, grey, noisy, grey];
        assert_eq!(parts(cell, &args(&[]).unwrap()), order);
        assert_eq!(parts(cell, &args(&["--side-by-side"]).unwrap()), [(Part::Both(cell), 10)]);
    }

    #[test]
    fn a_cell_that_is_none_is_refused_by_name() {
        assert_eq!(cell("filter/constant"), Ok((Kind::Filter, Kind::Constant)));
        for (words, complaint) in [
            ("brown", "like brown/brown"),
            ("brown/pink", "pink: unknown noise"),
            ("constant/constant", "the noiseless film itself"),
        ] {
            let error = args(&["--only", words]).unwrap_err().to_string();
            assert!(error.contains(complaint), "{error}");
        }
    }

    #[test]
    fn a_row_or_a_column_can_be_asked_for() {
        let cells = |words: &[&str]| args(words).unwrap().cells();
        assert_eq!(cells(&["--amplitude", "brown"]).unwrap().len(), 5);
        assert_eq!(cells(&["--frequency", "constant"]).unwrap().len(), 4);
        assert_eq!(cells(&["--amplitude", "hosoda"]).unwrap().len(), 5);
        assert!(cells(&["--amplitude", "constant", "--frequency", "constant"]).is_err());
    }

    #[test]
    fn a_clip_and_its_side_by_side_form_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_string_lossy();
        let words = ["--size", "48x32", "--seconds", "1", "--only", "filter/brown", "--format", "gif"];
        for more in [&[][..], &["--side-by-side"]] {
            let mut args = args(&[&words[..], more].concat()).unwrap();
            args.out.folder = out.as_ref().into();
            make(&args).unwrap();
            let bytes = std::fs::read(folder.path().join("filter-brown.gif")).unwrap();
            let width = if more.is_empty() { 48 } else { 48 * 2 + GAP as u8 };
            assert_eq!((&bytes[..6], bytes[6]), (&b"GIF89a"[..], width));
        }
    }
}
