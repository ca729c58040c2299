//! Quadratic approximation of the cost of joints that a screening fit does not evaluate again.

use crate::model::{Effect, Slot};
use crate::prior::Prior;
use crate::problem::Problem;
use crate::rows::{JointRows, Scope, evaluate, normal_equations};
use nalgebra::{DMatrix, DVector};

/// The normal equations of each joint at a fit, which approximate the cost of the joints that are not evaluated again.
#[derive(Clone, Debug)]
pub(crate) struct QuadraticCost {
    values: Vec<f64>,
    /// Matrix and right-hand side of the normal equations of each joint, without the prior.
    joints: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl QuadraticCost {
    /// Those of a model with values and standard deviations of the joints' residuals.
    pub fn of(problem: &Problem, effects: &[Effect], slots: &[Slot], values: &[f64], sd: &[f64]) -> Self {
        let rows = evaluate(problem, effects, slots, values, Scope::Training, true);
        let flat: Vec<Slot> = slots.iter().map(|slot| Slot { prior: Prior::Flat, ..slot.clone() }).collect();
        let own =
            |rows: &JointRows| normal_equations(std::slice::from_ref(rows), sd, &flat, values, &|_| true);
        Self { values: values.to_vec(), joints: rows.iter().map(own).collect() }
    }

    /// Change of the values from the fit's. Further slots belong to new effects, which the other joints do not contain.
    fn change(&self, values: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.values.len(), self.values.iter().zip(values).map(|(old, new)| new - old))
    }

    /// Rise of the cost of all joints but one, nats.
    pub fn cost(&self, except: usize, values: &[f64]) -> f64 {
        let change = self.change(values);
        let one = |(matrix, right): &(DMatrix<f64>, DVector<f64>)| {
            0.5 * change.dot(&(matrix * &change)) - right.dot(&change)
        };
        self.joints.iter().enumerate().filter(|(j, _)| *j != except).map(|(_, own)| one(own)).sum()
    }

    /// Add the other joints' normal equations at some values.
    pub fn add_to(&self, except: usize, values: &[f64], matrix: &mut DMatrix<f64>, right: &mut DVector<f64>) {
        let (change, count) = (self.change(values), self.values.len());
        for (_, (own, slope)) in self.joints.iter().enumerate().filter(|(j, _)| *j != except) {
            let mut block = matrix.view_mut((0, 0), (count, count));
            block += own;
            let mut part = right.rows_mut(0, count);
            part += slope - own * &change;
        }
    }
}
