//! Thresholds for verdicts and names. The thresholds for places, windows, competing models, warnings,
//! experiments and the model discrepancy, the prior of the search, settings that only save time, and
//! numerical tolerances are defined where they are used. `benches/thresholds.py` counts both groups.

/// Gain in log likelihood below which an improvement counts as chance, nats. Twice the gain follows a χ²
/// distribution with one degree of freedom, halved at zero, so that 10 nats are one false alarm in 10⁵ on
/// exact data. The margin allows for integrators that differ from trundle's. The same number bounds the cost
/// of given values (plus half a nat for each parameter) and the gain of one block.
pub(crate) const MIN_SIGNIFICANT_GAIN_NATS: f64 = 10.0;

/// Mean square below which an error is negligible, as a share of the reference: a tenth in size. The lack of
/// fit is compared with the noise, where it gains half of this share per sample, nats. Errors are compared
/// with the motion. The residual of named effects is compared with what was missing: the right law leaves
/// thousandths, and a law that leaves more than a hundredth only resembles the missing one.
pub const NEGLIGIBLE_SHARE: f64 = 0.01;

/// Difference of log likelihood below which two explanations fit equally well, nats: two standard deviations
/// of one parameter.
pub const MAX_TIE_DIFFERENCE_NATS: f64 = 2.0;

/// Least bootstrap probability for an effect to be named, and least probability of a discriminating
/// experiment's outcome.
pub const MIN_EFFECT_PROBABILITY: f64 = 0.95;

/// Least ratio by which the squared errors of left-out training episodes rise without a material effect: an
/// eighth in size. Chosen on the tuning range of the wide benchmark.
pub const MIN_MATERIAL_ERROR_RATIO: f64 = 1.25;

/// Ratio of the prediction error to its stated standard deviation above which a model is refuted. For the
/// right model, the mean square over some dozens of windows is within a third of its expectation. The margin
/// allows for the right law with a slightly wrong shape, whose intervals are too narrow by this factor.
pub(crate) const MAX_ERROR_RATIO: f64 = 3.0;

/// Mean square error within a second, as a share of the motion, above which a refuted model is not named:
/// about a third in size.
pub(crate) const MAX_ERROR_SHARE: f64 = 0.1;

/// Mean square error below which prediction errors are immaterial, in units of the instruments' variance.
/// Errors below a tenth of the motion are also immaterial unless they refute the model. Chosen on the tuning
/// range of the wide benchmark, where 3 of 38 clean recordings exceed it. If the nominal model errs less than
/// this, no effect is named.
pub(crate) const MIN_MATERIAL_VARIANCES: f64 = 2.0;

/// Largest share that named effects may leave: half in size. It applies to the missing gain, and to the squared errors
/// of the nominal model one second ahead if the named model is refuted ([`MAX_ERROR_RATIO`]).
pub const MAX_RESIDUAL_GAIN_SHARE: f64 = 0.25;

/// Misfit per sample that named effects may always leave, nats.
pub(crate) const MAX_MISFIT_PER_SAMPLE_NATS: f64 = 2.0;

/// Whether a gain in log likelihood, nats, exceeds both chance and the negligible share.
pub(crate) fn is_significant(gain: f64, observations: usize) -> bool {
    gain > MIN_SIGNIFICANT_GAIN_NATS.max(0.5 * NEGLIGIBLE_SHARE * observations as f64)
}

/// Largest log likelihood that given values of `parameters` parameters may cost and still count as right,
/// nats.
#[must_use]
pub fn max_given_cost(parameters: usize) -> f64 {
    MIN_SIGNIFICANT_GAIN_NATS + 0.5 * parameters as f64
}
