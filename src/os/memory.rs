//! How much memory a panel needs, and how much there is.

use crate::{
    effect::shimmer::{automatic_mask::scratch_len, storage_len},
    frame::Size,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Bytes that showing photos on a panel of `size` takes, beyond decoding: two photos that fade into each other, the picture and the
/// mask that one is prepared from, what finding a mask takes, and two frames.
pub(super) const fn needed(size: Size) -> u64 {
    let prepared = 2 * storage_len(size) as u64 * 8;
    let picture = size.pixels() as u64 * 4;
    let mask = scratch_len(size) as u64 * SCRATCH_BYTES;
    let frames = size.pixels() as u64 * 4 * 2;
    prepared + picture + mask + frames
}

/// Bytes of a word of the scratch memory of the automatic mask.
const SCRATCH_BYTES: u64 = 4;

/// Bytes that can still be had: what the kernel says, and no more than the limits of the service (control groups of version 2) leave.
/// `None` where the kernel does not tell.
pub(super) fn available() -> Option<u64> {
    let text = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let groups = left_of_groups(Path::new("/sys/fs/cgroup"), &text("/proc/self/cgroup"));
    Some(mem_available(&text("/proc/meminfo"))?.min(groups.unwrap_or(u64::MAX)))
}

/// MemAvailable of proc_meminfo(5).
fn mem_available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? << 10)
}

/// What the limits of a control group and of those around it leave; `own` is /proc/self/cgroup. `None` where there is no limit.
fn left_of_groups(root: &Path, own: &str) -> Option<u64> {
    let group = own.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let group: PathBuf = root.join(group);
    let number = |folder: &Path, name| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
    let left = |folder: &Path| {
        Some(number(folder, "memory.max")?.saturating_sub(number(folder, "memory.current").unwrap_or(0)))
    };
    group.ancestors().take_while(|folder| folder.starts_with(root)).filter_map(left).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_panel_needs_more() {
        let [small, large] = [Size::new(1024, 600), Size::new(1920, 1080)].map(needed);
        // 14 bytes a pixel and a little for each of two photos, 12 for a picture and two frames; the mask's grid is no finer.
        let per_pixel = (large - small) as f64 / (1920.0 * 1080.0 - 1024.0 * 600.0);
        assert!((39.0..42.0).contains(&per_pixel), "{per_pixel} bytes a pixel");
    }

    #[test]
    fn the_kernels_word_on_memory_is_read() {
        assert_eq!(mem_available("MemTotal:  9 kB\nMemAvailable:     431 kB\n"), Some(431 * 1024));
        assert_eq!(mem_available("MemTotal:  9 kB\n"), None);
    }

    #[test]
    fn the_tightest_limit_around_counts() {
        let root = tempfile::tempdir().unwrap();
        let inner = root.path().join("system.slice/yurameki.service");
        fs::create_dir_all(&inner).unwrap();
        let own = "1:name=x:/other\n0::/system.slice/yurameki.service\n";
        assert_eq!(left_of_groups(root.path(), own), None);
        fs::write(inner.join("memory.max"), "max\n").unwrap();
        assert_eq!(left_of_groups(root.path(), own), None);
        fs::write(root.path().join("system.slice/memory.max"), "900\n").unwrap();
        fs::write(root.path().join("system.slice/memory.current"), "300\n").unwrap();
        assert_eq!(left_of_groups(root.path(), own), Some(600));
        fs::write(inner.join("memory.max"), "500\n").unwrap();
        assert_eq!(left_of_groups(root.path(), own), Some(500));
        assert_eq!(left_of_groups(root.path(), "1:name=x:/other\n"), None);
    }
}
