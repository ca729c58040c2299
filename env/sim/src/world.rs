//! A physics-engine world with one object on the floor among fixed obstacles.
//!
//! The laws of `trundle-model` determine the change of velocity in a step, which the engine receives as an impulse.
//!
//! - Without contact, half of the impulse is applied before the engine step, so that the body meets obstacles in its way.
//!   If there is still no contact after the step, the body is set to the state that the laws predict, because the engine
//!   linearises rotation.
//! - In contact, the whole impulse is applied first, because the contact solver must react to it.
//!
//! If a law changes the mass properties, the engine's body is updated. The velocity of its origin stays the same.

use rapier2d_f64::prelude::*;
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, LinearPropagator, MAX_INNER_STATES, Model, Plant, Rigid, State};

use crate::SimError;
use crate::colliders::{in_tracked_frame, mass_properties, object_colliders, obstacle_colliders, rigid_body};

/// Clock before contact.
const PRECONTACT_CLOCK: Clock = Clock { t: f64::MIN, ..Clock::since_contact(-1.0) };

/// One object among fixed obstacles.
pub struct World {
    engine: PhysicsWorld,
    body: RigidBodyHandle,
    plant: Plant<f64>,
    /// Current mass properties of the engine's body.
    rigid: Rigid<f64>,
    /// Internal states of the laws.
    inner: [f64; MAX_INNER_STATES],
    /// Precomputed step of the laws, if the model is linear.
    propagator: Option<LinearPropagator>,
    /// Whether the object touched an obstacle in the last step.
    touching: bool,
}

/// Saved state of a world, including the engine's contact data.
#[derive(Serialize, Deserialize)]
pub(crate) struct EngineState {
    world: PhysicsWorld,
    rigid: [f64; 4],
    inner: [f64; MAX_INNER_STATES],
    touching: bool,
}

impl Clone for EngineState {
    fn clone(&self) -> Self {
        Self { world: copy_engine(&self.world), ..*self }
    }
}

impl Clone for World {
    fn clone(&self) -> Self {
        Self {
            engine: copy_engine(&self.engine),
            body: self.body,
            plant: self.plant.clone(),
            rigid: self.rigid,
            inner: self.inner,
            propagator: self.propagator,
            touching: self.touching,
        }
    }
}

/// A copy that continues identically. It omits the engine's workspaces.
fn copy_engine(engine: &PhysicsWorld) -> PhysicsWorld {
    PhysicsWorld {
        gravity: engine.gravity,
        integration_parameters: engine.integration_parameters,
        islands: engine.islands.clone(),
        broad_phase: engine.broad_phase.clone(),
        narrow_phase: engine.narrow_phase.clone(),
        bodies: engine.bodies.clone(),
        colliders: engine.colliders.clone(),
        ..PhysicsWorld::default()
    }
}

/// Exact motion state: position, cosine and sine of the heading, and velocities of the mass centre; then the internal
/// states of the laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot(pub [f64; 7], pub [f64; MAX_INNER_STATES]);

impl World {
    /// A world with the object at rest at the origin. `obstacles` are simple polygons, m, world frame;
    /// `dt` is the step, s.
    ///
    /// # Errors
    /// If a parameter of the model has no value, or a shape is not a simple polygon.
    pub fn new(model: &Model, obstacles: &[Vec<[f64; 2]>], dt: f64) -> Result<Self, SimError> {
        let plant = model.resolved()?;
        let mut engine = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        engine.integration_parameters.dt = dt;
        configure_solver(&mut engine.integration_parameters);
        let rigid = plant.rigid(PRECONTACT_CLOCK);
        let body = engine.insert_body(rigid_body(&rigid));
        for piece in object_colliders(&model.body)? {
            engine.insert_collider(in_tracked_frame(piece, &plant), Some(body));
        }
        for (index, polygon) in obstacles.iter().enumerate() {
            for piece in obstacle_colliders(polygon, index)? {
                engine.insert_collider(piece, None);
            }
        }
        let PhysicsWorld { bodies, colliders, .. } = &mut engine;
        bodies[body].recompute_mass_properties_from_colliders(colliders);
        let propagator = plant.linear_propagator(dt);
        Ok(Self { engine, body, plant, rigid, inner: [0.0; MAX_INNER_STATES], propagator, touching: false })
    }

    /// The plant: laws and mass properties.
    pub fn plant(&self) -> &Plant<f64> {
        &self.plant
    }

    /// Mass properties as of the last step.
    pub fn rigid(&self) -> &Rigid<f64> {
        &self.rigid
    }

    /// Step length, s.
    pub fn dt(&self) -> f64 {
        self.engine.integration_parameters.dt
    }

    /// Set the step length, s.
    pub(crate) fn set_dt(&mut self, dt: f64) {
        if dt == self.dt() {
            return;
        }
        self.propagator = self.plant.linear_propagator(dt);
        self.engine.integration_parameters.dt = dt;
    }

    /// Pose and twist of the object frame, with the heading in (−π, π], and the internal states of the laws.
    pub fn state(&self) -> State<f64> {
        let body = self.body();
        let (position, rotation) = (body.translation(), body.rotation());
        let (velocity, spin) = (body.linvel(), body.angvel());
        let com_offset = body.center_of_mass() - position;
        State::moving(
            [position.x, position.y, rotation.angle()],
            [velocity.x + spin * com_offset.y, velocity.y - spin * com_offset.x, spin],
        )
        .with_inner(self.inner)
    }

    /// Place the object at rest at a pose `[m, m, rad]`, with the internal states at zero.
    pub fn place(&mut self, [x, y, theta]: [f64; 3]) {
        let (sin, cos) = theta.sin_cos();
        self.restore(&Snapshot([x, y, cos, sin, 0.0, 0.0, 0.0], [0.0; MAX_INNER_STATES]));
    }

    /// Set the internal states of the laws.
    pub fn set_inner(&mut self, inner: [f64; MAX_INNER_STATES]) {
        self.inner = inner;
    }

    /// Set the state of the object, with the mass properties at this time.
    pub fn set_state(&mut self, state: &State<f64>, clock: Clock) {
        self.update_mass(clock);
        self.set_motion(state);
    }

    fn set_motion(&mut self, state: &State<f64>) {
        let ([x, y, heading], [vx, vy, spin]) = (state.pose, state.twist);
        let (sin, cos) = heading.sin_cos();
        let [ax, ay] = self.com_offset(cos, sin);
        self.restore(&Snapshot([x, y, cos, sin, vx - spin * ay, vy + spin * ax, spin], state.inner));
    }

    /// The motion state.
    pub fn snapshot(&self) -> Snapshot {
        let body = self.body();
        let (p, r, v) = (body.translation(), body.rotation(), body.linvel());
        Snapshot([p.x, p.y, r.re, r.im, v.x, v.y, body.angvel()], self.inner)
    }

    /// The complete state, including contacts.
    pub(crate) fn save(&self) -> EngineState {
        let Rigid { mass, com: [x, y], inertia } = self.rigid;
        let (world, inner, touching) = (copy_engine(&self.engine), self.inner, self.touching);
        EngineState { world, rigid: [mass, x, y, inertia], inner, touching }
    }

    /// Restore the state saved by a world with the same object and obstacles, bit for bit.
    pub(crate) fn load(&mut self, saved: EngineState) {
        let EngineState { world, rigid: [mass, x, y, inertia], inner, touching } = saved;
        (self.engine, self.inner, self.touching) = (world, inner, touching);
        self.rigid = Rigid { mass, com: [x, y], inertia };
        self.propagator = self.plant.linear_propagator(self.dt());
    }

    /// Restore a snapshot. The motion that follows repeats bit for bit as long as there is no contact.
    pub fn restore(&mut self, Snapshot([x, y, cos, sin, vx, vy, spin], inner): &Snapshot) {
        self.inner = *inner;
        let body = &mut self.engine.bodies[self.body];
        let rotation = Rotation::from_cos_sin_unchecked(*cos, *sin);
        body.set_position(Pose::from_parts(Vector::new(*x, *y), rotation), true);
        body.set_linvel(Vector::new(*vx, *vy), true);
        body.set_angvel(*spin, true);
    }

    /// Advance one step under `applied`, the mean wrench on the object over the step, object axes about the object origin
    /// `[N, N, N·m]`.
    pub fn step(&mut self, applied: [f64; 3], clock: Clock) {
        self.update_mass(clock);
        let mut after = self.state();
        match &self.propagator {
            Some(propagator) => propagator.step_in_place(&mut after, &applied),
            None => self.plant.step_in_place(&mut after, &applied, clock, self.dt()),
        }
        let impulse = self.impulse(&after);
        self.inner = after.inner;
        let first = if self.touching { 1.0 } else { 0.5 };
        self.apply_impulse(impulse, first);
        self.engine.step();
        self.touching = self.detect_contact();
        if self.touching || first == 1.0 {
            self.apply_impulse(impulse, 1.0 - first);
        } else {
            self.set_motion(&after);
        }
    }

    /// Whether the object touched an obstacle in the last step.
    pub fn is_touching(&self) -> bool {
        self.touching
    }

    /// Impulse of obstacles on the object in the last step: the sum of all magnitudes, N·s.
    pub fn contact_impulse(&self) -> f64 {
        let pairs = self.engine.narrow_phase.contact_pairs();
        let active = pairs.filter(|pair| pair.has_any_active_contact());
        active.map(|pair| pair.total_impulse_magnitude()).sum()
    }

    fn detect_contact(&self) -> bool {
        // Only the object moves, so every contact involves it.
        self.engine.narrow_phase.contact_pairs().any(|pair| pair.has_any_active_contact())
    }

    /// Kinetic energy, J.
    pub fn energy(&self) -> f64 {
        self.body().kinetic_energy()
    }

    /// Change of momentum in one step due to the laws and the applied wrench: `[N·s, N·s, N·m·s]`, world axes about the
    /// mass centre.
    fn impulse(&self, after: &State<f64>) -> [f64; 3] {
        let (sin, cos) = after.pose[2].sin_cos();
        let com_offset = self.com_offset(cos, sin);
        let [vx, vy, spin] = after.twist;
        let (body, Rigid { mass, inertia, .. }) = (self.body(), self.rigid);
        [
            mass * (vx - spin * com_offset[1] - body.linvel().x),
            mass * (vy + spin * com_offset[0] - body.linvel().y),
            inertia * (spin - body.angvel()),
        ]
    }

    /// Vector from the object origin to the mass centre, world axes, m.
    fn com_offset(&self, cos: f64, sin: f64) -> [f64; 2] {
        let [cx, cy] = self.rigid.com;
        [cos * cx - sin * cy, sin * cx + cos * cy]
    }

    /// Update the mass properties of the engine's body to those of the laws.
    fn update_mass(&mut self, clock: Clock) {
        let rigid = self.plant.rigid(clock);
        let numbers = |r: &Rigid<f64>| [r.mass, r.com[0], r.com[1], r.inertia];
        if numbers(&rigid) == numbers(&self.rigid) {
            return;
        }
        let twist = self.state().twist;
        self.rigid = rigid;
        let PhysicsWorld { bodies, colliders, .. } = &mut self.engine;
        let body = &mut bodies[self.body];
        body.set_additional_mass_properties(mass_properties(&rigid), true);
        body.recompute_mass_properties_from_colliders(colliders);
        let (rotation, [vx, vy, spin]) = (*body.rotation(), twist);
        let [ax, ay] = self.com_offset(rotation.re, rotation.im);
        self.engine.bodies[self.body].set_linvel(Vector::new(vx - spin * ay, vy + spin * ax), true);
    }

    fn apply_impulse(&mut self, [px, py, spin]: [f64; 3], share: f64) {
        let body = &mut self.engine.bodies[self.body];
        body.apply_impulse(Vector::new(px * share, py * share), true);
        body.apply_torque_impulse(spin * share, true);
    }

    fn body(&self) -> &RigidBody {
        &self.engine.bodies[self.body]
    }
}

/// Configure the solver for few but accurate contacts.
///
/// - A recycled contact keeps its position until a body has moved by 5 cm, so recycling is off.
/// - A corner that hits an obstacle with friction bounces unless normal and friction forces are solved together in
///   several iterations.
/// - The steps are short, so one solver iteration suffices.
fn configure_solver(parameters: &mut IntegrationParameters) {
    parameters.contact_recycling = false;
    parameters.num_solver_iterations = 1;
    parameters.num_internal_stabilization_iterations = 4;
}
