//! A TOML text every key of which must be known, and every mistake in which is told with its line and column.
//!
//! Whoever reads a document asks for its keys one by one. What was asked for is what is known: [`Document::finish`] tells the
//! keys that nobody asked for, so that a key cannot be read without being known, or known without being read.

use std::{
    error::Error, fmt, fs, io::Read, ops::RangeInclusive, os::unix::fs::OpenOptionsExt, path::Path,
    str::FromStr,
};
use toml::de::{DeTable, DeValue};

/// A configuration, board file or sidecar that cannot be used: what is wrong with it, each as one line.
#[derive(Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The name of the file.
    pub name: String,
    /// What is wrong with it, in the order in which it stands there; at least one.
    pub faults: Vec<Fault>,
}

/// One mistake.
#[derive(Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where it is, if it is in the text.
    pub place: Option<Place>,
    /// What is wrong, and the cure.
    pub message: String,
}

/// A place in a text, counted from 1. Columns are characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The line.
    pub line: usize,
    /// The character in it.
    pub column: usize,
}

impl ConfigError {
    /// A file with one fault that is at no place in its text.
    pub(super) fn whole(name: impl Into<String>, message: impl Into<String>) -> Self {
        Self { name: name.into(), faults: vec![Fault { place: None, message: message.into() }] }
    }

    /// The first mistake, and how many more there are, on one line.
    pub(super) fn first(&self) -> String {
        let line = self.to_string();
        let first = line.lines().next().unwrap_or_default();
        match self.faults.len() {
            0 | 1 => first.to_owned(),
            faults => format!("{first} (and {} more)", faults - 1),
        }
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Fault { place, message }) in self.faults.iter().enumerate() {
            let (end, name) = (if i == 0 { "" } else { "\n" }, &self.name);
            match place {
                Some(Place { line, column }) => write!(f, "{end}{name}:{line}:{column}: {message}")?,
                None => write!(f, "{end}{name}: {message}")?,
            }
        }
        Ok(())
    }
}

impl Error for ConfigError {}

/// The most bytes of a file: a hundred times what a configuration with all its comments takes.
const MAX_BYTES: u64 = 1 << 20;

/// The text of the file at `path`. Only regular files are opened, and nothing blocks.
pub(super) fn read_text(path: &Path) -> Result<String, ConfigError> {
    let name = path.display().to_string();
    let system = |error: std::io::Error| ConfigError::whole(name.as_str(), error.to_string());
    let not_a_file = || ConfigError::whole(name.as_str(), "this is no file; name a text file");
    if !fs::metadata(path).map_err(system)?.is_file() {
        return Err(not_a_file());
    }
    let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    let file = fs::File::options().read(true).custom_flags(flags).open(path).map_err(system)?;
    if !file.metadata().map_err(system)?.is_file() {
        return Err(not_a_file());
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(system)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(ConfigError::whole(name, "this is larger than 1 MiB; make it shorter"));
    }
    decode(&name, bytes)
}

/// The text in `bytes`, which must be UTF-8; `name` stands for them in messages.
fn decode(name: &str, bytes: Vec<u8>) -> Result<String, ConfigError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(ConfigError::whole(name, "this is UTF-16; save it as UTF-8"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let before = std::str::from_utf8(&bytes[..good]).unwrap_or_default();
        let message = format!(
            "the byte 0x{:02X} is no UTF-8 (is the file in Latin-1?); save the file as UTF-8",
            bytes[good]
        );
        ConfigError {
            name: name.to_owned(),
            faults: vec![Fault { place: Some(place(before, good)), message }],
        }
    })
}

/// The place of the byte at `offset`.
fn place(text: &str, offset: usize) -> Place {
    let before = &text[..text.floor_char_boundary(offset)];
    let line = before.rsplit('\n').next().unwrap_or_default();
    let column = line.trim_start_matches(BYTE_ORDER_MARK).chars().count() + 1;
    Place { line: before.matches('\n').count() + 1, column }
}

/// What some editors put before a text. It takes no column.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// A key: the section it stands in (`""` is before all sections), and its name.
type Key = (&'static str, &'static str);

/// A parsed text that is being read.
pub(super) struct Document<'t> {
    name: &'t str,
    text: &'t str,
    table: DeTable<'t>,
    /// The keys that were asked for.
    known: Vec<Key>,
    /// The sections whose keys anybody may choose.
    free: Vec<&'static str>,
    /// What is wrong, and the byte at which it is.
    faults: Vec<(usize, String)>,
}

impl<'t> Document<'t> {
    /// Parses `text`; `name` stands for it in messages.
    pub(super) fn parse(name: &'t str, text: &'t str) -> Result<Self, ConfigError> {
        let table = DeTable::parse(text).map_err(|error| {
            let place = error.span().map(|span| place(text, span.start));
            let message = error.message().lines().collect::<Vec<_>>().join("; ");
            ConfigError { name: name.to_owned(), faults: vec![Fault { place, message }] }
        })?;
        let table = table.into_inner();
        Ok(Self { name, text, table, known: Vec::new(), free: Vec::new(), faults: Vec::new() })
    }

    /// Puts the value of `key` into `into`, if it is there and `check` takes it.
    pub(super) fn read<T>(
        &mut self,
        key: Key,
        into: &mut T,
        check: impl FnOnce(&DeValue<'_>) -> Result<T, String>,
    ) {
        self.known.push(key);
        let Some(value) = find(&self.table, key) else { return };
        match check(value.get_ref()) {
            Ok(value) => *into = value,
            Err(why) => self.faults.push((value.span().start, format!("{}: {why}", key.1))),
        }
    }

    /// As [`Document::read`], for what may be absent.
    pub(super) fn read_some<T>(
        &mut self,
        key: Key,
        into: &mut Option<T>,
        check: impl FnOnce(&DeValue<'_>) -> Result<T, String>,
    ) {
        self.read(key, into, |value| check(value).map(Some));
    }

    /// Lets `check` take every element of the list at `key`, if there is one.
    pub(super) fn read_list(&mut self, key: Key, mut check: impl FnMut(&DeValue<'_>) -> Result<(), String>) {
        self.known.push(key);
        let Some(value) = find(&self.table, key) else { return };
        let DeValue::Array(list) = value.get_ref() else {
            let why = wrong("a list in brackets", value.get_ref());
            return self.faults.push((value.span().start, format!("{}: {why}", key.1)));
        };
        for element in list {
            if let Err(why) = check(element.get_ref()) {
                self.faults.push((element.span().start, format!("{}: {why}", key.1)));
            }
        }
    }

    /// Whether there is a value at `key`.
    pub(super) fn has(&self, key: Key) -> bool {
        find(&self.table, key).is_some()
    }

    /// Lets `check` take every key of `section` with its value.
    pub(super) fn read_section(
        &mut self,
        section: &'static str,
        mut check: impl FnMut(&str, &DeValue<'_>) -> Result<(), String>,
    ) {
        self.free.push(section);
        let Some(DeValue::Table(table)) = self.table.get(section).map(|value| value.get_ref()) else {
            return;
        };
        for (key, value) in table {
            if let Err(why) = check(key.get_ref(), value.get_ref()) {
                self.faults.push((value.span().start, format!("{}: {why}", plain(key.get_ref()))));
            }
        }
    }

    /// Tells what is wrong with the text: values that were not taken, and keys that nobody asked for.
    pub(super) fn finish(mut self) -> Result<(), ConfigError> {
        let table = std::mem::take(&mut self.table);
        for (key, value) in &table {
            let (name, at) = (key.get_ref().as_ref(), key.span().start);
            let is_section = !name.is_empty() && self.sections().any(|section| section == name);
            match value.get_ref() {
                DeValue::Table(keys) if is_section && !self.free.contains(&name) => {
                    for key in keys.keys() {
                        self.check_known(name, key.get_ref(), key.span().start);
                    }
                }
                DeValue::Table(_) if is_section => {}
                _ if is_section => {
                    let message = format!("{name} is a section: write [{name}] on a line of its own");
                    self.faults.push((at, message));
                }
                DeValue::Table(_) if !self.known.contains(&("", name)) => {
                    let mut sections: Vec<&str> = self.sections().filter(|name| !name.is_empty()).collect();
                    sections.dedup();
                    let message = unknown("section", name, &sections);
                    self.faults.push((at, message));
                }
                _ => self.check_known("", name, at),
            }
        }
        if self.faults.is_empty() {
            return Ok(());
        }
        self.faults.sort();
        let fault = |(at, message)| Fault { place: Some(place(self.text, at)), message };
        Err(ConfigError { name: self.name.to_owned(), faults: self.faults.into_iter().map(fault).collect() })
    }

    /// The known sections, each as often as it has keys.
    fn sections(&self) -> impl Iterator<Item = &'static str> {
        self.known.iter().map(|(section, _)| *section).chain(self.free.iter().copied())
    }

    /// Notes a key that nobody asked for.
    fn check_known(&mut self, section: &str, key: &str, at: usize) {
        if self.known.contains(&(section, key)) {
            return;
        }
        let elsewhere = self.known.iter().find(|(_, name)| *name == key).map(|(section, _)| *section);
        let message = match elsewhere {
            Some("") => format!("{key} belongs before the first [section]"),
            Some(right) => format!("{key} belongs in [{right}]"),
            None => {
                let keys = self.known.iter().filter(|(s, _)| *s == section).map(|(_, key)| *key);
                unknown("key", key, &keys.collect::<Vec<_>>())
            }
        };
        self.faults.push((at, message));
    }
}

fn find<'a, 't>(table: &'a DeTable<'t>, (section, key): Key) -> Option<&'a toml::Spanned<DeValue<'t>>> {
    match section {
        "" => table.get(key),
        _ => match table.get(section)?.get_ref() {
            DeValue::Table(table) => table.get(key),
            _ => None,
        },
    }
}

/// "unknown `what` `word`", with what may have been meant.
pub(super) fn unknown(what: &str, word: &str, known: &[&str]) -> String {
    // A word of six letters may have two wrong ones; in a shorter word two wrong letters make another word.
    let limit = (word.chars().count() / 3).clamp(1, 3);
    let distance = |name: &str| strsim::damerau_levenshtein(&word.to_lowercase(), name);
    // The distance takes the product of the lengths in time and memory: a long word is none of the known anyway.
    let near = known.iter().filter(|_| word.len() <= 64).map(|name| (distance(name), name)).min();
    let hint = match near {
        Some((distance, name)) if distance <= limit => format!("; did you mean {name}?"),
        _ => String::new(),
    };
    let word = plain(word);
    match known {
        [] => format!("unknown {what} {word}{hint}"),
        known => format!("unknown {what} {word}{hint}; the known ones are {}", known.join(", ")),
    }
}

/// A word from the text as a part of a line: not too long, and without what would break the line.
fn plain(word: &str) -> String {
    word.chars().take(64).flat_map(char::escape_debug).collect()
}

/// "`needed` is needed; this is …".
fn wrong(needed: &str, value: &DeValue<'_>) -> String {
    let is = match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time without quotes",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    };
    format!("{needed} is needed; this is {is}")
}

/// The text of a value that must be one.
pub(super) fn text<'a>(value: &'a DeValue<'_>) -> Result<&'a str, String> {
    match value {
        DeValue::String(text) => Ok(text),
        other => Err(wrong("a text in quotes", other)),
    }
}

/// Takes a text that `T` can be parsed from.
pub(super) fn word<T: FromStr<Err: fmt::Display>>(value: &DeValue<'_>) -> Result<T, String> {
    text(value)?.parse().map_err(|error: T::Err| error.to_string())
}

/// Takes a text by a parser.
pub(super) fn worded<T, E: fmt::Display>(
    parser: impl FnOnce(&str) -> Result<T, E>,
) -> impl FnOnce(&DeValue<'_>) -> Result<T, String> {
    |value| parser(text(value)?).map_err(|error| error.to_string())
}

/// Takes a number by a parser of its text.
pub(super) fn number<T, E: fmt::Display>(
    parser: impl FnOnce(&str) -> Result<T, E>,
) -> impl FnOnce(&DeValue<'_>) -> Result<T, String> {
    |value| {
        let text = match value {
            DeValue::Integer(number) if number.radix() == 10 => number.as_str(),
            DeValue::Float(number) => number.as_str(),
            DeValue::Integer(_) => return Err("a decimal number is needed".into()),
            other => return Err(wrong("a number", other)),
        };
        parser(text).map_err(|error| error.to_string())
    }
}

/// Takes a whole number in `range`.
pub(super) fn whole<T: FromStr + PartialOrd + fmt::Display>(
    range: RangeInclusive<T>,
) -> impl FnOnce(&DeValue<'_>) -> Result<T, String> {
    number(move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("a whole number from {} to {} is needed", range.start(), range.end()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_counts_lines_and_characters() {
        let text = "\u{feff}a\r\nö = x\n";
        let at = |what| place(text, text.find(what).unwrap());
        assert_eq!(at("a"), Place { line: 1, column: 1 });
        assert_eq!(at("x"), Place { line: 2, column: 5 });
        assert_eq!(place(text, usize::MAX), Place { line: 3, column: 1 });
    }

    #[test]
    fn a_near_word_is_suggested_and_a_far_one_is_not() {
        let known = ["fps", "rotation", "seconds"];
        assert!(unknown("key", "fsp", &known).contains("did you mean fps?"));
        assert!(unknown("key", "ROTATON", &known).contains("did you mean rotation?"));
        assert!(!unknown("key", "zebra", &known).contains("did you mean"));
        assert!(unknown("key", &"s".repeat(1 << 20), &known).len() < 200);
    }
}
