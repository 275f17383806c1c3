use super::{HISTORY, History, PhotoId, Playlist, Slot};
use crate::config::Order;
use core::ops::DerefMut;
use heapless::Vec;

/// New photos of a round whose places are kept. Those beyond come where the salt puts them: again in this round, or in the next.
pub const EARLY: usize = 256;

/// What a playlist must remember over a restart: at most 6 KiB, however many photos there are. Hidden photos are not in it;
/// they are in a list of their own, which people can read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot {
    /// The order of the round.
    pub order: Order,
    /// What the round was shuffled by.
    pub salt: u64,
    /// The key and the photo that were drawn last in this round.
    pub place: Option<(u64, PhotoId)>,
    /// What was shown, from the oldest to the newest.
    pub history: Vec<PhotoId, HISTORY>,
    /// How many photos of the history come after the current one.
    pub back: usize,
    /// Photos that came in this round, and their keys.
    pub early: Vec<(PhotoId, u64), EARLY>,
}

impl<M: DerefMut<Target = [Slot]>> Playlist<M> {
    /// What must be remembered.
    pub fn snapshot(&self) -> Snapshot {
        // One whose turn passed while it was away is new again when it comes back.
        let passed_over = |slot: &Slot| !slot.drawn && Some(slot.place()) <= self.place;
        let early = self.slots[..self.len].iter().filter(|slot| slot.early && !passed_over(slot));
        Snapshot {
            order: self.order,
            salt: self.salt,
            place: self.place,
            history: self.history.photos().collect(),
            back: self.history.gone_back(),
            early: early.take(EARLY).map(|slot| (slot.id, slot.key)).collect(),
        }
    }

    /// The playlist that goes on from `snapshot` once the first [`Playlist::update`] has told which photos there are: with the
    /// same photo, if it is still there. With another `order` than that of the snapshot a round of its own begins. The
    /// `seed` is that of [`Playlist::new`].
    pub fn restore(slots: M, order: Order, seed: u64, snapshot: &Snapshot) -> Self {
        let mut playlist = Self::new(slots, order, seed);
        playlist.history = History::new(&snapshot.history, snapshot.back);
        if order != snapshot.order {
            return playlist;
        }
        (playlist.salt, playlist.place) = (snapshot.salt, snapshot.place);
        for (slot, &(id, key)) in playlist.slots.iter_mut().zip(&snapshot.early) {
            let drawn = Some((key, id)) <= snapshot.place;
            *slot = Slot { id, key, drawn, early: true, ..Slot::EMPTY };
            playlist.len += 1;
        }
        playlist.slots_mut().sort_unstable_by_key(|slot| slot.id);
        playlist
    }
}
