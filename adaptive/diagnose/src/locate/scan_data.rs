//! Data that all scans of a misfit share.

use super::knots::{self, Knots};
use super::score_test::ScoreTest;
use trundle_infer::{Fit, InferError, MotionLikelihood, Residual};

/// Data that all scans share.
pub(crate) struct ScanData {
    pub score_test: ScoreTest,
    pub knots: Vec<Knots>,
    /// χ² that any missing wrench explains.
    pub total: f64,
}

impl ScanData {
    pub fn new(
        motion: &MotionLikelihood,
        fit: &Fit,
        residuals: &[Vec<Residual>],
    ) -> Result<Option<Self>, InferError> {
        let Some(score_test) = ScoreTest::new(motion, fit, residuals)? else { return Ok(None) };
        let knots = knots::knots(&score_test);
        let total = knots::explainable_chi_square(&knots);
        Ok(Some(Self { score_test, knots, total }))
    }
}
