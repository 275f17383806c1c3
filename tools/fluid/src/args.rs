//! The command line, as typed.

use crate::footage::Class;
use clap::{Parser, Subcommand, ValueEnum};
use std::{path::PathBuf, str::FromStr};

/// Brings water, fire and smoke of a picture to life with detail from a database of videos.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Take videos into a database, or, without videos, mend it and end what was broken off.
    Index(Index),
    /// Join databases that were indexed apart.
    Merge(Merge),
    /// Print what is in a database.
    Stats(Stats),
    /// Read a whole database for its checksums and print what is lost.
    Check(Check),
    /// Bring a picture to life and write it as a clip.
    Animate(Animate),
    /// Animate the first frames of videos that are not in the database, and compare with what they really do.
    Evaluate(Evaluate),
}

/// Options of `index`.
#[derive(Debug, clap::Args)]
pub struct Index {
    /// Video files, folders with video files, folders of frames.
    #[arg(value_name = "VIDEO|FOLDER")]
    pub videos: Vec<PathBuf>,
    /// The database's directory. It is made if it is not there.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
    /// What the videos show; otherwise the first word of a file's or its folder's name tells (water_, fire_, smoke_, clouds_), or else
    /// colour and texture.
    #[arg(long)]
    pub class: Option<ClassChoice>,
    /// Videos that are worked on at a time, about 300 MB each; as many as there are processors if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Take only every n-th video of the list, from the i-th on; `merge` joins the parts.
    #[arg(long, value_name = "I/N", requires = "videos")]
    pub shard: Option<Shard>,
    /// Seconds that are taken of a video, from its beginning.
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = positive)]
    pub seconds: f32,
    /// Frames a second of folders of frames.
    #[arg(long, value_name = "R", default_value_t = 25.0, value_parser = positive)]
    pub rate: f32,
    /// Take videos with a moving camera and looped ones too.
    #[arg(long)]
    pub force: bool,
    /// Use the vocabulary of another database and train none: for many shards, which then need no more work when they are merged.
    #[arg(long, value_name = "DB")]
    pub vocabulary: Option<PathBuf>,
}

/// Options of `merge`.
#[derive(Debug, clap::Args)]
pub struct Merge {
    /// The databases to join.
    #[arg(value_name = "DB", required = true)]
    pub parts: Vec<PathBuf>,
    /// The directory of the database that they are added to. It is made if it is not there.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
    /// Videos that are worked on at a time; as many as there are processors if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
}

/// Options of `stats`.
#[derive(Debug, clap::Args)]
pub struct Stats {
    /// The database's directory.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
}

/// Options of `check`.
#[derive(Debug, clap::Args)]
pub struct Check {
    /// The database's directory.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
}

/// Options of `animate`.
#[derive(Debug, clap::Args)]
pub struct Animate {
    /// The picture: a photo or a painting.
    #[arg(value_name = "PICTURE")]
    pub picture: PathBuf,
    /// The database's directory.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
    /// The clip to write.
    #[arg(long, value_name = "CLIP")]
    pub out: PathBuf,
    /// What the picture shows; guessed if not given.
    #[arg(long)]
    pub class: Option<ClassChoice>,
    /// A grey picture of the picture's size that is white where there is fluid, or `auto`.
    #[arg(long, value_name = "FILE|auto", default_value = "auto")]
    pub matte: PathBuf,
    /// Strokes along which the fluid flows.
    #[arg(long, value_name = "FILE.svg|FILE.json")]
    pub strokes: Option<PathBuf>,
    /// A grey picture of how fast the fluid is: black is still.
    #[arg(long, value_name = "FILE.png")]
    pub speed: Option<PathBuf>,
    /// How patches are given.
    #[arg(long, value_enum, default_value_t = SolverChoice::Trws)]
    pub solver: SolverChoice,
    /// Seconds of a round of the clip.
    #[arg(long, value_name = "N", default_value_t = 4.0, value_parser = positive)]
    pub seconds: f32,
    /// What is behind moving fire and smoke; otherwise it is painted in.
    #[arg(long, value_name = "FILE")]
    pub background: Option<PathBuf>,
    /// Write a picture of which patch was given where.
    #[arg(long, value_name = "FILE.png")]
    pub show_assignment: Option<PathBuf>,
    /// Write the map of directions that was understood.
    #[arg(long, value_name = "FILE.png")]
    pub show_direction: Option<PathBuf>,
    /// Write the map of speeds of the result, to be edited and given as --speed.
    #[arg(long, value_name = "FILE.png")]
    pub show_speed: Option<PathBuf>,
    /// Print the energies of all solvers, and the lower bound.
    #[arg(long)]
    pub energies: bool,
}

/// Options of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Evaluate {
    /// The database's directory.
    #[arg(long, value_name = "DIR")]
    pub db: PathBuf,
    /// How the full method gives patches.
    #[arg(long, value_enum, default_value_t = SolverChoice::Trws)]
    pub solver: SolverChoice,
    /// Videos; those that are in the database are left out of it for their turn.
    #[arg(long, value_name = "VIDEO", required = true, num_args = 1..)]
    pub truth: Vec<PathBuf>,
}

/// A class as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClassChoice {
    /// Rivers, falls, fountains, the sea.
    Water,
    /// Flames.
    Fire,
    /// Smoke, steam and clouds.
    Smoke,
}

impl From<ClassChoice> for Class {
    fn from(choice: ClassChoice) -> Self {
        match choice {
            ClassChoice::Water => Self::Water,
            ClassChoice::Fire => Self::Fire,
            ClassChoice::Smoke => Self::Smoke,
        }
    }
}

/// A solver as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SolverChoice {
    /// Sequential tree-reweighted message passing, then ICM.
    Trws,
    /// Alpha-expansion with graph cuts, as the paper has it.
    Expansion,
    /// Iterated conditional modes.
    Icm,
    /// The best patch for each place alone.
    Greedy,
}

/// One of several parts, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// Those of a list that are this part's.
    pub fn of<T>(self, list: Vec<T>) -> Vec<T> {
        list.into_iter().skip(self.index - 1).step_by(self.count).collect()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts =
            text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        match parts {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("two numbers like 3/8 are wanted, the first from 1 to the second".into()),
        }
    }
}

fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value > 0.0 && value <= 1000.0 => Ok(value),
        _ => Err("a number over 0 and up to 1000 is wanted".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shards_are_the_list() {
        let all: Vec<u8> = (0..23).collect();
        let mut joined: Vec<u8> = (1..=5)
            .flat_map(|index| format!("{index}/5").parse::<Shard>().unwrap().of(all.clone()))
            .collect();
        joined.sort_unstable();
        assert_eq!(joined, all);
        assert!(["0/5", "6/5", "1/0", "1", "a/b"].iter().all(|text| text.parse::<Shard>().is_err()));
    }

    #[test]
    fn the_command_line_is_in_order() {
        use clap::CommandFactory;
        Args::command().debug_assert();
        let parsed = Args::try_parse_from(["yurameki-fluid", "index", "--db", "d", "--seconds", "0", "v"]);
        assert!(parsed.is_err());
    }
}
