//! `yurameki probe`: what this machine could show on and be told by, as a table for people.

use super::{
    args,
    backlight::{self, Backlight},
    config::Config,
    memory,
};
use crate::frame::Size;
use clap::Parser;
use std::{collections::BTreeSet, fmt::Write as _, io, path::Path};

/// Everything that was found.
pub(super) fn report() -> String {
    let mut report = String::new();
    let (config, fault) = config();
    let displays = displays();
    section(&mut report, "Displays", "none that this program was built for", &displays.lines);
    section(&mut report, "Memory", "", &memory(&displays.sizes, config.memory_ceiling_bytes));
    #[cfg(any(feature = "kms", feature = "linuxfb"))]
    section(&mut report, "Console", "", &[super::console::report()]);
    #[cfg(target_os = "linux")]
    section(&mut report, "Buttons", "none", &buttons(&config));
    section(&mut report, "Backlights", "none", &backlights(Path::new(backlight::CLASS)));
    if let Some(fault) = fault {
        section(&mut report, "Configuration", "", &[format!("{fault}; this tells of the defaults")]);
    }
    report
}

fn section(report: &mut String, title: &str, nothing: &str, lines: &[String]) {
    let _ = writeln!(report, "{title}");
    if lines.is_empty() {
        let _ = writeln!(report, "  {nothing}");
    }
    for line in lines {
        let _ = writeln!(report, "  {line}");
    }
}

/// The configuration of this machine, or the default and what is wrong with the machine's.
fn config() -> (Config, Option<String>) {
    let args = args::Args::parse_from(["yurameki", "run"]);
    let Some(args::Command::Run(args)) = args.command else { unreachable!("`run` was asked for") };
    match Config::resolve(&args) {
        Ok(config) => (config, None),
        Err(error) => (Config::default(), Some(error.first())),
    }
}

/// The displays.
#[derive(Default)]
struct Displays {
    /// A line each, and under it what belongs to it.
    lines: Vec<String>,
    /// Those of all modes of what is connected.
    sizes: BTreeSet<(u32, u32)>,
}

fn displays() -> Displays {
    #[cfg_attr(
        not(any(feature = "kms", feature = "linuxfb", feature = "window")),
        expect(unused_mut, reason = "none")
    )]
    let mut displays = Displays::default();
    #[cfg(feature = "kms")]
    displays.add_kms();
    #[cfg(feature = "linuxfb")]
    displays.add_fbdev();
    #[cfg(feature = "window")]
    if super::window::is_possible() {
        displays.lines.push("a desktop session: --display window".into());
    }
    displays
}

impl Displays {
    #[cfg(feature = "kms")]
    fn add_kms(&mut self) {
        use super::kms::Card;
        for path in Card::list() {
            if let Err(error) = Card::open(&path).and_then(|card| self.add_card(&card)) {
                self.lines.push(refused(&path, &error, "video"));
            }
        }
    }

    #[cfg(feature = "kms")]
    fn add_card(&mut self, card: &super::kms::Card) -> io::Result<()> {
        use super::kms::{buffers_for, holders, mode_name};
        use drm::{Device as _, control::connector::State};
        let driver = card.get_driver()?.name().to_string_lossy().into_owned();
        let path = card.path.display();
        let Ok(connectors) = card.connectors() else {
            self.lines.push(format!("{path}  {driver}: only renders"));
            return Ok(());
        };
        let free = card.acquire_master_lock().is_ok();
        let holders = holders(&card.path);
        let held = match (free, holders.is_empty()) {
            (true, _) => "free".into(),
            (false, true) => "held by another program".into(),
            (false, false) => format!("held by {}", holders.join(", ")),
        };
        self.lines.push(format!("{path}  {driver}: {held}"));
        for connector in connectors {
            let state = match connector.state() {
                State::Connected => "connected",
                State::Disconnected => "nothing connected",
                State::Unknown => "unknown",
            };
            let modes: Vec<_> = connector.modes().iter().map(mode_name).collect();
            self.lines.push(format!("  {connector}  {state}  {}", modes.join(" ")));
            if connector.state() == State::Connected {
                self.sizes.extend(
                    connector.modes().iter().map(|mode| mode.size()).map(|(w, h)| (w.into(), h.into())),
                );
                if free {
                    self.lines.push(format!("    {}, shown by page flips", buffers_for(card, &connector)));
                }
            }
        }
        Ok(())
    }

    #[cfg(feature = "linuxfb")]
    fn add_fbdev(&mut self) {
        for path in super::fbdev::list() {
            match super::fbdev::describe(&path) {
                Ok((line, size)) => {
                    self.lines.push(line);
                    self.sizes.insert((size.width, size.height));
                }
                Err(error) => self.lines.push(refused(&path, &error, "video")),
            }
        }
    }
}

/// Why a device tells nothing, and the cure where this user may not ask it.
fn refused(path: &Path, error: &io::Error, group: &str) -> String {
    let path = path.display();
    match error.kind() {
        io::ErrorKind::PermissionDenied => {
            format!(
                "{path}: there, but this user may not open it: add the user to the group {group} (usermod -aG {group} USER)"
            )
        }
        _ => format!("{path}: {error}"),
    }
}

/// For each size of a panel, what it needs of memory and whether that is there.
fn memory(sizes: &BTreeSet<(u32, u32)>, ceiling: u64) -> Vec<String> {
    const MEBIBYTE: u64 = 1 << 20;
    let available = memory::available();
    let there = available.map_or("unknown".into(), |bytes| format!("{} MiB", bytes / MEBIBYTE));
    let mut lines = vec![format!(
        "available: {there}; reading and decoding one photo takes up to {} MiB more (memory.ceiling)",
        ceiling / MEBIBYTE
    )];
    let simulated = BTreeSet::from([(1024, 600)]);
    for &(width, height) in if sizes.is_empty() { &simulated } else { sizes } {
        let size = Size::new(width, height);
        let needed = memory::needed(size);
        let verdict = match available.map(|available| available.checked_sub(needed)) {
            None => String::new(),
            Some(None) => ": more than there is".into(),
            Some(Some(left)) if left < ceiling => {
                format!(": leaves {} MiB, which memory.ceiling should not exceed", left / MEBIBYTE)
            }
            Some(Some(_)) => ": fits".into(),
        };
        lines.push(format!("{size}: {} MiB{verdict}", needed.div_ceil(MEBIBYTE)));
    }
    lines
}

/// Every input device, with the keys on it that are buttons.
#[cfg(target_os = "linux")]
fn buttons(config: &Config) -> Vec<String> {
    use super::evdev::{Listed, list};
    let line = |listed: Listed| match &listed.device {
        Err(error) => refused(&listed.path, error, "input"),
        Ok(_) => listed.to_string(),
    };
    list(&config.keys).into_iter().map(line).collect()
}

fn backlights(class: &Path) -> Vec<String> {
    let line = |light: &Backlight| {
        let cure = if light.is_writable() {
            ""
        } else {
            ": install board/udev, and add the user to the group video"
        };
        format!("{light}{cure}")
    };
    Backlight::list(class).iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_may_not_be_opened_is_told_with_its_group() {
        let line = refused(Path::new("/dev/input/event0"), &io::ErrorKind::PermissionDenied.into(), "input");
        assert!(
            line.starts_with("/dev/input/event0: there, but") && line.contains("usermod -aG input"),
            "{line}"
        );
        let line = refused(Path::new("/dev/fb0"), &io::ErrorKind::NotFound.into(), "video");
        assert!(line.starts_with("/dev/fb0: ") && !line.contains("usermod"), "{line}");
    }

    #[test]
    fn a_panel_that_needs_more_memory_than_there_is_is_told() {
        let sizes = BTreeSet::from([(320, 240), (16_384, 16_384)]);
        let lines = memory(&sizes, 16 << 20);
        assert_eq!(lines.len(), 3);
        let mebibytes = |width, height| memory::needed(Size::new(width, height)).div_ceil(1 << 20);
        assert!(lines[1].starts_with(&format!("320×240: {} MiB", mebibytes(320, 240))), "{lines:?}");
        assert!(
            lines[2].starts_with(&format!("16384×16384: {} MiB", mebibytes(16_384, 16_384))),
            "{lines:?}"
        );
        let lines = memory(&sizes, u64::MAX);
        assert!(lines[1].contains("which memory.ceiling should not exceed"), "{lines:?}");
    }

    #[test]
    fn backlights_are_told_with_what_is_in_the_way() {
        let class = tempfile::tempdir().unwrap();
        let folder = class.path().join("10-0045");
        std::fs::create_dir(&folder).unwrap();
        for (name, text) in [("max_brightness", "31"), ("brightness", "20")] {
            std::fs::write(folder.join(name), text).unwrap();
        }
        assert_eq!(backlights(class.path()), ["10-0045 (raw, 20 of 31)"]);
    }
}
