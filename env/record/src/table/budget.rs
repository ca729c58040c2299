//! Memory limit for reading tables.

use crate::fault::Fault;

/// Memory that every recording may use, bytes. Ten minutes at 1 kHz with ten columns need 48 MB, while a compressed file
/// that repeats one value can be arbitrarily small.
const BASE_BYTES: u64 = 64 << 20;
/// Additional memory per byte of the tables on disk. A number has 8 bytes in memory and uncompressed on disk. Measured
/// values compress by at most 2; columns with 90 % empty cells compress by 20.
const MEMORY_PER_TABLE_BYTE: u64 = 64;

/// Remaining memory for the tables of a recording.
#[derive(Debug)]
pub(crate) struct Budget {
    limit: u64,
    remaining: u64,
}

impl Budget {
    /// The budget for tables with a total size of `size` bytes.
    pub fn of(size: u64) -> Self {
        let limit = BASE_BYTES.saturating_add(size.saturating_mul(MEMORY_PER_TABLE_BYTE));
        Self { limit, remaining: limit }
    }

    /// Reserves `count` times `bytes`.
    ///
    /// # Errors
    /// If the remaining memory does not suffice.
    pub fn reserve(&mut self, count: u64, bytes: usize) -> Result<(), Fault> {
        self.check(count, bytes)?;
        self.remaining -= count.saturating_mul(bytes as u64);
        Ok(())
    }

    /// Checks that `count` times `bytes` are available, without reserving them.
    ///
    /// # Errors
    /// If the remaining memory does not suffice.
    pub fn check(&self, count: u64, bytes: usize) -> Result<(), Fault> {
        match count.saturating_mul(bytes as u64) <= self.remaining {
            true => Ok(()),
            false => Err(Fault::TooLarge {
                limit: self.limit >> 20,
                base: BASE_BYTES >> 20,
                factor: MEMORY_PER_TABLE_BYTE,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reserved_memory_is_not_available_again() {
        let mut budget = Budget::of(1 << 20);
        assert!(budget.reserve(16, 8 << 20).is_ok());
        let message = budget.reserve(1, 1).unwrap_err().to_string();
        assert!(message.contains("128 MiB"), "{message}");
        assert!(budget.check(u64::MAX, usize::MAX).is_err());
    }
}
