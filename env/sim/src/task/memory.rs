//! Available memory for environments.

use std::fs;

/// Assumed available memory if the system reports none, bytes.
const DEFAULT_AVAILABLE_BYTES: u64 = 4 << 30;

/// Memory available to this process, bytes: the smaller of the system's free memory and the container's limit.
pub(super) fn available_bytes() -> u64 {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let left = |limit, used| Some(number(limit)?.saturating_sub(number(used)?));
    let free = fs::read_to_string("/proc/meminfo").ok().and_then(|text| mem_available_bytes(&text));
    let group = left("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current");
    let older =
        left("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes");
    [free, group, older].into_iter().flatten().min().unwrap_or(DEFAULT_AVAILABLE_BYTES)
}

/// Value of the line `MemAvailable:  12345 kB` of `/proc/meminfo`, bytes.
fn mem_available_bytes(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_in_bytes() {
        assert_eq!(mem_available_bytes("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(mem_available_bytes("MemTotal: 9 kB\n"), None);
        assert!(available_bytes() > 0);
    }
}
