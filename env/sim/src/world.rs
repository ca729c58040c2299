//! The engine's world: one object on the floor, and what stands around it.
//!
//! The laws of `trundle-model` say what velocity the object gains in a step; the engine gets it as an
//! impulse and carries what touches. Free motion is a leapfrog, half of the impulse before the engine
//! moves the body and half after, which is the trapezoid rule of [`Plant::step`]. What is left is the
//! engine's linearised rotation, `(ω dt/4)³/3` in each quarter step: below 10⁻⁶ rad in 1 s at 2 ms and
//! 3 rad/s. In contact the whole impulse goes first, because the contact solver must answer it.
//!
//! Where a law changes what is moved, the engine's body is weighed anew; the velocity of its origin stays.

use rapier2d_f64::prelude::*;
use serde::{Deserialize, Serialize};
use trundle_model::{Clock, INNER, Model, Plant, Rigid, State};

use crate::SimError;
use crate::gripper::relative;
use crate::object::{hull, obstacle, rigid_body, weight};

/// Before anything has happened.
const BEFORE: Clock = Clock { t: f64::MIN, ..Clock::since_contact(-1.0) };

/// One object among fixed obstacles.
pub struct World {
    engine: PhysicsWorld,
    body: RigidBodyHandle,
    hull: Option<ColliderHandle>,
    plant: Plant<f64>,
    /// What the engine's body is made to weigh.
    rigid: Rigid<f64>,
    /// States of the laws' own.
    inner: [f64; INNER],
}

/// The engine with all that it remembers of contacts, and what hangs on it.
#[derive(Serialize, Deserialize)]
pub(crate) struct Engine {
    world: PhysicsWorld,
    rigid: [f64; 4],
    inner: [f64; INNER],
}

impl Clone for Engine {
    fn clone(&self) -> Self {
        Self { world: copy(&self.world), rigid: self.rigid, inner: self.inner }
    }
}

impl Clone for World {
    fn clone(&self) -> Self {
        Self {
            engine: copy(&self.engine),
            body: self.body,
            hull: self.hull,
            plant: self.plant.clone(),
            rigid: self.rigid,
            inner: self.inner,
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
pub struct Snapshot(pub [f64; 7], pub [f64; INNER]);

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
        let rigid = plant.rigid(BEFORE);
        let body = engine.insert_body(rigid_body(&rigid));
        let hull = hull(&model.body)?.map(|h| engine.insert_collider(placed(h, &plant), Some(body)));
        for (index, polygon) in obstacles.iter().enumerate() {
            engine.insert_collider(obstacle(polygon, index)?, None);
        }
        let PhysicsWorld { bodies, colliders, .. } = &mut engine;
        bodies[body].recompute_mass_properties_from_colliders(colliders);
        Ok(Self { engine, body, hull, plant, rigid, inner: [0.0; INNER] })
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
        self.restore(&Snapshot([x, y, cos, sin, 0.0, 0.0, 0.0], [0.0; INNER]));
    }

    /// Start the laws' own states from these values.
    pub fn start_inner(&mut self, inner: [f64; INNER]) {
        self.inner = inner;
    }

    /// Put the object into a state, weighing what it weighs at that time.
    pub fn put(&mut self, state: &State<f64>, clock: Clock) {
        self.weigh(clock);
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
        Engine { world: copy(&self.engine), rigid: [mass, x, y, inertia], inner: self.inner }
    }

    /// Go on from what a world of the same object and obstacles has saved; exact to the last bit.
    pub(crate) fn load(&mut self, Engine { world, rigid: [mass, x, y, inertia], inner }: Engine) {
        (self.engine, self.inner) = (world, inner);
        self.rigid = Rigid { mass, com: [x, y], inertia };
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
        let after = self.plant.step(&self.state(), applied, clock, self.dt());
        let impulse = self.impulse(&after);
        self.inner = after.inner;
        let first = if self.touching() { 1.0 } else { 0.5 };
        self.kick(impulse, first);
        self.engine.step();
        self.kick(impulse, 1.0 - first);
    }

    /// Whether the object touches an obstacle.
    pub fn touching(&self) -> bool {
        let pairs = self.hull.into_iter().flat_map(|hull| self.engine.narrow_phase.contact_pairs_with(hull));
        pairs.into_iter().any(|pair| pair.has_any_active_contact())
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

/// The outline where the frame that moves is a tracked one, beside the object's own.
fn placed(mut hull: Collider, plant: &Plant<f64>) -> Collider {
    if let Some(mount) = plant.mount() {
        let [x, y, angle] = relative(mount, [0.0; 3]);
        hull.set_position_wrt_parent(Pose::new(Vector::new(x, y), angle));
    }
    hull
}
