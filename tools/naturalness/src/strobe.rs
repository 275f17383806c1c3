//! What could harm people with photosensitive epilepsy: ITU-R BT.1702 and WCAG 2.3 limit flashes of large parts of a picture.

use crate::{Clip, temporal::Spectrum};

/// The mean of the luminance may change by at most this share of full white from frame to frame.
pub const MEAN_STEP: f32 = 0.02;

/// No component of 3 to 30 Hz may have more than this modulation (half of its swing by the mean) …
pub const MODULATION: f32 = 0.10;

/// … on more than this share of the picture.
pub const AREA: f32 = 0.25;

/// How near a clip is to the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strobe {
    /// The largest change of the mean from frame to frame, as a share of full white.
    pub mean_step: f32,
    /// The largest share of the picture that a component between 3 and 30 Hz modulates by more than [`MODULATION`].
    pub area: f32,
}

impl Strobe {
    /// Measures `clip`: cells of 16 pixels, windows of a second or of the clip, whichever is shorter.
    pub fn of(clip: &Clip) -> Self {
        Self { mean_step: mean_step(clip), area: area(clip) }
    }

    /// Whether nobody is harmed.
    pub fn is_safe(self) -> bool {
        self.mean_step <= MEAN_STEP && self.area <= AREA
    }
}

fn mean_step(clip: &Clip) -> f32 {
    let means: Vec<f64> = clip
        .frames
        .iter()
        .map(|frame| frame.iter().map(|&value| f64::from(value)).sum::<f64>() / frame.len() as f64)
        .collect();
    means.windows(2).map(|pair| ((pair[1] - pair[0]).abs() / 255.0) as f32).fold(0.0, f32::max)
}

fn area(clip: &Clip) -> f32 {
    const CELL: usize = 16;
    let window = (clip.rate.round() as usize).min(clip.frames.len()) & !1;
    let (columns, rows) = (clip.width / CELL, clip.height / CELL);
    if window < 4 || columns * rows == 0 {
        return 0.0;
    }
    let mut spectrum = Spectrum::new(window);
    let mut over = vec![0usize; window / 2];
    for cell in 0..columns * rows {
        let (x, y) = (cell % columns * CELL, cell / columns * CELL);
        let levels: Vec<f32> = clip
            .frames
            .iter()
            .map(|frame| {
                let rows = (y..y + CELL).flat_map(|row| &frame[row * clip.width + x..][..CELL]);
                rows.sum::<f32>() / (CELL * CELL) as f32
            })
            .collect();
        // A dark cell that swings by a few levels is no flash: WCAG counts from a tenth of full white on.
        let mean = (levels.iter().sum::<f32>() / levels.len() as f32).max(25.5);
        let power = spectrum.of(|frame| levels[frame], levels.len());
        for (count, power) in over.iter_mut().zip(power) {
            // A sine of amplitude a has the power a²·(Σw)²/(4·Σw²) = a²·n/6 under a Hann window.
            let amplitude = (power * 6.0 / window as f32).sqrt();
            *count += usize::from(amplitude / mean > MODULATION);
        }
    }
    let hertz = |number: usize| (number + 1) as f32 * clip.rate / window as f32;
    let worst = over.iter().enumerate().filter(|(number, _)| (3.0..=30.0).contains(&hertz(*number)));
    worst.map(|(_, count)| *count).max().unwrap_or(0) as f32 / (columns * rows) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    fn blinking(hertz: f32, modulation: f32, share: f32) -> Clip {
        let frame = |number: usize| {
            let level = 128.0 * (1.0 + modulation * (TAU * hertz * number as f32 / 24.0).sin());
            (0..64 * 64).map(|index| if (index as f32) < share * 4096.0 { level } else { 128.0 }).collect()
        };
        Clip { width: 64, height: 64, rate: 24.0, frames: (0..48).map(frame).collect() }
    }

    #[test]
    fn a_strobe_is_refused_and_a_slow_swell_is_not() {
        assert!(Strobe::of(&blinking(8.0, 0.3, 0.5)).area >= 0.5);
        assert!(!Strobe::of(&blinking(8.0, 0.3, 0.5)).is_safe());
        assert_eq!(Strobe::of(&blinking(8.0, 0.05, 0.5)).area, 0.0);
        assert_eq!(Strobe::of(&blinking(1.0, 0.05, 1.0)).area, 0.0);
        assert!(Strobe::of(&blinking(8.0, 0.3, 0.25)).area <= AREA);
    }

    #[test]
    fn a_jump_of_the_whole_picture_is_a_step() {
        let strobe = Strobe::of(&blinking(12.0 - 1e-3, 0.0, 1.0));
        assert_eq!(strobe.mean_step, 0.0);
        let mut clip = blinking(1.0, 0.0, 1.0);
        clip.frames[5].iter_mut().for_each(|value| *value += 25.5);
        assert!((Strobe::of(&clip).mean_step - 0.1).abs() < 1e-4);
    }
}
