//! Pixel formats by the channels' bits.

use crate::frame::PixelFormat;
use linuxfb::{PixelLayout, PixelLayoutChannel};

/// The format whose red, green and blue lie at these bits of a pixel of so many bytes, as `offset:length` from the lowest.
pub(super) fn from_channels(bytes_per_pixel: u32, channels: &PixelLayout) -> Option<PixelFormat> {
    let bits = |channel: &PixelLayoutChannel| (channel.offset, channel.length);
    let straight = [&channels.red, &channels.green, &channels.blue].iter().all(|channel| !channel.msb_right);
    let channels = [bits(&channels.red), bits(&channels.green), bits(&channels.blue)];
    let format = match (bytes_per_pixel, channels) {
        (4, [(16, 8), (8, 8), (0, 8)]) => PixelFormat::Xrgb8888,
        (4, [(0, 8), (8, 8), (16, 8)]) => PixelFormat::Xbgr8888,
        (4, [(20, 10), (10, 10), (0, 10)]) => PixelFormat::Xrgb2101010,
        (3, [(16, 8), (8, 8), (0, 8)]) => PixelFormat::Rgb888,
        (3, [(0, 8), (8, 8), (16, 8)]) => PixelFormat::Bgr888,
        (2, [(11, 5), (5, 6), (0, 5)]) => PixelFormat::Rgb565,
        (2, [(0, 5), (5, 6), (11, 5)]) => PixelFormat::Bgr565,
        _ => return None,
    };
    straight.then_some(format)
}

/// The channels as people compare them with a driver's documentation.
pub(super) fn numbers(bytes_per_pixel: u32, channels: &PixelLayout) -> String {
    let at = |name, channel: &PixelLayoutChannel| format!(" {name} {}:{}", channel.offset, channel.length);
    format!(
        "{} bits with{}{}{}",
        bytes_per_pixel * 8,
        at("red", &channels.red),
        at("green", &channels.green),
        at("blue", &channels.blue)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::pack::{Colours, pack};

    fn layout(channels: [(u32, u32); 3]) -> PixelLayout {
        let [red, green, blue] =
            channels.map(|(offset, length)| PixelLayoutChannel { offset, length, msb_right: false });
        PixelLayout { alpha: PixelLayoutChannel { offset: 0, length: 0, msb_right: false }, red, green, blue }
    }

    /// Where `pack` puts the bits of a channel.
    fn bits(format: PixelFormat, channel: usize) -> (u32, u32) {
        let word = |level: [u16; 3]| {
            let mut bytes = [0; 4];
            let [red, green, blue] = &level;
            let colours = Colours {
                red: std::slice::from_ref(red),
                green: std::slice::from_ref(green),
                blue: std::slice::from_ref(blue),
            };
            pack(format, colours, 0, 0, &mut bytes[..format.bytes_per_pixel()]);
            u32::from_le_bytes(bytes)
        };
        let mut level = [0; 3];
        level[channel] = 255 * 16;
        let set = word(level) ^ word([0; 3]);
        (set.trailing_zeros(), set.count_ones())
    }

    #[test]
    fn every_format_is_told_by_the_bits_that_it_is_packed_into() {
        for format in PixelFormat::ALL {
            let channels = layout([0, 1, 2].map(|channel| bits(format, channel)));
            assert_eq!(from_channels(format.bytes_per_pixel() as u32, &channels), Some(format), "{format}");
        }
    }

    #[test]
    fn other_layouts_are_refused_with_their_numbers() {
        let fifteen = layout([(10, 5), (5, 5), (0, 5)]);
        assert_eq!(from_channels(2, &fifteen), None);
        assert_eq!(numbers(2, &fifteen), "16 bits with red 10:5 green 5:5 blue 0:5");
        assert_eq!(from_channels(1, &layout([(0, 8); 3])), None);
        let mut mirrored = layout([(16, 8), (8, 8), (0, 8)]);
        mirrored.green.msb_right = true;
        assert_eq!(from_channels(4, &mirrored), None);
    }
}
