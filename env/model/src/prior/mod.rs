//! Prior files: distributions that replace the priors of the catalogue, one entry per parameter.
//!
//! ```toml
//! [body]
//! mass = { distribution = "log_normal", median = 20, sd = 0.5 }
//! [viscous_wheel]
//! x = { distribution = "uniform", low = -0.6, high = 0.0 }
//! angle = { distribution = "fixed", value = 0.0 }
//! mu_x = { scope = "episode" }
//! ```

mod apply;
mod read;
mod spelling;

use crate::law::Prior;
use std::collections::BTreeSet;

/// A prior that replaces the one of the catalogue: a distribution truncated to an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedPrior {
    /// The distribution.
    pub prior: Prior,
    /// Lower end of the support.
    pub lower: f64,
    /// Upper end of the support.
    pub upper: f64,
}

impl TruncatedPrior {
    /// The same prior for a value in a unit that is `1 / size` as large.
    #[must_use]
    pub fn rescaled(&self, size: f64) -> Self {
        let prior = match self.prior {
            Prior::Normal { mean, sd } => Prior::Normal { mean: mean * size, sd: sd * size },
            Prior::LogNormal { median, sd } => Prior::LogNormal { median: median * size, sd },
            other => other,
        };
        Self { prior, lower: self.lower * size, upper: self.upper * size }
    }
}

/// A parsed prior file, not yet applied to a model.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorFile {
    /// File name, for messages.
    source: String,
    entries: Vec<Entry>,
}

/// Entry of one parameter.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    /// Name as in [`crate::Slot::name`]: table and key.
    slot: String,
    /// `None`: the prior of the catalogue applies.
    distribution: Option<Distribution>,
    per_episode: bool,
}

/// A distribution as written in the file. Omitted ends of the support are the bounds of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Distribution {
    Normal { mean: f64, sd: f64, low: Option<f64>, high: Option<f64> },
    LogNormal { median: f64, sd: f64, low: Option<f64>, high: Option<f64> },
    Uniform { low: f64, high: f64 },
    OnBody,
    Angle,
    Fixed { value: f64 },
}

impl PriorFile {
    /// Names of the parameters with a separate value for each episode (`scope = "episode"`).
    pub fn per_episode(&self) -> BTreeSet<String> {
        self.entries.iter().filter(|e| e.per_episode).map(|e| e.slot.clone()).collect()
    }
}

#[cfg(test)]
mod tests;
