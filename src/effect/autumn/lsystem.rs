//! From the rule of an L-system to a controlled IFS.
//!
//! The paper, eq. 7 to 13 (after Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants"): in a rule like
//! `a(s) -> F(s) [ +(32) a(s/1.75) ] [ -(32) a(s/1.75) ] F(s) a(s/1.75)` every `a` is a map T_k, the turtle's position and
//! orientation there with the scale 1/R, and every `F` a piece of wood, the attractor of Q1 and Q2 between where the turtle
//! was and is. The plane (eq. 8 to 10) is the space whose turtle never tips or rolls.

use super::{
    space::{AffineMap, Axis, BITS, Matrix, ONE, Vector, plus},
    text::{Cursor, Fault, Number, SpeciesError},
};
use crate::math::Turns;
use heapless::Vec;

/// The most maps of a tree: one symbol of an address has 3 bits at most.
pub(super) const MOST_BOUGHS: usize = 8;
const MOST_WOOD: usize = 16;
const MOST_SYMBOLS: u32 = 200;
const DEEPEST_BRACKETS: usize = 8;

/// A piece of wood between two places, for s = 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wood {
    pub(super) from: Vector,
    pub(super) to: Vector,
}

/// A controlled IFS: T_1 to T_N, and what is drawn on the way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Rule {
    pub(super) boughs: Vec<AffineMap, MOST_BOUGHS>,
    pub(super) wood: Vec<Wood, MOST_WOOD>,
    /// Whether the turtle stays within the plane of the picture.
    pub(super) is_flat: bool,
}

/// Where the turtle is; its scale is 1.
#[derive(Clone, Copy, Debug)]
struct Turtle(AffineMap);

impl Turtle {
    fn turn(&mut self, axis: Axis, angle: Turns) {
        self.0.matrix = self.0.matrix.after(&Matrix::rotation(axis, angle));
    }

    /// Goes ahead and leaves wood behind.
    fn forward(&mut self, length: i32) -> Wood {
        let from = self.0.shift;
        self.0.shift = plus(from, self.0.matrix.apply([0, length, 0]));
        Wood { from, to: self.0.shift }
    }
}

impl Rule {
    /// Reads what follows the arrow of a rule.
    pub(super) fn parse(mut cursor: Cursor<'_>) -> Result<Self, SpeciesError> {
        let mut rule = Self { boughs: Vec::new(), wood: Vec::new(), is_flat: true };
        let mut turtle = Turtle(AffineMap::IDENTITY);
        let mut saved = Vec::<(Turtle, Cursor<'_>), DEEPEST_BRACKETS>::new();
        let mut symbols = 0;
        while let Some(symbol) = cursor.peek() {
            let at = cursor;
            let too_many = |_| at.error(Fault::TooManySymbols);
            symbols += 1;
            if symbols > MOST_SYMBOLS {
                return Err(at.error(Fault::TooManySymbols));
            }
            cursor.next();
            match symbol {
                '[' => saved.push((turtle, at)).map_err(|_| at.error(Fault::TooDeep))?,
                ']' => turtle = saved.pop().ok_or(at.error(Fault::Unopened))?.0,
                'F' => {
                    let length = share(&mut cursor)?;
                    rule.wood.push(turtle.forward(length)).map_err(|_| at.error(Fault::TooManySymbols))?;
                }
                'a' => {
                    let scale = share(&mut cursor)?;
                    if scale >= ONE {
                        return Err(at.error(Fault::NotContracting));
                    }
                    let map = AffineMap { matrix: turtle.0.matrix.scaled(scale), shift: turtle.0.shift };
                    rule.boughs.push(map).map_err(too_many)?;
                }
                _ => rule.is_flat &= turn(symbol, &mut turtle, &mut cursor, at)?,
            }
        }
        match (saved.last(), rule.boughs.is_empty()) {
            (Some((_, opened)), _) => Err(opened.error(Fault::Unclosed)),
            (None, true) => Err(cursor.error(Fault::Expected("a bough, a(s/R),"))),
            (None, false) => Ok(rule),
        }
    }
}

/// Turns the turtle by a symbol and its angle, and tells whether that keeps it within the plane.
fn turn(
    symbol: char,
    turtle: &mut Turtle,
    cursor: &mut Cursor<'_>,
    at: Cursor<'_>,
) -> Result<bool, SpeciesError> {
    let (axis, backwards) = match symbol {
        '+' => (Axis::Viewer, false),
        '-' => (Axis::Viewer, true),
        '&' => (Axis::Right, false),
        '^' => (Axis::Right, true),
        '/' => (Axis::Heading, false),
        '\\' => (Axis::Heading, true),
        _ => return Err(at.error(Fault::UnknownSymbol)),
    };
    cursor.expect("(")?;
    let angle = cursor.angle()?;
    cursor.expect(")")?;
    turtle.turn(axis, if backwards { Turns(angle.0.wrapping_neg()) } else { angle });
    Ok(axis == Axis::Viewer)
}

/// Reads `(s)`, `(s*K)` or `(s/K)`: a share of s.
fn share(cursor: &mut Cursor<'_>) -> Result<i32, SpeciesError> {
    cursor.expect("(")?;
    cursor.expect("s")?;
    let share = if cursor.take("*") {
        i64::from(cursor.number("0.01", "100")?.to_bits()) << (BITS - Number::FRAC_NBITS)
    } else if cursor.take("/") {
        (1 << (BITS + Number::FRAC_NBITS)) / i64::from(cursor.number("0.01", "100")?.to_bits())
    } else {
        ONE.into()
    };
    cursor.expect(")")?;
    Ok(share as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(rule: &str) -> Result<Rule, SpeciesError> {
        Rule::parse(Cursor::new(rule, 3))
    }

    fn float(number: i32) -> f64 {
        f64::from(number) / f64::from(ONE)
    }

    #[test]
    fn the_papers_rule_becomes_the_papers_maps() {
        let (r, delta, s) = (1.75, 32_f64.to_radians(), 1.);
        let rule = parse("F(s) [ +(32) a(s/1.75) ] [ -(32) a(s/1.75) ] [ F(s) a(s/1.75) ]").unwrap();
        // Eq. 8 to 10, for row vectors: the rows are what becomes of the axes, and the shift.
        let want = [
            [delta.cos() / r, delta.sin() / r, -delta.sin() / r, delta.cos() / r, 0., s],
            [delta.cos() / r, -delta.sin() / r, delta.sin() / r, delta.cos() / r, 0., s],
            [1. / r, 0., 0., 1. / r, 0., 2. * s],
        ];
        assert!(rule.is_flat && rule.boughs.len() == 3);
        for (map, want) in rule.boughs.iter().zip(want) {
            let [right, up, _] = map.matrix.0;
            let got = [right[0], right[1], up[0], up[1], map.shift[0], map.shift[1]].map(float);
            // The paper's T1 turns to the right where its plane has y up; ours to the left, as its turtle does.
            for (got, want) in got.into_iter().zip(want) {
                assert!((got - want).abs() < 1e-5, "{got} for {want}");
            }
        }
        // Eq. 11: between (0, 0) and (0, s), and between (0, s) and (0, 2s).
        assert_eq!(
            rule.wood,
            [Wood { from: [0; 3], to: [0, ONE, 0] }, Wood { from: [0, ONE, 0], to: [0, 2 * ONE, 0] }]
        );
    }

    #[test]
    fn a_turtle_in_space_makes_the_map_that_its_turns_make() {
        let rule = parse("F(s*1.25) [ /(94.74) &(47) a(s/1.62) ]").unwrap();
        let (p, q, r) = (94.74_f64.to_radians(), 47_f64.to_radians(), 1.62);
        let heading = rule.boughs[0].matrix.0[1].map(float);
        let want = [q.sin() * p.sin() / r, q.cos() / r, q.sin() * p.cos() / r];
        for (got, want) in heading.into_iter().zip(want) {
            assert!((got - want).abs() < 1e-4, "{heading:?} for {want}");
        }
        assert!(!rule.is_flat && rule.boughs[0].shift == [0, ONE / 4 * 5, 0]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (rule, column, fault) in [
            ("F(s) ] a(s/2)", 6, Fault::Unopened),
            ("F(s) [ a(s/2)", 6, Fault::Unclosed),
            ("F(s) a(s/0.5)", 6, Fault::NotContracting),
            ("F(s) a(s)", 6, Fault::NotContracting),
            ("F(s) a(s*1.2)", 6, Fault::NotContracting),
            ("F(s) X a(s/2)", 6, Fault::UnknownSymbol),
            ("F(s) +(x) a(s/2)", 8, Fault::Expected("a number")),
            ("F(s) +(720) a(s/2)", 8, Fault::OutOfRange("-360", "360")),
            ("F(2) a(s/2)", 3, Fault::Expected("s")),
            ("[[[[[[[[[ a(s/2)", 9, Fault::TooDeep),
            ("F(s)", 5, Fault::Expected("a bough, a(s/R),")),
        ] {
            assert_eq!(parse(rule), Err(SpeciesError { line: 3, column, fault }), "{rule}");
        }
    }

    #[test]
    fn a_million_symbols_are_refused() {
        let rule = "+(1)".repeat(1_000_000) + "a(s/2)";
        assert_eq!(parse(&rule).map_err(|error| error.fault), Err(Fault::TooManySymbols));
        let boughs = "[ a(s/2) ]".repeat(9);
        assert_eq!(parse(&boughs).map_err(|error| error.fault), Err(Fault::TooManySymbols));
    }
}
