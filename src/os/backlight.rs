//! The light behind the panel: `/sys/class/backlight` (Linux, Documentation/ABI/stable/sysfs-class-backlight).
//!
//! Writing needs the right to: the shipped udev rule gives it to the group `video`.

use crate::{app::night::light, config::night::Level};
use std::{
    fmt, fs, io,
    path::{Path, PathBuf},
};

/// Where the kernel lists backlights.
pub const CLASS: &str = "/sys/class/backlight";

/// `bl_power` of a light that is on, and of one that is off: FB_BLANK_UNBLANK and FB_BLANK_POWERDOWN.
const POWER_ON: u32 = 0;
const POWER_DOWN: u32 = 4;

/// Who drives the light, the best first: where the same light is listed twice, firmware knows more of it than the chip's driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Driver {
    /// A standard interface of the firmware.
    Firmware,
    /// An interface of this kind of board.
    Platform,
    /// The registers of the chip.
    Raw,
}

impl fmt::Display for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Firmware => "firmware",
            Self::Platform => "platform",
            Self::Raw => "raw",
        })
    }
}

/// A backlight. When it is dropped, it is as it was found.
#[derive(Debug)]
pub struct Backlight {
    folder: PathBuf,
    driver: Driver,
    max: u32,
    /// The driver's steps look even: they are no shares of light.
    even: bool,
    brightness: Option<Value>,
    power: Option<Value>,
}

/// A file with a number.
#[derive(Debug)]
struct Value {
    path: PathBuf,
    found: u32,
    last: u32,
}

impl Value {
    fn open(path: PathBuf) -> io::Result<Self> {
        let found = number(&path)?;
        Ok(Self { path, found, last: found })
    }

    fn set(&mut self, value: u32) -> io::Result<()> {
        if value != self.last {
            fs::write(&self.path, value.to_string())?;
            self.last = value;
        }
        Ok(())
    }
}

impl Backlight {
    /// The best backlight of this board that can be written to.
    pub fn find() -> Option<Self> {
        Self::list(Path::new(CLASS)).into_iter().find(Self::is_writable)
    }

    /// All backlights under `class` ([`CLASS`]), the best first.
    pub fn list(class: &Path) -> Vec<Self> {
        let entries = fs::read_dir(class).into_iter().flatten().flatten();
        let mut all: Vec<Self> = entries.filter_map(|entry| Self::open(entry.path()).ok()).collect();
        all.sort_by(|a, b| a.driver.cmp(&b.driver).then_with(|| a.folder.cmp(&b.folder)));
        all
    }

    /// The backlight in `folder`, one of those in [`CLASS`].
    ///
    /// # Errors
    /// If there is none.
    pub fn open(folder: PathBuf) -> io::Result<Self> {
        let word = |name| fs::read_to_string(folder.join(name)).unwrap_or_default();
        let driver = match word("type").trim() {
            "firmware" => Driver::Firmware,
            "platform" => Driver::Platform,
            _ => Driver::Raw,
        };
        let max = number(&folder.join("max_brightness"))?;
        if max == 0 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(Self {
            driver,
            max,
            even: word("scale").trim() == "non-linear",
            brightness: Value::open(folder.join("brightness")).ok(),
            power: Value::open(folder.join("bl_power")).ok(),
            folder,
        })
    }

    /// The name that the kernel gives it.
    pub fn name(&self) -> String {
        self.folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Whether this user may change it.
    pub fn is_writable(&self) -> bool {
        let may_write = |value: &Value| rustix::fs::access(&value.path, rustix::fs::Access::WRITE_OK).is_ok();
        self.brightness.as_ref().is_some_and(may_write)
    }

    /// Whether it has steps between off and full. One that has none (a GPIO pin) can only switch: levels are then left to
    /// dimming in software.
    pub const fn has_levels(&self) -> bool {
        self.max > 1
    }

    /// Sets the light. A level that is not [`Level::Off`] is never dark.
    ///
    /// # Errors
    /// If the kernel does not take it; one line that names the file.
    pub fn set(&mut self, level: Level) -> io::Result<()> {
        let max = u64::from(self.max);
        let brightness = match level {
            Level::Off => 0,
            Level::Percent(percent) if self.even => (max * u64::from(percent.min(100)) + 50) / 100,
            Level::Percent(_) => (max * u64::from(light(level)) + 32_768) >> 16,
        };
        let brightness = (brightness as u32).max(u32::from(level != Level::Off));
        let power = if level == Level::Off { POWER_DOWN } else { POWER_ON };
        for (value, target) in [(&mut self.brightness, brightness), (&mut self.power, power)] {
            if let Some(value) = value {
                value.set(target).map_err(|error| {
                    let path = value.path.display();
                    io::Error::new(error.kind(), format!("{path}: {error}: let the group video write to it"))
                })?;
            }
        }
        Ok(())
    }
}

impl Drop for Backlight {
    fn drop(&mut self) {
        for value in [&mut self.brightness, &mut self.power].into_iter().flatten() {
            // There is nobody left to tell.
            let _ = value.set(value.found);
        }
    }
}

/// As `probe` tells it.
impl fmt::Display for Backlight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}", self.name(), self.driver)?;
        if let Some(brightness) = &self.brightness {
            write!(f, ", {} of {}", brightness.last, self.max)?;
        }
        if self.power.is_some() {
            f.write_str(", can be switched off")?;
        }
        f.write_str(if self.is_writable() { ")" } else { ", may not be changed by this user)" })
    }
}

fn number(path: &Path) -> io::Result<u32> {
    fs::read_to_string(path)?.trim().parse().map_err(|_| io::ErrorKind::InvalidData.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(class: &Path, name: &str, files: &[(&str, &str)]) -> PathBuf {
        let folder = class.join(name);
        fs::create_dir(&folder).unwrap();
        for (file, text) in files {
            fs::write(folder.join(file), text).unwrap();
        }
        folder
    }

    fn found(class: &Path, name: &str) -> Backlight {
        Backlight::list(class).into_iter().find(|light| light.name() == name).unwrap()
    }

    #[test]
    fn the_light_is_even_to_the_eye_and_put_back_at_the_end() {
        let class = tempfile::tempdir().unwrap();
        let files =
            [("max_brightness", "255\n"), ("brightness", "200\n"), ("bl_power", "0\n"), ("type", "raw\n")];
        let folder = device(class.path(), "10-0045", &files);
        let now = |file| number(&folder.join(file)).unwrap();
        let mut light = found(class.path(), "10-0045");
        assert_eq!(light.to_string(), "10-0045 (raw, 200 of 255, can be switched off)");
        for (level, brightness, power) in [
            (crate::app::night::FULL, 255, 0),
            (Level::Percent(50), 47, 0),
            (Level::Percent(1), 1, 0),
            (Level::Off, 0, 4),
        ] {
            light.set(level).unwrap();
            assert_eq!((now("brightness"), now("bl_power")), (brightness, power), "{level}");
        }
        drop(light);
        assert_eq!((now("brightness"), now("bl_power")), (200, 0));
    }

    #[test]
    fn a_driver_with_even_steps_gets_no_second_curve() {
        let class = tempfile::tempdir().unwrap();
        let files = [("max_brightness", "10"), ("brightness", "10"), ("scale", "non-linear\n")];
        let folder = device(class.path(), "a", &files);
        found(class.path(), "a").set(Level::Percent(50)).unwrap();
        assert_eq!(number(&folder.join("brightness")).unwrap(), 10, "put back");
        let mut light = found(class.path(), "a");
        light.set(Level::Percent(50)).unwrap();
        assert_eq!(number(&folder.join("brightness")).unwrap(), 5);
    }

    #[test]
    fn firmware_comes_before_the_chip_and_broken_entries_are_passed_over() {
        let class = tempfile::tempdir().unwrap();
        device(class.path(), "a", &[("max_brightness", "1"), ("brightness", "1"), ("type", "raw")]);
        device(class.path(), "b", &[("max_brightness", "9"), ("brightness", "1"), ("type", "firmware")]);
        device(class.path(), "c", &[("max_brightness", "0"), ("brightness", "0")]);
        device(class.path(), "d", &[("brightness", "3")]);
        let names: Vec<_> = Backlight::list(class.path()).iter().map(Backlight::name).collect();
        assert_eq!(names, ["b", "a"]);
        assert!(!found(class.path(), "a").has_levels());
        assert!(Backlight::list(Path::new("no such folder")).is_empty());
    }
}
