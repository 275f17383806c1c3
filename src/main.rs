//! Yurameki, the program: arguments in, an exit code out. What it does stands in [`yurameki::os`].

use clap::Parser;
use std::{
    io::{self, Write},
    process::ExitCode,
};

/// Exit codes: 0 done, 1 failed, 2 asked for what cannot be (by clap, or in a configuration).
fn main() -> ExitCode {
    let args = yurameki::os::args::Args::parse();
    // What the program may say where RUST_LOG says nothing; how much it does is up to the configuration.
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("warn,yurameki=trace"))
        .format(|line, record| match record.level() {
            log::Level::Info => writeln!(line, "yurameki: {}", record.args()),
            level => writeln!(line, "yurameki: {}: {}", level.as_str().to_lowercase(), record.args()),
        })
        .init();
    yurameki::os::set_log_level(log::LevelFilter::Info);
    match yurameki::os::execute(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // `eprintln!` would panic where even that cannot be written.
            for line in failure.to_string().lines() {
                let _ = writeln!(io::stderr(), "yurameki: {line}");
            }
            ExitCode::from(failure.exit_code())
        }
    }
}
