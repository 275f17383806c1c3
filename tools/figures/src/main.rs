//! # Yurameki's figures
//!
//! Draws the figures of Yamamoto and Sakamoto's paper ("the paper", see the library's `effect::shimmer`) from what the library
//! makes today, measures the noises, and makes and rates the clips of the paper's experiment. A tool for the PC: nothing here
//! reaches the frame, and it uses the library's public interface only.
//!
//! | command | what of the paper |
//! |---|---|
//! | `paper` | Fig. 3, 4, 5 |
//! | `spectra` | the spectra that section 3.1 defines the noises by |
//! | `clips` | the films of section 4.3 (Fig. 6) |
//! | `rating` | Tables 1 and 2 |
//! | `autumn-figures` | Fig. 5, 6, 8, 11, 13 to 17 of Mochizuki, Horie and Cai (see `effect::autumn`) |
//! | `no-repeat` | – (that no noise repeats itself) |
//! | `kaleidoscope` | – (coder, likeness, motion and cost of the other effect, see `effect::kaleidoscope`) |

mod autumn;
mod autumn_measures;
mod clips;
mod drawing;
mod film;
mod kaleidoscope;
mod no_repeat;
mod paper;
mod rating;
mod spectra;
mod spectrum;

use clap::{Parser, Subcommand};
use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Why a command ended early, as one line for people.
type Failure = Box<dyn Error>;

/// Draws the figures of the paper that Yurameki follows, measures its noises, and makes and rates clips.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Args {
    /// What to do.
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Draw Fig. 3 (two frames and their difference), Fig. 4 (A(t)) and Fig. 5 (H(t)).
    ///
    /// Fig. 3 shows the photo with 1/f noise by filter on amplitude and frequency, unless others are named, and with the paper's
    /// full range, unless another is. Of all options but --seed, Fig. 4 and 5 take no notice: they show what the paper's do.
    Paper(paper::Args),
    /// Draw the power spectrum of every noise with its fitted line, and print the slopes.
    Spectra(spectra::Args),
    /// Make the clips of Table 2: noiseless, grey, noisy, grey, twice.
    ///
    /// The photo moves over the paper's full range, unless another --range or --preset is named.
    Clips(clips::Args),
    /// Write rating sheets for the clips, and sum up filled ones.
    #[command(subcommand)]
    Rating(rating::Command),
    /// Draw Fig. 5, 6, 8, 11 and 13 to 17 of the paper on autumn colours, and print its measures with what must hold of them.
    AutumnFigures(autumn::Args),
    /// Check that a noise never repeats 256 frames within 2^N.
    NoRepeat(no_repeat::Args),
    /// Measure the kaleidoscope: its coder, its pictures, their motion and what they cost.
    Kaleidoscope(kaleidoscope::Args),
}

/// Where pictures and clips go.
#[derive(Debug, clap::Args)]
struct Out {
    /// The folder to write to; made where it is missing.
    #[arg(long = "out", value_name = "DIR")]
    folder: PathBuf,
}

impl Out {
    /// Makes the folder.
    fn create(&self) -> Result<&Path, Failure> {
        fs::create_dir_all(&self.folder).map_err(|error| {
            format!("{}: {error}; name a folder that can be written", self.folder.display())
        })?;
        Ok(&self.folder)
    }
}

/// Exit codes: 0 done, 1 failed, 2 asked for what cannot be (by clap).
fn main() -> ExitCode {
    let done = match Args::parse().command {
        Command::Paper(args) => paper::draw(&args),
        Command::Spectra(args) => spectra::draw(&args),
        Command::Clips(args) => clips::make(&args),
        Command::Rating(command) => rating::execute(&command),
        Command::AutumnFigures(args) => autumn::draw_figures(&args),
        Command::NoRepeat(args) => no_repeat::check(&args),
        Command::Kaleidoscope(args) => kaleidoscope::measure(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => match failure.downcast::<clap::Error>() {
            Ok(usage) => usage.exit(),
            Err(failure) => {
                eprintln!("yurameki-figures: {failure}");
                ExitCode::FAILURE
            }
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }
}
