//! The shimmer in float32, as one would first write it: the paper's equations 1, 3 and 4 and Lambert's law, pixel by pixel.

use yurameki::frame::Size;

pub(crate) struct Naive {
    size: Size,
    rgb: Vec<u8>,
    phase: Vec<f32>,
    heights: Vec<f32>,
    frame: Vec<u8>,
}

impl Naive {
    pub(crate) fn new(size: Size, rgb: &[u8]) -> Self {
        let luma = |p: &[u8]| 0.2126 * f32::from(p[0]) + 0.7152 * f32::from(p[1]) + 0.0722 * f32::from(p[2]);
        let phase = rgb.chunks_exact(3).map(|p| ((luma(p) - 127.5) / 127.5).asin()).collect();
        Self {
            size,
            rgb: rgb.into(),
            phase,
            heights: vec![0.0; size.pixels()],
            frame: vec![0; size.pixels() * 4],
        }
    }

    pub(crate) fn render(&mut self, frame: u32) -> u8 {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let theta = frame as f32 * std::f32::consts::TAU / 20.0;
        for (h, alpha) in self.heights.iter_mut().zip(&self.phase) {
            *h = 127.5 + 127.5 * 0.5 * (theta + alpha).sin();
        }
        for y in 0..height {
            for x in 0..width {
                let at = |x: usize, y: usize| self.heights[y.min(height - 1) * width + x.min(width - 1)];
                let dx = (at(x + 1, y) - at(x.saturating_sub(1), y)) * 0.05;
                let dy = (at(x, y + 1) - at(x, y.saturating_sub(1))) * 0.05;
                let shade = ((0.707 + 0.5 * dx + 0.5 * dy) / (1.0 + dx * dx + dy * dy).sqrt()).max(0.0);
                let gain = 1.0 + (shade - 0.707) / 0.707;
                let i = y * width + x;
                for channel in 0..3 {
                    let value = f32::from(self.rgb[i * 3 + channel]) * gain;
                    self.frame[i * 4 + 2 - channel] = value.clamp(0.0, 255.0) as u8;
                }
            }
        }
        self.frame[self.frame.len() / 2]
    }
}
