use crate::frame::FrameRef;
use sha2::{Digest, Sha256};

/// One SHA-256 over all frames: the same frames give the same number on every machine.
///
/// Each frame adds its width and height (32 bits each, little-endian), the name of its pixel format, and its rows from top to
/// bottom without the padding of the stride.
#[derive(Clone, Debug, Default)]
pub struct FrameHash(Sha256);

impl FrameHash {
    /// The hash of no frames.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the next frame.
    pub fn update(&mut self, frame: FrameRef<'_>) {
        let layout = frame.layout();
        self.0.update(layout.size.width.to_le_bytes());
        self.0.update(layout.size.height.to_le_bytes());
        self.0.update(layout.format.name());
        for row in frame.rows() {
            self.0.update(row);
        }
    }

    /// The hash of all frames so far: 64 hexadecimal digits.
    pub fn hex(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
