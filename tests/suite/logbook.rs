//! What the program wrote to the log, a test at a time.

use log::{LevelFilter, Log, Metadata, Record};
use std::{cell::RefCell, sync::Once};

struct Logbook;

thread_local! {
    static LINES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

impl Log for Logbook {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        LINES.with_borrow_mut(|lines| lines.push(format!("{}: {}", record.level(), record.args())));
    }

    fn flush(&self) {}
}

/// The lines that this thread logged since the last call. The first call of all starts the logbook.
pub(crate) fn lines() -> Vec<String> {
    static START: Once = Once::new();
    START.call_once(|| {
        log::set_logger(&Logbook).expect("nothing else logs in this program");
        log::set_max_level(LevelFilter::Debug);
    });
    LINES.take()
}
