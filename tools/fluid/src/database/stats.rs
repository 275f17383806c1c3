//! What is in a database.

use super::{DatabaseError, catalogue::Catalogue, frames};
use std::{
    fmt,
    path::{Path, PathBuf},
};

/// Counts and sizes.
#[derive(Clone, Debug)]
pub struct Stats {
    directory: PathBuf,
    classes: Vec<(String, u64, u64)>,
    videos: Vec<String>,
    refusals: Vec<(String, String, String)>,
    parameters: Vec<(String, String)>,
    words: Option<usize>,
    unworded: usize,
    frame_bytes: u64,
    catalogue_bytes: u64,
}

impl Stats {
    /// Counts. The database may be unfinished.
    ///
    /// # Errors
    ///
    /// It cannot be opened.
    pub fn of(directory: &Path) -> Result<Self, DatabaseError> {
        let catalogue = Catalogue::open(directory)?;
        let entries = catalogue.videos()?;
        let vocabulary = catalogue.vocabulary()?;
        let unworded = entries
            .iter()
            .filter(|entry| !vocabulary.as_ref().is_some_and(|words| entry.is_worded_by(words)))
            .count();
        let size = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
        let describe = |entry: &super::catalogue::Entry| {
            let video = &entry.video;
            let there = if size(&frames::path(directory, &entry.content)) == entry.bytes {
                ""
            } else {
                ", frames damaged"
            };
            format!(
                "{:08x} {}: {} ({}), {} × {}, {} frames, {:.3} a second, noise {:.2}, {:.0} % fluid{}{there}",
                video.number,
                video.name,
                video.class.name(),
                entry.class_by,
                video.width,
                video.height,
                video.frames,
                video.rate,
                entry.noise,
                100.0 * entry.fluid,
                if entry.forced { ", forced" } else { "" }
            )
        };
        Ok(Self {
            directory: directory.to_owned(),
            classes: catalogue.patch_counts()?,
            videos: entries.iter().map(describe).collect(),
            refusals: catalogue.refusals()?,
            parameters: catalogue.parameters()?,
            words: vocabulary.map(|vocabulary| vocabulary.words.len()),
            unworded,
            frame_bytes: entries.iter().map(|entry| entry.bytes).sum(),
            catalogue_bytes: size(&super::catalogue::path(directory)),
        })
    }
}

impl Stats {
    /// The counts alone.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_counts(&mut text);
        text
    }

    fn write_counts(&self, f: &mut impl fmt::Write) -> fmt::Result {
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        writeln!(
            f,
            "{}: {} videos, {:.1} MB of frames, catalogue {:.1} MB",
            self.directory.display(),
            self.videos.len(),
            megabytes(self.frame_bytes),
            megabytes(self.catalogue_bytes)
        )?;
        for (class, videos, patches) in &self.classes {
            writeln!(f, "{class}: {videos} videos, {patches} patches")?;
        }
        match self.words {
            Some(words) => writeln!(f, "vocabulary: {words} words and the flat one")?,
            None => writeln!(f, "vocabulary: none yet")?,
        }
        if self.unworded > 0 {
            writeln!(
                f,
                "unfinished: {} videos have no words yet; `index` or `merge` ends it",
                self.unworded
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for Stats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_counts(f)?;
        self.videos.iter().try_for_each(|video| writeln!(f, "video {video}"))?;
        self.refusals.iter().try_for_each(|(_, source, reason)| writeln!(f, "refused {source}: {reason}"))?;
        self.parameters.iter().try_for_each(|(name, value)| writeln!(f, "parameter {name}: {value}"))
    }
}
