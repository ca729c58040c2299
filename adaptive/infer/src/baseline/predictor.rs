//! Models that predict the next state.

/// Pose and twist of an object in the world: `[m, m, rad, m/s, m/s, rad/s]`.
pub type StateVector = [f64; 6];

/// Predicts the next state under a constant wrench.
pub trait Predictor {
    /// State `dt` seconds after `x` under the wrench `u` (`[N, N, N·m]`, object axes about the object's
    /// origin). The wrench is constant in object axes, so it rotates with the object.
    fn predict(&self, x: &StateVector, u: &[f64; 3], dt: f64) -> StateVector;
}
