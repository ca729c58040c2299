//! Readings of an episode for external simulators: the wrench that acts in a step according to a model's
//! instrument laws.

use crate::curve::Curve;
use crate::filter::applied_wrench;
use crate::track::{Step, Track, cut_into_steps};
use std::sync::Arc;
use trundle_model::{Clock, Plant};
use trundle_record::{PoseSample, Prepared};

/// All readings of an episode.
#[derive(Clone, Debug)]
pub struct Readings(Arc<Curve>);

impl Readings {
    /// Readings of an episode for a simulation without noise.
    pub fn new(episode: &Prepared) -> Self {
        Self(Arc::new(Curve::new(episode)))
    }

    /// Readings of an episode that is compared with a simulation: its steps include the noise of the
    /// readings.
    pub fn of(track: &Track) -> Self {
        Self(track.curve.clone())
    }

    /// Divides the time between two poses into simulation steps.
    pub fn steps(&self, from: f64, to: &PoseSample) -> Vec<Step> {
        let mut steps = vec![];
        cut_into_steps(from, to, &self.0, self.0.max_step(), &mut steps);
        steps
    }

    /// Mean wrench on the object over a step, object axes about its origin, corrected by a model's instrument
    /// laws, and the clock of the reading.
    pub fn applied_wrench(&self, plant: &Plant<f64>, step: &Step) -> ([f64; 3], Clock) {
        applied_wrench(plant, &[0.0; 3], step, &self.0)
    }
}
