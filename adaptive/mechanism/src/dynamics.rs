//! What the nominal mechanism needs along the measured motion: efforts, and their derivatives.

use crate::error::MechanismError;
use crate::simulator::SimulatorSetup;

/// Dynamics along one episode. The outer index is the joint, the last index is the time.
#[derive(Clone, Debug, Default)]
pub struct EpisodeDynamics {
    /// Effort that the model needs at its own parameters, without armature and damping of the joints.
    pub effort: Vec<Vec<f64>>,
    /// Mass matrix without armature: by joint, then by the other joint.
    pub mass_matrix: Vec<Vec<Vec<f64>>>,
    /// Derivative of the effort by each body's mass, whose inertia scales with it: by joint, then by body.
    pub by_mass: Vec<Vec<Vec<f64>>>,
    /// The same of the mass matrix: by joint, then by body, then by the other joint.
    pub matrix_by_mass: Vec<Vec<Vec<Vec<f64>>>>,
    /// Derivative of the effort by each component of gravity, world axes: by joint, then x, y, z.
    pub by_gravity: Vec<[Vec<f64>; 3]>,
    /// Derivative of the effort by a body's mass and a component of gravity together: by joint, then by body, then x, y, z.
    pub by_mass_and_gravity: Vec<Vec<[Vec<f64>; 3]>>,
    /// Derivative of the effort by a point mass on a body, body axes: by joint, then by body, then by m, m·x, m·y, m·z,
    /// m·x², m·y², m·z², m·x·y, m·x·z, m·y·z.
    pub by_payload: Vec<Vec<[Vec<f64>; 10]>>,
    /// The same of the own inertia.
    pub inertia_by_payload: Vec<Vec<[Vec<f64>; 10]>>,
    /// First and second derivative of the effort by the position of another joint: by joint, then by the other joint.
    pub by_offset: Vec<Vec<[Vec<f64>; 2]>>,
    /// Derivative of the effort by the velocity of another joint: by joint, then by the other joint.
    pub by_velocity: Vec<Vec<Vec<f64>>>,
    /// Derivative of the effort by a body's mass and the position of another joint together: by joint, then by body, then by
    /// the other joint.
    pub by_mass_and_offset: Vec<Vec<Vec<Vec<f64>>>>,
    /// Derivative of the effort by each parameter of the user's own simulator: by joint, then by parameter.
    pub by_parameter: Vec<Vec<Vec<f64>>>,
}

impl EpisodeDynamics {
    /// Diagonal of the mass matrix at a joint: its own inertia.
    pub(crate) fn own_inertia(&self, j: usize) -> &Vec<f64> {
        &self.mass_matrix[j][j]
    }
}

/// What the links of a model need at one joint along an episode.
#[derive(Clone, Debug)]
pub(crate) struct InverseDynamics<T> {
    /// Effort, without armature and damping.
    pub effort: Vec<T>,
    /// Own inertia of the joint; `None` if no law reads it.
    pub own_inertia: Option<Vec<T>>,
}

/// A change of the load on an axis without a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLoad {
    /// Factor on its gravity torque.
    pub gravity_factor: f64,
    /// Factor on its inertia.
    pub inertia_factor: f64,
    /// Known added coefficient of sin q in the needed effort, N·m.
    pub gravity_torque: f64,
    /// Known added inertia, kg·m² or kg.
    pub inertia: f64,
    /// Known added effort that the axis needs in every position, N·m or N.
    pub effort: f64,
}

impl Default for AxisLoad {
    fn default() -> Self {
        Self { gravity_factor: 1.0, inertia_factor: 1.0, gravity_torque: 0.0, inertia: 0.0, effort: 0.0 }
    }
}

/// A mechanism from a model file or the user's own simulator: what either computed along the motion.
#[derive(Clone, Debug, Default)]
pub struct Dynamics {
    /// Bodies whose mass may be refitted or loaded.
    pub bodies: Vec<String>,
    /// Their masses, kg.
    pub masses: Vec<f64>,
    /// Armature of each joint in the model.
    pub armature: Vec<f64>,
    /// Damping of each joint in the model.
    pub damping: Vec<f64>,
    /// Dry friction of each joint in the model.
    pub frictionloss: Vec<f64>,
    /// Gravity, world axes, m/s².
    pub gravity: [f64; 3],
    /// Whether each joint is a hinge.
    pub is_hinge: Vec<bool>,
    /// The user's own simulator; `None` for a model file.
    pub simulator: Option<SimulatorSetup>,
    /// One entry for each episode of the recording.
    pub episodes: Vec<EpisodeDynamics>,
}

/// Plausible distance of a payload from the origin of its body, in units of the body's largest lever arm: that of a rod's end
/// from a hinge at its other end is 1.7.
const PAYLOAD_ARMS: f64 = 2.0;

impl Dynamics {
    /// Distance of a payload from the origin of each body that is plausible, m.
    pub(crate) fn farthest_payloads(&self) -> Vec<f64> {
        (0..self.bodies.len()).map(|body| PAYLOAD_ARMS * self.lever_arm(body)).collect()
    }

    /// Largest radius of gyration of a body about the axes of the hinges, m; 1 m if no hinge moves it.
    fn lever_arm(&self, body: usize) -> f64 {
        let radius = |j: usize| {
            let episodes =
                self.episodes.iter().filter_map(|episode| episode.matrix_by_mass.get(j)?.get(body)?.get(j));
            rms_of(episodes.flatten().map(|inertia| inertia.max(0.0).sqrt()))
        };
        let hinges = (0..self.is_hinge.len()).filter(|j| self.is_hinge[*j]);
        let largest = hinges.map(radius).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }
}

/// Root mean square of some values.
pub(crate) fn rms_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The dynamics of an episode, for its name, its number of samples and the number of joints.
///
/// # Errors
/// If there are none, or the sizes differ.
pub(crate) fn checked(
    all: &Dynamics,
    index: usize,
    (name, len): (&str, usize),
    joints: usize,
) -> Result<EpisodeDynamics, MechanismError> {
    let problem =
        |reason: &str| MechanismError::Dynamics { episode: name.to_owned(), reason: reason.to_owned() };
    let own = all.episodes.get(index).ok_or_else(|| problem("there is no entry for it"))?;
    let per_joint = [all.armature.len(), all.damping.len(), all.frictionloss.len(), all.is_hinge.len()];
    if per_joint.iter().any(|n| *n != joints) {
        return Err(problem(WRONG_JOINTS));
    }
    check_episode(own, name, (joints, all.masses.len(), len))?;
    let count = all.simulator.as_ref().map_or(0, |simulator| simulator.parameters.len());
    if count > 0 && (own.by_parameter.len() != joints || own.by_parameter.iter().any(|p| p.len() != count)) {
        return Err(problem("`by_parameter` needs one array for each joint and parameter"));
    }
    Ok(own.clone())
}

const WRONG_JOINTS: &str = "the number of joints differs from the recording's";

/// Check the arrays of an episode for numbers of joints, bodies and samples.
pub(crate) fn check_episode(
    own: &EpisodeDynamics,
    name: &str,
    (joints, bodies, len): (usize, usize, usize),
) -> Result<(), MechanismError> {
    let problem =
        |reason: &str| MechanismError::Dynamics { episode: name.to_owned(), reason: reason.to_owned() };
    let fits = |series: &Vec<f64>| series.len() == len && series.iter().all(|x| x.is_finite());
    let are_square = is_square(&own.mass_matrix, joints)
        && is_square(&own.by_offset, joints)
        && is_square(&own.by_velocity, joints);
    if own.effort.len() != joints || !are_square {
        return Err(problem(WRONG_JOINTS));
    }
    let by_parameter = own.by_parameter.iter().flatten();
    let by_body = own.by_mass.iter().flatten().chain(own.matrix_by_mass.iter().flatten().flatten());
    let by_body = by_body.chain(own.by_payload.iter().chain(&own.inertia_by_payload).flatten().flatten());
    let by_body = by_body.chain(own.by_mass_and_gravity.iter().flatten().flatten());
    let by_body = by_body.chain(own.by_mass_and_offset.iter().flatten().flatten());
    let by_body = by_body.chain(own.by_velocity.iter().flatten());
    let others = own.by_gravity.iter().flatten().chain(own.by_offset.iter().flatten().flatten());
    if !own
        .effort
        .iter()
        .chain(own.mass_matrix.iter().flatten())
        .chain(by_body)
        .chain(others)
        .chain(by_parameter)
        .all(fits)
    {
        return Err(problem(
            "an array has another length than the motion, or contains a value that is not finite",
        ));
    }
    if own.by_mass.len() != joints || own.by_mass.iter().any(|of_joint| of_joint.len() != bodies) {
        return Err(problem("`by_mass` needs one array for each joint and body"));
    }
    Ok(())
}

/// Whether there is an entry for every pair of joints.
fn is_square<T>(rows: &[Vec<T>], joints: usize) -> bool {
    rows.len() == joints && rows.iter().all(|row| row.len() == joints)
}
