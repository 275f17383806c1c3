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
