//! `yurameki config`: what can be configured, and whether a file does it right.

use super::{
    Failure, args,
    board::{self, BOARDS},
    config::Config,
    config_file,
    document::read_text,
};
use std::io::{self, ErrorKind, Write};

pub(super) fn config(args: &args::ConfigFile) -> Result<(), Failure> {
    if let Some(path) = &args.check {
        let mut config = Config::default();
        let heading = config_file::apply(path, &read_text(path)?, &mut config)?;
        if let Some(name) = heading.board {
            board::apply(&name, &mut config)?;
        }
        return print(&format!("{}: good\n", path.display()));
    }
    if let Some(name) = &args.board {
        return print(board::find(name)?);
    }
    if args.boards {
        let line = |(name, text): &(&str, &str)| format!("{name:<20} {}\n", board::title(text));
        return print(&BOARDS.iter().map(line).collect::<String>());
    }
    print(config_file::DEFAULT)
}

fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        // `| head` has seen enough.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::new(format!("standard output: {error}; write to a place with room"))),
        Ok(()) => Ok(()),
    }
}
