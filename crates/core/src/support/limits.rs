//! What the system lets a process have: memory, and the size of a file. Linux says so; elsewhere nothing is known and nothing is refused.

use std::{fmt::Display, fs, path::Path};

use crate::error::{Result, require};

/// Memory that this process can still get, bytes: the least of what is free, of what its group may have and of its address space.
pub fn memory() -> Option<u64> {
    let used = figure("/proc/self/status", "VmSize");
    let address_space = limit("Max address space").zip(used).map(|(most, used)| most.saturating_sub(used));
    [figure("/proc/meminfo", "MemAvailable"), group(), address_space].into_iter().flatten().min()
}

/// Refuses the value of a field if its work needs more memory (bytes) than is left; `most` says of what is left which value fits.
///
/// # Errors
///
/// Names the field, its value, and both figures.
pub fn fits_memory(name: &str, value: impl Display, needed: f64, most: impl Fn(f64) -> f64) -> Result<()> {
    let Some(left) = memory().map(|bytes| bytes as f64) else { return Ok(()) };
    let [needs, free] = [needed, left].map(|bytes| bytes / f64::from(1 << 30));
    let accepted =
        format!("needs {needs:.1} GiB of memory, and {free:.1} are left; expected at most {:.0} here", most(left).floor());
    require(needed <= left, name, value, accepted)
}

/// The largest file that this process may write, bytes (`ulimit -f`).
pub fn file_size() -> Option<u64> {
    limit("Max file size")
}

/// A soft limit of the process; none where it is unlimited.
fn limit(name: &str) -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    limits.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// A figure of a file of lines `Name:   1234 kB`, bytes.
fn figure(file: &str, name: &str) -> Option<u64> {
    let text = fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    value.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// What the control groups leave (version 2), the process's own and those around it: a container's limit.
fn group() -> Option<u64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let root = Path::new("/sys/fs/cgroup");
    let number = |path: &Path| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let left = |group: &Path| {
        let most = number(&group.join("memory.max"))?;
        Some(most.saturating_sub(number(&group.join("memory.current")).unwrap_or(0)))
    };
    root.join(own).ancestors().take_while(|group| group.starts_with(root)).filter_map(left).min()
}
