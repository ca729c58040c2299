//! What is believed of parameters before the data, other than what the catalogue says: a file of
//! tables, one entry a parameter.
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

/// A prior that replaces the catalogue's: a distribution cut off at the ends of its support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedPrior {
    /// The distribution.
    pub prior: Prior,
    /// Smallest value that it allows.
    pub lower: f64,
    /// Largest value that it allows.
    pub upper: f64,
}

impl TruncatedPrior {
    /// The same of a value in units that are `1 / size` as large.
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

/// A file of priors, read but not yet held against a model.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorFile {
    /// Its name, for messages.
    source: String,
    entries: Vec<Entry>,
}

/// One parameter's entry.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    /// Name as in [`crate::Slot::name`]: table and key.
    slot: String,
    /// `None`: the distribution is the catalogue's.
    distribution: Option<Distribution>,
    per_episode: bool,
}

/// A distribution as it is written; ends of the support that are left out are the legal ones.
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
    /// Names of the parameters that each episode has its own of (`scope = "episode"`).
    pub fn per_episode(&self) -> BTreeSet<String> {
        self.entries.iter().filter(|e| e.per_episode).map(|e| e.slot.clone()).collect()
    }
}

#[cfg(test)]
mod tests;
