//! How a residual is judged: normal, or with the heavier tails of Student's t.

use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// Distribution of a whitened residual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// Normal, as in the paper's eq. 5.
    #[default]
    Gaussian,
    /// Student's t: an outlier counts by its logarithm, not by its square.
    StudentT {
        /// Degrees of freedom, positive.
        nu: f64,
    },
}

/// What a residual costs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Charge {
    /// −log density of the whitened residual.
    pub cost: f64,
    /// Twice the cost's slope by the squared length of the residual: what the residual counts for.
    pub weight: f64,
    /// By what the squared slopes of the whitened residual are multiplied to have the expectation of Fisher's
    /// information where the distribution is right.
    pub curvature: f64,
}

impl Loss {
    /// Student's t with four degrees of freedom, the usual choice.
    pub const STUDENT: Self = Self::StudentT { nu: 4.0 };

    /// Charge of a residual in `n` dimensions whose squared length, in standard deviations, is `square`.
    pub(crate) fn charge(self, square: f64, n: f64) -> Charge {
        match self {
            Self::Gaussian => Charge { cost: 0.5 * (square + n * TAU.ln()), weight: 1.0, curvature: 1.0 },
            Self::StudentT { nu } => {
                let constant = ln_gamma(0.5 * nu) - ln_gamma(0.5 * (nu + n)) + 0.5 * n * (nu * PI).ln();
                let weight = (nu + n) / (nu + square);
                // The weight's mean is one; Fisher's information of a place is this much less (Lange, Little and
                // Taylor 1989, J. Am. Stat. Assoc. 84:881).
                let curvature = weight * (nu + n) / (nu + n + 2.0);
                Charge { cost: 0.5 * (nu + n) * (square / nu).ln_1p() + constant, weight, curvature }
            }
        }
    }

    /// Fisher's information of the logarithm of the scale, from one residual in one dimension.
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
                (-loss.charge(x * x, 1.0).cost).exp() * (1.0 + x * x)
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
                let slope = (loss.charge(square + h, n).cost - loss.charge(square - h, n).cost) / (2.0 * h);
                assert!((2.0 * slope - loss.charge(square, n).weight).abs() < 1e-6);
            }
        }
    }
}
