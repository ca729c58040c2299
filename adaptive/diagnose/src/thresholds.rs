//! The numbers that the verdict of a diagnosis and its names hang on. What places, windows, rivals, warnings, designs and an
//! unnamed force are decided by, the prior of the search, what only saves time, and numerical tolerances stay with the code
//! that uses them; `benches/thresholds.py` counts both.

/// Gain in log likelihood below which something is chance, nats: twice the gain is distributed like χ² with one degree of
/// freedom, halved at zero, so 10 nats are a false alarm in 10⁵ on exact data. The rest is a margin for integrators that
/// differ from ours. It is also what given values may cost beyond half a nat a parameter, and what one block may count.
pub(crate) const MIN_SIGNIFICANT_GAIN_NATS: f64 = 10.0;

/// Mean square below which something does not matter, as a share of that of what it is compared with: a tenth of its size.
/// A remainder is compared with the noise, where it gains half of this share per sample, nats; errors with the motion; and
/// what named effects leave with what was missing: a right law leaves thousandths, and what leaves more than a hundredth
/// is a law that is like the missing one.
pub(crate) const NEGLIGIBLE_SHARE: f64 = 0.01;

/// Difference of log likelihood below which two explanations are the same, nats: two standard deviations of one parameter.
pub(crate) const MAX_TIE_DIFFERENCE_NATS: f64 = 2.0;

/// Chance that an effect must have, block by block, to be named, and that a push is asked to give.
pub(crate) const MIN_EFFECT_PROBABILITY: f64 = 0.95;

/// Factor by which the squared errors of left-out training episodes must rise without an effect for the effect to be
/// material: an eighth of the error. Chosen on the tuning range of the wide benchmark.
pub(crate) const MIN_MATERIAL_ERROR_RATIO: f64 = 1.25;

/// Errors this many times larger than a model claims refute it. In a right model the mean square over a recording's
/// some dozens of windows is within a third of what it claims; the rest is a margin for laws that
/// are right in name and a little wrong in shape, whose intervals would then be too narrow by this factor.
pub(crate) const MAX_ERROR_RATIO: f64 = 3.0;

/// A refuted model that leaves more than this share of the motion within a second, as a mean square, is no
/// explanation: it is wrong about a third of the way.
pub(crate) const MAX_ERROR_SHARE: f64 = 0.1;

/// Errors below this many times the instruments' variance, or below a tenth of the motion unless they refute the model, are
/// immaterial: no correction of the model would improve its predictions
/// to speak of. Chosen on the tuning range of the wide benchmark: of 38 clean recordings 3 are material by this. Where the
/// simulation under test errs less than the first, no effect is named.
pub(crate) const MATERIAL_VARIANCES: f64 = 2.0;

/// Share of what was missing that named effects may leave and still explain it: half of the error.
pub(crate) const MAX_RESIDUAL_GAIN_SHARE: f64 = 0.25;

/// Misfit per sample that named effects may leave however little was missing, nats.
pub(crate) const MAX_RESIDUAL_MISFIT_NATS: f64 = 2.0;

/// Whether a gain in log likelihood, nats, is more than chance and large enough to matter.
pub(crate) fn is_significant(gain: f64, observations: usize) -> bool {
    gain > MIN_SIGNIFICANT_GAIN_NATS.max(0.5 * NEGLIGIBLE_SHARE * observations as f64)
}

/// Log likelihood that the given values of so many parameters may cost and still be right, nats.
pub(crate) fn max_given_cost(parameters: usize) -> f64 {
    MIN_SIGNIFICANT_GAIN_NATS + 0.5 * parameters as f64
}
