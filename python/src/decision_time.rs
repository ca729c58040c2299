//! Time between an observation and the action that follows, stated or measured.

use std::time::Instant;

use trundle_sim::Options;

/// Stated decision time, or a clock that measures it.
pub(crate) struct DecisionClock {
    stated_s: f64,
    measures: bool,
    since: Option<Instant>,
}

impl DecisionClock {
    /// The clock of an environment with these options.
    pub fn new(options: &Options) -> Self {
        Self { stated_s: options.decision_time, measures: options.measures_decisions, since: None }
    }

    /// Start to measure: the caller receives an observation now.
    pub fn start(&mut self) {
        self.since = self.measures.then(Instant::now);
    }

    /// Decision time until now, s. It is 0 before the first observation.
    pub fn elapsed_s(&self) -> f64 {
        match self.measures {
            true => self.since.map_or(0.0, |since| since.elapsed().as_secs_f64()),
            false => self.stated_s,
        }
    }
}
