//! What the system lets a process have: memory, and the size of a file. Linux says so; elsewhere nothing is known and nothing is refused.

use std::{fs, path::Path};

/// Memory that this process can still get, bytes: the least of what is free, of what its group may have and of its address space.
pub fn memory() -> Option<u64> {
    let used = figure("/proc/self/status", "VmSize");
    let address_space = limit("Max address space").zip(used).map(|(most, used)| most.saturating_sub(used));
    [figure("/proc/meminfo", "MemAvailable"), group(), address_space].into_iter().flatten().min()
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
