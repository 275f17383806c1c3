//! Whether a video can be used: the paper's conditions (section 4), measured.
//!
//! | condition | measure |
//! |---|---|
//! | large enough | both sides at least [`LEAST_SIDE`]: one patch at half its size |
//! | long enough | at least [`LEAST_FRAMES`] frames |
//! | a fixed camera | the motion that most of what is textured shares: see [`camera_motion`] |
//! | neither looped nor synthetic | the first frame's deviation from the mean is not the last one's: see [`loop_correlation`] |
//! | fluid | at least a patch of it |

use crate::{
    motion::{field::LumaFrames, flow::Flow},
    patch::SIDE,
};
use std::fmt;

/// Least width and height.
pub const LEAST_SIDE: u32 = 2 * SIDE as u32;

/// Least number of frames: less has no motion to speak of.
pub const LEAST_FRAMES: usize = 12;

/// Share of the moving frames' textured points that move as one if the camera moves.
const AS_ONE: f32 = 0.6;

/// How far from the common motion a point may be and still move with it: so many pixels, and a share of the motion.
const TOLERANCE: (f32, f32) = (0.2, 0.15);

/// Shake or drift of the camera, in pixels a frame, that is still taken: the motion that counts as fluid is as large.
const STEADY: f32 = 0.15;

/// Correlation of the first and the last frame from which a video counts as looped.
const LOOPED: f32 = 0.5;

/// Why a video was not taken.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// It cannot be read.
    Unreadable(String),
    /// It is too small.
    Small(u32, u32),
    /// It is too short: frames there are.
    Short(usize),
    /// The camera moves, by so many pixels a frame.
    MovingCamera(f32),
    /// It repeats itself: the correlation.
    Looped(f32),
    /// Nothing moves that could be fluid.
    Still,
}

impl Refusal {
    /// Whether the person can have it taken all the same.
    pub fn can_be_forced(&self) -> bool {
        matches!(self, Self::MovingCamera(_) | Self::Looped(_))
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(reason) => write!(f, "cannot be read: {reason}"),
            Self::Small(width, height) => {
                write!(f, "too small: {width} × {height}, {LEAST_SIDE} × {LEAST_SIDE} is the least")
            }
            Self::Short(frames) => {
                write!(f, "too short: {frames} different frames, {LEAST_FRAMES} are the least")
            }
            Self::MovingCamera(motion) => {
                write!(
                    f,
                    "the camera moves by {motion:.2} pixels a frame, {STEADY} is the most (--force takes it)"
                )
            }
            Self::Looped(correlation) => write!(
                f,
                "looped or synthetic: the first and the last frame correlate by {correlation:.2}, {LOOPED} is the most (--force takes it)"
            ),
            Self::Still => write!(f, "nothing in it moves, changes and shows something"),
        }
    }
}

/// Size and length.
///
/// # Errors
///
/// What is too small.
pub fn check_size(width: u32, height: u32, frames: usize) -> Result<(), Refusal> {
    if width < LEAST_SIDE || height < LEAST_SIDE {
        return Err(Refusal::Small(width, height));
    }
    if frames < LEAST_FRAMES { Err(Refusal::Short(frames)) } else { Ok(()) }
}

/// Camera and loop.
///
/// # Errors
///
/// The camera moves, or the video is looped.
pub fn check_scene(luma: LumaFrames<'_>, flows: &[Flow]) -> Result<(), Refusal> {
    let motion = camera_motion(luma, flows);
    if motion > STEADY {
        return Err(Refusal::MovingCamera(motion));
    }
    let correlation = loop_correlation(luma);
    if correlation > LOOPED { Err(Refusal::Looped(correlation)) } else { Ok(()) }
}

/// The camera's motion in pixels a frame: of the frames, the mean length of the median motion of what is textured; 0 for frames where
/// fewer than `AS_ONE` of the textured points share it. Fluid that fills the picture never moves as one: points differ from each
/// other by much of their motion.
pub fn camera_motion(luma: LumaFrames<'_>, flows: &[Flow]) -> f32 {
    let motions: f32 =
        flows.iter().zip(luma.frames).map(|(flow, frame)| common_motion(luma, frame, flow)).sum();
    motions / flows.len().max(1) as f32
}

fn common_motion(luma: LumaFrames<'_>, frame: &[u8], flow: &Flow) -> f32 {
    let grid = crate::motion::GRID;
    let points = (1..flow.rows - 1).flat_map(|row| (1..flow.columns - 1).map(move |column| (column, row)));
    let textured: Vec<[f32; 2]> = points
        .filter(|(column, row)| is_textured(frame, luma.width, column * grid, row * grid))
        .map(|(column, row)| {
            flow.values[row * flow.columns + column].map(|part| f32::from(part) / Flow::UNIT)
        })
        .collect();
    if textured.len() * 50 < flow.values.len() {
        return 0.0;
    }
    let common = [0, 1].map(|part| median(textured.iter().map(|motion| motion[part]).collect()));
    let length = common[0].hypot(common[1]);
    let tolerance = TOLERANCE.0 + TOLERANCE.1 * length;
    let with_it = textured
        .iter()
        .filter(|motion| (motion[0] - common[0]).hypot(motion[1] - common[1]) < tolerance)
        .count();
    if with_it as f32 > AS_ONE * textured.len() as f32 { length } else { 0.0 }
}

/// Whether a corner or a busy texture is at a place: luminance differs both along the row and down.
fn is_textured(frame: &[u8], width: usize, x: usize, y: usize) -> bool {
    /// Sum of four differences, well over noise.
    const BUSY: u32 = 24;
    let at = |dx: usize, dy: usize| frame[(y + dy) * width + x + dx];
    let along: u32 = (0..4).map(|row| u32::from(at(0, row).abs_diff(at(3, row)))).sum();
    let down: u32 = (0..4).map(|column| u32::from(at(column, 0).abs_diff(at(column, 3)))).sum();
    along.min(down) > BUSY
}

fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// Correlation of the first and the last frame, the mean of all frames taken off both. A video that ends where it begins has nearly 1;
/// in nature it is around 0, or under it when something moves slowly one way.
pub fn loop_correlation(luma: LumaFrames<'_>) -> f32 {
    let (Some(first), Some(last)) = (luma.frames.first(), luma.frames.last()) else { return 0.0 };
    let mut sums = vec![0u32; first.len()];
    for frame in luma.frames {
        sums.iter_mut().zip(frame).for_each(|(sum, level)| *sum += u32::from(*level));
    }
    let count = luma.frames.len() as f64;
    let (mut both, mut one, mut two) = (0.0, 0.0, 0.0);
    for ((sum, first), last) in sums.iter().zip(first).zip(last) {
        let mean = f64::from(*sum) / count;
        let (a, b) = (f64::from(*first) - mean, f64::from(*last) - mean);
        both += a * b;
        one += a * a;
        two += b * b;
    }
    if one * two > 0.0 { (both / (one * two).sqrt()) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(x: f32, y: f32) -> f32 {
        128.0 + 30.0 * ((0.31 * x + 0.12 * y).sin() + (0.23 * y - 0.17 * x).cos() + (0.4 * y).sin())
    }

    fn frames(count: usize, level: impl Fn(usize, f32, f32) -> f32) -> Vec<Vec<u8>> {
        (0..count)
            .map(|frame| {
                (0..160 * 120)
                    .map(|pixel| level(frame, (pixel % 160) as f32, (pixel / 160) as f32) as u8)
                    .collect()
            })
            .collect()
    }

    fn checked(frames: &[Vec<u8>]) -> Result<(), Refusal> {
        let flows: Vec<Flow> =
            frames.windows(2).map(|pair| Flow::between(&pair[0], &pair[1], 160, 120)).collect();
        check_scene(LumaFrames { width: 160, height: 120, frames }, &flows)
    }

    #[test]
    fn a_moving_camera_is_measured() {
        let panned = frames(12, |frame, x, y| texture(x + 1.5 * frame as f32, y));
        let Err(Refusal::MovingCamera(motion)) = checked(&panned) else { panic!("taken") };
        assert!((motion - 1.5).abs() < 0.1, "{motion}");
    }

    #[test]
    fn a_river_between_its_banks_is_no_moving_camera() {
        let river = frames(12, |frame, x, y| {
            texture(if (40.0..80.0).contains(&y) { x + 1.5 * frame as f32 } else { x }, y)
        });
        assert_eq!(checked(&river), Ok(()));
    }

    #[test]
    fn a_loop_is_found_out() {
        let swing = |frame: usize| 3.0 * (core::f32::consts::TAU * frame as f32 / 11.0).cos();
        let river = frames(12, |frame, x, y| texture(if y < 40.0 { x + swing(frame) } else { x }, y));
        assert!(matches!(checked(&river), Err(Refusal::Looped(correlation)) if correlation > 0.9));
    }

    #[test]
    fn small_and_short_videos_are_refused_with_their_figures() {
        assert_eq!(check_size(96, 96, 12), Ok(()));
        let refusal = check_size(640, 90, 50).unwrap_err();
        assert!(refusal.to_string().contains("640 × 90"), "{refusal}");
        assert_eq!(check_size(640, 360, 11), Err(Refusal::Short(11)));
    }
}
