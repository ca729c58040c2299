//! What moves an object among fixed obstacles: the laws alone while nothing is within reach, else the engine.
//!
//! Where nothing is near both agree (`tests/world.rs`), and the laws alone are an order of magnitude faster.

use std::sync::Arc;

use trundle_model::{Clock, LinearPropagator, MAX_INNER_STATES, Model, Plant, Rigid, State};

use crate::contact::{MARGIN, nearest, reach};
use crate::gripper::wrap;
use crate::world::Engine;
use crate::{SimError, World};

/// Longest step of the engine, s.
const STEP: f64 = 0.002;

/// Once so much farther than it need be from all obstacles the object is the laws' again, m: not to and fro.
const SLACK: f64 = 0.01;

/// One object among fixed obstacles, in motion.
#[derive(Clone)]
pub struct Mover {
    model: Arc<Model>,
    plant: Arc<Plant<f64>>,
    /// The plant's step of the length last asked for, where it can be solved beforehand.
    propagator: Option<(f64, LinearPropagator)>,
    obstacles: Arc<Vec<Vec<[f64; 2]>>>,
    /// How far the outline reaches from the object's origin, m.
    radius: f64,
    state: State<f64>,
    /// How far it may yet travel before an obstacle can be within reach, m.
    clear: f64,
    /// Made when something first comes near.
    engine: Option<Box<World>>,
    /// Whether the engine has it.
    engaged: bool,
}

/// What of a [`Mover`] changes.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Motion {
    state: [[f64; 3]; 2],
    inner: [f64; MAX_INNER_STATES],
    clear: f64,
    engine: Option<Engine>,
    engaged: bool,
}

impl Mover {
    /// An object at rest at the origin among simple polygons, m, world frame.
    ///
    /// # Errors
    /// When a parameter of the model has no value, or a shape is no simple polygon.
    pub fn new(model: Model, obstacles: Vec<Vec<[f64; 2]>>) -> Result<Self, SimError> {
        for (index, polygon) in obstacles.iter().enumerate() {
            crate::object::obstacle(polygon, index)?;
        }
        crate::object::hull(&model.body)?;
        let plant = Arc::new(model.resolved()?);
        let radius = reach(&model.body);
        let mut mover = Self {
            model: Arc::new(model),
            plant,
            propagator: None,
            obstacles: Arc::new(obstacles),
            radius,
            state: State::at_rest([0.0; 3]),
            clear: 0.0,
            engine: None,
            engaged: false,
        };
        mover.put(State::at_rest([0.0; 3]));
        Ok(mover)
    }

    /// Put the object into a state.
    pub fn put(&mut self, state: State<f64>) {
        (self.state, self.engaged) = (state, false);
        self.clear = self.clearance();
    }

    /// Pose and twist of the object frame, and the laws' own states.
    pub fn state(&self) -> &State<f64> {
        &self.state
    }

    /// The laws and the mass.
    pub fn plant(&self) -> &Plant<f64> {
        &self.plant
    }

    /// What moves as one.
    pub fn rigid(&self, clock: Clock) -> Rigid<f64> {
        self.plant.rigid(clock)
    }

    /// Whether the object touches an obstacle.
    pub fn touching(&self) -> bool {
        self.engaged && self.engine.as_ref().is_some_and(|world| world.touching())
    }

    /// One step of `dt` seconds under `applied`, the mean wrench on the object over the step, object axes about the
    /// object origin `[N, N, N·m]`. The heading is not wound back.
    ///
    /// # Errors
    /// Never, as far as is known: the engine is made of shapes and values that [`Mover::new`] has tried.
    pub fn step(&mut self, applied: [f64; 3], clock: Clock, dt: f64) -> Result<(), SimError> {
        if self.obstacles.is_empty() {
            self.move_on(&applied, clock, dt);
            return Ok(());
        }
        if self.touching() {
            return self.carry(applied, clock, dt);
        }
        let travel = self.travel(dt);
        if self.clear < travel {
            self.clear = self.clearance();
        }
        let needed = if self.engaged { travel + SLACK } else { travel };
        if self.clear >= needed || !self.finite() {
            self.engaged = false;
            self.move_on(&applied, clock, dt);
            // What the push adds to the speed within the step counts too.
            self.clear -= travel.max(self.travel(dt));
            return Ok(());
        }
        self.carry(applied, clock, dt)
    }

    /// Let the laws alone have it for a step.
    #[inline]
    fn move_on(&mut self, applied: &[f64; 3], clock: Clock, dt: f64) {
        match &self.propagator {
            Some((length, propagator)) if *length == dt => propagator.step_in_place(&mut self.state, applied),
            _ => self.plant.step_in_place(&mut self.state, applied, clock, dt),
        }
    }

    /// Solve steps of this length beforehand, where that can be.
    pub fn prepare(&mut self, dt: f64) {
        self.propagator = self.plant.linear_propagator(dt).map(|propagator| (dt, propagator));
    }

    /// Let the engine have it for a step.
    fn carry(&mut self, applied: [f64; 3], clock: Clock, dt: f64) -> Result<(), SimError> {
        let count = (dt / STEP - 1e-9).ceil().max(1.0);
        if self.engine.is_none() {
            self.engine = Some(Box::new(World::new(&self.model, &self.obstacles, STEP)?));
        }
        let Some(world) = self.engine.as_mut() else { return Ok(()) };
        world.set_dt(dt / count);
        if !self.engaged {
            world.put(&self.state, clock);
            self.engaged = true;
        }
        let mut heading = self.state.pose[2];
        for _ in 0..count as usize {
            world.step(applied, clock);
            self.state = world.state();
            heading += wrap(self.state.pose[2] - heading);
        }
        self.state.pose[2] = heading;
        self.clear = 0.0;
        Ok(())
    }

    /// How far the outline may get in a step, m.
    fn travel(&self, dt: f64) -> f64 {
        let [vx, vy, spin] = self.state.twist;
        ((vx * vx + vy * vy).sqrt() + spin.abs() * self.radius) * dt
    }

    /// From the outline's reach to the margin of the nearest obstacle, m.
    fn clearance(&self) -> f64 {
        nearest(&self.obstacles, self.state.pose) - self.radius - MARGIN
    }

    fn finite(&self) -> bool {
        self.state.pose.iter().chain(&self.state.twist).all(|v| v.is_finite())
    }

    /// All that changes.
    pub(crate) fn save(&self) -> Motion {
        Motion {
            state: [self.state.pose, self.state.twist],
            inner: self.state.inner,
            clear: self.clear,
            engine: self.engine.as_ref().map(|world| world.save()),
            engaged: self.engaged,
        }
    }

    /// Put all back that [`Mover::save`] kept of one like this.
    ///
    /// # Errors
    /// As [`World::new`].
    pub(crate) fn load(&mut self, motion: Motion) -> Result<(), SimError> {
        let Motion { state: [pose, twist], inner, clear, engine, engaged } = motion;
        self.engine = match engine {
            None => None,
            Some(engine) => {
                let mut world = World::new(&self.model, &self.obstacles, STEP)?;
                world.load(engine);
                Some(Box::new(world))
            }
        };
        self.state = State { pose, twist, inner };
        (self.clear, self.engaged) = (clear, engaged);
        Ok(())
    }
}
