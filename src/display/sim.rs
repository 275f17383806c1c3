//! The simulated panel: any geometry, in memory.
//!
//! It is what the tests draw to, and a product: `--display sim:800x480:RGB565:2048` runs the whole program for a panel that
//! is not at hand. It paints nothing by itself, waits for nothing and reads no clock.

use super::{BackBuffer, Display, DisplayError, Mode};
use crate::frame::{FrameMut, FrameRef, Layout, LayoutError, PixelFormat, Size, UnknownFormat};
use core::{fmt, ops::DerefMut, str::FromStr};

/// How many frame buffers a panel shows in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Buffering {
    /// One, painted while it is shown: a back buffer is 1 present old.
    Single,
    /// Two, one painted while the other is shown: a back buffer is 2 presents old.
    Double,
}

impl Buffering {
    const fn count(self) -> usize {
        match self {
            Self::Single => 1,
            Self::Double => 2,
        }
    }
}

/// A panel in memory `M`: lent (`&mut [u8]`) or owned (`Vec<u8>`).
#[derive(Debug)]
pub struct Sim<M> {
    memory: M,
    mode: Mode,
    buffering: Buffering,
    /// The number of the back buffer.
    back: usize,
    /// Presents since the buffers' pixels were unknown.
    known: u64,
    now_us: u64,
    log: PresentLog,
}

/// The bytes that a simulated panel needs: [`Layout::len_bytes`] for each buffer.
pub const fn memory_len(layout: Layout, buffering: Buffering) -> usize {
    // Saturates for a layout that no memory could hold, so that the check of the memory refuses it.
    layout.len_bytes().saturating_mul(buffering.count())
}

impl<M: DerefMut<Target = [u8]>> Sim<M> {
    /// A panel of `layout` in `memory`, which must hold [`memory_len`] bytes and may hold more. It expects a present
    /// `refresh_millihertz` / 1000 times a second (0: whenever one comes), and counts those that it misses as dropped.
    pub fn new(
        memory: M,
        layout: Layout,
        buffering: Buffering,
        refresh_millihertz: u32,
    ) -> Result<Self, LayoutError> {
        let mode = Mode { layout, refresh_millihertz };
        let mut sim = Self { memory, mode, buffering, back: 0, known: 0, now_us: 0, log: PresentLog::new() };
        sim.set_layout(layout)?;
        Ok(sim)
    }

    /// Changes size, format and stride, as a panel does when another monitor is plugged in. Nothing is shown then until the
    /// next present, and what the buffers hold is unknown. Refused, with nothing changed, where the memory is too short.
    pub fn set_layout(&mut self, layout: Layout) -> Result<(), LayoutError> {
        let needed = memory_len(layout, self.buffering);
        if self.memory.len() < needed {
            return Err(LayoutError::Memory { needed, got: self.memory.len() });
        }
        self.mode.layout = layout;
        self.forget();
        Ok(())
    }

    /// Takes what the buffers hold as unknown, as after a switch from another console: nothing is shown until the next
    /// present, and every buffer is of age 0 until it was presented again.
    pub const fn forget(&mut self) {
        self.known = 0;
    }

    /// Sets the time, in microseconds from any start, that the log notes for the presents to come. It must not run back.
    pub fn set_now(&mut self, now_us: u64) {
        self.now_us = now_us;
    }

    /// The time in microseconds as it was set last.
    pub const fn now_us(&self) -> u64 {
        self.now_us
    }

    /// The frame that was presented last; `None` before the first present. With [`Buffering::Single`] it is the back buffer
    /// too, and so holds what has been painted since.
    pub fn shown(&self) -> Option<FrameRef<'_>> {
        let front = self.after(self.back);
        let frame = FrameRef::new(&self.memory[self.start_of(front)..], self.mode.layout).ok()?;
        (self.known > 0).then_some(frame)
    }

    /// What was presented when.
    pub const fn log(&self) -> &PresentLog {
        &self.log
    }

    /// The pixel memory, whole.
    pub fn memory(&self) -> &[u8] {
        &self.memory
    }

    /// The buffer whose turn comes after that of `buffer`; with two of them also the one whose turn came before.
    const fn after(&self, buffer: usize) -> usize {
        (buffer + 1) % self.buffering.count()
    }

    /// Where in the memory `buffer` starts.
    const fn start_of(&self, buffer: usize) -> usize {
        buffer * self.mode.layout.len_bytes()
    }
}

impl<M: DerefMut<Target = [u8]>> Display for Sim<M> {
    fn mode(&self) -> Mode {
        self.mode
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        let age = if self.known < self.buffering.count() as u64 { 0 } else { self.buffering.count() as u32 };
        let start = self.start_of(self.back);
        // The length was checked with the layout.
        let frame =
            FrameMut::new(&mut self.memory[start..], self.mode.layout).map_err(|_| DisplayError::Lost)?;
        Ok(BackBuffer { frame, age })
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        self.back = self.after(self.back);
        self.known += 1;
        self.log.note(self.now_us, self.mode.refresh_millihertz);
        Ok(())
    }
}

/// When frames were presented: all of them counted, the last ones by time.
#[derive(Clone, Debug)]
pub struct PresentLog {
    presents: u64,
    dropped: u64,
    first_us: u64,
    last_us: u64,
    recent_us: heapless::HistoryBuf<u64, { PresentLog::RECENT }>,
}

impl PresentLog {
    /// How many times are kept: two seconds at 60 frames a second, in 1 KiB.
    pub const RECENT: usize = 128;

    const fn new() -> Self {
        Self { presents: 0, dropped: 0, first_us: 0, last_us: 0, recent_us: heapless::HistoryBuf::new() }
    }

    /// Frames presented.
    pub const fn presents(&self) -> u64 {
        self.presents
    }

    /// Refreshes between the first present and the last that had no frame of their own: each gap between presents is
    /// rounded to whole refreshes, and all but one of those were missed.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Frames a second from the first present to the last, in thousandths; 0 before the time has moved.
    pub fn mean_millihertz(&self) -> u64 {
        let span_us = self.last_us.saturating_sub(self.first_us);
        let gaps = u128::from(self.presents.saturating_sub(1));
        let millihertz = (gaps * 1_000_000_000).checked_div(u128::from(span_us)).unwrap_or(0);
        u64::try_from(millihertz).unwrap_or(u64::MAX)
    }

    /// The times of the last [`Self::RECENT`] presents in microseconds, oldest first.
    pub fn recent_us(&self) -> impl Iterator<Item = u64> + '_ {
        self.recent_us.oldest_ordered().copied()
    }

    fn note(&mut self, now_us: u64, refresh_millihertz: u32) {
        if self.presents == 0 {
            self.first_us = now_us;
        } else {
            let gap_us = u128::from(now_us.saturating_sub(self.last_us));
            let refreshes = (gap_us * u128::from(refresh_millihertz) + 500_000_000) / 1_000_000_000;
            let missed = u64::try_from(refreshes.saturating_sub(1)).unwrap_or(u64::MAX);
            self.dropped = self.dropped.saturating_add(missed);
        }
        self.presents += 1;
        self.last_us = now_us;
        self.recent_us.write(now_us);
    }
}

/// A simulated panel as people ask for it: `sim:WIDTHxHEIGHT[:FORMAT[:STRIDE_BYTES]]`.
///
/// The format is XRGB8888 and the rows have no gap unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spec(pub Layout);

impl Spec {
    /// The longest stride that can be asked for: the longest row there is (16,384 pixels of 4 bytes), and as much again for
    /// padding. A slip of the finger then gives a message instead of an allocation of gigabytes.
    pub const MAX_STRIDE_BYTES: usize = 2 * 4 * Layout::MAX_SIDE as usize;
}

/// Why a [`Spec`] cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpecError {
    /// It has not the form of one.
    Form,
    /// Width and height are not two whole numbers with an `x` between them.
    Size,
    /// The third part names no pixel format.
    Format(UnknownFormat),
    /// The fourth part is not a number of bytes up to [`Spec::MAX_STRIDE_BYTES`].
    Stride,
    /// The parts are fine, but no frame is like that.
    Layout(LayoutError),
}

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Form => f.write_str(
                "a simulated display is asked for as sim:WIDTHxHEIGHT[:FORMAT[:STRIDE_BYTES]], like sim:800x480:RGB565:2048",
            ),
            Self::Size => write!(
                f,
                "the size must be WIDTHxHEIGHT in pixels, each 1 to {}, like 800x480",
                Layout::MAX_SIDE
            ),
            Self::Format(unknown) => unknown.fmt(f),
            Self::Stride => write!(
                f,
                "the stride must be a number of bytes from row to row, at most {}",
                Spec::MAX_STRIDE_BYTES
            ),
            Self::Layout(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SpecError {}

impl FromStr for Spec {
    type Err = SpecError;

    fn from_str(words: &str) -> Result<Self, SpecError> {
        let mut parts = words.split(':');
        let (Some("sim"), Some(size)) = (parts.next(), parts.next()) else {
            return Err(SpecError::Form);
        };
        let (format, stride, None) = (parts.next(), parts.next(), parts.next()) else {
            return Err(SpecError::Form);
        };
        let size = parse_size(size).ok_or(SpecError::Size)?;
        let format = match format {
            Some(word) => word.parse().map_err(SpecError::Format)?,
            None => PixelFormat::Xrgb8888,
        };
        let stride_bytes = match stride {
            Some(word) => Some(parse_stride(word).ok_or(SpecError::Stride)?),
            None => None,
        };
        Layout::new(size, format, stride_bytes).map(Self).map_err(SpecError::Layout)
    }
}

fn parse_size(word: &str) -> Option<Size> {
    let (width, height) = word.split_once(['x', 'X', '×'])?;
    Some(Size::new(width.parse().ok()?, height.parse().ok()?))
}

fn parse_stride(word: &str) -> Option<usize> {
    word.parse().ok().filter(|&bytes| bytes <= Spec::MAX_STRIDE_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout() -> Layout {
        Layout::new(Size::new(3, 2), PixelFormat::Rgb565, Some(9)).expect("a good layout")
    }

    fn ages(buffering: Buffering) -> Vec<u32> {
        let mut sim = Sim::new(vec![0; 30], layout(), buffering, 0).expect("enough memory");
        (0..4)
            .map(|_| {
                let age = sim.back_buffer().expect("always there").age;
                sim.present().expect("always works");
                age
            })
            .collect()
    }

    #[test]
    fn a_single_buffer_is_one_present_old_and_two_are_two() {
        assert_eq!(ages(Buffering::Single), [0, 1, 1, 1]);
        assert_eq!(ages(Buffering::Double), [0, 0, 2, 2]);
    }

    #[test]
    fn nothing_is_shown_before_the_first_present_and_after_a_change_of_layout() {
        let mut sim = Sim::new(vec![0; 30], layout(), Buffering::Double, 0).expect("enough memory");
        assert!(sim.shown().is_none());
        sim.present().expect("always works");
        assert!(sim.shown().is_some());
        sim.set_layout(layout()).expect("enough memory");
        assert!(sim.shown().is_none());
        assert_eq!(sim.back_buffer().expect("always there").age, 0);
    }

    #[test]
    fn two_buffers_need_twice_the_memory() {
        assert_eq!(memory_len(layout(), Buffering::Single), 15);
        let error = Sim::new(vec![0; 29], layout(), Buffering::Double, 0).expect_err("one byte short");
        assert_eq!(error, LayoutError::Memory { needed: 30, got: 29 });
    }

    #[test]
    fn the_log_tells_rate_and_dropped_frames() {
        let mut sim = Sim::new(vec![0; 15], layout(), Buffering::Single, 50_000).expect("enough memory");
        for now_us in [7_000, 27_100, 46_900, 107_000, 127_000] {
            sim.set_now(now_us);
            sim.present().expect("always works");
        }
        assert_eq!((sim.log().presents(), sim.log().dropped()), (5, 2));
        assert_eq!(sim.log().mean_millihertz(), 33_333);
        assert_eq!(sim.log().recent_us().last(), Some(127_000));
    }

    #[test]
    fn the_log_is_bounded_and_survives_a_clock_that_stands_runs_back_or_leaps() {
        let mut log = PresentLog::new();
        assert_eq!(log.mean_millihertz(), 0);
        for now_us in [5, 5, 3, 0, u64::MAX] {
            log.note(now_us, u32::MAX);
        }
        (0..1000).for_each(|_| log.note(u64::MAX, 60_000));
        assert_eq!(log.recent_us().count(), PresentLog::RECENT);
        assert_eq!(log.presents(), 1005);
        assert_eq!(log.mean_millihertz(), 0, "one thousand frames in the age of the universe");
    }

    #[test]
    fn a_spec_names_size_format_and_stride() {
        let parse = |words: &str| words.parse::<Spec>().map(|spec| spec.0);
        let new = |w, h, format, stride| Ok(Layout::new(Size::new(w, h), format, stride).expect("good"));
        assert_eq!(parse("sim:800x480"), new(800, 480, PixelFormat::Xrgb8888, None));
        assert_eq!(parse("sim:1366x768:rgb565"), new(1366, 768, PixelFormat::Rgb565, None));
        assert_eq!(parse("sim:1366X768:RGB565:2752"), new(1366, 768, PixelFormat::Rgb565, Some(2752)));
    }

    #[test]
    fn a_bad_spec_is_refused_with_its_cure() {
        let message = |words: &str| words.parse::<Spec>().expect_err(words).to_string();
        for words in ["", "sim", "800x480", "sim:1x1:RGB888:3:4", "window"] {
            assert!(message(words).contains("sim:WIDTHxHEIGHT"), "{words}");
        }
        for words in ["sim:", "sim:800", "sim:x480", "sim:-1x5", "sim:99999999999x1", "sim:800 x480"] {
            assert!(message(words).contains("like 800x480"), "{words}");
        }
        assert!(message("sim:0x480").contains("1 to 16384"));
        assert!(message("sim:8x4:RGB").contains("RGB565"));
        assert_eq!(message("sim:8x4:RGB565:15"), "a stride of 15 bytes: the pixels of a row take 16");
        for words in ["sim:8x4:RGB565:", "sim:8x4:RGB565:many", "sim:8x4:RGB565:99999999999999999999"] {
            assert!(message(words).contains("at most 131072"), "{words}");
        }
    }
}
