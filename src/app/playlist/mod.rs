//! The order in which photos are shown.
//!
//! A photo is a [`PhotoId`]; whoever shows it knows its name. Which photos there are is told by [`Playlist::update`], at any
//! time and in the order of the listing.
//!
//! Shuffled, the playlist is a deck: a round shows every photo once, then the next round begins in another order, never with
//! the photo that came last. The deck is not stored. Every photo has a key, drawn from the stream of its id and the round's
//! salt, and a round goes by growing keys: what has a key up to that of the photo drawn last has been shown. So a photo that
//! goes away and comes back (a stick that is pulled out and plugged in) keeps its place, and a restart needs one salt and one
//! key of the whole deck ([`Snapshot`]). A photo that comes while the show is running, or comes back after its turn, has a key
//! among the next [`SOON`], so that it is seen soon, and still only once in its round.
//!
//! In the listing's order the key is the place in the listing.
//!
//! Going back is going through what was really shown ([`HISTORY`] photos), and forwards again through the same.
//!
//! Memory: one [`Slot`] (24 bytes) for every photo, lent. Cost: a step looks at each slot once and an update sorts them: 0.4 ms
//! and 14 ms for [`CAPACITY`] photos on a PC (x86-64 server core, November 2026, the development profile).

mod dwell;
mod history;
mod snapshot;

pub use dwell::Dwell;
pub use history::HISTORY;
pub use snapshot::{EARLY, Snapshot};

use crate::{
    config::Order,
    math::random::{Stream, stream},
};
use core::ops::DerefMut;
use history::History;
use rand::Rng as _;

/// How many photos a frame should have room for: 1.5 MiB of slots. It is what a card of 256 GB holds at 4 MB a photo.
pub const CAPACITY: usize = 65_536;

/// A new photo comes within so many photos of the deck: soon enough for the person who has just copied it.
pub const SOON: usize = 4;

/// The least room for the keys of new photos, of 2^63 for a whole round. Thousands of photos find different keys there, and it is
/// 1/256 of the mean distance of the keys of 65,536 photos, so that no old photo is passed over by it.
const LEAST_ROOM: u64 = 1 << 39;

/// Salts that are tried for a round that does not begin with the photo just shown. With two photos one in two does, so
/// that 32 tries fail once in four thousand million rounds; the photo then stays for twice its time.
const TRIES: usize = 32;

/// A photo, by a number that stays the same over restarts: say, a hash of its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PhotoId(pub u64);

/// A place in a round: the key, and the id where keys are the same.
type Place = (u64, PhotoId);

/// What the playlist remembers of a photo.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    id: PhotoId,
    key: u64,
    /// It is there now.
    present: bool,
    /// It is never to be shown.
    hidden: bool,
    /// It was drawn in this round.
    drawn: bool,
    /// It came in this round and has a key of its own, which does not follow from the salt.
    early: bool,
}

impl Slot {
    /// Room for a photo.
    pub const EMPTY: Self =
        Self { id: PhotoId(0), key: 0, present: false, hidden: false, drawn: false, early: false };

    const fn place(&self) -> Place {
        (self.key, self.id)
    }

    const fn is_visible(&self) -> bool {
        self.present && !self.hidden
    }
}

/// The photos of a show, in slots that are lent (`&mut [Slot]`) or owned (`Vec<Slot>`).
#[derive(Clone, Debug)]
pub struct Playlist<M> {
    /// The first `len` are in use, sorted by id.
    slots: M,
    len: usize,
    order: Order,
    salt: u64,
    /// What of this round was drawn last.
    place: Option<Place>,
    history: History,
    forwards: bool,
    /// There were photos already: those that come now are new.
    filled: bool,
}

impl<M: DerefMut<Target = [Slot]>> Playlist<M> {
    /// A playlist without photos. It takes as many as there are `slots`. The `seed` decides how they are shuffled.
    pub fn new(slots: M, order: Order, seed: u64) -> Self {
        let salt = stream(seed, Stream::Playlist).next_u64();
        let history = History::default();
        Self { slots, len: 0, order, salt, place: None, history, forwards: true, filled: false }
    }

    /// The photo to show; none while there is no photo.
    pub fn current(&self) -> Option<PhotoId> {
        self.history.current().filter(|&id| self.is_visible(id))
    }

    /// How many photos can be shown.
    pub fn len(&self) -> usize {
        self.visible().count()
    }

    /// Whether no photo can be shown.
    pub fn is_empty(&self) -> bool {
        self.visible().next().is_none()
    }

    /// Goes on: forwards through the history, then to the next of the round.
    pub fn next(&mut self) {
        self.forwards = true;
        while let Some(id) = self.history.forwards() {
            if self.is_visible(id) {
                return;
            }
        }
        if let Some(slot) = self.peek() {
            self.place = Some(slot.place());
            self.history.push(slot.id);
            if let Ok(at) = self.find(slot.id) {
                self.slots[at].drawn = true;
            }
        }
    }

    /// Goes back to the photo that was shown before. Where nothing is remembered, a shuffled show stays where it is, and a
    /// listed one goes back in the listing, from the first to the last.
    pub fn previous(&mut self) {
        self.forwards = false;
        self.back();
    }

    /// The current photo cannot be shown: goes on in the direction taken last. After twice [`Self::len`] of these in a row, every
    /// photo was tried.
    pub fn skip(&mut self) {
        if self.forwards || !self.back() {
            self.next();
        }
    }

    /// The photo that [`Self::next`] will go to, as far as is known now; to be loaded in good time.
    pub fn upcoming(&mut self) -> Option<PhotoId> {
        let again = self.history.later().find(|&id| self.is_visible(id));
        again.or_else(|| self.peek().map(|slot| slot.id))
    }

    /// Never shows `id` again, whether it is there or not. If it is the current photo, goes on. Tells whether there was room to
    /// remember that.
    pub fn hide(&mut self, id: PhotoId) -> bool {
        let at = match self.find(id) {
            Ok(at) => at,
            Err(at) if self.len < self.slots.len() => {
                self.slots[at..=self.len].rotate_right(1);
                self.slots[at] = Slot { id, ..Slot::EMPTY };
                self.len += 1;
                at
            }
            Err(_) => return false,
        };
        self.slots[at].hidden = true;
        if self.history.current() == Some(id) {
            self.next();
        }
        true
    }

    /// These are the photos that there are now, in the order of the listing. If the current one is gone, goes on. Gives the number
    /// of those that there was no slot for; they are not shown.
    pub fn update(&mut self, photos: &[PhotoId]) -> usize {
        self.mark(photos);
        let survivor = self.place.and_then(|place| self.first(|slot| slot.place() >= place));
        let left_out = self.add(photos);
        if self.order != Order::Shuffle {
            self.list(photos, survivor);
        }
        self.filled |= !self.is_empty();
        if self.current().is_none() {
            self.next();
        }
        left_out
    }

    /// Marks which of the photos that are known are there.
    fn mark(&mut self, photos: &[PhotoId]) {
        self.slots_mut().iter_mut().for_each(|slot| slot.present = false);
        for &id in photos {
            if let Ok(at) = self.find(id) {
                self.slots[at].present = true;
            }
        }
    }

    /// Adds those of `photos` that are not known, and gives the number of those that there is no slot for.
    fn add(&mut self, photos: &[PhotoId]) -> usize {
        let unknown = photos.iter().filter(|&&id| self.find(id).is_err()).count();
        if unknown > self.slots.len() - self.len {
            self.forget_absent();
        }
        let (salt, place) = (self.salt, self.place);
        let soon = (self.filled && self.order == Order::Shuffle).then(|| self.soon());
        let early_key = |id| soon.map(|(floor, room)| floor.saturating_add(1 + key(salt, id) % room));
        let known = self.len;
        let mut left_out = 0;
        for &id in photos {
            let (key, early) = early_key(id).map_or((key(salt, id), false), |key| (key, true));
            // Of photos that were there at the start, those up to the place have been shown.
            let slot = Slot { id, key, present: true, hidden: false, drawn: Some((key, id)) <= place, early };
            match self.slots[..known].binary_search_by_key(&id, |slot| slot.id) {
                // It was away, and its turn has passed meanwhile.
                Ok(at) if !self.slots[at].drawn && Some(self.slots[at].place()) <= place => {
                    let hidden = self.slots[at].hidden;
                    self.slots[at] = Slot { hidden, ..slot };
                }
                Ok(_) => {}
                Err(_) if self.len < self.slots.len() => {
                    self.slots[self.len] = slot;
                    self.len += 1;
                }
                Err(_) => left_out += 1,
            }
        }
        self.slots_mut().sort_unstable_by_key(|slot| slot.id);
        // A photo that was told twice.
        let mut last = None;
        self.retain(|slot| last.replace(slot.id) != Some(slot.id));
        left_out
    }

    /// Where the keys of new photos lie: above which, and in how much room.
    fn soon(&self) -> (u64, u64) {
        let floor = self.place.map_or(0, |(key, _)| key);
        let mut ceiling = self.place;
        for _ in 0..SOON {
            match self.first(|slot| !slot.early && Some(slot.place()) > ceiling) {
                Some(slot) => ceiling = Some(slot.place()),
                None => break,
            }
        }
        (floor, ceiling.map_or(0, |(key, _)| key - floor).max(LEAST_ROOM))
    }

    /// Takes the keys from the listing. `survivor` is the first photo from the place onwards that is still there.
    fn list(&mut self, photos: &[PhotoId], survivor: Option<Slot>) {
        self.forget_absent();
        // Even keys, so that there is a place between any two.
        for (key, &id) in (2..).step_by(2).zip(photos) {
            if let Ok(at) = self.find(id) {
                self.slots[at].key = key;
            }
        }
        let new_place = |id| self.find(id).ok().map(|at| self.slots[at].place());
        self.place = match (self.place, survivor) {
            // After a restart: behind the photo that was shown last, or where it was.
            (place, _) if !self.filled => {
                place.map(|(_, id)| id).or(self.history.newest()).and_then(new_place).or(place)
            }
            (Some(place), Some(slot)) if place.1 == slot.id => new_place(slot.id),
            (Some(_), Some(slot)) => new_place(slot.id).map(|(key, _)| (key - 1, slot.id)),
            (Some(_), None) => Some((u64::MAX, PhotoId(u64::MAX))),
            (None, _) => None,
        };
    }

    /// Goes back. Tells whether there was anything to go back to.
    fn back(&mut self) -> bool {
        let earlier = self.history.earlier().position(|id| self.is_visible(id));
        if let Some(steps) = earlier {
            self.history.back(steps + 1);
            return true;
        }
        let current = self.current().and_then(|id| self.find(id).ok()).map(|at| self.slots[at].place());
        match (self.order, current) {
            (Order::Name | Order::Date, Some(current)) => {
                let last =
                    |among: &dyn Fn(&&Slot) -> bool| self.visible().filter(among).max_by_key(|s| s.place());
                let before =
                    last(&|slot| slot.place() < current).or_else(|| last(&|_| true)).map(|slot| slot.id);
                before.is_some_and(|id| self.history.push_front(id))
            }
            _ => false,
        }
    }

    /// The next of the round, or of the next round, which then begins.
    fn peek(&mut self) -> Option<Slot> {
        let place = self.place;
        let next = self.first(|slot| Some(slot.place()) > place);
        // While there is no photo at all, the round waits for them to come back.
        if next.is_none() && place.is_some() && !self.is_empty() {
            self.begin_round();
            return self.first(|_| true);
        }
        next
    }

    fn begin_round(&mut self) {
        self.place = None;
        if self.order != Order::Shuffle {
            return;
        }
        self.forget_absent();
        let last = self.history.newest();
        for _ in 0..TRIES {
            self.salt = stream(self.salt, Stream::Playlist).next_u64();
            let salt = self.salt;
            for slot in self.slots_mut() {
                *slot = Slot { key: key(salt, slot.id), drawn: false, early: false, ..*slot };
            }
            if self.first(|_| true).map(|slot| slot.id) != last {
                break;
            }
        }
    }

    fn find(&self, id: PhotoId) -> Result<usize, usize> {
        self.slots[..self.len].binary_search_by_key(&id, |slot| slot.id)
    }

    fn is_visible(&self, id: PhotoId) -> bool {
        self.find(id).is_ok_and(|at| self.slots[at].is_visible())
    }

    fn visible(&self) -> impl Iterator<Item = &Slot> {
        self.slots[..self.len].iter().filter(|slot| slot.is_visible())
    }

    /// The first in the round of those `among` the photos that can be shown.
    fn first(&self, among: impl Fn(&Slot) -> bool) -> Option<Slot> {
        self.visible().filter(|slot| among(slot)).min_by_key(|slot| slot.place()).copied()
    }

    fn slots_mut(&mut self) -> &mut [Slot] {
        &mut self.slots[..self.len]
    }

    fn forget_absent(&mut self) {
        self.retain(|slot| slot.present || slot.hidden);
    }

    fn retain(&mut self, mut keep: impl FnMut(&Slot) -> bool) {
        let mut kept = 0;
        for at in 0..self.len {
            if keep(&self.slots[at]) {
                self.slots[kept] = self.slots[at];
                kept += 1;
            }
        }
        self.len = kept;
    }
}

/// The key of a photo in the round of `salt`: of 63 bits, so that there is room for new photos after the last.
fn key(salt: u64, id: PhotoId) -> u64 {
    stream(salt ^ id.0, Stream::Playlist).next_u64() >> 1
}
