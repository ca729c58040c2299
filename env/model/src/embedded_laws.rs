//! The laws of a model as an addition to a rigid body in another simulator.

use crate::law::{Clock, MAX_INNER_STATES, Rigid};
use crate::{Model, ModelError, Plant, State, to_body};

/// The laws of a model that act on the object, one step at a time. The other simulator moves a rigid body without
/// these effects.
///
/// ```
/// use trundle_model::{Body, Clock, EmbeddedLaws, Model, State};
///
/// let square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
/// let body = Body::from_footprint(&square, 3.0)?;
/// let model = Model { effects: vec![], ..Model::nominal(body, Some(3.0), [true; 3]) };
/// let laws = EmbeddedLaws::new(&model)?;
/// let wrench = laws.wrench(&State::at_rest([0.0; 3]), Clock::since_contact(0.0));
/// assert_eq!(wrench, [0.0; 3]);
/// # Ok::<(), trundle_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EmbeddedLaws {
    plant: Plant<f64>,
    /// The model without the laws of the instruments.
    model: Model,
    /// The rigid body of the other simulator: the object after all events.
    body: Rigid<f64>,
    /// Initial values of the laws' inner states.
    initial_inner: Vec<f64>,
}

/// Effect of the laws over a step of a simulator that integrates damping implicitly.
#[derive(Clone, Copy, Debug)]
pub struct EmbeddedStep {
    /// Wrench in addition to the damping, object axes about the object origin, `[N, N, N·m]`.
    pub push: [f64; 3],
    /// Lower triangle of the damping matrix in the same axes.
    pub damping: [f64; 6],
    /// State after the step, with the laws' inner states.
    pub after: State<f64>,
}

impl EmbeddedLaws {
    /// The laws of a model that has a value for every parameter.
    ///
    /// # Errors
    /// If a parameter has no value.
    pub fn new(model: &Model) -> Result<Self, ModelError> {
        let physics = model.clone().without_instruments();
        let plant = physics.resolved()?;
        let after_events = Clock { episode: f64::INFINITY, ..Clock::since_contact(0.0) };
        Ok(Self {
            body: plant.rigid(after_events),
            initial_inner: physics.default_inner(),
            plant,
            model: physics,
        })
    }

    /// Mass properties of the rigid body.
    pub fn body(&self) -> &Rigid<f64> {
        &self.body
    }

    /// Initial values of the laws' inner states.
    pub fn initial_inner(&self) -> &[f64] {
        &self.initial_inner
    }

    /// Initial values of the laws' inner states: the given ones, or the defaults if none are given.
    ///
    /// # Errors
    /// As [`Model::inner_with`].
    pub fn inner_with(&self, given: &[f64]) -> Result<[f64; MAX_INNER_STATES], ModelError> {
        self.model.inner_with(given)
    }

    /// Wrench of all laws at a state, object axes about the object origin, `[N, N, N·m]`.
    pub fn wrench(&self, state: &State<f64>, clock: Clock) -> [f64; 3] {
        self.plant.generalised_force(state, clock).wrench(to_body(state.twist, state.pose[2]))
    }

    /// Effect of the laws over a step under the applied wrench `force`.
    ///
    /// A step `M (v' − v)/dt = push − D v' + force`, in the axes of the object at its beginning, with the same
    /// force ends in the velocity of [`Plant::step`]. With another force, the damping answers as the laws would, to first order.
    pub fn step(&self, state: &State<f64>, force: [f64; 3], clock: Clock, dt: f64) -> EmbeddedStep {
        let after = self.plant.step(state, force, clock, dt);
        let damping = self.plant.generalised_force(&after, clock).damping;
        let heading = state.pose[2];
        let twists = [state.twist, after.twist].map(|twist| to_body(twist, heading));
        let acceleration = [0, 1, 2].map(|k| (twists[1][k] - twists[0][k]) / dt);
        let inertial = self.inertial_wrench(acceleration, twists[0][2]);
        let damped = product(damping, twists[1]);
        EmbeddedStep { push: [0, 1, 2].map(|k| inertial[k] + damped[k] - force[k]), damping, after }
    }

    /// Wrench about the origin, object axes, that causes the acceleration `[x, y, spin]` of the origin.
    fn inertial_wrench(&self, [ax, ay, alpha]: [f64; 3], spin: f64) -> [f64; 3] {
        let Rigid { mass, inertia, com: [x, y] } = self.body;
        let fx = mass * (ax - alpha * y - spin * spin * x);
        let fy = mass * (ay + alpha * x - spin * spin * y);
        [fx, fy, inertia * alpha + x * fy - y * fx]
    }
}

/// Product of a symmetric matrix, given by its lower triangle, with a twist.
fn product([xx, xy, yy, tx, ty, tt]: [f64; 6], [vx, vy, spin]: [f64; 3]) -> [f64; 3] {
    [xx * vx + xy * vy + tx * spin, xy * vx + yy * vy + ty * spin, tx * vx + ty * vy + tt * spin]
}
