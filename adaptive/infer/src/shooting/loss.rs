//! Distribution of the residuals: normal, or Student's t with heavier tails.

use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// Distribution of a whitened residual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// Normal, as in the paper's eq. 5.
    #[default]
    Gaussian,
    /// Student's t: the cost of an outlier grows with its logarithm, not with its square.
    StudentT {
        /// Degrees of freedom, positive.
        nu: f64,
    },
}

/// Cost of a residual, with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contribution {
    /// −log density of the whitened residual.
    pub cost: f64,
    /// Twice the derivative of the cost by the squared length of the residual: the weight of the residual.
    pub weight: f64,
    /// Factor on the squared slopes of the whitened residual whose expectation gives the Fisher information
    /// under this distribution.
    pub curvature: f64,
}

impl Loss {
    /// Student's t with four degrees of freedom, the usual choice.
    pub const STUDENT: Self = Self::StudentT { nu: 4.0 };

    /// Cost of a residual in `n` dimensions with the squared length `square`, in standard deviations.
    pub(crate) fn contribution(self, square: f64, n: f64) -> Contribution {
        match self {
            Self::Gaussian => {
                Contribution { cost: 0.5 * (square + n * TAU.ln()), weight: 1.0, curvature: 1.0 }
            }
            Self::StudentT { nu } => {
                let constant = ln_gamma(0.5 * nu) - ln_gamma(0.5 * (nu + n)) + 0.5 * n * (nu * PI).ln();
                let weight = (nu + n) / (nu + square);
                // The mean of the weight is one. The Fisher information of a location is smaller by this
                // factor (Lange, Little and Taylor 1989, J. Am. Stat. Assoc. 84:881).
                let curvature = weight * (nu + n) / (nu + n + 2.0);
                Contribution { cost: 0.5 * (nu + n) * (square / nu).ln_1p() + constant, weight, curvature }
            }
        }
    }

    /// Fisher information of the logarithm of the scale from one residual in one dimension.
    pub(crate) fn scale_information(self) -> f64 {
        match self {
            Self::Gaussian => 2.0,
            Self::StudentT { nu } => 2.0 * nu / (nu + 3.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_add_up_to_one() {
        for loss in [Loss::Gaussian, Loss::STUDENT, Loss::StudentT { nu: 1.5 }] {
            // Midpoints of x = tan u, which maps the line to a finite interval.
            let n = 20_000;
            let h = PI / f64::from(n);
            let density = |u: f64| {
                let x = u.tan();
                (-loss.contribution(x * x, 1.0).cost).exp() * (1.0 + x * x)
            };
            let sum: f64 = (0..n).map(|k| h * density(-PI / 2.0 + (f64::from(k) + 0.5) * h)).sum();
            assert!((sum - 1.0).abs() < 1e-3, "{loss:?} {sum}");
        }
    }

    #[test]
    fn weights_are_the_slopes_of_the_cost() {
        for loss in [Loss::Gaussian, Loss::STUDENT] {
            for (square, n) in [(0.3, 1.0), (9.0, 1.0), (2.0, 3.0)] {
                let h = 1e-6;
                let slope = (loss.contribution(square + h, n).cost - loss.contribution(square - h, n).cost)
                    / (2.0 * h);
                assert!((2.0 * slope - loss.contribution(square, n).weight).abs() < 1e-6);
            }
        }
    }
}
