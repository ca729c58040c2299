//! How much memory there is for environments.

use std::fs;

/// Where nothing is known, bytes.
const ASSUMED: u64 = 4 << 30;

/// Memory that this process may yet take, bytes: what the system says is free, or less where a container has a limit.
pub(super) fn available() -> u64 {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let left = |limit, used| Some(number(limit)?.saturating_sub(number(used)?));
    let free = fs::read_to_string("/proc/meminfo").ok().and_then(|text| free(&text));
    let group = left("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current");
    let older =
        left("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes");
    [free, group, older].into_iter().flatten().min().unwrap_or(ASSUMED)
}

/// The line `MemAvailable:  12345 kB` of `/proc/meminfo`, bytes.
fn free(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_in_bytes() {
        assert_eq!(free("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(free("MemTotal: 9 kB\n"), None);
        assert!(available() > 0);
    }
}
