//! Yurameki, the program: arguments in, an exit code out. What it does stands in [`yurameki::os`].

use clap::Parser;
use std::{
    io::{self, Write},
    process::ExitCode,
};

/// Exit codes: 0 done, 1 failed, 2 asked for what cannot be (by clap).
fn main() -> ExitCode {
    let args = yurameki::os::args::Args::parse();
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("info"))
        .format(|line, record| match record.level() {
            log::Level::Info => writeln!(line, "yurameki: {}", record.args()),
            level => writeln!(line, "yurameki: {}: {}", level.as_str().to_lowercase(), record.args()),
        })
        .init();
    match yurameki::os::execute(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // `eprintln!` would panic where even that cannot be written.
            let _ = writeln!(io::stderr(), "yurameki: {failure}");
            ExitCode::FAILURE
        }
    }
}
