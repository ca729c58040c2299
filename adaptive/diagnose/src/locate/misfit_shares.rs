//! Shares of the coordinates in the misfit of a simulation.

use crate::answer::Channels;
use trundle_infer::{Comparison, Fit, InferError};

/// Shares of x, y and θ in the squared standardised innovations, or in the squared residual wrenches if wrenches
/// are compared.
pub(crate) fn misfit_shares(comparison: &Comparison, fit: &Fit) -> Result<Channels, InferError> {
    let mut sums = [0.0; 3];
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => {
            for innovation in motion.innovations(&fit.model, &fit.values)?.iter().flatten().flatten() {
                for k in (0..3).filter(|&k| fit.model.dof[k]) {
                    sums[k] += innovation.error[k].powi(2) / innovation.covariance[(k, k)];
                }
            }
        }
        Comparison::Wrench(wrench) => {
            let plant = fit.model.plant(&fit.values)?;
            let rho = fit.model.body.gyration;
            for sample in wrench.samples() {
                let [x, y, torque] = sample.residual(&plant);
                let [x, y, _] = trundle_model::to_world([x, y, 0.0], sample.pose[2]);
                for (sum, r) in sums.iter_mut().zip([x, y, torque / rho]) {
                    *sum += r * r;
                }
            }
        }
    }
    let total: f64 = sums.iter().sum();
    if total <= 0.0 {
        return Ok(Channels::default());
    }
    let [x, y, theta] = sums.map(|e| e / total);
    Ok(Channels { x, y, theta })
}
