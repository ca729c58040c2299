//! The equation of motion of a step, linear in the parameters.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::dry_friction::{Contact, Sliding, body_twist};
use super::parameters::{DRY_FRICTION, PARAMETERS};
use crate::baseline::Transition;

pub(super) type Regressors = SMatrix<f64, 3, PARAMETERS>;

/// `regressors · parameters = impulse`, object axes about the origin.
#[derive(Clone, Debug)]
pub(super) struct StepEquation {
    pub regressors: Regressors,
    /// Impulse of the applied wrench, `[N·s, N·s, N·m·s]`.
    pub impulse: Vector3<f64>,
    /// Share of the dry friction whose direction is unknown.
    pub undirected: f64,
    /// Duration, s.
    pub dt: f64,
}

impl StepEquation {
    /// The equation of motion, integrated over a step. The mean twist of the damping is `before + mean (after − before)`;
    /// the slow terms of the rotating axes follow from the trapezoidal rule.
    pub fn of(step: &Transition, mean: &Matrix3<f64>, contact: &Contact) -> Self {
        let (before, after) = (body_twist(&step.before), body_twist(&step.after));
        let change = momentum(after) - momentum(before);
        let turning = (rotation(before) + rotation(after)) * 0.5;
        let middle = before + mean * (after - before);
        let Sliding { wrench, undirected } = contact.sliding(before, after);
        let mut rates = turning + damping(middle);
        rates.set_column(DRY_FRICTION, &wrench);
        let impulse = Vector3::from(step.wrench) * step.dt;
        Self { regressors: change + rates * step.dt, impulse, undirected, dt: step.dt }
    }
}

/// Momentum about the origin, as a function of the parameters.
fn momentum(twist: Vector3<f64>) -> Regressors {
    let [u, v, w] = twist.into();
    with_columns(0, [[u, 0.0, -w, 0.0], [v, w, 0.0, 0.0], [0.0, v, -u, w]])
}

/// Rate of the momentum due to the rotation of the axes and the motion of the origin.
fn rotation(twist: Vector3<f64>) -> Regressors {
    let [u, v, w] = twist.into();
    with_columns(0, [[-w * v, -w * w, 0.0, 0.0], [w * u, 0.0, -w * w, 0.0], [0.0, w * u, w * v, 0.0]])
}

/// Wrench of the damping.
fn damping(twist: Vector3<f64>) -> Regressors {
    let [u, v, w] = twist.into();
    with_columns(4, [[u, v, 0.0, w, 0.0, 0.0], [0.0, u, v, 0.0, w, 0.0], [0.0, 0.0, 0.0, u, v, w]])
}

/// Regressors with some columns from `first` on.
fn with_columns<const N: usize>(first: usize, rows: [[f64; N]; 3]) -> Regressors {
    let entry = |row: usize, column: usize| {
        column.checked_sub(first).and_then(|column| rows[row].get(column)).copied().unwrap_or(0.0)
    };
    Regressors::from_fn(entry)
}

/// Mass matrix about the origin.
#[rustfmt::skip]
pub(super) fn mass_matrix([m, x, y, i]: [f64; 4]) -> Matrix3<f64> {
    Matrix3::new(
        m, 0.0, -y,
        0.0, m, x,
        -y, x, i,
    )
}
