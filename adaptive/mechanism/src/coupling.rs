//! Joints that are coupled by the free masses of bodies that they move.

use crate::laws::JointKind;
use crate::model::{Kind, Nominal, Role, slots};
use crate::problem::Problem;

/// Least share of a joint's effort that a body needs if it is moved by the joint.
const MIN_BODY_SHARE: f64 = 1e-6;

/// For each joint, the joints that move a body of free mass with it, and itself.
pub(crate) fn coupled_joints(problem: &Problem) -> Vec<Vec<usize>> {
    let free = |slot: &crate::model::Slot| match slot.role {
        Role::Nominal(Nominal::Mass(body)) => Some(body),
        _ => None,
    };
    let bodies: Vec<usize> = slots(problem, &[]).iter().filter_map(free).collect();
    let moves = |j: usize, body: usize| {
        let least = MIN_BODY_SHARE * problem.joints[j].scales.effort / problem.bodies[body].1;
        let training = problem.episodes.iter().filter(|episode| !episode.held_out);
        training
            .filter_map(|episode| episode.dynamics.as_ref())
            .any(|dynamics| dynamics.by_mass[j][body].iter().any(|effort| effort.abs() > least))
    };
    let count = problem.joints.len();
    let moved: Vec<Vec<bool>> =
        (0..count).map(|j| bodies.iter().map(|body| moves(j, *body)).collect()).collect();
    let share_body = |i: usize, j: usize| moved[i].iter().zip(&moved[j]).any(|(a, b)| *a && *b);
    (0..count).map(|i| (0..count).filter(|j| *j == i || share_body(i, *j)).collect()).collect()
}

/// Joints whose equations an effect enters by its own parameters or, for a gain, by the masses; `None` if it enters all.
/// `coupled` as by [`coupled_joints`].
pub(crate) fn acts_on(coupled: &[Vec<usize>], kind: Kind) -> Option<Vec<usize>> {
    match kind {
        Kind::Joint(JointKind::EffortGain, joint) => Some(coupled[joint].clone()),
        _ => kind.joint().map(|joint| vec![joint]),
    }
}
