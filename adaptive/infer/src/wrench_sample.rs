//! Averaged samples of twist and wrench.

use trundle_model::{Clock, Plant, Real, State, to_body, transport};

/// Twist and wrench averaged over a short interval.
#[derive(Clone, Debug)]
pub struct WrenchSample {
    /// Index of the episode.
    pub episode: usize,
    /// Middle of the interval, s.
    pub t: f64,
    /// Pose of the object.
    pub pose: [f64; 3],
    /// Twist of the object, world axes.
    pub twist: [f64; 3],
    /// Mean reading, reading axes.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame.
    pub frame: [f64; 3],
    /// Clock at the middle of the interval.
    pub clock: Clock,
}

impl WrenchSample {
    fn state<T: Real>(&self) -> State<T> {
        State::moving(self.pose.map(T::lift), self.twist.map(T::lift))
    }

    /// The recorded wrench, corrected by the model's instrument laws, object axes about the origin.
    pub fn recorded<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        transport(plant.correct(self.reading.map(T::lift), self.clock), self.frame)
    }

    /// The wrench that the model requires for the twist, object axes about the origin.
    pub fn needed<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        let state = self.state();
        let twist = to_body(state.twist, state.pose[2]);
        plant.generalised_force(&state, self.clock).wrench(twist).map(|w| -w)
    }

    /// Required minus recorded wrench.
    pub fn residual<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        let (needed, recorded) = (self.needed(plant), self.recorded(plant));
        [0, 1, 2].map(|k| needed[k] - recorded[k])
    }
}
