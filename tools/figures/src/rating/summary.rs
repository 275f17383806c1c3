//! The mean score of every clip, with its interval: Table 2.

use super::sheet::Rating;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::{collections::BTreeSet, fmt};
use yurameki::noise::Kind;

/// How sure the interval is to hold the mean of all people.
const CONFIDENCE: f64 = 0.95;

/// What people think of one clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Opinion {
    /// Mean opinion score.
    pub(super) mean: f64,
    /// Half the width of the 95 % interval; none from a single rating, which tells nothing of the spread.
    pub(super) half_width: Option<f64>,
    /// How many have rated it.
    pub(super) count: usize,
}

impl Opinion {
    /// The opinion that `scores` make; none without a score. The interval is Student's t: mean ± t·s/√n.
    fn of(scores: &[f64]) -> Option<Self> {
        let count = scores.len();
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = scores.iter().sum::<f64>() / n;
        let squares = scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>();
        let half_width = quantile(count).map(|t| t * (squares / (n - 1.) / n).sqrt());
        Some(Self { mean, half_width, count })
    }
}

/// The quantile of Student's t with `count` − 1 degrees of freedom that [`CONFIDENCE`] asks for on both sides.
fn quantile(count: usize) -> Option<f64> {
    let freedom = (count > 1).then(|| (count - 1) as f64)?;
    let student = StudentsT::new(0., 1., freedom).ok()?;
    Some(student.inverse_cdf(f64::midpoint(1., CONFIDENCE)))
}

/// The opinions of every clip.
#[derive(Debug)]
pub(super) struct Summary {
    raters: usize,
    opinions: [[Option<Opinion>; 5]; 5],
}

impl Summary {
    pub(super) fn of(ratings: &[Rating]) -> Self {
        let raters: BTreeSet<&str> = ratings.iter().map(|rating| rating.rater.as_str()).collect();
        let opinion = |cell| {
            let scores = ratings.iter().filter(|rating| rating.cell == cell);
            Opinion::of(&scores.map(|rating| f64::from(rating.score)).collect::<Vec<_>>())
        };
        let opinions = Kind::CHOICES.map(|row| Kind::CHOICES.map(|column| opinion((row, column))));
        Self { raters: raters.len(), opinions }
    }

    /// The opinions row by row: each row is an amplitude's noise.
    pub(super) fn rows(&self) -> impl Iterator<Item = (Kind, &[Option<Opinion>; 5])> {
        Kind::CHOICES.into_iter().zip(&self.opinions)
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Mean score ± half the 95 % interval (ratings); raters: {}", self.raters)?;
        write!(f, "{:<19}", "amplitude\\frequency")?;
        for column in Kind::CHOICES {
            write!(f, " {:>15}", column.name())?;
        }
        writeln!(f)?;
        for (row, opinions) in self.rows() {
            write!(f, "{:<19}", row.name())?;
            for opinion in opinions {
                let words = match opinion {
                    None => "–".to_owned(),
                    Some(Opinion { mean, half_width: Some(half), count }) => {
                        format!("{mean:.1} ± {half:.1} ({count})")
                    }
                    Some(Opinion { mean, half_width: None, count }) => format!("{mean:.1} ({count})"),
                };
                write!(f, " {words:>15}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::sheet;
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_printed_tables() {
        for (count, t) in [(2, 12.706), (3, 4.303), (8, 2.365), (31, 2.042)] {
            let found = quantile(count).unwrap();
            assert!((found - t).abs() < 6e-4, "{count}: {found}");
        }
        assert_eq!(quantile(1), None);
    }

    #[test]
    fn a_mean_has_its_interval() {
        // s² = 2.5, so that t·s/√n = 2.776·√(2.5/5).
        let opinion = Opinion::of(&[1., 2., 3., 4., 5.]).unwrap();
        assert_eq!((opinion.mean, opinion.count), (3., 5));
        assert!((opinion.half_width.unwrap() - 1.9632).abs() < 1e-3, "{opinion:?}");
        assert_eq!(Opinion::of(&[4.; 8]).unwrap().half_width, Some(0.));
        assert_eq!(Opinion::of(&[2.]), Some(Opinion { mean: 2., half_width: None, count: 1 }));
        assert_eq!(Opinion::of(&[]), None);
    }

    #[test]
    fn ratings_of_several_sheets_come_together_in_a_table() {
        let mut ratings = Vec::new();
        for (rater, score) in [("A", 3), ("B", 4)] {
            let text = format!("rater,amplitude,frequency,score\n{rater},brown,filter,{score}\n");
            sheet::read("a sheet", &text, &mut ratings).unwrap();
        }
        let table = Summary::of(&ratings).to_string();
        let brown = table.lines().last().unwrap();
        assert!(brown.starts_with("brown ") && brown.contains("3.5 ± 6.4 (2)"), "{table}");
        assert!(table.contains("raters: 2"));
    }
}
