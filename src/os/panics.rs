//! Libraries that give up in disorder.

use std::{
    cell::Cell,
    panic::{self, AssertUnwindSafe},
    sync::Once,
};

thread_local! {
    /// Whether a panic of this thread is expected, and so not told.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// What `work` gives, or the message of its panic, which is not printed. `work` must own what a panic could leave half done.
pub(super) fn without_panic<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !EXPECTED.get() {
                usual(panic);
            }
        }));
    });
    let outer = EXPECTED.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(work));
    EXPECTED.set(outer);
    outcome.map_err(|panic| match panic.downcast::<String>() {
        Ok(message) => *message,
        Err(panic) => panic.downcast_ref::<&str>().copied().unwrap_or("an unknown failure").to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message() {
        assert_eq!(without_panic(|| 1), Ok(1));
        assert_eq!(without_panic(|| -> u8 { panic!("no {}", "library") }), Err("no library".into()));
        assert_eq!(without_panic(|| -> u8 { panic!("no library") }), Err("no library".into()));
    }

    #[test]
    fn a_panic_is_expected_only_within() {
        let inner = || without_panic(|| -> u8 { panic!("within") });
        assert_eq!(without_panic(|| (inner(), EXPECTED.get())), Ok((Err("within".into()), true)));
        assert!(!EXPECTED.get());
    }
}
