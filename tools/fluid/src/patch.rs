//! Patches, and the eighteen versions of a video that they are cut from (the paper, section 4).

/// Side of a patch in pixels.
pub const SIDE: usize = 48;

/// From a patch to the next, across and down: neighbours share half of their pixels.
pub const STRIDE: usize = 24;

/// Versions of a video: as it is and mirrored, in three sizes, at three angles.
pub const VERSIONS: u8 = 18;

/// A patch of the database. Its pixels are not stored: they are a view of the video's frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchRef {
    /// The video's number in the database.
    pub video: u32,
    /// Which version of the video.
    pub version: Version,
    /// Column of its centre in the version, whose origin is the centre of the video's picture, in pixels of the version.
    pub x: i16,
    /// Row of its centre.
    pub y: i16,
}

/// A version of a video, 0..[`VERSIONS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version(u8);

impl Version {
    /// The version of this number, if there is one.
    pub fn new(number: u8) -> Option<Self> {
        (number < VERSIONS).then_some(Self(number))
    }

    /// All of them; the first is the video as it is.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..VERSIONS).map(Self)
    }

    /// Its number.
    pub fn number(self) -> u8 {
        self.0
    }

    /// Whether left and right are exchanged.
    pub fn mirrored(self) -> bool {
        self.0 % 2 == 1
    }

    /// Its size as a share of the video's: 1, 0.75 or 0.5.
    pub fn scale(self) -> f32 {
        [1.0, 0.75, 0.5][usize::from(self.0 / 2 % 3)]
    }

    /// By how much it is turned, in radians, from the x axis towards the y axis: 0, −π/8 or π/8.
    pub fn angle(self) -> f32 {
        [0.0, -core::f32::consts::FRAC_PI_8, core::f32::consts::FRAC_PI_8][usize::from(self.0 / 6)]
    }

    /// The linear map from the version to the video, both with their origin in the middle: a place (x, y) of the version shows the place
    /// `(m[0][0]·x + m[0][1]·y, m[1][0]·x + m[1][1]·y)` of the video.
    pub fn to_video(self) -> [[f32; 2]; 2] {
        let (sine, cosine) = self.angle().sin_cos();
        let mirror = if self.mirrored() { -1.0 } else { 1.0 };
        let scale = self.scale();
        // The version is the video mirrored, then scaled, then turned.
        [[mirror * cosine / scale, mirror * sine / scale], [-sine / scale, cosine / scale]]
    }

    /// The linear map of motion from the video to the version: the inverse of [`Self::to_video`].
    pub fn from_video(self) -> [[f32; 2]; 2] {
        let (sine, cosine) = self.angle().sin_cos();
        let mirror = if self.mirrored() { -1.0 } else { 1.0 };
        let scale = self.scale();
        [[mirror * cosine * scale, -sine * scale], [mirror * sine * scale, cosine * scale]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_same_place() {
        for version in Version::all() {
            let (a, b) = (version.to_video(), version.from_video());
            for (row, line) in a.iter().enumerate() {
                let product = [0, 1].map(|column| line[0] * b[0][column] + line[1] * b[1][column]);
                let expected = [[1.0, 0.0], [0.0, 1.0]][row];
                assert!(
                    (0..2).all(|column: usize| (product[column] - expected[column]).abs() < 1e-6),
                    "{version:?}: {product:?}"
                );
            }
        }
    }

    #[test]
    fn the_versions_differ() {
        let mut seen = Vec::new();
        for version in Version::all() {
            let kind = (version.mirrored(), version.scale().to_bits(), version.angle().to_bits());
            assert!(!seen.contains(&kind), "{version:?} is there twice");
            seen.push(kind);
        }
    }
}
