//! Transitions of a simulated object: successive pushes with constant wrenches.

use super::error::BaselineError;
use super::predictor::StateVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trundle_model::{Clock, Model, Plant, State, to_body, to_world};

/// Clock of an object in contact.
const IN_CONTACT: Clock = Clock::since_contact(0.0);

/// One observation: a state, the constant wrench applied from it on, and the state that followed (eq. 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// World pose and twist before, `[m, m, rad, m/s, m/s, rad/s]`.
    pub before: StateVector,
    /// Applied wrench, `[N, N, N·m]`, object axes about the object's origin; it rotates with the object.
    pub wrench: [f64; 3],
    /// Duration, s.
    pub dt: f64,
    /// World pose and twist after.
    pub after: StateVector,
}

/// Settings of the simulated pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pushes {
    /// Duration of each wrench, s. The default of 0.2 s is long against the 0.1 s in which a locked wheel
    /// stops a table, so that an observation shows the effect of friction. Meanwhile the wrench rotates by
    /// less than about 10°, so that an unconstrained object remains nearly linear.
    pub dt: f64,
    /// Number of pushes in an episode, which starts at rest at a random pose.
    pub per_episode: usize,
    /// Standard deviation of the target speed along each axis, m/s: the speed of furniture moved at a walk.
    pub speed: f64,
    /// Standard deviation of the target spin, rad/s.
    pub spin: f64,
    /// Maximum force, N, of one person or a mobile manipulator.
    pub force: f64,
    /// Half the side of the square of initial positions, m.
    pub arena: f64,
    /// Maximum absolute initial heading, rad. A larger range makes a regression in world axes harder.
    pub heading: f64,
}

impl Default for Pushes {
    fn default() -> Self {
        Self { dt: 0.2, per_episode: 10, speed: 0.3, spin: 0.4, force: 150.0, arena: 0.5, heading: 0.5 }
    }
}

/// Unit of the paper's σ per channel, which the paper does not state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SigmaReading {
    /// m, rad, m/s, rad/s.
    Si,
    /// cm, degrees, cm/s, degrees/s.
    CentimetreDegree,
    /// Multiples of the standard deviation of each channel's change `x' − x` over the data.
    OfMotion,
}

impl SigmaReading {
    /// Noise standard deviation of each channel, SI units. `data` are noise-free transitions of the object.
    pub fn sd(self, sigma: f64, data: &[Transition]) -> StateVector {
        match self {
            Self::Si => [sigma; 6],
            Self::CentimetreDegree => {
                let (cm, degree) = (sigma * 0.01, sigma.to_radians());
                [cm, cm, degree, cm, cm, degree]
            }
            Self::OfMotion => change_sd(data).map(|sd| sigma * sd),
        }
    }
}

/// Standard deviation of each channel's change.
fn change_sd(data: &[Transition]) -> StateVector {
    let n = data.len().max(1) as f64;
    std::array::from_fn(|k| {
        let change = |t: &Transition| t.after[k] - t.before[k];
        let mean = data.iter().map(change).sum::<f64>() / n;
        (data.iter().map(|t| (change(t) - mean).powi(2)).sum::<f64>() / n).sqrt()
    })
}

/// Maximum step of the plant within a push, s.
const MAX_STEP_S: f64 = 0.005;

/// State after a constant wrench over `dt` seconds; see [`super::Predictor::predict`].
pub fn hold(plant: &Plant<f64>, x: &StateVector, u: &[f64; 3], dt: f64) -> StateVector {
    let steps = (dt / MAX_STEP_S).ceil().max(1.0);
    let mut state = state(x);
    for _ in 0..steps as usize {
        state = plant.step(&state, *u, IN_CONTACT, dt / steps);
    }
    let ([x, y, heading], [vx, vy, spin]) = (state.pose, state.twist);
    [x, y, heading, vx, vy, spin]
}

fn state(&[x, y, heading, vx, vy, spin]: &StateVector) -> State<f64> {
    State::moving([x, y, heading], [vx, vy, spin])
}

/// First `n` noise-free transitions of a model with all values given. The same seed gives the same
/// transitions, and a larger `n` extends them.
///
/// Each push has a random target twist, like a velocity-controlled gripper. Its wrench would reach the target
/// within `dt` and hold it against friction, limited to the maximum force.
///
/// # Errors
/// When a value of the model is free, or a setting is not positive.
pub fn transitions(
    model: &Model,
    n: usize,
    seed: u64,
    pushes: &Pushes,
) -> Result<Vec<Transition>, BaselineError> {
    pushes.check()?;
    let plant = model.resolved()?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut x = [0.0; 6];
    let mut found = Vec::with_capacity(n);
    for k in 0..n {
        if k % pushes.per_episode == 0 {
            x = pushes.start(model.dof, &mut rng);
        }
        let wrench = pushes.wrench(&plant, model.dof, &x, &mut rng);
        let after = hold(&plant, &x, &wrench, pushes.dt);
        found.push(Transition { before: x, wrench, dt: pushes.dt, after });
        x = after;
    }
    Ok(found)
}

/// The same transitions with normal noise of standard deviation `sd` (SI units) on each channel of the state
/// after. The state before and the wrench stay exact.
#[must_use]
pub fn noisy(data: &[Transition], sd: &StateVector, seed: u64) -> Vec<Transition> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1); // Not the stream of the pushes, should the seeds be equal.
    let mut add = |value: f64, sd: f64| value + sd * normal(&mut rng);
    data.iter().map(|t| Transition { after: std::array::from_fn(|k| add(t.after[k], sd[k])), ..*t }).collect()
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

impl Pushes {
    fn check(&self) -> Result<(), BaselineError> {
        let positive = [("dt", self.dt), ("force", self.force), ("per_episode", self.per_episode as f64)];
        let not_negative =
            [("speed", self.speed), ("spin", self.spin), ("arena", self.arena), ("heading", self.heading)];
        let refuse =
            |name: &str, value, remedy| Err(BaselineError::Value { name: name.to_owned(), value, remedy });
        if let Some((name, value)) = positive.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
            return refuse(name, value, "must be positive");
        }
        match not_negative.into_iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)) {
            Some((name, value)) => refuse(name, value, "must not be negative"),
            None => Ok(()),
        }
    }

    /// A random initial pose at rest.
    fn start(&self, dof: [bool; 3], rng: &mut ChaCha8Rng) -> StateVector {
        let mut uniform = |half: f64, moves: bool| {
            let value = half * (2.0 * rng.random::<f64>() - 1.0);
            if moves { value } else { 0.0 }
        };
        let (x, y) = (uniform(self.arena, dof[0]), uniform(self.arena, dof[1]));
        [x, y, uniform(self.heading, dof[2]), 0.0, 0.0, 0.0]
    }

    fn wrench(&self, plant: &Plant<f64>, dof: [bool; 3], x: &StateVector, rng: &mut ChaCha8Rng) -> [f64; 3] {
        let mut aim = [self.speed, self.speed, self.spin].map(|size| size * normal(rng));
        for (value, moves) in aim.iter_mut().zip(dof) {
            *value *= f64::from(u8::from(moves));
        }
        let now = to_body([x[3], x[4], x[5]], x[2]);
        let accel = [0, 1, 2].map(|k| (aim[k] - now[k]) / self.dt);
        let resistance = resistance(plant, x, aim);
        let inertial = inertial(plant, accel);
        let wrench = [0, 1, 2].map(|k| inertial[k] - resistance[k]);
        let cut = (self.force / wrench[0].hypot(wrench[1]).max(1e-12)).min(1.0);
        wrench.map(|w| cut * w)
    }
}

/// Wrench of the laws at the pose of `x` and a twist in object axes.
fn resistance(plant: &Plant<f64>, x: &StateVector, twist: [f64; 3]) -> [f64; 3] {
    let mut at = state(x);
    at.twist = to_world(twist, x[2]);
    let force = plant.generalised_force(&at, IN_CONTACT);
    let ([xx, xy, yy, xt, yt, tt], [vx, vy, spin]) = (force.damping, twist);
    let drag = [xx * vx + xy * vy + xt * spin, xy * vx + yy * vy + yt * spin, xt * vx + yt * vy + tt * spin];
    [0, 1, 2].map(|k| force.force[k] - drag[k])
}

/// Wrench about the origin that produces an acceleration, object axes.
fn inertial(plant: &Plant<f64>, [ax, ay, turn]: [f64; 3]) -> [f64; 3] {
    let rigid = plant.rigid(IN_CONTACT);
    let [cx, cy] = rigid.com;
    let (fx, fy) = (rigid.mass * (ax - turn * cy), rigid.mass * (ay + turn * cx));
    [fx, fy, rigid.inertia * turn + cx * fy - cy * fx]
}
