//! A filtered episode as a linear system.

use super::Filter;
use super::response::{Response, Stage};
use crate::Track;
use nalgebra::{Matrix3, Vector3};
use trundle_model::transport;

impl<const N: usize, const D: usize> Filter<N, D> {
    /// The episode as a linear system; `None` if a number is not finite.
    pub(super) fn linear(&self, track: &Track) -> Option<Response> {
        let (mut stages, mut innovations) = (Vec::with_capacity(track.steps.len()), Vec::new());
        let (mut middles, mut durations) = (Vec::new(), Vec::new());
        let mut belief = self.initial_belief(track, &self.initial_inner(track)?);
        let mut t = track.start;
        for step in &track.steps {
            let transition = self.predict(&mut belief, step, &track.curve);
            middles.push(t + step.dt / 2.0);
            durations.push(step.dt);
            t += step.dt;
            let mut seen = None;
            if let Some(pose) = step.pose {
                let innovation = self.observe(&belief, t, pose, step)?;
                innovations.extend((innovation.whitener * innovation.error).iter());
                seen = Some((innovation.gain, innovation.whitener));
                self.update(&mut belief, &innovation);
            }
            stages.push(Stage { transition, error_map: error_map(step.frame)?, seen });
        }
        Some(Response { system: Box::new(stages), innovations, t: middles, dt: durations })
    }
}

/// Map from a wrench on the object to the error of the reading, which has the opposite sign, in reading axes.
fn error_map(frame: [f64; 3]) -> Option<Matrix3<f64>> {
    let columns = [0, 1, 2].map(|k| {
        let mut unit = [0.0; 3];
        unit[k] = -1.0;
        Vector3::from(transport(unit, frame))
    });
    Matrix3::from_columns(&columns).try_inverse()
}
