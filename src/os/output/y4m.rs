//! Uncompressed video (YUV4MPEG2), read by ffmpeg, mpv and most video programs.
//!
//! The colours are BT.601 in limited range (16 to 235), the only ones that readers agree on: the header can name the range but
//! not the matrix, and readers that must convert to RGB take BT.601.
//!
//! Chroma is not halved (4:4:4): on a photo of 640×427 the way to RGB and back then errs by 0.4 levels on average instead of 2.4
//! with 4:2:0, and encoders take odd sizes. For phones and browsers, which play only 4:2:0, give ffmpeg `-pix_fmt yuv420p` and
//! even sides.

use super::{Encode, Film};
use std::io::{self, Write};

pub(super) struct Encoder<W: Write> {
    to: W,
    planes: Vec<u8>,
}

impl<W: Write> Encoder<W> {
    pub(super) fn new(mut to: W, film: Film) -> io::Result<Self> {
        let (size, rate) = (film.size, film.rate);
        writeln!(
            to,
            "YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C444 XCOLORRANGE=LIMITED",
            size.width,
            size.height,
            rate.frames(),
            rate.seconds()
        )?;
        Ok(Self { to, planes: vec![0; size.pixels() * 3] })
    }
}

impl<W: Write> Encode for Encoder<W> {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        let (y, chroma) = self.planes.split_at_mut(rgb.len() / 3);
        let (cb, cr) = chroma.split_at_mut(rgb.len() / 3);
        for (((rgb, y), cb), cr) in rgb.as_chunks::<3>().0.iter().zip(y).zip(cb).zip(cr) {
            [*y, *cb, *cr] = ycbcr(*rgb);
        }
        self.to.write_all(b"FRAME\n")?;
        self.to.write_all(&self.planes)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.to.flush()
    }
}

/// ITU-R BT.601-7, section 2.5.1, for 8 bits, with coefficients in 1/65536:
/// Y = 16 + 219·(0.299 R + 0.587 G + 0.114 B), Cb = 128 + 224·(B − luma)/1.772, Cr = 128 + 224·(R − luma)/1.402.
fn ycbcr([r, g, b]: [u8; 3]) -> [u8; 3] {
    let weigh = |weights: [i32; 3], offset: i32| {
        let sum = weights[0] * i32::from(r) + weights[1] * i32::from(g) + weights[2] * i32::from(b);
        (((sum + (1 << 15)) >> 16) + offset) as u8
    };
    [
        weigh([16_829, 33_039, 6_416], 16),
        weigh([-9_714, -19_071, 28_785], 128),
        weigh([28_785, -24_104, -4_681], 128),
    ]
}
