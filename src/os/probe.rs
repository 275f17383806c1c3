//! `yurameki probe`: what this machine could show on, as a table for people.

use std::fmt::Write as _;

/// Everything that was found.
pub(super) fn report() -> String {
    let mut report = String::new();
    section(&mut report, "Displays", &displays());
    #[cfg(any(feature = "kms", feature = "linuxfb"))]
    section(&mut report, "Console", &[super::console::report()]);
    report
}

fn section(report: &mut String, title: &str, lines: &[String]) {
    let _ = writeln!(report, "{title}");
    for line in lines {
        let _ = writeln!(report, "  {line}");
    }
}

/// Every display, a line each, and under it what belongs to it.
fn displays() -> Vec<String> {
    let mut lines = Vec::new();
    #[cfg(feature = "kms")]
    lines.extend(kms());
    #[cfg(feature = "linuxfb")]
    lines.extend(fbdev());
    #[cfg(feature = "window")]
    if super::window::is_possible() {
        lines.push("a desktop session: --display window".into());
    }
    if lines.is_empty() {
        lines.push("none that this program was built for".into());
    }
    lines
}

#[cfg(feature = "kms")]
fn kms() -> Vec<String> {
    use super::kms::Card;
    let describe = |path: &std::path::PathBuf| match Card::open(path).and_then(|card| card_lines(&card)) {
        Ok(lines) => lines,
        Err(error) => vec![format!("{}: {error}", path.display())],
    };
    Card::list().iter().flat_map(describe).collect()
}

#[cfg(feature = "kms")]
fn card_lines(card: &super::kms::Card) -> std::io::Result<Vec<String>> {
    use super::kms::{buffers_for, holders, mode_name};
    use drm::{Device as _, control::connector::State};
    let driver = card.get_driver()?.name().to_string_lossy().into_owned();
    let path = card.path.display();
    let Ok(connectors) = card.connectors() else {
        return Ok(vec![format!("{path}  {driver}: only renders")]);
    };
    let free = card.acquire_master_lock().is_ok();
    let holders = holders(&card.path);
    let held = match (free, holders.is_empty()) {
        (true, _) => "free".into(),
        (false, true) => "held by another program".into(),
        (false, false) => format!("held by {}", holders.join(", ")),
    };
    let mut lines = vec![format!("{path}  {driver}: {held}")];
    for connector in connectors {
        let state = match connector.state() {
            State::Connected => "connected",
            State::Disconnected => "nothing connected",
            State::Unknown => "unknown",
        };
        let modes: Vec<_> = connector.modes().iter().map(mode_name).collect();
        lines.push(format!("  {connector}  {state}  {}", modes.join(" ")));
        if connector.state() == State::Connected && free {
            lines.push(format!("    {}", buffers_for(card, &connector)));
        }
    }
    Ok(lines)
}

#[cfg(feature = "linuxfb")]
fn fbdev() -> Vec<String> {
    let describe = |path: &std::path::PathBuf| {
        super::fbdev::describe(path).unwrap_or_else(|error| format!("{}: {error}", path.display()))
    };
    super::fbdev::list().iter().map(describe).collect()
}
