//! The published cost of a task.

/// Costs per second, in addition to distance and heading error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Cost of each second.
    pub time: f64,
    /// Cost of each second at full effort: the mean square of the wrench as a fraction of the full wrench.
    pub effort: f64,
    /// Cost of each second of contact with an obstacle.
    pub touch: f64,
    /// Whether a step with any contact counts as contact during the whole step.
    pub charges_whole_steps: bool,
}

impl Costs {
    /// Default costs of a version.
    pub fn of_version(version: u32) -> Self {
        match version {
            0 => Self { time: 0.0, effort: 0.0, touch: 1.0, charges_whole_steps: true },
            _ => Self { time: 0.05, effort: 0.02, touch: 10.0, charges_whole_steps: false },
        }
    }
}
