//! The engine's world: one object on the floor, and what stands around it.
//!
//! The laws of `trundle-model` say what velocity the object gains in a step; the engine gets it as an impulse and
//! carries what touches. While nothing does, half of the impulse goes before the engine moves the body, so that it meets
//! what is in its way; if nothing was, the body is put where the laws alone take it, for the engine's rotation is
//! linearised. In contact the whole impulse goes first, because the contact solver must answer it.
//!
//! Where a law changes what is moved, the engine's body is weighed anew; the velocity of its origin stays.

use rapier2d_f64::prelude::*;
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, LinearPropagator, MAX_INNER_STATES, Model, Plant, Rigid, State};

use crate::SimError;
use crate::gripper::relative;
use crate::object::{hull, obstacle, rigid_body, weight};

/// Before anything has happened.
const BEFORE: Clock = Clock { t: f64::MIN, ..Clock::since_contact(-1.0) };

/// One object among fixed obstacles.
pub struct World {
    engine: PhysicsWorld,
    body: RigidBodyHandle,
    plant: Plant<f64>,
    /// What the engine's body is made to weigh.
    rigid: Rigid<f64>,
    /// States of the laws' own.
    inner: [f64; MAX_INNER_STATES],
    /// The laws' step where it can be solved beforehand.
    propagator: Option<LinearPropagator>,
    /// Whether it touched an obstacle in the last step.
    touches: bool,
}

/// The engine with all that it remembers of contacts, and what hangs on it.
#[derive(Serialize, Deserialize)]
pub(crate) struct Engine {
    world: PhysicsWorld,
    rigid: [f64; 4],
    inner: [f64; MAX_INNER_STATES],
    touches: bool,
}

impl Clone for Engine {
    fn clone(&self) -> Self {
        Self { world: copy(&self.world), ..*self }
    }
}

impl Clone for World {
    fn clone(&self) -> Self {
        Self {
            engine: copy(&self.engine),
            body: self.body,
            plant: self.plant.clone(),
            rigid: self.rigid,
            inner: self.inner,
            propagator: self.propagator,
            touches: self.touches,
        }
    }
}

/// A copy that goes on alike: what is left out are workspaces.
fn copy(engine: &PhysicsWorld) -> PhysicsWorld {
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

/// All that moves, to the last bit: position, cosine and sine of the heading, and velocities of the
/// mass centre; and the laws' own states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot(pub [f64; 7], pub [f64; MAX_INNER_STATES]);

impl World {
    /// A world with the object at rest at the origin. `obstacles` are simple polygons, m, world frame;
    /// `dt` is the step, s.
    ///
    /// # Errors
    /// When a parameter of the model has no value, or a shape is no simple polygon.
    pub fn new(model: &Model, obstacles: &[Vec<[f64; 2]>], dt: f64) -> Result<Self, SimError> {
        let plant = model.resolved()?;
        let mut engine = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        engine.integration_parameters.dt = dt;
        tune(&mut engine.integration_parameters);
        let rigid = plant.rigid(BEFORE);
        let body = engine.insert_body(rigid_body(&rigid));
        for piece in hull(&model.body)? {
            engine.insert_collider(placed(piece, &plant), Some(body));
        }
        for (index, polygon) in obstacles.iter().enumerate() {
            for piece in obstacle(polygon, index)? {
                engine.insert_collider(piece, None);
            }
        }
        let PhysicsWorld { bodies, colliders, .. } = &mut engine;
        bodies[body].recompute_mass_properties_from_colliders(colliders);
        let propagator = plant.linear_propagator(dt);
        Ok(Self { engine, body, plant, rigid, inner: [0.0; MAX_INNER_STATES], propagator, touches: false })
    }

    /// The laws and the mass.
    pub fn plant(&self) -> &Plant<f64> {
        &self.plant
    }

    /// What moves as one, as of the last step.
    pub fn rigid(&self) -> &Rigid<f64> {
        &self.rigid
    }

    /// The step, s.
    pub fn dt(&self) -> f64 {
        self.engine.integration_parameters.dt
    }

    /// Change the step, s.
    pub(crate) fn set_dt(&mut self, dt: f64) {
        if dt == self.dt() {
            return;
        }
        self.propagator = self.plant.linear_propagator(dt);
        self.engine.integration_parameters.dt = dt;
    }

    /// Pose and twist of the object frame, the heading in (−π, π], and the laws' own states.
    pub fn state(&self) -> State<f64> {
        let body = self.body();
        let (position, rotation) = (body.translation(), body.rotation());
        let (velocity, spin) = (body.linvel(), body.angvel());
        let arm = body.center_of_mass() - position;
        State::moving(
            [position.x, position.y, rotation.angle()],
            [velocity.x + spin * arm.y, velocity.y - spin * arm.x, spin],
        )
        .with_inner(self.inner)
    }

    /// Put the object at rest at a pose `[m, m, rad]`, the laws' own states at zero.
    pub fn place(&mut self, [x, y, theta]: [f64; 3]) {
        let (sin, cos) = theta.sin_cos();
        self.restore(&Snapshot([x, y, cos, sin, 0.0, 0.0, 0.0], [0.0; MAX_INNER_STATES]));
    }

    /// Start the laws' own states from these values.
    pub fn start_inner(&mut self, inner: [f64; MAX_INNER_STATES]) {
        self.inner = inner;
    }

    /// Put the object into a state, weighing what it weighs at that time.
    pub fn put(&mut self, state: &State<f64>, clock: Clock) {
        self.weigh(clock);
        self.set(state);
    }

    fn set(&mut self, state: &State<f64>) {
        let ([x, y, heading], [vx, vy, spin]) = (state.pose, state.twist);
        let (sin, cos) = heading.sin_cos();
        let [ax, ay] = self.arm(cos, sin);
        self.restore(&Snapshot([x, y, cos, sin, vx - spin * ay, vy + spin * ax, spin], state.inner));
    }

    /// All that moves.
    pub fn snapshot(&self) -> Snapshot {
        let body = self.body();
        let (p, r, v) = (body.translation(), body.rotation(), body.linvel());
        Snapshot([p.x, p.y, r.re, r.im, v.x, v.y, body.angvel()], self.inner)
    }

    /// The engine as it is, contacts included.
    pub(crate) fn save(&self) -> Engine {
        let Rigid { mass, com: [x, y], inertia } = self.rigid;
        let (world, inner, touches) = (copy(&self.engine), self.inner, self.touches);
        Engine { world, rigid: [mass, x, y, inertia], inner, touches }
    }

    /// Go on from what a world of the same object and obstacles has saved; exact to the last bit.
    pub(crate) fn load(&mut self, saved: Engine) {
        let Engine { world, rigid: [mass, x, y, inertia], inner, touches } = saved;
        (self.engine, self.inner, self.touches) = (world, inner, touches);
        self.rigid = Rigid { mass, com: [x, y], inertia };
        self.propagator = self.plant.linear_propagator(self.dt());
    }

    /// Go back to a snapshot; what follows is the same to the last bit as long as nothing touched.
    pub fn restore(&mut self, Snapshot([x, y, cos, sin, vx, vy, spin], inner): &Snapshot) {
        self.inner = *inner;
        let body = &mut self.engine.bodies[self.body];
        let rotation = Rotation::from_cos_sin_unchecked(*cos, *sin);
        body.set_position(Pose::from_parts(Vector::new(*x, *y), rotation), true);
        body.set_linvel(Vector::new(*vx, *vy), true);
        body.set_angvel(*spin, true);
    }

    /// One step under `applied`, the mean wrench on the object over the step, object axes about the
    /// object origin `[N, N, N·m]`.
    pub fn step(&mut self, applied: [f64; 3], clock: Clock) {
        self.weigh(clock);
        let mut after = self.state();
        match &self.propagator {
            Some(propagator) => propagator.step_in_place(&mut after, &applied),
            None => self.plant.step_in_place(&mut after, &applied, clock, self.dt()),
        }
        let impulse = self.impulse(&after);
        self.inner = after.inner;
        let first = if self.touches { 1.0 } else { 0.5 };
        self.kick(impulse, first);
        self.engine.step();
        self.touches = self.in_contact();
        if self.touches || first == 1.0 {
            self.kick(impulse, 1.0 - first);
        } else {
            self.set(&after);
        }
    }

    /// Whether the object touched an obstacle in the last step.
    pub fn touching(&self) -> bool {
        self.touches
    }

    fn in_contact(&self) -> bool {
        // Nothing but the object moves, so that whatever is in contact is so with it.
        self.engine.narrow_phase.contact_pairs().any(|pair| pair.has_any_active_contact())
    }

    /// Kinetic energy, J.
    pub fn energy(&self) -> f64 {
        self.body().kinetic_energy()
    }

    /// What the laws and the applied wrench add to the momentum in one step: `[N·s, N·s, N·m·s]`,
    /// world axes, about the mass centre.
    fn impulse(&self, after: &State<f64>) -> [f64; 3] {
        let (sin, cos) = after.pose[2].sin_cos();
        let arm = self.arm(cos, sin);
        let [vx, vy, spin] = after.twist;
        let (body, Rigid { mass, inertia, .. }) = (self.body(), self.rigid);
        [
            mass * (vx - spin * arm[1] - body.linvel().x),
            mass * (vy + spin * arm[0] - body.linvel().y),
            inertia * (spin - body.angvel()),
        ]
    }

    /// From the object's origin to the mass centre, world axes, m.
    fn arm(&self, cos: f64, sin: f64) -> [f64; 2] {
        let [cx, cy] = self.rigid.com;
        [cos * cx - sin * cy, sin * cx + cos * cy]
    }

    /// Make the engine's body weigh what the laws say.
    fn weigh(&mut self, clock: Clock) {
        let rigid = self.plant.rigid(clock);
        let numbers = |r: &Rigid<f64>| [r.mass, r.com[0], r.com[1], r.inertia];
        if numbers(&rigid) == numbers(&self.rigid) {
            return;
        }
        let twist = self.state().twist;
        self.rigid = rigid;
        let PhysicsWorld { bodies, colliders, .. } = &mut self.engine;
        let body = &mut bodies[self.body];
        body.set_additional_mass_properties(weight(&rigid), true);
        body.recompute_mass_properties_from_colliders(colliders);
        let (rotation, [vx, vy, spin]) = (*body.rotation(), twist);
        let [ax, ay] = self.arm(rotation.re, rotation.im);
        self.engine.bodies[self.body].set_linvel(Vector::new(vx - spin * ay, vy + spin * ax), true);
    }

    fn kick(&mut self, [px, py, spin]: [f64; 3], share: f64) {
        let body = &mut self.engine.bodies[self.body];
        body.apply_impulse(Vector::new(px * share, py * share), true);
        body.apply_torque_impulse(spin * share, true);
    }

    fn body(&self) -> &RigidBody {
        &self.engine.bodies[self.body]
    }
}

/// For few contacts that are right, where the engine's defaults are for many that look right. A recycled contact stays
/// where it was until something has moved by 5 cm; a corner that hits with friction bounces, unless normal and friction
/// are solved together a few times. Steps being short, they need not be divided.
fn tune(parameters: &mut IntegrationParameters) {
    parameters.contact_recycling = false;
    parameters.num_solver_iterations = 1;
    parameters.num_internal_stabilization_iterations = 4;
}

/// A piece of the outline where the frame that moves is a tracked one, beside the object's own.
fn placed(mut piece: Collider, plant: &Plant<f64>) -> Collider {
    if let Some(mount) = plant.mount() {
        let [x, y, angle] = relative(mount, [0.0; 3]);
        piece.set_position_wrt_parent(Pose::new(Vector::new(x, y), angle) * *piece.position());
    }
    piece
}
