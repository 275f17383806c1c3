use super::PhotoId;
use heapless::Deque;

/// Photos that were shown and can be gone back to: at a minute a photo, the last two hours.
pub const HISTORY: usize = 128;

/// What was shown, and how far the person has gone back in it.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    /// The oldest first.
    photos: Deque<PhotoId, HISTORY>,
    /// Photos after the current one.
    back: usize,
}

impl History {
    /// `photos` from the oldest to the newest, gone `back` in them.
    pub(super) fn new(photos: &[PhotoId], back: usize) -> Self {
        let mut history = Self::default();
        photos.iter().for_each(|&id| history.push(id));
        history.back = back.min(history.photos.len().saturating_sub(1));
        history
    }

    pub(super) fn current(&self) -> Option<PhotoId> {
        self.photos.get(self.at()?).copied()
    }

    pub(super) fn newest(&self) -> Option<PhotoId> {
        self.photos.back().copied()
    }

    /// From the oldest to the newest.
    pub(super) fn photos(&self) -> impl Iterator<Item = PhotoId> {
        self.photos.iter().copied()
    }

    /// Photos between the current one and the newest, with the newest.
    pub(super) const fn gone_back(&self) -> usize {
        self.back
    }

    /// Those after the current one, from it to the newest.
    pub(super) fn later(&self) -> impl Iterator<Item = PhotoId> {
        self.photos().skip(self.photos.len() - self.back)
    }

    /// Those before the current one, from it to the oldest.
    pub(super) fn earlier(&self) -> impl Iterator<Item = PhotoId> {
        self.photos.iter().rev().skip(self.back + 1).copied()
    }

    /// Another photo is shown after the newest; the oldest may be forgotten.
    pub(super) fn push(&mut self, id: PhotoId) {
        self.back = 0;
        if self.newest() == Some(id) {
            return;
        }
        if self.photos.is_full() {
            self.photos.pop_front();
        }
        // There is room now.
        let _ = self.photos.push_back(id);
    }

    /// A photo is shown as if it had come before the oldest, which is the current one or was too; tells whether it is another.
    /// The newest may be forgotten.
    pub(super) fn push_front(&mut self, id: PhotoId) -> bool {
        if self.current() == Some(id) {
            return false;
        }
        if self.photos.is_full() {
            self.photos.pop_back();
        }
        let _ = self.photos.push_front(id);
        self.back = self.photos.len() - 1;
        true
    }

    /// Goes forwards by one; none at the newest.
    pub(super) fn forwards(&mut self) -> Option<PhotoId> {
        self.back = self.back.checked_sub(1)?;
        self.current()
    }

    /// Goes back by `steps`, to the oldest at the most.
    pub(super) fn back(&mut self, steps: usize) {
        self.back = (self.back + steps).min(self.photos.len().saturating_sub(1));
    }

    fn at(&self) -> Option<usize> {
        self.photos.len().checked_sub(self.back + 1)
    }
}
