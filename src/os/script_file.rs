//! Scripts of presses in files.

use super::Failure;
use crate::input::script::Script;
use std::{fs::File, io::Read, path::Path};

/// The most bytes of a script: a press a second for a week would fit.
const LONGEST_SCRIPT: u64 = 16 << 20;

/// The text of a script, of a file or of a pipe.
///
/// # Errors
/// One line that names the file, what is wrong and the cure.
pub(super) fn read(path: &Path) -> Result<String, Failure> {
    let refused = |why: &str| Failure::new(format!("{}: {why}", path.display()));
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LONGEST_SCRIPT + 1).read_to_end(&mut bytes));
    read.map_err(|error| refused(&format!("the script cannot be read ({error}); name another file")))?;
    if bytes.len() as u64 > LONGEST_SCRIPT {
        return Err(refused("the script is over 16 MiB; make it shorter"));
    }
    String::from_utf8(bytes).map_err(|_| refused("the script is no text; save it as UTF-8"))
}

/// The script of the `text` of the file at `path`.
///
/// # Errors
/// The first line that is no press.
pub(super) fn parse<'a>(path: &Path, text: &'a str) -> Result<Script<'a>, Failure> {
    Script::parse(text).map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}
