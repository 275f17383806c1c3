//! GIF, by the `gif` crate.
//!
//! One [`Palette`] serves the whole film and its dither is fixed in space, so that a pixel that is still in the picture is still
//! in the file: nothing flickers or crawls. A frame stores the rectangle that changed, with the unchanged pixels in it
//! transparent.
//!
//! GIF counts delays in 1/100 s. They are rounded so that the film keeps its time; but browsers show a frame with a delay below
//! 2/100 s for 10/100 s, so films of more than 50 frames a second play slowly there.

use super::{Encode, Film, changed::Rect, dither::Dither, palette};
use gif::{DisposalMethod, EncodingError, Frame, Repeat};
use std::{
    borrow::Cow,
    io::{self, Write},
};

/// The palette entry that stands for no change. The palette has one colour less.
const TRANSPARENT: u8 = 255;

pub(super) struct Encoder<W: Write> {
    state: State<W>,
    film: Film,
    delays: Box<dyn Iterator<Item = u32>>,
    before: Vec<u8>,
    after: Vec<u8>,
    cut: Vec<u8>,
}

/// The palette is known when the first frame is.
enum State<W: Write> {
    Waiting(Option<W>),
    Started { gif: gif::Encoder<W>, dither: Dither },
}

impl<W: Write> Encoder<W> {
    pub(super) fn new(to: W, film: Film) -> Self {
        if u32::from(film.rate.frames()) > 50 * u32::from(film.rate.seconds()) {
            log::warn!(
                "browsers play a GIF of more than 50 frames a second slowly; use APNG or WebP, or fewer"
            );
        }
        Self {
            state: State::Waiting(Some(to)),
            film,
            delays: Box::new(film.rate.delays(100)),
            before: Vec::new(),
            after: Vec::new(),
            cut: Vec::new(),
        }
    }

    fn start(to: W, film: Film, rgb: &[u8]) -> io::Result<State<W>> {
        let colours = palette::choose(rgb.as_chunks().0);
        // A side is at most Layout::MAX_SIDE, which fits.
        let (width, height) = (film.size.width as u16, film.size.height as u16);
        let mut gif = gif::Encoder::new(to, width, height, &colours.concat()).map_err(io_error)?;
        if film.frames > 1 {
            gif.set_repeat(Repeat::Infinite).map_err(io_error)?;
        }
        Ok(State::Started { gif, dither: Dither::new(colours) })
    }
}

impl<W: Write> Encode for Encoder<W> {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        if let State::Waiting(to) = &mut self.state
            && let Some(to) = to.take()
        {
            self.state = Self::start(to, self.film, rgb)?;
        }
        let State::Started { gif, dither } = &mut self.state else {
            return Err(io::Error::other("the first frame failed"));
        };
        let width = self.film.size.width;
        dither.apply(rgb, width, &mut self.after);
        let rect = if self.before.is_empty() {
            self.before.clone_from(&self.after);
            Rect::all(self.film.size)
        } else {
            let rect = Rect::changed::<1>(&self.before, &self.after, width).unwrap_or(Rect::first_pixel());
            for (before, after) in self.before.iter_mut().zip(&self.after) {
                *before = if before == after { TRANSPARENT } else { *after };
            }
            rect
        };
        // Here `before` holds what is to be stored; after the swap, what is shown.
        rect.cut::<1>(&self.before, width, &mut self.cut);
        std::mem::swap(&mut self.before, &mut self.after);
        gif.write_frame(&Frame {
            delay: self.delays.next().unwrap_or_default() as u16,
            dispose: DisposalMethod::Keep,
            transparent: Some(TRANSPARENT),
            left: rect.left as u16,
            top: rect.top as u16,
            width: rect.width as u16,
            height: rect.height as u16,
            buffer: Cow::Borrowed(&self.cut),
            ..Frame::default()
        })
        .map_err(io_error)
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        match self.state {
            State::Waiting(_) => Ok(()),
            State::Started { gif, .. } => gif.into_inner().map_err(io_error)?.flush(),
        }
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}
