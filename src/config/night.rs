//! The hours at which the panel is dimmed or off.

use core::{fmt, str::FromStr};
use heapless::{String, Vec};

/// How bright the panel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Switched off, or black where it cannot be switched.
    Off,
    /// A share of full brightness, 1 to 100 %.
    Percent(u8),
}

/// From when on the panel has a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The minute of the local day, 0..1440.
    pub minute: u16,
    /// The level from then on.
    pub level: Level,
}

/// The most edges of a day: one for every hour and a half.
pub const MAX_EDGES: usize = 16;

/// The schedule of a day. Without an edge the panel is always at its full brightness.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Night {
    edges: Vec<Edge, MAX_EDGES>,
    /// Whose clock the times are read from.
    pub zone: Zone,
}

/// Why an edge cannot be added to a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeError {
    /// There is one at this time already.
    Twice,
    /// There are [`MAX_EDGES`] already.
    Full,
}

impl Night {
    /// Adds an edge, in its place by the time of day.
    pub fn insert(&mut self, edge: Edge) -> Result<(), EdgeError> {
        match self.edges.binary_search_by_key(&edge.minute, |e| e.minute) {
            Ok(_) => Err(EdgeError::Twice),
            Err(at) => self.edges.insert(at, edge).map_err(|_| EdgeError::Full),
        }
    }

    /// Forgets all edges.
    pub fn clear(&mut self) {
        self.edges.clear();
    }

    /// The edges in the order of the day. The last of them holds over midnight until the first.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }
}

impl fmt::Display for EdgeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Twice => f.write_str("this time is in the list already"),
            Self::Full => write!(f, "at most {MAX_EDGES} times can be listed"),
        }
    }
}

impl core::error::Error for EdgeError {}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Percent(share) => write!(f, "{share}%"),
        }
    }
}

impl fmt::Display for Edge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02}:{:02} {}", self.minute / 60, self.minute % 60, self.level)
    }
}

/// A text that is no [`Edge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAnEdge;

impl fmt::Display for NotAnEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a time of day (00:00 to 23:59) and a level (0% to 100%, or off) are needed, like \"21:30 40%\"",
        )
    }
}

impl core::error::Error for NotAnEdge {}

impl FromStr for Edge {
    type Err = NotAnEdge;

    /// `HH:MM LEVEL`, the level `off` or a percentage like `40%`; 0 % is off.
    fn from_str(text: &str) -> Result<Self, NotAnEdge> {
        let (time, level) = text.trim().split_once(' ').ok_or(NotAnEdge)?;
        let (hour, minute) = time.split_once(':').ok_or(NotAnEdge)?;
        let (hour, minute) = (number(hour, 23)?, number(minute, 59)?);
        let level = match level.trim_start() {
            "off" => Level::Off,
            share => match number(share.strip_suffix('%').ok_or(NotAnEdge)?, 100)? {
                0 => Level::Off,
                share => Level::Percent(share),
            },
        };
        Ok(Self { minute: u16::from(hour) * 60 + u16::from(minute), level })
    }
}

/// A number of one to three digits, up to `most`.
fn number(digits: &str, most: u8) -> Result<u8, NotAnEdge> {
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|&number| plain && number <= most).ok_or(NotAnEdge)
}

/// Whose local time counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Zone {
    /// The system's.
    #[default]
    Local,
    /// That of a name in the time zone database, like `Asia/Tokyo`. Whether it is there shows when it is asked for.
    Named(String<64>),
}

/// A text that cannot be the name of a time zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAZone;

impl fmt::Display for NotAZone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("local or the name of a time zone is needed, like \"Asia/Tokyo\"")
    }
}

impl core::error::Error for NotAZone {}

impl FromStr for Zone {
    type Err = NotAZone;

    fn from_str(text: &str) -> Result<Self, NotAZone> {
        if text == "local" {
            return Ok(Self::Local);
        }
        // A name is a path below the database's folder: nothing in it may lead out of there.
        let part = |part: &str| {
            part.starts_with(|c: char| c.is_ascii_alphabetic())
                && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_+-".contains(&byte))
        };
        let named = text.split('/').all(part);
        String::try_from(text).ok().filter(|_| named).map(Self::Named).ok_or(NotAZone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_is_a_time_and_a_level() {
        let edge = |text: &str| text.parse::<Edge>();
        assert_eq!(edge("21:30 40%"), Ok(Edge { minute: 1290, level: Level::Percent(40) }));
        assert_eq!(edge(" 7:05   100% "), Ok(Edge { minute: 425, level: Level::Percent(100) }));
        assert_eq!(edge("00:00 off"), Ok(Edge { minute: 0, level: Level::Off }));
        assert_eq!(edge("23:59 0%"), Ok(Edge { minute: 1439, level: Level::Off }));
        for bad in [
            "",
            "21:30",
            "24:00 1%",
            "21:60 1%",
            "21:30 101%",
            "21:30 -1%",
            "+1:30 5%",
            "21 30%",
            "9:00 off%",
            ": 1%",
            "1:1 %",
            "1:1 40",
        ] {
            assert_eq!(edge(bad), Err(NotAnEdge), "{bad}");
        }
    }

    #[test]
    fn an_edge_is_read_back_as_it_is_written() {
        extern crate std;
        for text in ["00:00 off", "07:05 100%", "21:30 1%"] {
            assert_eq!(std::format!("{}", text.parse::<Edge>().unwrap()), text);
        }
    }

    #[test]
    fn edges_are_in_the_order_of_the_day_and_once_each() {
        let mut night = Night::default();
        for text in ["23:00 off", "07:00 100%", "21:30 40%"] {
            assert_eq!(night.insert(text.parse().unwrap()), Ok(()));
        }
        assert!(night.edges().is_sorted_by_key(|edge| edge.minute));
        assert_eq!(night.insert("07:00 5%".parse().unwrap()), Err(EdgeError::Twice));
        for minute in 0..13 {
            assert_eq!(night.insert(Edge { minute, level: Level::Off }), Ok(()));
        }
        assert_eq!(night.insert(Edge { minute: 13, level: Level::Off }), Err(EdgeError::Full));
    }

    #[test]
    fn a_zone_leads_nowhere_but_into_the_database() {
        assert_eq!("local".parse(), Ok(Zone::Local));
        for good in ["Asia/Tokyo", "America/Argentina/Buenos_Aires", "Etc/GMT+9", "UTC"] {
            assert_eq!(good.parse(), Ok(Zone::Named(String::try_from(good).unwrap())));
        }
        for bad in ["", "/etc/passwd", "../x", "Asia/", "Asia//Tokyo", "Asia/../../x", "a b", "Zürich"] {
            assert_eq!(bad.parse::<Zone>(), Err(NotAZone), "{bad}");
        }
    }
}
