//! Joints whose equations an effect at another joint enters.

use crate::laws::JointKind;
use crate::model::{Kind, Nominal, Role, Slot};
use crate::problem::Problem;
use crate::slots::slots;

/// Least share of a joint's effort that a body needs if it is moved by the joint, and least entry of the mass matrix as a share of
/// the joints' own inertias.
const MIN_SHARE: f64 = 1e-6;

/// For each joint, others whose equations its effects enter, and itself.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// Joints that move a body of free mass with it.
    pub by_masses: Vec<Vec<usize>>,
    /// Joints that feel the motion of its link where the encoder is at the drive.
    by_links: Vec<Vec<usize>>,
}

impl Coupling {
    pub fn of(problem: &Problem) -> Self {
        Self { by_masses: by_masses(problem), by_links: by_links(problem) }
    }

    /// Joints whose equations an effect enters by its own parameters or, for a gain, by the masses; `None` if it enters all.
    pub fn acts_on(&self, kind: Kind) -> Option<Vec<usize>> {
        match kind {
            Kind::Joint(JointKind::EffortGain, joint) => Some(self.by_masses[joint].clone()),
            Kind::Joint(kind, joint) if kind.is_compliance() => Some(self.by_links[joint].clone()),
            _ => kind.joint().map(|joint| vec![joint]),
        }
    }
}

fn by_masses(problem: &Problem) -> Vec<Vec<usize>> {
    let free = |slot: &Slot| match slot.role {
        Role::Nominal(Nominal::Mass(body)) => Some(body),
        _ => None,
    };
    let bodies: Vec<usize> = slots(problem, &[]).iter().filter_map(free).collect();
    let moves = |j: usize, body: usize| {
        let least = MIN_SHARE * problem.joints[j].scales.effort / problem.bodies[body].1;
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

fn by_links(problem: &Problem) -> Vec<Vec<usize>> {
    let feels = |i: usize, j: usize| {
        let training = problem.episodes.iter().filter(|episode| !episode.held_out);
        training.filter_map(|episode| episode.dynamics.as_ref()).any(|dynamics| {
            let own = dynamics.own_inertia(i).iter().zip(dynamics.own_inertia(j));
            let both = dynamics.mass_matrix[i][j].iter().zip(own);
            both.into_iter().any(|(shared, (a, b))| shared * shared > MIN_SHARE * MIN_SHARE * a * b)
        })
    };
    let others = |j: usize, i: usize| problem.joints[j].encoder_on_drive && feels(i, j);
    let count = problem.joints.len();
    (0..count).map(|j| (0..count).filter(|i| *i == j || others(j, *i)).collect()).collect()
}
