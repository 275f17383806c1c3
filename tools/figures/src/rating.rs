//! `rating`: the sheets on which people rate the clips, and what comes of them.

mod plot;
mod sheet;
mod summary;

use crate::{Failure, Out, drawing};
use std::{fs, path::PathBuf};
use summary::Summary;

/// Rating sheets.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Command {
    /// Write an empty sheet: one row a clip, and the five scores in words.
    Sheet {
        /// The sheet to write; a file that is there already is kept.
        #[arg(long = "out", value_name = "FILE.csv")]
        file: PathBuf,
        /// Who is going to rate.
        #[arg(long, value_name = "NAME", default_value = "")]
        rater: String,
    },
    /// Print and plot the mean score of every clip with its 95 % interval (Student's t), as in Table 2.
    Summary {
        /// Filled sheets.
        #[arg(required = true, value_name = "FILE.csv")]
        files: Vec<PathBuf>,
        /// Where the plot goes.
        #[command(flatten)]
        out: Out,
    },
}

/// Does what was asked for.
pub(crate) fn execute(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Sheet { file, rater } => {
            let text = sheet::empty(rater)?;
            let mut out = fs::File::create_new(file).map_err(|error| {
                format!("{}: {error}; name a new file in a folder that can be written", file.display())
            })?;
            std::io::Write::write_all(&mut out, &text)
                .map_err(|error| format!("{}: {error}; write to a place with room", file.display()))?;
            println!("{}", file.display());
        }
        Command::Summary { files, out } => {
            let mut ratings = Vec::new();
            for file in files {
                let name = file.display().to_string();
                let text = fs::read_to_string(file)
                    .map_err(|error| format!("{name}: {error}; name a rating sheet, a CSV file in UTF-8"))?;
                sheet::read(&name, &text, &mut ratings)?;
            }
            let summary = Summary::of(&ratings);
            print!("{summary}");
            let path = out.create()?.join("ratings.png");
            drawing::draw(&path, plot::SIZE, |area| plot::draw(area, &summary))?;
        }
    }
    Ok(())
}
