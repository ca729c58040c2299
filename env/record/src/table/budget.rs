//! How much memory tables may take.

use crate::fault::Fault;

/// A recording may take this much whatever its size, bytes: ten minutes at 1 kHz with ten columns take 48 MB, and a
/// file that repeats one value takes next to nothing.
const BASE: u64 = 64 << 20;
/// And this many times the size of its tables. A stored number has 8 bytes, in memory and on disk. Measured values
/// compress at most by 2, and columns of which nine cells in ten are empty by 20.
const PER_BYTE: u64 = 64;

/// What is left of the memory that a recording may take.
#[derive(Debug)]
pub(crate) struct Budget {
    limit: u64,
    left: u64,
}

impl Budget {
    /// The memory that tables of `size` bytes together may take.
    pub fn of(size: u64) -> Self {
        let limit = BASE.saturating_add(size.saturating_mul(PER_BYTE));
        Self { limit, left: limit }
    }

    /// Takes `count` times `bytes` of it.
    ///
    /// # Errors
    /// When so much is not left.
    pub fn take(&mut self, count: u64, bytes: usize) -> Result<(), Fault> {
        self.check(count, bytes)?;
        self.left -= count.saturating_mul(bytes as u64);
        Ok(())
    }

    /// Checks that `count` times `bytes` are left, and takes nothing.
    ///
    /// # Errors
    /// When so much is not left.
    pub fn check(&self, count: u64, bytes: usize) -> Result<(), Fault> {
        match count.saturating_mul(bytes as u64) <= self.left {
            true => Ok(()),
            false => Err(Fault::TooLarge { limit: self.limit >> 20, base: BASE >> 20, factor: PER_BYTE }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_gone() {
        let mut budget = Budget::of(1 << 20);
        assert!(budget.take(16, 8 << 20).is_ok());
        let message = budget.take(1, 1).unwrap_err().to_string();
        assert!(message.contains("128 MiB"), "{message}");
        assert!(budget.check(u64::MAX, usize::MAX).is_err());
    }
}
