//! The readings of an episode for simulators outside of this crate: what acted in a step by a model's laws of instruments.

use crate::curve::Curve;
use crate::filter::acting;
use crate::track::{Step, Track, cut};
use std::sync::Arc;
use trundle_model::{Clock, Plant};
use trundle_record::{PoseSample, Prepared};

/// All readings of an episode.
#[derive(Clone, Debug)]
pub struct Readings(Arc<Curve>);

impl Readings {
    /// Of an episode that is simulated.
    pub fn new(episode: &Prepared) -> Self {
        Self(Arc::new(Curve::new(episode)))
    }

    /// Of an episode that is compared with a simulation: its steps know the noise of what was read.
    pub fn of(track: &Track) -> Self {
        Self(track.curve.clone())
    }

    /// The time between two poses cut into the steps of a simulation.
    pub fn steps(&self, from: f64, to: &PoseSample) -> Vec<Step> {
        let mut steps = vec![];
        cut(from, to, &self.0, self.0.longest(), &mut steps);
        steps
    }

    /// Mean wrench on the object over a step, object axes about its origin, by a model's laws of instruments; and when
    /// that was read.
    pub fn acting(&self, plant: &Plant<f64>, step: &Step) -> ([f64; 3], Clock) {
        acting(plant, &[0.0; 3], step, &self.0)
    }
}
