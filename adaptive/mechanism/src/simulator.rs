//! The user's own simulator as the mechanism under test: a function of which only evaluations are known.

/// A simulator, evaluated along the measured motion. Only its parameters are refitted; its bodies are not known.
#[derive(Clone, Debug, Default)]
pub struct SimulatorSetup {
    /// Parameters that may be refitted.
    pub parameters: Vec<SimulatorParameter>,
    /// Whether their starting values are those under test.
    pub is_given: bool,
}

/// A parameter of the simulator, in which the required efforts are linear near `reference`.
#[derive(Clone, Debug)]
pub struct SimulatorParameter {
    /// Name.
    pub name: String,
    /// Unit; empty if it is not known.
    pub unit: &'static str,
    /// Starting value, which is also the mean of the prior.
    pub start: f64,
    /// Value at which the efforts and their derivatives are evaluated.
    pub reference: f64,
    /// Bounds.
    pub bounds: [f64; 2],
    /// Standard deviation of the prior.
    pub sd: f64,
}
