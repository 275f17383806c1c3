//! Ctrl-C and other requests from outside, as flags that long work looks at between frames.

use signal_hook::{
    consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1},
    flag,
};
use std::{
    fs, io,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// Set by the first SIGINT (Ctrl-C), SIGTERM or SIGHUP; the second one ends the program at once, as if nobody had listened.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on. A signal that the program was started to ignore (`nohup`, a job in the background of a script)
    /// stays ignored.
    ///
    /// # Errors
    ///
    /// Those of `sigaction`; no known system has any.
    pub fn install() -> io::Result<Self> {
        let requested = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal)) {
            // In this order: the first signal finds the flag unset and only sets it.
            flag::register_conditional_default(signal, Arc::clone(&requested))?;
            flag::register(signal, Arc::clone(&requested))?;
        }
        Ok(Self(requested))
    }

    /// Whether the work should end.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// SIGUSR1, by which `systemctl reload` asks to read the configuration anew. SIGHUP cannot be it: that is how a terminal says that it
/// has gone, and the program must end then.
#[derive(Clone, Debug)]
pub struct ReloadRequest(Arc<AtomicBool>);

impl ReloadRequest {
    /// Listens from now on.
    ///
    /// # Errors
    ///
    /// Those of `sigaction`; no known system has any.
    pub fn install() -> io::Result<Self> {
        let requested = Arc::new(AtomicBool::new(false));
        flag::register(SIGUSR1, Arc::clone(&requested))?;
        Ok(Self(requested))
    }

    /// Whether it was asked for since the last time.
    pub fn take(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}

/// Whether the program was started with `signal` ignored: bit `signal` − 1 of the mask that proc(5) calls SigIgn.
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok()).unwrap_or_default();
    mask >> (signal - 1) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal_hook::low_level::raise;
    use std::{
        env,
        os::unix::process::ExitStatusExt,
        process::{Command, Output},
    };

    const CHILD: &str = "YURAMEKI_INTERRUPTED_CHILD";

    /// Runs the test `name` of this module again, as a process of its own whose shell has run `prepare`.
    fn run_child(name: &str, prepare: &str) -> Output {
        let script = format!("{prepare}exec \"$0\" --exact os::interrupt::tests::{name} --nocapture");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(script).arg(env::current_exe().unwrap()).env(CHILD, "1");
        shell.output().unwrap()
    }

    #[test]
    fn the_first_signal_asks_and_the_second_ends_the_program() {
        if env::var_os(CHILD).is_some() {
            let interrupt = Interrupt::install().unwrap();
            assert!(!interrupt.requested());
            raise(SIGTERM).unwrap();
            assert!(interrupt.requested());
            println!("asked");
            raise(SIGTERM).unwrap();
            unreachable!("the second signal ends the program");
        }
        let output = run_child("the_first_signal_asks_and_the_second_ends_the_program", "");
        assert_eq!(output.status.signal(), Some(SIGTERM), "{output:?}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("asked"), "{output:?}");
    }

    #[test]
    fn a_signal_that_was_ignored_stays_ignored() {
        if env::var_os(CHILD).is_some() {
            let interrupt = Interrupt::install().unwrap();
            raise(SIGHUP).unwrap();
            assert!(!interrupt.requested());
            return;
        }
        let output = run_child("a_signal_that_was_ignored_stays_ignored", "trap '' HUP; ");
        assert!(output.status.success(), "{output:?}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"), "{output:?}");
    }
}
