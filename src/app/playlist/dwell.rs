use core::time::Duration;

/// How long a photo stays. Only the time counts in which it is really shown: whoever pauses or blanks passes none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dwell {
    length: Option<Duration>,
    shown: Duration,
}

impl Dwell {
    /// A photo that is shown for `length` from now on; without one, until somebody asks for another.
    pub const fn new(length: Option<Duration>) -> Self {
        Self { length, shown: Duration::ZERO }
    }

    /// The photo was shown for `time` more. Tells whether the next is due.
    pub const fn pass(&mut self, time: Duration) -> bool {
        self.shown = self.shown.saturating_add(time);
        self.is_over()
    }

    /// Whether the next photo is due.
    pub const fn is_over(&self) -> bool {
        match self.length {
            Some(length) => self.shown.as_nanos() >= length.as_nanos(),
            None => false,
        }
    }
}
