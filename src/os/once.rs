//! Lines of the log that are worth saying once, though what they tell of comes again with every round of the photos.

use log::Level;
use std::{
    collections::HashSet,
    sync::{Mutex, PoisonError},
};

static SAID: Mutex<Option<HashSet<String>>> = Mutex::new(None);

/// Lines that are remembered. What comes after them is not said, so that a year's log ends.
const MOST: usize = 10_000;

/// Logs `line` if it was not logged before.
pub(super) fn once(level: Level, line: String) {
    let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    let said = said.get_or_insert_default();
    if said.len() < MOST && !said.contains(&line) {
        log::log!(level, "{line}");
        said.insert(line);
    }
}
