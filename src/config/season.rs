//! When it is autumn: the calendar of a tree.

use crate::effect::autumn::Stage;
use core::{fmt, str::FromStr};

/// Which half of the Earth the frame hangs on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hemisphere {
    /// Autumn is from September on.
    #[default]
    North,
    /// Autumn is from March on.
    South,
}

named!(Hemisphere, "hemisphere", North = "north", South = "south");

/// A day of a year without leap days, 0..365.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Day(u16);

/// Days before the first of each month.
const MONTHS: [u16; 13] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334, 365];

const YEAR: u16 = 365;

/// A word is no day of the year.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotADay;

impl fmt::Display for NotADay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a day is MONTH-DAY, like 10-05 for the fifth of October")
    }
}

impl Day {
    /// The day of a month, both from 1; the 29th of February is the 28th.
    pub const fn new(month: u8, day: u8) -> Option<Self> {
        if month < 1 || month > 12 || day < 1 {
            return None;
        }
        let (before, after) = (MONTHS[month as usize - 1], MONTHS[month as usize]);
        let at = before + day as u16 - 1;
        if at < after {
            Some(Self(at))
        } else if month == 2 && day == 29 {
            Some(Self(after - 1))
        } else {
            None
        }
    }

    /// Days from `earlier` to this one.
    const fn since(self, earlier: Self) -> u16 {
        (self.0 + YEAR - earlier.0) % YEAR
    }
}

impl FromStr for Day {
    type Err = NotADay;

    fn from_str(word: &str) -> Result<Self, NotADay> {
        let (month, day) = word.split_once('-').ok_or(NotADay)?;
        let number = |text: &str| text.parse().map_err(|_| NotADay);
        Self::new(number(month)?, number(day)?).ok_or(NotADay)
    }
}

/// The year of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calendar {
    /// In the south all days are half a year later than they say.
    pub hemisphere: Hemisphere,
    /// The leaves are out.
    pub green: Day,
    /// The first leaves turn.
    pub turns: Day,
    /// All have turned.
    pub full: Day,
    /// All have fallen.
    pub bare: Day,
}

impl Default for Calendar {
    /// A maple in the middle of Honshu, or of Germany some days earlier.
    fn default() -> Self {
        let day = |month, day| Day::new(month, day).unwrap_or(Day(0));
        Self {
            hemisphere: Hemisphere::default(),
            green: day(4, 20),
            turns: day(10, 1),
            full: day(11, 20),
            bare: day(12, 10),
        }
    }
}

impl Calendar {
    /// The stage of a tree on a day, `minute` minutes after its midnight.
    pub fn stage(&self, today: Day, minute: u16) -> Stage {
        let shift = if self.hemisphere == Hemisphere::South { YEAR / 2 } else { 0 };
        let today = Day((today.0 + shift) % YEAR);
        let [turns, full, bare] = [self.turns, self.full, self.bare].map(|day| day.since(self.green));
        let since = today.since(self.green);
        let minutes = |days: u16| u64::from(days) * 24 * 60;
        let on_the_way = |from: (u16, Stage), to: (u16, Stage)| {
            from.1.towards(to.1, minutes(since - from.0) + u64::from(minute), minutes(to.0 - from.0))
        };
        if since < turns {
            Stage::GREEN
        } else if since < full {
            on_the_way((turns, Stage::GREEN), (full, Stage::COLOURED))
        } else if since < bare {
            on_the_way((full, Stage::COLOURED), (bare, Stage::BARE))
        } else {
            Stage::BARE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Factor;

    fn stage(calendar: Calendar, day: &str) -> Stage {
        calendar.stage(day.parse().unwrap(), 0)
    }

    #[test]
    fn the_year_goes_through_all_stages() {
        let calendar = Calendar::default();
        for (day, want) in [
            ("07-15", 0.),
            ("10-01", 0.),
            ("10-26", 3.),
            ("11-20", 6.),
            ("11-30", 6.5),
            ("12-10", 7.),
            ("02-01", 7.),
            ("04-20", 0.),
        ] {
            assert_eq!(stage(calendar, day), Stage::new(Factor::from_num(want)), "{day}");
        }
    }

    #[test]
    fn the_south_is_half_a_year_later() {
        let south = Calendar { hemisphere: Hemisphere::South, ..Calendar::default() };
        assert_eq!(stage(south, "01-15"), Stage::default());
        assert!(stage(south, "05-01") > Stage::default() && stage(south, "05-01") < Stage::COLOURED);
        assert_eq!(stage(south, "08-01"), Stage::BARE);
    }

    #[test]
    fn days_are_read_and_what_is_none_is_refused() {
        assert_eq!("02-29".parse(), Ok(Day(58)));
        assert_eq!("12-31".parse(), Ok(Day(364)));
        for word in ["13-01", "00-10", "04-31", "2-30", "1", "a-b", "", "-1-5"] {
            assert_eq!(word.parse::<Day>(), Err(NotADay), "{word}");
        }
    }

    #[test]
    fn dates_in_any_order_break_nothing() {
        let odd = Calendar { turns: Day(200), full: Day(100), bare: Day(50), ..Calendar::default() };
        (0..YEAR).for_each(|day| assert!(odd.stage(Day(day), 1_439) <= Stage::BARE));
    }
}
