use std::{fmt, str::FromStr};

/// Frames a second, as an exact fraction between 0.01 and 1000.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    frames: u16,
    seconds: u16,
}

impl FrameRate {
    /// `frames` in `seconds`; `None` where that is less than 0.01 or more than 1000 a second, or where the reduced fraction
    /// does not fit the 16 bits that APNG has for either number.
    pub const fn new(frames: u32, seconds: u32) -> Option<Self> {
        if frames == 0
            || seconds == 0
            || frames as u64 > 1000 * seconds as u64
            || seconds as u64 > 100 * frames as u64
        {
            return None;
        }
        let divisor = gcd(frames, seconds);
        let (frames, seconds) = (frames / divisor, seconds / divisor);
        if frames > u16::MAX as u32 || seconds > u16::MAX as u32 {
            return None;
        }
        Some(Self { frames: frames as u16, seconds: seconds as u16 })
    }

    /// The frames of the reduced fraction.
    pub const fn frames(self) -> u16 {
        self.frames
    }

    /// The seconds of the reduced fraction, in which [`Self::frames`] are shown.
    pub const fn seconds(self) -> u16 {
        self.seconds
    }

    /// How long each frame is shown, in units of which `units_a_second` make a second.
    ///
    /// Frame i ends at the unit nearest to its exact end, so that no error adds up.
    pub(super) fn delays(self, units_a_second: u32) -> impl Iterator<Item = u32> {
        let (frames, seconds) = (u64::from(self.frames), u64::from(self.seconds));
        let end = move |i: u64| (i * seconds * u64::from(units_a_second) + frames / 2) / frames;
        (0..=u64::from(u32::MAX)).map(move |i| (end(i + 1) - end(i)) as u32)
    }
}

const fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.seconds {
            1 => self.frames.fmt(f),
            seconds => write!(f, "{}/{seconds}", self.frames),
        }
    }
}

/// A word that is no [`FrameRate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParseFrameRateError;

impl fmt::Display for ParseFrameRateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("frames a second are a number from 0.01 to 1000, such as 30, 12.5 or 30000/1001")
    }
}

impl std::error::Error for ParseFrameRateError {}

impl FromStr for FrameRate {
    type Err = ParseFrameRateError;

    fn from_str(word: &str) -> Result<Self, ParseFrameRateError> {
        let number = |digits: &str| {
            let plain = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
            plain.then(|| digits.parse::<u32>().ok()).flatten()
        };
        let fraction = if let Some((frames, seconds)) = word.split_once('/') {
            number(frames).zip(number(seconds))
        } else if let Some((whole, decimals)) = word.split_once('.') {
            let seconds = 10_u32.checked_pow(decimals.len() as u32);
            number(&format!("{whole}{decimals}")).zip(seconds)
        } else {
            number(word).map(|frames| (frames, 1))
        };
        fraction.and_then(|(frames, seconds)| Self::new(frames, seconds)).ok_or(ParseFrameRateError)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_read_exactly() {
        let words =
            [("30", 30, 1), ("12.5", 25, 2), ("29.97", 2997, 100), ("60000/1001", 60000, 1001), (".5", 1, 2)];
        for (word, frames, seconds) in words {
            let rate: FrameRate = word.parse().expect(word);
            assert_eq!((rate.frames(), rate.seconds()), (frames, seconds), "{word}");
        }
    }

    #[test]
    fn words_that_are_no_rate_are_refused() {
        let words = [
            "",
            "0",
            "-3",
            "+3",
            "1001",
            "0.009",
            "1/0",
            "0/1",
            ".",
            "3/",
            "nan",
            "99999999999",
            "1.99999999999",
        ];
        for word in words {
            assert_eq!(word.parse::<FrameRate>(), Err(ParseFrameRateError), "{word}");
        }
    }

    #[test]
    fn delays_add_up_to_the_exact_time() {
        for (frames, seconds) in [(24, 1), (30, 1), (60, 1), (30_000, 1001), (1000, 1), (1, 100), (7, 3)] {
            let rate = FrameRate::new(frames, seconds).unwrap();
            let mut sum = 0_u64;
            for (i, delay) in rate.delays(100).take(10_000).enumerate() {
                sum += u64::from(delay);
                let exact = (i + 1) as f64 * f64::from(seconds) / f64::from(frames) * 100.0;
                assert!(
                    (sum as f64 - exact).abs() <= 0.5 + 1e-9,
                    "{rate}: frame {i} ends at {sum}, not {exact}"
                );
            }
        }
    }
}
