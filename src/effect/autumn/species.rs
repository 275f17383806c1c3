//! A species of tree, as read from a small text.

use super::{
    lsystem::Rule,
    plates::STAGES,
    scenery::Scene,
    space::{AffineMap, BITS, Matrix, ONE, PlaneMap},
    text::{Cursor, Fault, Number, SpeciesError},
};
use heapless::Vec;

/// The most maps of a leaf: a symbol of its address has 2 bits.
pub(super) const MOST_LEAF_MAPS: usize = 4;

/// Twigs that have an address of their own: 12 bits of 16, of which a leaf takes 4.
pub const MOST_TWIGS: usize = 4_096;

/// A species: its IFS, its leaf and its colours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Species {
    pub(super) rule: Rule,
    /// M: symbols of a twig's address.
    pub(super) depth: u32,
    /// How likely each bough is the next to turn; adds up to 2^16.
    pub(super) chances: Vec<i32, { super::lsystem::MOST_BOUGHS }>,
    /// By how many degrees a fork strays from the rule.
    pub(super) stray: Number,
    /// The trunk's width.
    pub(super) width: Number,
    /// How many times thinner a branch is than the one that it springs from.
    pub(super) taper: Number,
    /// The colour of lit bark.
    pub(super) bark: [u8; 3],
    /// Whether the bark has dark marks across it, as birches have.
    pub(super) bark_marks: bool,
    /// Leaves of a twig.
    pub(super) leaves: u32,
    /// The size of a leaf beside the length of a twig.
    pub(super) size: Number,
    /// How far leaves hang: 0 any way, 1 straight down.
    pub(super) droop: Number,
    /// The leaf's DIFS.
    pub(super) leaf: Vec<PlaneMap, MOST_LEAF_MAPS>,
    /// Keeps its leaves, and their colour.
    pub(super) evergreen: bool,
    /// Where it stands.
    pub(super) scene: &'static Scene,
    /// Chlorophyll, carotenoids and anthocyanins at each stage.
    pub(super) pigments: [[Number; STAGES]; 3],
}

/// The species that the program carries, by name.
pub const KNOWN: &[(&str, &str)] = &[
    ("maple", include_str!("species/maple.tree")),
    ("ginkgo", include_str!("species/ginkgo.tree")),
    ("birch", include_str!("species/birch.tree")),
    ("pine", include_str!("species/pine.tree")),
    ("paper", include_str!("species/paper.tree")),
];

impl Species {
    /// Reads a species.
    ///
    /// # Errors
    /// The first mistake in `text`, and where it is.
    pub fn parse(text: &str) -> Result<Self, SpeciesError> {
        let mut draft = Draft::default();
        for (line, number) in text.lines().zip(1..) {
            let cursor = Cursor::new(line, number);
            if !cursor.is_at_end() {
                draft.line(cursor)?;
            }
        }
        draft.finish()
    }

    /// The species of this name that the program carries.
    pub fn known(name: &str) -> Option<Self> {
        let (_, text) = KNOWN.iter().find(|(known, _)| *known == name)?;
        Self::parse(text).ok()
    }

    /// A single leaf of this species, as large as the picture (the paper's fig. 8).
    #[must_use]
    pub fn one_leaf(&self) -> Self {
        let matrix = Matrix::IDENTITY.scaled(ONE / 16);
        let twig = AffineMap { matrix, shift: [0, ONE / 2, 0] };
        let rule = Rule { boughs: [twig].into_iter().collect(), wood: Vec::new(), is_flat: true };
        let (chances, droop) = ([1 << 16].into_iter().collect(), Number::ZERO);
        let size = Number::lit("12");
        Self { rule, depth: 1, chances, stray: Number::ZERO, leaves: 1, size, droop, ..self.clone() }
    }

    /// N^M, how many twigs have an address.
    pub(super) fn twigs(&self) -> usize {
        self.rule.boughs.len().pow(self.depth)
    }
}

/// A species of which not all is known yet.
struct Draft {
    rule: Option<Rule>,
    chances: Option<(Vec<Number, { super::lsystem::MOST_BOUGHS }>, SpeciesError)>,
    depth: Option<(u32, SpeciesError)>,
    species: Species,
}

impl Default for Draft {
    fn default() -> Self {
        let number = |hundredths: i32| Number::from_bits((hundredths << 16) / 100);
        let species = Species {
            rule: Rule { boughs: Vec::new(), wood: Vec::new(), is_flat: true },
            depth: 1,
            chances: Vec::new(),
            stray: Number::ZERO,
            width: number(16),
            taper: number(160),
            bark: [104, 88, 76],
            bark_marks: false,
            leaves: 3,
            size: number(200),
            droop: Number::ZERO,
            leaf: Vec::new(),
            evergreen: false,
            scene: Scene::usual(),
            // The maple's, measured by Ishikura (the paper's references 8 and 9) and fitted by eye.
            pigments: [[120, 100, 58, 20, 7, 3, 2], [55, 55, 58, 60, 56, 50, 45], [2, 2, 2, 3, 16, 70, 115]]
                .map(|row| row.map(number)),
        };
        Self { rule: None, chances: None, depth: None, species }
    }
}

impl Draft {
    fn line(&mut self, mut cursor: Cursor<'_>) -> Result<(), SpeciesError> {
        let start = cursor;
        let species = &mut self.species;
        if cursor.take("a(s)") {
            cursor.expect("->")?;
            return match self.rule.replace(Rule::parse(cursor)?) {
                None => Ok(()),
                Some(_) => Err(start.error(Fault::Twice)),
            };
        }
        match cursor.word() {
            "tree" => {
                cursor.word();
            }
            "depth" => self.depth = Some((cursor.whole("1", "11")?, start.error(Fault::TooManyTwigs))),
            "chance" => {
                let mut chances = Vec::new();
                while !cursor.is_at_end() {
                    let chance = cursor.number("0.01", "1")?;
                    chances.push(chance).map_err(|_| start.error(Fault::ChancesDoNotFit))?;
                }
                self.chances = Some((chances, start.error(Fault::ChancesDoNotFit)));
            }
            "stray" => species.stray = cursor.number("0", "45")?,
            "width" => species.width = cursor.number("0", "1")?,
            "taper" => species.taper = cursor.number("1", "8")?,
            "bark" => {
                for channel in &mut species.bark {
                    *channel = cursor.whole("0", "255")? as u8;
                }
            }
            "bark-marks" => species.bark_marks = true,
            "leaves" => species.leaves = cursor.whole("1", "1000")?,
            "size" => species.size = cursor.number("0.05", "20")?,
            "droop" => species.droop = cursor.number("0", "1")?,
            "leaf" => {
                let map = plane_map(&mut cursor)?;
                if !map.is_contracting() {
                    return Err(start.error(Fault::NotContracting));
                }
                species
                    .leaf
                    .push(map)
                    .map_err(|_| start.error(Fault::Expected("no more than four maps of a leaf")))?;
            }
            "scene" => {
                let place = cursor;
                species.scene =
                    Scene::named(cursor.word()).ok_or(place.error(Fault::Expected(Scene::NAMES)))?;
            }
            "evergreen" => species.evergreen = true,
            "chlorophyll" => stages(&mut cursor, &mut species.pigments[0])?,
            "carotenoids" => stages(&mut cursor, &mut species.pigments[1])?,
            "anthocyanins" => stages(&mut cursor, &mut species.pigments[2])?,
            _ => return Err(start.error(Fault::UnknownKey)),
        }
        cursor.end()
    }

    fn finish(self) -> Result<Species, SpeciesError> {
        let whole_text = |fault| SpeciesError { line: 0, column: 0, fault };
        let mut species = self.species;
        species.rule = self.rule.ok_or(whole_text(Fault::NoTreeRule))?;
        if species.leaf.is_empty() {
            return Err(whole_text(Fault::NoLeafRule));
        }
        let boughs = species.rule.boughs.len();
        let (depth, error) = self.depth.unwrap_or((6, whole_text(Fault::TooManyTwigs)));
        if boughs.checked_pow(depth).is_none_or(|twigs| twigs > MOST_TWIGS) {
            return Err(error);
        }
        species.depth = depth;
        let (chances, error) = match self.chances {
            Some(chances) => chances,
            None => (core::iter::repeat_n(Number::ONE, boughs).collect(), whole_text(Fault::ChancesDoNotFit)),
        };
        if chances.len() != boughs {
            return Err(error);
        }
        let sum: i64 = chances.iter().map(|chance| i64::from(chance.to_bits())).sum();
        species.chances =
            chances.iter().map(|chance| ((i64::from(chance.to_bits()) << 16) / sum) as i32).collect();
        Ok(species)
    }
}

fn plane_map(cursor: &mut Cursor<'_>) -> Result<PlaneMap, SpeciesError> {
    let mut entry = || cursor.number("-8", "8").map(|number| number.to_bits() << (BITS - Number::FRAC_NBITS));
    Ok(PlaneMap { a: entry()?, b: entry()?, c: entry()?, d: entry()?, e: entry()?, f: entry()? })
}

fn stages(cursor: &mut Cursor<'_>, pigment: &mut [Number; STAGES]) -> Result<(), SpeciesError> {
    pigment.iter_mut().try_for_each(|stage| {
        *stage = cursor.number("0", "8")?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "tree x\na(s) -> F(s) [ +(30) a(s/2) ] a(s/1.5)\nleaf .5 0 0 .5 0 1\n";

    fn error(text: &str) -> (u32, u32, Fault) {
        let error = Species::parse(text).expect_err(text);
        (error.line, error.column, error.fault)
    }

    #[test]
    fn all_known_species_can_be_read_and_have_their_twigs() {
        for (name, text) in KNOWN {
            let species = Species::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!((512..=MOST_TWIGS).contains(&species.twigs()), "{name}: {}", species.twigs());
            let sum: i32 = species.chances.iter().sum();
            assert!((65_000..=65_536).contains(&sum), "{name}: the chances add up to {sum}");
        }
        assert!(Species::known("oak").is_none());
    }

    #[test]
    fn a_mistake_is_named_with_its_line_and_column() {
        let with = |line: &str| format!("{SMALL}{line}\n");
        assert_eq!(error(&with("  depht 6")), (4, 3, Fault::UnknownKey));
        assert_eq!(error(&with("depth 20")), (4, 7, Fault::OutOfRange("1", "11")));
        assert_eq!(error(&with("depth 2.5")), (4, 7, Fault::Expected("a whole number")));
        assert_eq!(error(&with("leaf 1.2 0 0 .5 0 0")), (4, 1, Fault::NotContracting));
        assert_eq!(error(&with("leaf .5 0 0 .5 0")), (4, 17, Fault::Expected("a number")));
        assert_eq!(error(&with("chance .5 .2 .3")), (4, 1, Fault::ChancesDoNotFit));
        assert_eq!(error(&with("a(s) -> a(s/2)")), (4, 1, Fault::Twice));
        assert_eq!(error(&with("size 2 3")), (4, 8, Fault::Expected("the end of the line")));
        assert_eq!(error(&with("a -> b")), (4, 1, Fault::UnknownKey));
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(error("leaf .5 0 0 .5 0 1"), (0, 0, Fault::NoTreeRule));
        assert_eq!(error("a(s) -> a(s/2)"), (0, 0, Fault::NoLeafRule));
        let many = "a(s) -> [ a(s/2) ] [ a(s/2) ] [ a(s/2) ] [ a(s/2) ] [ a(s/2) ]\nleaf .5 0 0 .5 0 1\n";
        assert_eq!(error(many), (0, 0, Fault::TooManyTwigs));
        assert_eq!(error(&format!("{many}depth 6")), (3, 1, Fault::TooManyTwigs));
        assert!(Species::parse(&format!("{many}depth 5")).is_ok());
    }

    #[test]
    fn every_message_is_one_line_that_says_the_cure() {
        for text in ["a(s) -> ]", "x", "leaf 2 0 0 2 0 0", ""] {
            let line = Species::parse(text).expect_err(text).to_string();
            assert!(!line.contains('\n') && line.len() > 30, "{line}");
        }
    }
}
