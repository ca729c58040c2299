//! Result of a task step.

/// Result of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Negative time integral of the pose error, minus penalties.
    pub reward: f64,
    /// The goal was reached, or the object left the workspace.
    pub terminated: bool,
    /// The horizon was reached.
    pub truncated: bool,
    /// The goal was reached.
    pub success: bool,
    /// The object left the workspace or exceeded a speed limit.
    pub lost: bool,
    /// The object touched an obstacle.
    pub touched: bool,
    /// Distance to the goal, or from the path, m.
    pub distance: f64,
    /// Heading minus goal heading, rad, in (−π, π].
    pub heading_error: f64,
    /// Completed fraction of the path; 0 without a path.
    pub progress: f64,
    /// The goal was reached, and the object has touched no obstacle in the episode.
    pub success_without_touching: bool,
    /// Time of contact with obstacles in the episode so far, s.
    pub contact_time: f64,
    /// Impulse of obstacles on the object in the episode so far, N·s.
    pub contact_impulse: f64,
    /// An entry of the action was outside [−1, 1] and has been clipped.
    pub action_clipped: bool,
    /// Duration of the step, s: longer than the period if the decision takes longer.
    pub duration: f64,
}
