//! A planned motion as an episode.

use crate::dynamics::{AxisLoad, EpisodeDynamics, check_episode};
use crate::error::MechanismError;
use crate::kernel::Kernel;
use crate::problem::{EpisodeData, Problem, keep_where};
use crate::series::Series;

/// A motion that all joints are made to follow, on uniform times. The outer index is the joint.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Positions, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Velocities.
    pub v: Vec<Vec<f64>>,
    /// Accelerations.
    pub a: Vec<Vec<f64>>,
    /// What the model needs along the motion; `None` for an axis without a model.
    pub dynamics: Option<EpisodeDynamics>,
    /// Change of the load on an axis without a model.
    pub load: AxisLoad,
    /// Covariate `load_JOINT` of each joint that has one.
    pub covariates: Vec<Option<f64>>,
    /// Whether the encoders are on the other side of the gears than in the recording.
    pub other_encoder: bool,
}

impl Plan {
    /// The problem whose only episode is this motion; `filter_sd` is the standard deviation of the filter.
    ///
    /// The planned motion needs no smoothing: one filter replaces both stages of a recording.
    pub(super) fn problem(
        &self,
        template: &Problem,
        gains: &EpisodeData,
        filter_sd: f64,
    ) -> Result<Problem, MechanismError> {
        let (joints, len) = (template.joints.len(), self.q.first().map_or(0, Vec::len));
        self.check(joints, template.bodies.len(), len)?;
        let one = |j: usize| {
            let recorded = &gains.joints[j];
            Series {
                raw: self.q[j].clone(),
                q: self.q[j].clone(),
                v: self.v[j].clone(),
                a: self.a[j].clone(),
                causal: self.q[j].iter().zip(&self.v[j]).map(|(q, v)| [*q, *v]).collect(),
                command: vec![0.0; len],
                interval: recorded.interval,
                noise: recorded.noise,
                gain: recorded.gain,
                drive_damping: recorded.drive_damping,
                limit: recorded.limit,
                known: vec![0.0; len],
                on: vec![1.0; len],
                load: self.covariates.get(j).copied().flatten().map(|load| vec![load; len]),
                kept: vec![],
                resting: vec![],
                weight: vec![1.0; len],
            }
        };
        let mut episode = EpisodeData {
            name: "plan".to_owned(),
            held_out: false,
            start: 0.0,
            dt: gains.dt,
            first_stage: Kernel::identity(),
            kernel: Kernel::new(filter_sd, gains.dt),
            spacing: gains.spacing,
            joints: (0..joints).map(one).collect(),
            dynamics: self.dynamics.clone(),
            load: self.load,
        };
        for (j, setup) in template.joints.iter().enumerate() {
            keep_where(&mut episode, j, setup.rest_speed, &|_| true);
        }
        let mut problem = Problem { episodes: vec![episode], ..template.clone() };
        for setup in &mut problem.joints {
            setup.encoder_on_drive ^= self.other_encoder;
        }
        Ok(problem)
    }

    fn check(&self, joints: usize, bodies: usize, len: usize) -> Result<(), MechanismError> {
        let all = || self.q.iter().chain(&self.v).chain(&self.a);
        let count = [self.q.len(), self.v.len(), self.a.len()];
        if count.iter().any(|n| *n != joints) || all().any(|series| series.len() != len) {
            return Err(MechanismError::Dynamics {
                episode: "plan".to_owned(),
                reason: format!("q, v and a need {joints} columns and one length"),
            });
        }
        self.dynamics.as_ref().map_or(Ok(()), |own| check_episode(own, "plan", (joints, bodies, len)))
    }
}
