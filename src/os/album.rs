//! The photos of a show: where they are, in which order they come, and what is remembered of them.

use super::{
    Failure,
    config::Config,
    library::{Library, photo_id},
    photo,
    state::{Memory, State, default_folder},
};
use crate::{
    app::playlist::{CAPACITY, PhotoId, Playlist, Slot, Snapshot},
    noise::Kind,
};
use std::{
    collections::HashSet,
    env,
    path::{Path, PathBuf},
    time::Duration,
};

/// The demo photo, which is in no folder.
const DEMO: PhotoId = PhotoId(0);

/// As many folders are named where there are no photos: as many lines as the smallest panel has.
const MOST_FOLDERS: usize = 8;

/// Photos in folders, or the demo photo.
pub(super) struct Album {
    /// None for the demo photo.
    library: Option<Library>,
    playlist: Playlist<Vec<Slot>>,
    memory: Option<Memory>,
    hidden: Vec<PhotoId>,
    /// Photos that could not be shown as they are.
    bad: HashSet<PhotoId>,
    /// Photos in a row that could not be shown.
    bad_in_a_row: usize,
    /// Why the last of them could not.
    last_failure: String,
    folders: Vec<PathBuf>,
}

impl Album {
    /// The photos that `config` names. A show that `remembers` goes on where it was before the restart, and gives the noises that
    /// were chosen then.
    ///
    /// # Errors
    /// If `typed` photos are not there: what a configuration names is waited for.
    pub(super) fn open(
        config: &Config,
        typed: bool,
        remembers: bool,
    ) -> Result<(Self, Option<State>), Failure> {
        if typed {
            photo::list(&config.photos)?;
        }
        let folder = remembers.then(|| default_folder(|name| env::var_os(name)));
        let (memory, state) = match folder.map(Memory::open) {
            Some((memory, state)) => (Some(memory), state),
            None => (None, None),
        };
        let hidden = memory.iter().flat_map(Memory::hidden).map(|path| photo_id(path)).collect();
        let mut album = Self {
            library: None,
            playlist: Playlist::new(Vec::new(), config.order, config.seed),
            memory,
            hidden,
            bad: HashSet::new(),
            bad_in_a_row: 0,
            last_failure: String::new(),
            folders: Vec::new(),
        };
        album.gather(config, state.as_ref().map(|state| &state.playlist));
        if album.playlist.is_empty() && typed {
            let line = "there is no photo in these folders; JPEG, PNG, WebP, GIF, BMP and TIFF files are shown, and clips";
            return Err(Failure::new(line));
        }
        Ok((album, state))
    }

    /// The photos are those that `config` names from now on, in the order that it says; what was shown stays known.
    pub(super) fn change(&mut self, config: &Config) {
        let snapshot = self.playlist.snapshot();
        self.gather(config, Some(&snapshot));
    }

    fn gather(&mut self, config: &Config, before: Option<&Snapshot>) {
        let slots = vec![Slot::EMPTY; CAPACITY];
        self.playlist = match before {
            Some(before) => Playlist::restore(slots, config.order, config.seed, before),
            None => Playlist::new(slots, config.order, config.seed),
        };
        for &id in &self.hidden {
            self.playlist.hide(id);
        }
        self.folders.clone_from(&config.photos);
        self.library = (!config.photos.is_empty()).then(|| Library::watch(&config.photos, config.order));
        self.update();
    }

    fn update(&mut self) {
        let left_out = match &self.library {
            Some(library) => self.playlist.update(library.photos()),
            None => self.playlist.update(&[DEMO]),
        };
        if left_out > 0 {
            log::warn!("{left_out} photos are not shown: there is room for {CAPACITY}");
        }
    }

    /// Looks whether photos have come, gone or changed, and gives those that have changed.
    pub(super) fn look(&mut self) -> Vec<PhotoId> {
        let Some(news) = self.library.as_mut().and_then(Library::news) else { return Vec::new() };
        news.changed.iter().for_each(|id| {
            self.bad.remove(id);
        });
        self.bad_in_a_row = 0;
        self.update();
        news.changed
    }

    /// Tries again what could not be shown.
    pub(super) fn retry(&mut self) {
        self.bad.clear();
        self.bad_in_a_row = 0;
    }

    /// The photo to show, of those that can be shown.
    pub(super) fn current(&mut self) -> Option<PhotoId> {
        while self.playlist.current().is_some_and(|id| self.bad.contains(&id)) {
            if self.is_hopeless() {
                return None;
            }
            self.bad_in_a_row += 1;
            self.playlist.skip();
        }
        self.playlist.current()
    }

    /// The photo that comes after it, where that is known, is another, and can be shown.
    pub(super) fn upcoming(&mut self) -> Option<PhotoId> {
        let current = self.playlist.current();
        self.playlist.upcoming().filter(|id| Some(*id) != current && !self.bad.contains(id))
    }

    /// Where the photo is whose colours the one of `id` may take: the one that is shown before it, or comes after it.
    pub(super) fn neighbour(&mut self, id: PhotoId) -> Option<PathBuf> {
        let current = self.playlist.current().filter(|&other| other != id);
        let other = current.or_else(|| self.upcoming());
        other.and_then(|other| self.path(other))
    }

    /// Where the next photo is whose colours the one of `id` may take, after the one at `before`: round and round in the order of the
    /// folders. `None` where there is no other.
    pub(super) fn colours_after(&self, id: PhotoId, before: Option<&Path>) -> Option<PathBuf> {
        let photos = self.library.as_ref()?.photos();
        let last = before.map_or(id, photo_id);
        let start = photos.iter().position(|&photo| photo == last).map_or(0, |at| at + 1);
        let mut others = photos[start..].iter().chain(&photos[..start]).copied();
        let other =
            others.find(|other| *other != id && !self.bad.contains(other) && !self.hidden.contains(other));
        other.and_then(|other| self.path(other))
    }

    /// Whether there is another photo to go on to.
    pub(super) fn goes_on(&self) -> bool {
        self.playlist.len() > 1
    }

    /// Where a photo is; `None` for the demo photo, and for one that has just gone.
    pub(super) fn path(&self, id: PhotoId) -> Option<PathBuf> {
        self.library.as_ref()?.path(id).map(Into::into)
    }

    pub(super) fn next(&mut self) {
        self.playlist.next();
    }

    pub(super) fn previous(&mut self) {
        self.playlist.previous();
    }

    /// A photo cannot be shown, because of `why`. Told once.
    pub(super) fn fails(&mut self, id: PhotoId, why: &Failure) {
        if self.bad.insert(id) {
            self.last_failure = why.to_string();
            log::warn!("skipped: {why}");
        }
    }

    /// A photo was shown.
    pub(super) const fn succeeds(&mut self) {
        self.bad_in_a_row = 0;
    }

    /// Whether every photo was tried in vain.
    pub(super) fn is_hopeless(&self) -> bool {
        self.bad_in_a_row > 2 * self.playlist.len()
    }

    /// Why there is no photo to show, as a few lines for the panel; `None` where there is one.
    pub(super) fn nothing(&mut self) -> Option<String> {
        if self.current().is_some() {
            return None;
        }
        if !self.playlist.is_empty() {
            return Some(format!("no photo can be shown\n{}", self.last_failure));
        }
        if self.library.as_ref().is_some_and(|library| !library.photos().is_empty()) {
            return Some("all photos are hidden".into());
        }
        let mut lines = String::from("no photos yet: copy some to");
        for folder in self.folders.iter().take(MOST_FOLDERS) {
            let away = if folder.exists() { "" } else { " (not there)" };
            lines += &format!("\n{}{away}", folder.display());
        }
        Some(lines)
    }

    /// Never shows a photo again.
    pub(super) fn hide(&mut self, id: PhotoId) {
        let path = self.path(id);
        let kept = match (&path, &mut self.memory) {
            (Some(path), Some(memory)) => {
                memory.hide(path);
                "for ever"
            }
            _ => "until the program ends",
        };
        if let Some(path) = path {
            log::info!("{}: hidden {kept}", path.display());
        }
        self.hidden.push(id);
        self.playlist.hide(id);
    }

    /// Remembers where the show is, from time to time, or `at_once`.
    pub(super) fn remember(&mut self, now: Duration, chosen: (Kind, Kind), at_once: bool) {
        let Some(memory) = &mut self.memory else { return };
        let state = || State {
            playlist: self.playlist.snapshot(),
            amplitude: Some(chosen.0),
            frequency: Some(chosen.1),
        };
        if at_once {
            memory.keep_now(&state());
        } else {
            memory.keep(now, state);
        }
    }
}
