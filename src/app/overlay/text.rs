//! Text in the scripts that names of photos are mostly written in: Latin and Japanese.
//!
//! Two fonts of the U8g2 collection. Latin (with accents, as far as U+017F) is "fixed" 10×20 of the X Window System, by Markus
//! Kuhn and others, which is in the public domain. Japanese (kana, and 3,449 kanji) is the 16-pixel bold font of
//! [/efont/](http://openlab.ring.gr.jp/efont/), © 2000–2003 The Electronic Font Open Laboratory, of the three-clause BSD licence in
//! LICENSE-EFONT. What neither has is drawn as an empty box.

use super::canvas::{Canvas, at};
use embedded_graphics::{
    Drawable,
    geometry::{Point, Size},
    pixelcolor::Rgb888,
    primitives::{Primitive, PrimitiveStyle, Rectangle},
};
use u8g2_fonts::{
    FontRenderer,
    fonts::{u8g2_font_10x20_te, u8g2_font_b16_b_t_japanese3},
    types::{FontColor, VerticalPosition},
};

static LATIN: FontRenderer = FontRenderer::new::<u8g2_font_10x20_te>();
static JAPANESE: FontRenderer = FontRenderer::new::<u8g2_font_b16_b_t_japanese3>();

/// From the top of a line to the top of the next: the highest letter (Å) rises 16 cells above the base line, the lowest falls 4
/// below it.
pub(super) const LINE: u32 = 22;
const BASE: u32 = 17;

/// What stands for what was left out.
const DOTS: &str = "...";

/// How a character is drawn, and the cells that it takes.
enum Glyph {
    In(&'static FontRenderer, u32),
    /// A box.
    Unknown,
    /// An accent without a letter of its own, or the like.
    Nothing,
}

/// Cells of a character that no font has, with the gap after it.
const UNKNOWN_WIDTH: u32 = 10;

impl Glyph {
    fn of(c: char) -> Self {
        if matches!(c, '\u{300}'..='\u{36f}' | '\u{200b}'..='\u{200f}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}')
        {
            return Self::Nothing;
        }
        let find = |font: &'static FontRenderer| {
            let found = font.get_rendered_dimensions(c, Point::zero(), VerticalPosition::Baseline).ok()?;
            Some(Self::In(font, u32::try_from(found.advance.x).ok()?))
        };
        find(&LATIN).or_else(|| find(&JAPANESE)).unwrap_or(Self::Unknown)
    }

    const fn width(&self) -> u32 {
        match self {
            Self::In(_, width) => *width,
            Self::Unknown => UNKNOWN_WIDTH,
            Self::Nothing => 0,
        }
    }
}

/// A sign of the same meaning that the fonts have.
const fn usual(c: char) -> char {
    match c {
        '\u{2018}' | '\u{2019}' => '\'',
        '\u{201c}' | '\u{201d}' => '"',
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        '\u{2000}'..='\u{200a}' | '\u{202f}' => ' ',
        other => other,
    }
}

/// Cells that `text` takes.
pub(super) fn width(text: &str) -> u32 {
    text.chars().map(|c| Glyph::of(usual(c)).width()).sum()
}

/// What is shown of a `text` for which there are `room` cells: its start, and its end where its middle is left out.
pub(super) fn shortened(text: &str, room: u32) -> (&str, Option<&str>) {
    if width(text) <= room {
        return (text, None);
    }
    // The end often holds the number of the photo.
    let room = room.saturating_sub(width(DOTS));
    let fitting = |chars: &mut dyn Iterator<Item = char>, room: u32| -> usize {
        let mut used = 0;
        let fits = chars.take_while(|&c| {
            used += Glyph::of(usual(c)).width();
            used <= room
        });
        fits.map(char::len_utf8).sum()
    };
    let tail = &text[text.len() - fitting(&mut text.chars().rev(), room / 2)..];
    (&text[..fitting(&mut text.chars(), room - width(tail))], Some(tail))
}

/// Draws `text` from column `x` of the line whose top is row `y`, in at most `room` cells.
pub(super) fn draw(text: &str, x: u32, y: u32, room: u32, colour: Rgb888, canvas: &mut Canvas<'_, '_>) {
    let (head, tail) = shortened(text, room);
    let x = draw_whole(head, x, y, colour, canvas);
    if let Some(tail) = tail {
        let x = draw_whole(DOTS, x, y, colour, canvas);
        draw_whole(tail, x, y, colour, canvas);
    }
}

/// Draws `text`, and gives the column after it.
fn draw_whole(text: &str, mut x: u32, y: u32, colour: Rgb888, canvas: &mut Canvas<'_, '_>) -> u32 {
    for c in text.chars().map(usual) {
        let glyph = Glyph::of(c);
        match glyph {
            Glyph::In(font, _) => {
                let colour = FontColor::Transparent(colour);
                let drawn = font.render(c, at(x, y + BASE), VerticalPosition::Baseline, colour, canvas);
                debug_assert!(drawn.is_ok(), "the font has it, and the canvas takes everything");
            }
            Glyph::Unknown => {
                let outline = Rectangle::new(at(x + 1, y + 4), Size::new(UNKNOWN_WIDTH - 2, BASE - 4));
                let Ok(()) = outline.into_styled(PrimitiveStyle::with_stroke(colour, 1)).draw(canvas);
            }
            Glyph::Nothing => {}
        }
        x += glyph.width();
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_known(c: char) -> bool {
        matches!(Glyph::of(usual(c)), Glyph::In(..))
    }

    #[test]
    fn latin_1_its_neighbours_and_japanese_are_known() {
        let latin = (' '..='~').chain('\u{a0}'..='\u{17f}');
        assert!(
            latin.clone().all(is_known),
            "{:?}",
            latin.filter(|&c| !is_known(c)).collect::<std::vec::Vec<_>>()
        );
        assert!("ひらがな、カタカナ。漢字「写真」自然揺らめき々ー凜麒".chars().all(is_known));
        assert!("Mum’s “best” 2019–20".chars().all(is_known));
        assert!(!is_known('😀') && !is_known('\u{fffd}') && width("\u{301}") == 0);
    }

    #[test]
    fn a_long_text_keeps_its_start_and_its_end() {
        assert_eq!(shortened("lake.jpg", 80), ("lake.jpg", None));
        assert_eq!(shortened("a long way 0042.jpg", 130), ("a lon", Some("2.jpg")));
        assert_eq!(shortened("夏の山の写真.jpg", 110), ("夏の", Some(".jpg")));
        assert_eq!(shortened("anything", 9), ("", Some("")));
        for room in 0..400 {
            let (head, tail) = shortened("夏 of the 写真 and é, 0042.jpg", room);
            let all = width(head) + tail.map_or(0, |tail| width(tail) + width(DOTS));
            assert!(all <= room.max(width(DOTS)), "{all} cells in {room}");
        }
    }
}
