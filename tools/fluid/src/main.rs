//! The command line: see `yurameki-fluid --help`.

use clap::Parser;
use std::process::ExitCode;
use yurameki_fluid::{
    args::{Args, Command},
    commands::{self, Failure},
};

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("yurameki-fluid: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), Failure> {
    match &args.command {
        Command::Index(args) => commands::index(args),
        Command::Merge(args) => commands::merge(args),
        Command::Stats(args) => commands::stats(args),
        Command::Check(args) => commands::check(args),
        Command::Animate(_) | Command::Evaluate(_) => {
            Err("this build has no labelling and rendering yet".into())
        }
    }
}
