//! The known boards: facts, no code. A board's file is a configuration that a person's own goes before.
//!
//! A board that nobody names is told by its device tree (Devicetree Specification 0.4, 2.3.1): the property `compatible` of
//! its root lists what the board is, the most specific name first, and the files of boards list the names that they are for.

use super::{
    config::Config,
    config_file,
    document::{ConfigError, read_text, unknown},
};
use std::{fs, path::Path};

/// Puts a name to the file of each board.
macro_rules! boards {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../board/", $name, ".toml")))),+]
    };
}

/// The name and the file of every known board.
pub const BOARDS: &[(&str, &str)] = boards![
    "raspberry-pi-zero",
    "raspberry-pi-zero-2",
    "raspberry-pi-3",
    "raspberry-pi-4",
    "raspberry-pi-5",
    "generic-kms",
    "generic-fbdev",
    "spi-480x320",
    "qemu",
];

/// Where the kernel tells what the board is; not there on PCs.
pub const DEVICE_TREE: &str = "/proc/device-tree/compatible";

/// The name of the board that the device tree at `path` ([`DEVICE_TREE`]) is of, if it is a known one; says so in the log.
pub fn detect(path: &Path) -> Option<&'static str> {
    let names = fs::read(path).ok()?;
    let name = names.split(|&byte| byte == 0).find_map(|name| compatible_with(str::from_utf8(name).ok()?))?;
    log::info!("this is a board of the kind {name}; the key `board` of the configuration can say otherwise");
    Some(name)
}

/// The board whose file lists `name`.
fn compatible_with(name: &str) -> Option<&'static str> {
    let lists = |text| {
        let heading = config_file::apply(Path::new("board"), text, &mut Config::default());
        heading.is_ok_and(|heading| heading.compatible.iter().any(|known| known == name))
    };
    BOARDS.iter().find(|(_, text)| lists(text)).map(|(board, _)| *board)
}

/// The file of the board of that name.
///
/// # Errors
/// There is none; the message lists those that there are.
pub fn find(name: &str) -> Result<&'static str, ConfigError> {
    let known = BOARDS.iter().find(|(known, _)| *known == name);
    known.map(|(_, text)| *text).ok_or_else(|| {
        let names: Vec<&str> = BOARDS.iter().map(|(name, _)| *name).collect();
        ConfigError::whole("board", unknown("board", name, &names))
    })
}

/// What the board is in a line: the first comment of its file.
pub fn title(text: &str) -> &str {
    text.lines().next().unwrap_or_default().trim_start_matches(['#', ' '])
}

/// Puts the facts of a board, by name or by the path of its file, in place of what `config` says.
pub(super) fn apply(board: &str, config: &mut Config) -> Result<(), ConfigError> {
    let heading = if board.contains('/') || board.ends_with(".toml") {
        let path = Path::new(board);
        config_file::apply(path, &read_text(path)?, config)?
    } else {
        config_file::apply(Path::new(&format!("board/{board}.toml")), find(board)?, config)?
    };
    match heading.board {
        Some(_) => {
            Err(ConfigError::whole(board, "the file of a board names no board; take the key `board` away"))
        }
        None => Ok(()),
    }
}
