//! Kaleidoscope
pub mod fractal;
mod storage;

/// Luma of BT.709 on the coded channels, rounded. The weights sum to 1024.
pub const fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((r as u32 * 218 + g as u32 * 732 + b as u32 * 74 + 512) >> 10) as u8
}
