//! What a step of a task comes to.

/// What a step has led to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Minus the time integral of the pose error, less penalties.
    pub reward: f64,
    /// The goal was reached, or the object was lost.
    pub terminated: bool,
    /// The time is up.
    pub truncated: bool,
    /// The goal was reached.
    pub success: bool,
    /// The object left the arena, or went too fast.
    pub lost: bool,
    /// The object touched an obstacle.
    pub touched: bool,
    /// Distance to the goal, or from the path, m.
    pub distance: f64,
    /// Heading less goal heading, rad, in (−π, π].
    pub heading_error: f64,
    /// Share of the path that lies behind it; 0 without a path.
    pub progress: f64,
}
