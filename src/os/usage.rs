//! What the program has used of the machine.

use rustix::time::{ClockId, clock_gettime};
use std::{fs, time::Duration};

/// The time that all processors together have worked for this program.
pub(super) fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.max(0) as u64, time.tv_nsec.max(0) as u32)
}

/// The most memory that was resident at a time, in KiB: VmHWM of proc(5). `None` where the kernel does not tell.
pub(super) fn peak_memory_kib() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse().ok()
}
