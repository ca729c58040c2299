//! Motion of links behind a play or an elastic transmission, where the encoder is at the drive.
//!
//! The link's motion is not the measured one. The difference enters the efforts of the other joints through the mass matrix and
//! the derivatives by position and velocity.

use crate::backlash::{Side, SideMotion, unmeasured_side};
use crate::deflection::{Deflection, Unmeasured, deflections};
use crate::dynamics::{EpisodeDynamics, InverseDynamics};
use crate::equation::JointModel;
use crate::model::{Effect, Kind, Slot};
use crate::problem::{EpisodeData, Problem};
use crate::shared_parameters::{coupling, inverse_dynamics};
use crate::signals;

/// Motion of a link relative to the measured one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkMotion {
    pub position: f64,
    pub velocity: f64,
    pub acceleration: f64,
}

/// What a model needs at joint `j` in an episode, for given values; `None` without a model. The motion of
/// links that are not at their measured positions is included.
pub(crate) fn inverse_dynamics_at(
    problem: &Problem,
    episode: &EpisodeData,
    j: usize,
    known: (&[Effect], &[Slot], &[f64]),
    wants_inertia: bool,
) -> Option<InverseDynamics<f64>> {
    let dynamics = episode.dynamics.as_ref()?;
    let mut found = inverse_dynamics(problem, dynamics, j, known, wants_inertia);
    for other in (0..problem.joints.len()).filter(|other| *other != j) {
        let Some(motion) = link_motion(problem, (episode, dynamics), other, known) else { continue };
        let inertia = coupling(problem, dynamics, [j, other], (known.1, known.2));
        let ([slope, curvature], damping) = (&dynamics.by_offset[j][other], &dynamics.by_velocity[j][other]);
        for (k, link) in motion.iter().enumerate() {
            found.effort[k] += inertia[k] * link.acceleration
                + damping[k] * link.velocity
                + (slope[k] + 0.5 * curvature[k] * link.position) * link.position;
        }
    }
    Some(found)
}

/// Motion of the link of joint `j` relative to the measured one; `None` if they are the same.
fn link_motion(
    problem: &Problem,
    (episode, dynamics): (&EpisodeData, &EpisodeDynamics),
    j: usize,
    known: (&[Effect], &[Slot], &[f64]),
) -> Option<Vec<LinkMotion>> {
    let (effects, slots, values) = known;
    let is_compliant = |effect: &Effect| match effect.kind {
        Kind::Joint(kind, joint) => joint == j && kind.is_compliance(),
        _ => false,
    };
    if !problem.joints[j].encoder_on_drive || !effects.iter().any(is_compliant) {
        return None;
    }
    let model = JointModel::new(problem, j, effects, slots, |slot| values[slot]);
    let InverseDynamics { effort, own_inertia } = inverse_dynamics(problem, dynamics, j, known, true);
    let (inertia, series) = (own_inertia?, &episode.joints[j]);
    let others = episode.first_stage.filtered(&series.known);
    let (q, dt, stiffness) = (&series.q, episode.dt, &dynamics.by_offset[j][j][0]);
    let side = |k: usize| Unmeasured { inertia: inertia[k], damping: 0.0, stiffness: stiffness[k] };
    if let Some(compliance) = model.compliance() {
        let rigid: Vec<f64> = effort.iter().zip(&others).map(|(effort, known)| effort - known).collect();
        let found = deflections(&rigid, compliance, &side, dt);
        let one = |state: &Deflection<f64>| LinkMotion {
            position: -state.position,
            velocity: -state.velocity,
            acceleration: -state.acceleration,
        };
        return Some(found.iter().map(one).collect());
    }
    let free = |k: usize| Side {
        effort: inertia[k] * series.a[k] - effort[k] + others[k],
        friction: 0.0,
        resistance: side(k),
    };
    let found = unmeasured_side(q, model.gap()?, dt, &free);
    let one = |(k, motion): (usize, &SideMotion<f64>)| LinkMotion {
        position: motion.position - q[k],
        velocity: motion.velocity - signals::slope(q, k, dt),
        acceleration: motion.acceleration - signals::curvature(q, k, dt),
    };
    Some(found.iter().enumerate().map(one).collect())
}
