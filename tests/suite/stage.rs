//! A small photo made of integers, the demo photo, and shows of them.

use yurameki::{
    app::Show,
    config::Life,
    display::sim::{Buffering, Sim, memory_len},
    effect::{
        Photo,
        shimmer::{Shimmer, storage_len},
    },
    frame::{FrameRef, Layout, Size},
    input::action::Action,
};

/// A photo and its mask.
pub(crate) struct Still {
    pub(crate) size: Size,
    pub(crate) rgb: Vec<u8>,
    pub(crate) mask: Vec<u8>,
}

impl Still {
    /// Stripes, ramps and grain in all three colours, with black and white among them. All of it moves.
    pub(crate) fn drawn(size: Size) -> Self {
        let triangle = |t: u32, period: u32| (t % period).abs_diff(period / 2) * 510 / period;
        let pixel = |i: usize| {
            let (x, y) = (i as u32 % size.width, i as u32 / size.width);
            let grain = (x * 73 + y * 179 + x * y * 31) % 41;
            let red = triangle(x * 3 + y, 47) + grain;
            let green = (triangle(x + 2 * y, 31) + x * 255 / size.width) / 2 + grain;
            let blue = (triangle(3 * y + 500 - x % 500, 61) * 3 / 2).saturating_sub(30);
            [red, green, blue].map(|level| level.min(255) as u8)
        };
        let rgb = (0..size.pixels()).flat_map(pixel).collect();
        Self { size, rgb, mask: vec![255; size.pixels()] }
    }

    /// The demo photo, shrunk to fill `size`. All of it moves.
    #[cfg(feature = "os")]
    pub(crate) fn demo(size: Size) -> Self {
        use yurameki::os::photo::{Fit, Options, from_bytes};
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/demo.jpg");
        let options = Options { fit: Fit::Fill, ..Options::new(size) };
        let photo =
            from_bytes("demo.jpg", &std::fs::read(file).expect("demo.jpg"), &options).expect("a photo");
        Self { size, rgb: photo.rgb, mask: vec![255; size.pixels()] }
    }

    /// With a mask of soft edges, holes, thin lines and wide still parts.
    pub(crate) fn with_holes(mut self) -> Self {
        let (width, height) = (self.size.width as i64, self.size.height as i64);
        let level = |i: usize| {
            let (x, y) = (i as i64 % width, i as i64 / width);
            let (dx, dy) = (3 * x - width, 2 * y - height);
            let soft = 300 - 500 * (dx * dx + dy * dy) / (width * width + height * height);
            let hole = x % 23 < 4 && y % 11 < 5;
            let line = x == width - 2 || y % 29 == 3 && x % 40 == 0;
            if line {
                255
            } else if hole {
                0
            } else {
                soft.clamp(0, 255) as u8
            }
        };
        self.mask = (0..self.size.pixels()).map(level).collect();
        self
    }

    /// What an effect is prepared from.
    pub(crate) fn photo(&self) -> Photo<'_> {
        Photo { size: self.size, rgb: &self.rgb, mask: &self.mask }
    }

    /// The colours of the pixel at column `x`, row `y`.
    pub(crate) fn rgb_at(&self, x: u32, y: u32) -> [u8; 3] {
        self.rgb.as_chunks().0[y as usize * self.size.width as usize + x as usize]
    }
}

/// How a photo is shown.
#[derive(Clone, Copy)]
pub(crate) struct Staging<'a> {
    pub(crate) life: Life,
    pub(crate) frames_per_second: u32,
    pub(crate) seed: u64,
    pub(crate) layout: Layout,
    pub(crate) buffering: Buffering,
    /// Presses, each before the frame of its number.
    pub(crate) presses: &'a [(u32, Action)],
}

impl Staging<'_> {
    /// Shows the first `frames` frames to `look`, and gives back the panel's memory, which held `untouched` at first.
    pub(crate) fn show(
        &self,
        still: &Still,
        frames: u32,
        untouched: u8,
        mut look: impl FnMut(u32, FrameRef<'_>),
    ) -> Vec<u8> {
        let mut storage = vec![0; storage_len(still.size)];
        let mut shimmer =
            Shimmer::prepare(still.photo(), &self.life.shimmer, &mut storage).expect("enough storage");
        let mut memory = vec![untouched; memory_len(self.layout, self.buffering)];
        let mut panel = Sim::new(&mut memory[..], self.layout, self.buffering, 0).expect("enough memory");
        let mut show = Show::new(self.life.drive, self.frames_per_second, self.seed);
        for frame in 0..frames {
            for (_, action) in self.presses.iter().filter(|(at, _)| *at == frame) {
                let _ = show.press(*action);
            }
            show.turn(&mut shimmer, "a photo.jpg", &mut panel).expect("a simulated panel shows everything");
            look(frame, panel.shown().expect("presented"));
        }
        memory
    }
}
