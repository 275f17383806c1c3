//! The commands that work on a database.

use crate::{
    args,
    database::{
        Database, check,
        index::{self, Listener, Outcome},
        merge,
        stats::Stats,
    },
    footage::Class,
    video::source::{Extent, Source},
};
use indicatif::{ProgressBar, ProgressStyle};
use std::{error::Error, num::NonZero, path::Path, sync::Mutex, thread};
use yurameki::os::interrupt::Interrupt;

/// Why a command ended early, as one line for people.
pub type Failure = Box<dyn Error>;

/// Tells people of the work: a line for every video on stdout, a bar on stderr where that is a terminal. Ctrl-C ends it.
struct Console {
    bar: ProgressBar,
    interrupt: Interrupt,
    counts: Mutex<Counts>,
}

#[derive(Clone, Copy, Default)]
struct Counts {
    taken: usize,
    known: usize,
    refused: usize,
    patches: usize,
}

impl Console {
    fn new() -> Result<Self, Failure> {
        // A template that does not parse would lose the numbers, not the work.
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(0).with_style(style);
        Ok(Self { bar, interrupt: Interrupt::install()?, counts: Mutex::default() })
    }

    fn counts(&self) -> Counts {
        *self.counts.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Listener for Console {
    fn done(&self, source: &Path, outcome: &Outcome) {
        let mut counts = self.counts.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let line = match outcome {
            Outcome::Taken { class, class_by, patches, frames, fluid } => {
                counts.taken += 1;
                counts.patches += patches;
                format!(
                    "taken: {} ({class_by}), {frames} frames, {:.0} % fluid, {patches} patches",
                    class.name(),
                    100.0 * fluid
                )
            }
            Outcome::Known(name) => {
                counts.known += 1;
                format!("known: it is there already as {name}")
            }
            Outcome::Refused(reason) => {
                counts.refused += 1;
                format!("refused: {reason}")
            }
        };
        drop(counts);
        self.bar.suspend(|| println!("{} {line}", source.display()));
    }

    fn stage(&self, name: &'static str, steps: usize) {
        self.bar.reset();
        self.bar.set_length(steps as u64);
        self.bar.set_message(name);
    }

    fn step(&self) {
        self.bar.inc(1);
    }

    fn interrupted(&self) -> bool {
        self.interrupt.requested()
    }
}

/// Runs `index`.
///
/// # Errors
///
/// The sources cannot be listed, or the database not be written.
pub fn index(args: &args::Index) -> Result<(), Failure> {
    let mut sources = if args.videos.is_empty() { Vec::new() } else { Source::list(&args.videos)? };
    if let Some(shard) = args.shard {
        sources = shard.of(sources);
        if sources.is_empty() {
            println!("nothing to do: there are more shards than videos");
            return Ok(());
        }
    }
    let vocabulary = args.vocabulary.as_deref().map(Database::open).transpose()?;
    let options = index::Options {
        class: args.class.map(Class::from),
        jobs: jobs(args.jobs),
        extent: Extent { seconds: args.seconds, rate: args.rate },
        forced: args.force,
        vocabulary: vocabulary.map(|database| database.vocabulary().clone()),
        wordless: args.shard.is_some(),
    };
    let console = Console::new()?;
    index::index(&args.db, &sources, &options, &console)?;
    let Counts { taken, known, refused, patches } = console.counts();
    drop(console);
    println!("{taken} videos taken with {patches} patches, {known} known, {refused} refused");
    Ok(())
}

/// Runs `merge`.
///
/// # Errors
///
/// A part cannot be read, or the database not be written.
pub fn merge(args: &args::Merge) -> Result<(), Failure> {
    merge::merge(&args.db, &args.parts, jobs(args.jobs), &Console::new()?)?;
    let stats = Stats::of(&args.db)?;
    print!("{}", stats.summary());
    Ok(())
}

/// Runs `stats`.
///
/// # Errors
///
/// The database cannot be read.
pub fn stats(args: &args::Stats) -> Result<(), Failure> {
    print!("{}", Stats::of(&args.db)?);
    Ok(())
}

/// Runs `check`.
///
/// # Errors
///
/// The database cannot be read, or it is damaged.
pub fn check(args: &args::Check) -> Result<(), Failure> {
    let damage = check::check(&args.db, &Console::new()?)?;
    if damage.is_empty() {
        println!("{}: all is well", args.db.display());
        return Ok(());
    }
    for found in &damage {
        println!("{}: {}; {}", found.source.display(), found.what, found.cure);
    }
    Err(format!(
        "{} videos are damaged; `index --db {}` mends what can be mended",
        damage.len(),
        args.db.display()
    )
    .into())
}

fn jobs(given: Option<u16>) -> usize {
    given.map_or_else(|| thread::available_parallelism().map_or(1, NonZero::get), usize::from)
}
