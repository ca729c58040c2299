//! Platt scaling of probabilities (Platt 1999): from the posterior odds of the fitted models to the
//! probability that a name is right.
//!
//! The odds only compare laws of the catalogue, which may not contain the true one. `trundle prove --config
//! configs/experiments/wide.toml --range tune` prints the constants that fit its answers. These constants are
//! from its range `smoke`.

/// Offset and slope of the logit. Too few wrong names were available to fit them.
const OFFSET: f64 = 0.0;
const SLOPE: f64 = 1.0;
/// Bound on the logit, so that no probability exceeds 0.970: the rule of succession for names that were all
/// right.
const MAX_LOGIT: f64 = 3.48;

/// Offset, slope and bound, for the command that fits them.
#[must_use]
pub fn platt() -> [f64; 3] {
    [OFFSET, SLOPE, MAX_LOGIT]
}

/// Calibrated probability of a name.
#[must_use]
pub fn calibrated(odds: f64) -> f64 {
    let logit = (odds / (1.0 - odds).max(f64::MIN_POSITIVE)).ln().clamp(-MAX_LOGIT, MAX_LOGIT);
    1.0 / (1.0 + (-(OFFSET + SLOPE * logit)).exp())
}

#[cfg(test)]
mod tests {
    use super::calibrated;

    #[test]
    fn odds_keep_their_order_and_none_are_certain() {
        let found = [0.0, 0.1, 0.5, 0.9, 0.95, 1.0].map(calibrated);
        assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "{found:?}");
        assert!(found[0] > 0.0 && found[5] < 1.0);
    }
}
