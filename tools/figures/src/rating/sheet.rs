//! A rating sheet: a CSV file with one row a clip.
//!
//! Lines that start with # are comments. The columns are the rater's name, the noises of the clip's amplitude and frequency, and
//! the score; a row without a score counts as not yet rated.

use crate::{Failure, clips};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::{fmt::Write, ops::RangeInclusive};
use yurameki::noise::Kind;

/// The scores of Table 1, in words.
const SCORES: [(u8, &str); 5] = [
    (5, "the second film is far more natural"),
    (4, "the second film is rather more natural"),
    (3, "neither (no difference)"),
    (2, "the second film is rather less natural"),
    (1, "the second film is far less natural"),
];

const KNOWN: RangeInclusive<u8> = 1..=5;

const COLUMNS: [&str; 4] = ["rater", "amplitude", "frequency", "score"];

/// What one person thinks of one clip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Rating {
    pub(super) rater: String,
    /// The noises of the amplitude and of the frequency.
    pub(super) cell: (Kind, Kind),
    pub(super) score: u8,
    /// Where it was read, for messages.
    place: String,
}

/// A sheet that is yet to be filled, by `rater` if that is known.
pub(super) fn empty(rater: &str) -> Result<Vec<u8>, Failure> {
    let mut comment = String::from(
        "# Yurameki rating sheet. Every clip shows a film without noise, grey, the film with noise, grey; twice.\n\
         # Score how natural the motion of the second film is, beside the first:\n",
    );
    for (score, words) in SCORES {
        writeln!(comment, "# {score} = {words}")?;
    }
    let mut sheet = csv::Writer::from_writer(comment.into_bytes());
    sheet.write_record(COLUMNS)?;
    for (amplitude, frequency) in clips::cells() {
        sheet.write_record([rater, amplitude.name(), frequency.name(), ""])?;
    }
    Ok(sheet.into_inner()?)
}

/// Adds what stands on the sheet called `name` to `ratings`.
///
/// # Errors
/// The first row that is wrong, by its line: another number of fields, a noise that is not in Table 2, a score that is none, a
/// score without a rater, a clip that its rater has rated already.
pub(super) fn read(name: &str, text: &str, ratings: &mut Vec<Rating>) -> Result<(), Failure> {
    let mut reader = ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(Trim::All)
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let headers = reader.headers().map_err(|error| format!("{name}: {error}"))?;
    if headers != COLUMNS.as_slice() {
        let columns = COLUMNS.join(",");
        return Err(format!("{name}: no rating sheet; its first line but comments must be {columns}").into());
    }
    for record in reader.records() {
        let record = record.map_err(|error| format!("{name}: {error}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let place = format!("{name}, line {line}");
        let wrong = |what: String| format!("{place}: {what}");
        let Some(rating) = rating(&record, &place).map_err(wrong)? else { continue };
        let before = ratings.iter().find(|other| (&other.rater, other.cell) == (&rating.rater, rating.cell));
        if let Some(before) = before {
            let (amplitude, frequency) = rating.cell;
            let clip = format!("{} has rated {amplitude}/{frequency} already", rating.rater);
            return Err(wrong(format!("{clip}, at {}; remove one of the two", before.place)).into());
        }
        ratings.push(rating);
    }
    Ok(())
}

/// The rating of a row; none if it has no score yet.
fn rating(record: &StringRecord, place: &str) -> Result<Option<Rating>, String> {
    let [rater, amplitude, frequency, score] = std::array::from_fn(|column| record.get(column));
    let (Some(rater), Some(amplitude), Some(frequency), Some(score), None) =
        (rater, amplitude, frequency, score, record.get(COLUMNS.len()))
    else {
        return Err(format!("{} fields; a row has {}: {}", record.len(), COLUMNS.len(), COLUMNS.join(",")));
    };
    let kind = |word: &str| word.parse::<Kind>().map_err(|error| format!("{word:?}: {error}"));
    let cell = (kind(amplitude)?, kind(frequency)?);
    if !clips::cells().contains(&cell) {
        return Err(format!("{amplitude}/{frequency} is no clip of Table 2; remove the row"));
    }
    if score.is_empty() {
        return Ok(None);
    }
    let score = score.parse().ok().filter(|score| KNOWN.contains(score));
    let score = score.ok_or_else(|| format!("score {:?}; a score is 1, 2, 3, 4 or 5", &record[3]))?;
    if rater.is_empty() {
        return Err("a score without a rater; write a name into the first field".into());
    }
    Ok(Some(Rating { rater: rater.to_owned(), cell, score, place: place.to_owned() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_one(text: &str) -> Result<Vec<Rating>, String> {
        let mut ratings = Vec::new();
        read("a.csv", text, &mut ratings).map_err(|failure| failure.to_string())?;
        Ok(ratings)
    }

    #[test]
    fn an_empty_sheet_is_read_back_without_a_rating() {
        let text = String::from_utf8(empty("Aki, the first").unwrap()).unwrap();
        assert_eq!(text.lines().filter(|line| line.ends_with(',')).count(), 24);
        assert_eq!(read_one(&text), Ok(vec![]));
        let filled = text.replace("brown,brown,", "brown,brown,4");
        let ratings = read_one(&filled).unwrap();
        assert_eq!(ratings.len(), 1);
        assert_eq!((ratings[0].rater.as_str(), ratings[0].score), ("Aki, the first", 4));
        assert_eq!(ratings[0].cell, (Kind::Brown, Kind::Brown));
    }

    #[test]
    fn a_wrong_row_is_refused_by_its_line() {
        let head = "# words\nrater,amplitude,frequency,score\nA,white,white,3\n";
        for (row, complaint) in [
            ("A,brown,brown,6", "a.csv, line 4: score \"6\"; a score is 1, 2, 3, 4 or 5"),
            ("A,brown,brown,3.5", "a.csv, line 4: score \"3.5\"; a score is 1, 2, 3, 4 or 5"),
            ("A,pink,brown,3", "a.csv, line 4: \"pink\": unknown noise; the known ones are"),
            ("A,hosoda,brown,3", "a.csv, line 4: hosoda/brown is no clip of Table 2"),
            ("A,constant,constant,3", "a.csv, line 4: constant/constant is no clip of Table 2"),
            (",brown,brown,3", "a.csv, line 4: a score without a rater"),
            ("A,brown,3", "a.csv, line 4: 3 fields; a row has 4"),
            ("A,brown,brown,3,4", "a.csv, line 4: 5 fields; a row has 4"),
            ("A,white,white,4", "a.csv, line 4: A has rated white/white already, at a.csv, line 3"),
        ] {
            let error = read_one(&format!("{head}{row}\n")).unwrap_err();
            assert!(error.starts_with(complaint), "{error}");
        }
    }

    #[test]
    fn what_is_no_sheet_is_refused() {
        for text in ["", "a,b\n1,2\n", "# only words\n"] {
            let error = read_one(text).unwrap_err();
            assert!(error.starts_with("a.csv: no rating sheet"), "{error}");
        }
    }

    #[test]
    fn a_sheet_from_a_spreadsheet_program_is_read() {
        let text = "\u{feff}rater,amplitude,frequency,score\r\n B , white , brown , 2 \r\n";
        let ratings = read_one(text).unwrap();
        assert_eq!((ratings[0].rater.as_str(), ratings[0].score), ("B", 2));
    }
}
