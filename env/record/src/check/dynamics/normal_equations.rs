//! Normal equations for any linear transform of the load.

use nalgebra::{DMatrix, DVector};

use super::regressors::{COLUMNS, Row};

/// Linear transform of a load (force x, force y, torque over the lever arm).
pub(crate) type LoadTransform = [[f64; 3]; 3];

/// The identity transform.
pub(crate) fn identity() -> LoadTransform {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

/// Sums of products over rows: regressors with regressors, regressors of each output with each load, and loads with loads.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    pub normal: DMatrix<f64>,
    cross: [[DVector<f64>; 3]; 3],
    load: LoadTransform,
}

impl NormalEquations {
    pub fn new() -> Self {
        let none = || DVector::zeros(COLUMNS);
        Self {
            normal: DMatrix::zeros(COLUMNS, COLUMNS),
            cross: std::array::from_fn(|_| std::array::from_fn(|_| none())),
            load: [[0.0; 3]; 3],
        }
    }

    /// Adds one row and its load.
    pub fn add(&mut self, row: &Row, load: &[f64; 3]) {
        for (k, output) in row.iter().enumerate() {
            let output = DVector::from_column_slice(output);
            self.normal.ger(1.0, &output, &output, 1.0);
            self.add_cross(k, &output, load);
        }
        self.add_load(load);
    }

    /// Adds a load without updating the normal matrix, for the same row with another load.
    pub fn add_load_of(&mut self, row: &Row, load: &[f64; 3]) {
        for (k, output) in row.iter().enumerate() {
            self.add_cross(k, &DVector::from_column_slice(output), load);
        }
        self.add_load(load);
    }

    fn add_cross(&mut self, output: usize, row: &DVector<f64>, load: &[f64; 3]) {
        for (sum, value) in self.cross[output].iter_mut().zip(load) {
            sum.axpy(*value, row, 1.0);
        }
    }

    fn add_load(&mut self, load: &[f64; 3]) {
        for i in 0..3 {
            (0..3).for_each(|j| self.load[i][j] += load[i] * load[j]);
        }
    }

    /// Adds the sums of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.normal += &other.normal;
        for i in 0..3 {
            for j in 0..3 {
                self.cross[i][j] += &other.cross[i][j];
                self.load[i][j] += other.load[i][j];
            }
        }
    }

    /// The sum of `parts`.
    pub fn sum<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        parts.into_iter().fold(Self::new(), |mut all, part| {
            all.merge(part);
            all
        })
    }

    /// Right-hand side and sum of squares of the transformed load.
    pub fn transformed(&self, correction: &LoadTransform) -> (DVector<f64>, f64) {
        let mut right = DVector::zeros(COLUMNS);
        let mut total = 0.0;
        for (output, gains) in correction.iter().enumerate() {
            for (i, gain) in gains.iter().enumerate() {
                right.axpy(*gain, &self.cross[output][i], 1.0);
                total +=
                    gains.iter().zip(&self.load[i]).map(|(other, load)| gain * load * other).sum::<f64>();
            }
        }
        (right, total)
    }
}
