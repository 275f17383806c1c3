//! Standard output, which may be a full disk or a closed pipe.

use super::Failure;
use std::{
    fmt,
    io::{self, ErrorKind, Write},
};

/// Prints one line.
pub(super) fn print_line(line: impl fmt::Display) -> Result<(), Failure> {
    written(writeln!(io::stdout(), "{line}").and_then(|()| io::stdout().flush()))
}

/// What became of something that was written to standard output. That the reader has gone is no failure: `| head` has seen
/// enough.
pub(super) fn written(outcome: io::Result<()>) -> Result<(), Failure> {
    match outcome {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("standard output: {error}; write to a place with room")))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
