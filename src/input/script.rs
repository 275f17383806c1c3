//! Presses by the frame: a show that can be repeated to the pixel.
//!
//! ```text
//! # the frame's number, from 0, the button, and how it is pressed if that is not short
//! 90   up
//! 90   right      # several presses may share a frame
//! 240  space long
//! ```

use super::{Button, Buttons, Known, Press, gesture::Gesture};
use core::{fmt, iter::Peekable};

/// Presses, each at its frame.
#[derive(Clone, Debug)]
pub struct Script<'a> {
    presses: Peekable<Lines<'a>>,
}

impl<'a> Script<'a> {
    /// The longest line, in bytes. A press takes 33 at the most; the rest is room for a comment.
    pub const MAX_LINE_BYTES: usize = 1024;

    /// The script in `text`: on each line the number of a frame, a button and perhaps a gesture, frames not decreasing. Empty
    /// lines and what follows a `#` are passed over; letters may be small or capital. The text is checked whole, once: a
    /// script that was accepted has no bad line.
    pub fn parse(text: &'a str) -> Result<Self, ScriptError<'a>> {
        let presses = Lines::new(text);
        let mut last_frame = 0;
        for press in presses.clone() {
            let (line, frame, _) = press?;
            if frame < last_frame {
                return Err(ScriptError { line, fault: ScriptFault::Order { frame, last_frame } });
            }
            last_frame = frame;
        }
        Ok(Self { presses: presses.peekable() })
    }
}

impl Buttons for Script<'_> {
    /// The next press that is due at `frame`; presses of frames that were left out come late rather than never.
    fn next_press(&mut self, frame: u64) -> Option<Press> {
        let due = |line: &Result<Line, _>| line.as_ref().is_ok_and(|&(_, at, _)| at <= frame);
        let (_, _, press) = self.presses.next_if(due)?.ok()?;
        Some(press)
    }
}

/// The number of the line, the frame, the press.
type Line = (usize, u64, Press);

/// The presses of a text, line by line.
#[derive(Clone, Debug)]
struct Lines<'a> {
    lines: core::iter::Enumerate<core::str::Lines<'a>>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        // Some editors begin a file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self { lines: text.lines().enumerate() }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Result<Line, ScriptError<'a>>;

    fn next(&mut self) -> Option<Self::Item> {
        self.lines.by_ref().find_map(|(index, line)| {
            let number = index + 1;
            match parse_line(line) {
                Ok(press) => press.map(|(frame, press)| Ok((number, frame, press))),
                Err(fault) => Some(Err(ScriptError { line: number, fault })),
            }
        })
    }
}

/// The press on a line; `None` where it has none.
fn parse_line(line: &str) -> Result<Option<(u64, Press)>, ScriptFault<'_>> {
    if line.len() > Script::MAX_LINE_BYTES {
        return Err(ScriptFault::Long { bytes: line.len() });
    }
    let code = line.split('#').next().unwrap_or_default();
    let mut words = code.split_whitespace();
    let Some(frame) = words.next() else { return Ok(None) };
    let frame = frame.parse().map_err(|_| ScriptFault::Frame(frame))?;
    let name = words.next().ok_or(ScriptFault::NoButton)?;
    let button = Button::from_name(name).ok_or(ScriptFault::Button(name))?;
    let gesture = match words.next() {
        Some(name) => name.parse().map_err(|_| ScriptFault::Gesture(name))?,
        None => Gesture::Short,
    };
    match words.next() {
        Some(word) => Err(ScriptFault::Extra(word)),
        None => Ok(Some((frame, Press { button, gesture }))),
    }
}

/// A line that is no press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScriptError<'a> {
    /// The number of the line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub fault: ScriptFault<'a>,
}

/// What can be wrong with a line of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScriptFault<'a> {
    /// The line is longer than [`Script::MAX_LINE_BYTES`].
    Long {
        /// Its length in bytes.
        bytes: usize,
    },
    /// The first word is not a frame's number.
    Frame(&'a str),
    /// There is no second word.
    NoButton,
    /// The second word names no button.
    Button(&'a str),
    /// The third word names no gesture.
    Gesture(&'a str),
    /// There is a fourth word.
    Extra(&'a str),
    /// The frame comes before that of an earlier line.
    Order {
        /// The frame's number.
        frame: u64,
        /// The one of the line before.
        last_frame: u64,
    },
}

impl fmt::Display for ScriptError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {} of the script: ", self.line)?;
        match self.fault {
            ScriptFault::Long { bytes } => {
                write!(f, "it has {bytes} bytes; a line may have {}", Script::MAX_LINE_BYTES)
            }
            ScriptFault::Frame(word) => {
                write!(f, "{} is not a frame's number; a press is a line like \"90 right\"", Quoted(word))
            }
            ScriptFault::NoButton => {
                let known = Button::ALL.map(Button::name);
                write!(f, "a button is missing after the frame's number; {}", Known(&known))
            }
            ScriptFault::Button(word) => {
                write!(f, "unknown button {}; {}", Quoted(word), Known(&Button::ALL.map(Button::name)))
            }
            ScriptFault::Gesture(word) => {
                let known = Gesture::ALL.map(Gesture::name);
                write!(
                    f,
                    "unknown gesture {}; {}; put each press on a line of its own",
                    Quoted(word),
                    Known(&known)
                )
            }
            ScriptFault::Extra(word) => {
                write!(f, "{} is one word too many; put each press on a line of its own", Quoted(word))
            }
            ScriptFault::Order { frame, last_frame } => {
                write!(f, "frame {frame} comes after frame {last_frame}; put the presses in their order")
            }
        }
    }
}

impl core::error::Error for ScriptError<'_> {}

/// A word of somebody's file within a message: in quotes, escaped, and cut where it is long.
struct Quoted<'a>(&'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// The longest word that is shown whole, in characters: any button and any number fit.
        const SHOWN: usize = 24;
        let end = self.0.char_indices().nth(SHOWN).map_or(self.0.len(), |(at, _)| at);
        let ellipsis = if end < self.0.len() { "…" } else { "" };
        write!(f, "\"{}{ellipsis}\"", self.0[..end].escape_debug())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The presses at each of the frames 0 to 9.
    fn by_frame(text: &str) -> Vec<(u64, Press)> {
        let mut script = Script::parse(text).expect("a good script");
        let mut presses = Vec::new();
        for frame in 0..10 {
            while let Some(press) = script.next_press(frame) {
                presses.push((frame, press));
            }
        }
        presses
    }

    #[test]
    fn presses_come_at_their_frames_in_order() {
        let text = "\u{feff}# a show\r\n\r\n0 right\n  3\tUP Long # louder\n3 Esc short\n9 i double\n12 left";
        let expected = [(0, "right"), (3, "up:long"), (3, "esc"), (9, "i:double")];
        assert_eq!(by_frame(text), expected.map(|(frame, press)| (frame, press.parse().expect("a press"))));
    }

    #[test]
    fn presses_of_frames_left_out_come_late() {
        let mut script = Script::parse("2 left\n5 right").expect("a good script");
        assert_eq!(script.next_press(1), None);
        assert_eq!(
            [7, 7, 7].map(|frame| script.next_press(frame).map(|press| press.button)),
            [Some(Button::Left), Some(Button::Right), None]
        );
    }

    #[test]
    fn every_button_is_known_by_its_name() {
        for button in Button::ALL {
            assert_eq!(Button::from_name(&button.name().to_uppercase()), Some(button));
        }
    }

    #[test]
    fn an_empty_script_presses_nothing() {
        assert!(by_frame("").is_empty());
        assert!(by_frame("\n# 3 left\n   ").is_empty());
    }
}
