//! Saved states with a checksum: a state with a bit that has flipped is refused, not gone on from.

use crate::SimError;

/// What a state begins with.
const MAGIC: [u8; 8] = *b"trundle\x02";
/// Bytes of the checksum that follows.
const SUM: usize = 8;
/// States without a checksum, as older versions saved them, begin with a random seed. Among 64 random bits so few
/// differ from `MAGIC` by chance once in 10⁹ times; where they do, a bit of `MAGIC` has flipped.
const MAX_FLIPPED_BITS: u32 = 10;

/// The state with its checksum.
pub(super) fn seal(state: &[u8]) -> Vec<u8> {
    [&MAGIC, &checksum(state).to_le_bytes(), state].concat()
}

/// The state itself; one of an older version as it is.
///
/// # Errors
/// When it is damaged.
pub(super) fn open(sealed: &[u8]) -> Result<&[u8], SimError> {
    let damaged = || SimError::State("it is damaged: take another snapshot".to_owned());
    let (magic, rest) = sealed.split_first_chunk::<{ MAGIC.len() }>().ok_or_else(damaged)?;
    let flipped = (u64::from_le_bytes(*magic) ^ u64::from_le_bytes(MAGIC)).count_ones();
    if flipped > MAX_FLIPPED_BITS {
        return Ok(sealed);
    }
    match rest.split_first_chunk::<SUM>() {
        Some((sum, state)) if flipped == 0 && u64::from_le_bytes(*sum) == checksum(state) => Ok(state),
        _ => Err(damaged()),
    }
}

/// FNV-1a, 64 bits. Each step is one-to-one in the sum so far, so that one changed byte always changes it.
fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xCBF2_9CE4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_flipped_bit_is_found_and_an_older_state_is_not_mistaken() {
        let state: Vec<u8> = (0..200).map(|k| (k * 7) as u8).collect();
        let sealed = seal(&state);
        assert_eq!(open(&sealed).unwrap(), state);
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(open(&flipped).is_err(), "bit {bit}");
        }
        assert!((0..sealed.len()).all(|length| open(&sealed[..length]).is_err()));
        assert_eq!(open(&state).unwrap(), state);
    }
}
