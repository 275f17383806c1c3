//! How far long work has come, shown on stderr.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};

/// A bar with the frames done, their number and the time left. It shows on stderr and only where that is a terminal, so that
/// neither pipes nor log files get it, and goes when it is dropped.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar for `frames` frames; `quiet` shows none.
    pub fn new(frames: u32, quiet: bool) -> Self {
        Self::with_template(u64::from(frames), FRAMES, quiet)
    }

    /// A bar for work of `length` steps, which people are told in percent.
    pub fn of_work(length: u64, quiet: bool) -> Self {
        Self::with_template(length, WORK, quiet)
    }

    fn with_template(length: u64, template: &str, quiet: bool) -> Self {
        let shown = !quiet && io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        // A template that does not parse would lose the numbers, not the work; a test parses it.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
        }
        Self(bar)
    }

    /// One more frame is done.
    pub fn frame_done(&self) {
        self.0.inc(1);
    }

    /// So many steps are done.
    pub fn set(&self, steps: u64) {
        self.0.set_position(steps);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

const FRAMES: &str = "{wide_bar} {pos}/{len} frames, {eta} left";
const WORK: &str = "{wide_bar} {percent} %, {eta} left";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_templates_are_ones_that_indicatif_reads() {
        assert!([FRAMES, WORK].into_iter().all(|template| ProgressStyle::with_template(template).is_ok()));
    }
}
