//! Priors of free parameters.

/// Prior of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Prior {
    /// Constant.
    Flat,
    Normal {
        mean: f64,
        sd: f64,
    },
    /// Normal in the logarithm of a positive parameter.
    LogNormal {
        median: f64,
        /// Standard deviation of the logarithm.
        log_sd: f64,
    },
}

impl Prior {
    /// Standard deviation, at the median if it depends on the value.
    pub fn sd(self) -> f64 {
        match self {
            Self::Flat => f64::INFINITY,
            Self::Normal { sd, .. } => sd,
            Self::LogNormal { median, log_sd } => median * log_sd,
        }
    }

    /// Distance of a value from the centre in standard deviations, and its derivative.
    fn deviation(self, value: f64) -> (f64, f64) {
        match self {
            Self::Flat => (0.0, 0.0),
            Self::Normal { mean, sd } => ((value - mean) / sd, sd.recip()),
            Self::LogNormal { median, log_sd } => ((value / median).ln() / log_sd, (value * log_sd).recip()),
        }
    }

    /// −log density up to a constant.
    pub fn cost(self, value: f64) -> f64 {
        0.5 * self.deviation(value).0.powi(2)
    }

    /// Precision and right-hand side of the normal equations of a Gauss–Newton step from a value.
    pub fn normal_equation(self, value: f64) -> (f64, f64) {
        let (deviation, slope) = self.deviation(value);
        (slope * slope, -slope * deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::Prior;

    #[test]
    fn steps_lead_to_the_median_of_a_log_normal_prior() {
        let prior = Prior::LogNormal { median: 9.5, log_sd: 0.3 };
        for start in [0.5, 5.0, 20.0] {
            let mut value: f64 = start;
            for _ in 0..60 {
                let (precision, right) = prior.normal_equation(value);
                value = (value + right / precision).max(0.1);
            }
            assert!((value - 9.5).abs() < 1e-6, "{start}: {value}");
        }
        assert!(prior.cost(9.5).abs() < 1e-12);
        // A factor of two costs the same up and down, and a mass near zero is excluded.
        assert!((prior.cost(19.0) - prior.cost(4.75)).abs() < 1e-9);
        assert!(prior.cost(0.1) > 100.0);
    }
}
