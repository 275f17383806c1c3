//! # Noise
//!
//! The paper's five noises (Yamamoto and Sakamoto, section 3.3) with the literal forms of those that had to be changed, the
//! response of a body with inertia (eq. 5, 6), and the [`drive`] that joins them. Knows frames and seeds; knows no picture.
//!
//! | kind | spectral slope, 1e-4..1e-1 of the frame rate | instructions a step | source |
//! |---|---|---|---|
//! | constant | – | 18 | – |
//! | white | 0 | 82 | [`white`] |
//! | chaos | 1 | 122 | [`chaos`] |
//! | filter | 1 | 156 | [`filter`] |
//! | brown | 2 above its leak | 88 | [`brown`] |
//! | chaos-literal | dies | – | [`chaos::Literal`] |
//! | hosoda | 0.956 | 166 | [`hosoda`] |
//! | brown-literal | 2, strays without limit | 92 | [`brown::Literal`] |
//!
//! (Instructions as valgrind counts them in the release profile on x86-64, [`Generator::step`] and the loop around it.)
//!
//! Every generator makes one sample a frame from integers alone, in constant time and without tables made at run time: the stream
//! of a seed is the same on every machine.

pub mod brown;
pub mod chaos;
pub mod drive;
pub mod filter;
pub mod guard;
pub mod hosoda;
#[cfg(test)]
pub(crate) mod reference;
pub mod response;
pub mod white;

use crate::math::{Sample, random::Rng};
use core::{fmt, str::FromStr};

/// Which noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// No noise: always 1.
    Constant,
    /// White noise.
    White,
    /// 1/f noise by intermittent chaos, kept alive.
    Chaos,
    /// 1/f noise by intermittent chaos as printed in the paper: it dies within minutes.
    ChaosLiteral,
    /// 1/f noise by a digital filter.
    Filter,
    /// 1/f noise by the digital filter that the paper cites: slope 0.956.
    Hosoda,
    /// Brown noise that forgets slowly.
    Brown,
    /// Brown noise as printed in the paper: it strays without limit.
    BrownLiteral,
}

/// Where the samples of a noise lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Around 0, with unit sigma, without a limit.
    Centred,
    /// In 0..=1.
    Unit,
}

impl Kind {
    /// Every kind, in the order in which they are listed to people.
    pub const ALL: [Self; 8] = [
        Self::Constant,
        Self::White,
        Self::Chaos,
        Self::ChaosLiteral,
        Self::Filter,
        Self::Hosoda,
        Self::Brown,
        Self::BrownLiteral,
    ];

    /// The five that buttons step through: the rows and columns of the paper's Table 2.
    pub const CHOICES: [Self; 5] = [Self::Constant, Self::White, Self::Chaos, Self::Filter, Self::Brown];

    /// The choice after this one; after the last comes the first. A literal form is followed by what follows its plain form.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Constant => Self::White,
            Self::White => Self::Chaos,
            Self::Chaos | Self::ChaosLiteral => Self::Filter,
            Self::Filter | Self::Hosoda => Self::Brown,
            Self::Brown | Self::BrownLiteral => Self::Constant,
        }
    }

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::White => "white",
            Self::Chaos => "chaos",
            Self::ChaosLiteral => "chaos-literal",
            Self::Filter => "filter",
            Self::Hosoda => "hosoda",
            Self::Brown => "brown",
            Self::BrownLiteral => "brown-literal",
        }
    }

    /// Where its samples lie.
    pub const fn range(self) -> Range {
        match self {
            Self::Constant | Self::Chaos | Self::ChaosLiteral => Range::Unit,
            Self::White | Self::Filter | Self::Hosoda | Self::Brown | Self::BrownLiteral => Range::Centred,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A word that names no [`Kind`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownKind;

impl fmt::Display for UnknownKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown noise; the known ones are ")?;
        for (i, kind) in Kind::ALL.iter().enumerate() {
            write!(f, "{}{kind}", if i == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

impl core::error::Error for UnknownKind {}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(word: &str) -> Result<Self, UnknownKind> {
        Self::ALL.into_iter().find(|kind| kind.name() == word).ok_or(UnknownKind)
    }
}

/// A noise of any kind, one sample a frame. [`Kind::range`] tells where the samples lie.
#[derive(Clone, Debug)]
pub struct Generator {
    rng: Rng,
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Constant,
    White,
    Chaos(chaos::Chaos),
    ChaosLiteral(chaos::Literal),
    Filter(filter::Filter),
    Hosoda(hosoda::Hosoda),
    Brown(brown::Brown),
    BrownLiteral(brown::Literal),
}

impl Source {
    fn new(kind: Kind, rng: &mut Rng) -> Self {
        match kind {
            Kind::Constant => Self::Constant,
            Kind::White => Self::White,
            Kind::Chaos => Self::Chaos(chaos::Chaos::new(rng)),
            Kind::ChaosLiteral => Self::ChaosLiteral(chaos::Literal::new(rng)),
            Kind::Filter => Self::Filter(filter::Filter::new(rng)),
            Kind::Hosoda => Self::Hosoda(hosoda::Hosoda::new(rng)),
            Kind::Brown => Self::Brown(brown::Brown::new(rng)),
            Kind::BrownLiteral => Self::BrownLiteral(brown::Literal::default()),
        }
    }
}

impl Generator {
    /// A noise of `kind` that draws from `rng`. All but the literal forms are stationary from the first sample on.
    pub fn new(kind: Kind, mut rng: Rng) -> Self {
        Self { source: Source::new(kind, &mut rng), rng }
    }

    /// Goes on as a noise of another kind. It draws from where the old one stopped, so that no number is ever drawn twice.
    pub fn change(&mut self, kind: Kind) {
        self.source = Source::new(kind, &mut self.rng);
    }

    /// The kind of noise.
    pub const fn kind(&self) -> Kind {
        match self.source {
            Source::Constant => Kind::Constant,
            Source::White => Kind::White,
            Source::Chaos(_) => Kind::Chaos,
            Source::ChaosLiteral(_) => Kind::ChaosLiteral,
            Source::Filter(_) => Kind::Filter,
            Source::Hosoda(_) => Kind::Hosoda,
            Source::Brown(_) => Kind::Brown,
            Source::BrownLiteral(_) => Kind::BrownLiteral,
        }
    }

    /// The next frame's sample.
    pub fn step(&mut self) -> Sample {
        let rng = &mut self.rng;
        match &mut self.source {
            Source::Constant => Sample::ONE,
            Source::White => white::step(rng),
            Source::Chaos(chaos) => chaos.step(rng),
            Source::ChaosLiteral(chaos) => chaos.step(),
            Source::Filter(filter) => filter.step(rng),
            Source::Hosoda(ladder) => ladder.step(rng),
            Source::Brown(brown) => brown.step(rng),
            Source::BrownLiteral(brown) => brown.step(rng),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{Stream, stream};

    #[test]
    fn names_are_read_back_and_an_unknown_one_lists_the_known() {
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
            assert_eq!(Generator::new(kind, stream(1, Stream::Amplitude)).kind(), kind);
        }
        assert_eq!(
            "pink".parse::<Kind>().unwrap_err().to_string(),
            "unknown noise; the known ones are \
             constant, white, chaos, chaos-literal, filter, hosoda, brown, brown-literal"
        );
    }

    #[test]
    fn buttons_step_through_the_five_choices_and_wrap() {
        for (i, kind) in Kind::CHOICES.into_iter().enumerate() {
            assert_eq!(kind.next(), Kind::CHOICES[(i + 1) % Kind::CHOICES.len()]);
        }
        assert_eq!(Kind::ChaosLiteral.next(), Kind::Chaos.next());
        assert_eq!(Kind::Hosoda.next(), Kind::Filter.next());
        assert_eq!(Kind::BrownLiteral.next(), Kind::Brown.next());
    }

    #[test]
    fn a_changed_generator_draws_new_numbers() {
        let mut changed = Generator::new(Kind::White, stream(1, Stream::Amplitude));
        let before: [Sample; 64] = core::array::from_fn(|_| changed.step());
        changed.change(Kind::White);
        for _ in 0..64 {
            assert!(!before.contains(&changed.step()));
        }
    }
}
