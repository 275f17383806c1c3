//! Reading the text of a species: words, numbers and where they stand.

use crate::math::Turns;
use core::fmt;
use fixed::types::I16F16;

/// A number of a species.
pub(super) type Number = I16F16;

/// What is wrong in the text of a species, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeciesError {
    /// The line, from 1; 0 for the text as a whole.
    pub line: u32,
    /// The character of the line, from 1.
    pub column: u32,
    /// What is wrong.
    pub fault: Fault,
}

/// What can be wrong in the text of a species.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A line begins with a word that means nothing.
    UnknownKey,
    /// A symbol that no turtle knows.
    UnknownSymbol,
    /// Something else was expected: what.
    Expected(&'static str),
    /// A number is not within its limits: the least, and the most.
    OutOfRange(&'static str, &'static str),
    /// `]` without `[`.
    Unopened,
    /// `[` without `]`.
    Unclosed,
    /// Brackets within brackets, too deep.
    TooDeep,
    /// More symbols than a rule may have.
    TooManySymbols,
    /// The map does not bring all points closer together.
    NotContracting,
    /// A key that may stand once stands twice.
    Twice,
    /// No rule `a(s) -> ...`.
    NoTreeRule,
    /// No line `leaf ...`.
    NoLeafRule,
    /// Not as many chances as the tree has boughs.
    ChancesDoNotFit,
    /// More twigs than addresses.
    TooManyTwigs,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownKey => f.write_str(
                "no such key; a line begins with tree, a(s) ->, depth, chance, stray, width, taper, bark, bark-marks, leaves, \
                 size, droop, leaf, evergreen, chlorophyll, carotenoids, anthocyanins or #",
            ),
            Self::UnknownSymbol => f.write_str("no such symbol; a rule is made of F( ) a( ) [ ] + - & ^ / \\"),
            Self::Expected(what) => write!(f, "{what} is expected here"),
            Self::OutOfRange(least, most) => write!(f, "this must be {least} to {most}"),
            Self::Unopened => f.write_str("this ] closes nothing; remove it, or add a [ before it"),
            Self::Unclosed => f.write_str("this [ is never closed; add a ] after it"),
            Self::TooDeep => f.write_str("brackets may lie in each other 8 deep, no deeper"),
            Self::TooManySymbols => f.write_str("a rule may have 8 boughs, 16 pieces of wood and 200 symbols; write a smaller one"),
            Self::NotContracting => f.write_str(
                "this map is not contracting: all it draws must come out smaller; divide a bough's s by more than 1, and make \
                 the numbers of a leaf's map smaller",
            ),
            Self::Twice => f.write_str("this was said before; say it once"),
            Self::NoTreeRule => f.write_str("there is no tree rule; add a line like a(s) -> F(s) [ +(32) a(s/1.75) ]"),
            Self::NoLeafRule => f.write_str("there is no leaf rule; add one to four lines like leaf .49 0 0 .51 .02 1.62"),
            Self::ChancesDoNotFit => f.write_str("chance must name one number for each bough of the tree rule"),
            Self::TooManyTwigs => f.write_str(
                "the first six to eleven boughs of a twig are its address, and there are 4096 addresses; take a smaller depth",
            ),
        }
    }
}

impl fmt::Display for SpeciesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => self.fault.fmt(f),
            line => write!(f, "line {line}, column {}: {}", self.column, self.fault),
        }
    }
}

impl core::error::Error for SpeciesError {}

/// Where in one line the reading is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor<'a> {
    rest: &'a str,
    line: u32,
    column: u32,
}

impl<'a> Cursor<'a> {
    /// The start of line number `line`, without its comment.
    pub(super) fn new(text: &'a str, line: u32) -> Self {
        let rest = text.split('#').next().unwrap_or_default().trim_end();
        let mut cursor = Self { rest, line, column: 1 };
        cursor.skip_space();
        cursor
    }

    /// The error `fault` at this place.
    pub(super) const fn error(&self, fault: Fault) -> SpeciesError {
        SpeciesError { line: self.line, column: self.column, fault }
    }

    /// Whether the line has ended.
    pub(super) const fn is_at_end(&self) -> bool {
        self.rest.is_empty()
    }

    /// The next character, which stays.
    pub(super) fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    /// The next character, and the space after it.
    pub(super) fn next(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.advance(next.len_utf8());
        Some(next)
    }

    /// Takes `text` if it comes next.
    pub(super) fn take(&mut self, text: &str) -> bool {
        let takes = self.rest.starts_with(text);
        if takes {
            self.advance(text.len());
        }
        takes
    }

    /// Takes `text`, which must come next.
    pub(super) fn expect(&mut self, text: &'static str) -> Result<(), SpeciesError> {
        if self.take(text) { Ok(()) } else { Err(self.error(Fault::Expected(text))) }
    }

    /// The next word.
    pub(super) fn word(&mut self) -> &'a str {
        let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
        let word = &self.rest[..end];
        self.advance(end);
        word
    }

    /// The next number, which must be `least` to `most`.
    pub(super) fn number(&mut self, least: &'static str, most: &'static str) -> Result<Number, SpeciesError> {
        let end =
            self.rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(self.rest.len());
        let number: Number = self.rest[..end].parse().map_err(|_| self.error(Fault::Expected("a number")))?;
        if number < Number::lit(least) || number > Number::lit(most) {
            return Err(self.error(Fault::OutOfRange(least, most)));
        }
        self.advance(end);
        Ok(number)
    }

    /// The next number, which must be `least` to `most` and whole.
    pub(super) fn whole(&mut self, least: &'static str, most: &'static str) -> Result<u32, SpeciesError> {
        let start = *self;
        let number = self.number(least, most)?;
        if number.frac() == 0 {
            Ok(number.to_num())
        } else {
            Err(start.error(Fault::Expected("a whole number")))
        }
    }

    /// The next number as an angle in degrees.
    pub(super) fn angle(&mut self) -> Result<Turns, SpeciesError> {
        let degrees = i64::from(self.number("-360", "360")?.to_bits());
        Ok(Turns(((degrees << 16) / 360) as u32))
    }

    /// The line must have ended.
    pub(super) fn end(&self) -> Result<(), SpeciesError> {
        if self.is_at_end() { Ok(()) } else { Err(self.error(Fault::Expected("the end of the line"))) }
    }

    fn advance(&mut self, bytes: usize) {
        self.column += self.rest[..bytes].chars().count() as u32;
        self.rest = &self.rest[bytes..];
        self.skip_space();
    }

    fn skip_space(&mut self) {
        let trimmed = self.rest.trim_start();
        self.column += self.rest[..self.rest.len() - trimmed.len()].chars().count() as u32;
        self.rest = trimmed;
    }
}
