//! Normal equations of a stretch of rows, for any linear change of the load.

use nalgebra::{DMatrix, DVector};

use super::regressors::{COLUMNS, Row};

/// What is done to a load (force x, force y, torque over the arm) before it is explained.
pub(crate) type Linear = [[f64; 3]; 3];

/// The load as it is.
pub(crate) fn identity() -> Linear {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

/// Sums over rows: of regressors with themselves, with each load on each output, and of loads with themselves.
#[derive(Debug, Clone)]
pub(crate) struct Moments {
    pub normal: DMatrix<f64>,
    cross: [[DVector<f64>; 3]; 3],
    load: Linear,
}

impl Moments {
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

    /// The same rows under other loads: no sums of regressors.
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

    /// Adds the sums of another stretch.
    pub fn merge(&mut self, other: &Self) {
        self.normal += &other.normal;
        for i in 0..3 {
            for j in 0..3 {
                self.cross[i][j] += &other.cross[i][j];
                self.load[i][j] += other.load[i][j];
            }
        }
    }

    /// The sum of several stretches.
    pub fn sum<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        parts.into_iter().fold(Self::new(), |mut all, part| {
            all.merge(part);
            all
        })
    }

    /// Right side and sum of squares of the load after `change`.
    pub fn changed(&self, change: &Linear) -> (DVector<f64>, f64) {
        let mut right = DVector::zeros(COLUMNS);
        let mut total = 0.0;
        for (output, gains) in change.iter().enumerate() {
            for (i, gain) in gains.iter().enumerate() {
                right.axpy(*gain, &self.cross[output][i], 1.0);
                total +=
                    gains.iter().zip(&self.load[i]).map(|(other, load)| gain * load * other).sum::<f64>();
            }
        }
        (right, total)
    }
}
