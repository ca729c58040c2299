//! Checksums of saved states, which detect flipped bits.

use crate::SimError;

/// First bytes of a saved state.
const MAGIC: [u8; 8] = *b"trundle\x03";
/// Length of the checksum after [`MAGIC`], bytes.
const CHECKSUM_BYTES: usize = 8;
/// Largest number of bits by which the first bytes may differ from [`MAGIC`] and still count as a damaged `MAGIC`. States
/// of older versions have no checksum and start with a random seed, which is this close with probability 10⁻⁹.
const MAX_FLIPPED_BITS: u32 = 10;

/// Prepend magic bytes and checksum to a state.
pub(super) fn append(state: &[u8]) -> Vec<u8> {
    [&MAGIC, &checksum(state).to_le_bytes(), state].concat()
}

/// Verify the checksum and return the state. States of older versions are returned unchanged.
///
/// # Errors
/// If the state is damaged.
pub(super) fn verify(sealed: &[u8]) -> Result<&[u8], SimError> {
    let damaged = || SimError::State("it is damaged or of another version: take another snapshot".to_owned());
    let (magic, rest) = sealed.split_first_chunk::<{ MAGIC.len() }>().ok_or_else(damaged)?;
    let flipped = (u64::from_le_bytes(*magic) ^ u64::from_le_bytes(MAGIC)).count_ones();
    if flipped > MAX_FLIPPED_BITS {
        return Ok(sealed);
    }
    match rest.split_first_chunk::<CHECKSUM_BYTES>() {
        Some((sum, state)) if flipped == 0 && u64::from_le_bytes(*sum) == checksum(state) => Ok(state),
        _ => Err(damaged()),
    }
}

/// FNV-1a hash, 64 bits. Each step is a bijection of the hash so far, so a single changed byte always changes the result.
fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xCBF2_9CE4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detects_any_flipped_bit_and_accepts_older_states() {
        let state: Vec<u8> = (0..200).map(|k| (k * 7) as u8).collect();
        let sealed = append(&state);
        assert_eq!(verify(&sealed).unwrap(), state);
        for bit in 0..8 * sealed.len() {
            let mut flipped = sealed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(verify(&flipped).is_err(), "bit {bit}");
        }
        assert!((0..sealed.len()).all(|length| verify(&sealed[..length]).is_err()));
        assert_eq!(verify(&state).unwrap(), state);
    }
}
