//! `yurameki noise`: a noise as numbers, for people who check a slope with their own tools.

use super::{Failure, args, stdout::written};
use crate::{
    math::random::{Stream, stream},
    noise::{
        Generator, Kind,
        drive::{Oscillator, Settings},
    },
};
use std::io::{self, BufWriter, Write};

pub(super) fn noise(args: &args::Noise) -> Result<(), Failure> {
    written(print(args, BufWriter::new(io::stdout().lock())))
}

fn print(args: &args::Noise, mut out: impl Write) -> io::Result<()> {
    if args.raw {
        let mut generator = Generator::new(args.kind, stream(args.seed, Stream::Amplitude));
        for _ in 0..args.steps {
            writeln!(out, "{:.9}", generator.step().to_num::<f64>())?;
        }
    } else {
        let mut settings = Settings::default();
        match args.response {
            Some(frames) => (settings.amplitude, settings.response_frames) = (args.kind, frames),
            None => (settings.amplitude, settings.frequency) = (Kind::Constant, args.kind),
        }
        let mut oscillator = Oscillator::new(settings, args.seed);
        for _ in 0..args.steps {
            let drive = oscillator.step();
            let number = if args.response.is_some() { drive.amplitude } else { drive.frequency };
            writeln!(out, "{:.9}", number.to_num::<f64>())?;
        }
    }
    out.flush()
}
