//! The order in which photos are shown.

/// A place in a round of photos. Photos are numbered; whoever shows them knows their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Playlist {
    photos: usize,
    current: usize,
    forwards: bool,
}

impl Playlist {
    /// The round of photos 0..`photos`, at its first; `None` where there is no photo.
    pub const fn new(photos: usize) -> Option<Self> {
        if photos == 0 { None } else { Some(Self { photos, current: 0, forwards: true }) }
    }

    /// The number of the photo to show.
    pub const fn current(&self) -> usize {
        self.current
    }

    /// Goes on to the next photo, after the last to the first.
    pub const fn next(&mut self) {
        self.forwards = true;
        self.step();
    }

    /// Goes back to the photo before, from the first to the last.
    pub const fn previous(&mut self) {
        self.forwards = false;
        self.step();
    }

    /// The current photo could not be shown: goes on in the direction taken last.
    pub const fn skip(&mut self) {
        self.step();
    }

    const fn step(&mut self) {
        let step = if self.forwards { 1 } else { self.photos - 1 };
        self.current = (self.current + step) % self.photos;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_round_closes_in_both_directions() {
        let mut list = Playlist::new(3).unwrap();
        let mut seen = [0; 4].map(|_| {
            list.next();
            list.current()
        });
        assert_eq!(seen, [1, 2, 0, 1]);
        seen = seen.map(|_| {
            list.previous();
            list.current()
        });
        assert_eq!(seen, [0, 2, 1, 0]);
        assert_eq!(Playlist::new(0), None);
    }

    #[test]
    fn a_bad_photo_is_skipped_in_the_direction_of_travel() {
        let mut list = Playlist::new(4).unwrap();
        list.previous();
        list.skip();
        assert_eq!(list.current(), 2);
    }
}
