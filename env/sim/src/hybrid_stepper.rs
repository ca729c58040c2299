//! Hybrid stepper: integrates an object among fixed obstacles with the laws alone while no obstacle is in reach, and with
//! contacts otherwise.
//!
//! Away from obstacles both agree (`tests/all/world.rs`), and the laws alone are an order of magnitude faster. Two solvers
//! of contacts agree within the tolerances of `tests/all/contact.rs`: see [`ContactMethod`].

use std::sync::Arc;

use trundle_model::{Clock, LinearPropagator, MAX_INNER_STATES, Model, Plant, Rigid, State};

use crate::contact::{CONTACT_DISTANCE_M, ContactState, ContactStepper};
use crate::gripper::wrap_angle;
use crate::obstacle_distance::{ENGINE_MARGIN_M, obstacle_distance, outline_radius};
use crate::world::EngineState;
use crate::{SimError, World};

/// Largest step of the engine, s.
const MAX_ENGINE_STEP_S: f64 = 0.002;

/// Additional distance to all obstacles at which the laws take over again, m. It prevents frequent switching.
const HANDOVER_HYSTERESIS_M: f64 = 0.01;

/// Solver of contacts with obstacles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactMethod {
    /// rapier2d, from the time when an obstacle is within 2 cm of the space that the object can reach.
    #[default]
    Engine,
    /// The same equations for one body against fixed shapes, without the engine: an order of magnitude faster.
    Direct,
}

/// A moving object among fixed obstacles.
#[derive(Clone)]
pub struct HybridStepper {
    model: Arc<Model>,
    plant: Arc<Plant<f64>>,
    /// Precomputed step of the plant with its length, s, if the model is linear.
    propagator: Option<(f64, LinearPropagator)>,
    obstacles: Arc<Vec<Vec<[f64; 2]>>>,
    /// Largest distance of the outline from the object origin, m.
    radius: f64,
    state: State<f64>,
    /// Distance that the object can travel before an obstacle can be in reach, m.
    free_travel: f64,
    /// Physics engine, created when an obstacle first comes into reach.
    engine: Option<Box<World>>,
    /// Whether the engine or the contacts integrate the motion.
    engine_active: bool,
    /// Contacts of [`ContactMethod::Direct`].
    contacts: Option<Box<ContactStepper>>,
}

/// Saved state of a [`HybridStepper`].
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct SavedMotion {
    state: [[f64; 3]; 2],
    inner: [f64; MAX_INNER_STATES],
    free_travel: f64,
    engine: Option<EngineState>,
    engine_active: bool,
    contacts: Option<ContactState>,
}

impl HybridStepper {
    /// An object at rest at the origin among simple polygons, m, world frame.
    ///
    /// # Errors
    /// If a parameter of the model has no value, or a shape is not a simple polygon.
    pub fn new(model: Model, obstacles: Vec<Vec<[f64; 2]>>) -> Result<Self, SimError> {
        Self::with_contacts(model, obstacles, ContactMethod::Engine)
    }

    /// As [`HybridStepper::new`], with a solver of contacts.
    ///
    /// # Errors
    /// As [`HybridStepper::new`].
    pub fn with_contacts(
        model: Model,
        obstacles: Vec<Vec<[f64; 2]>>,
        method: ContactMethod,
    ) -> Result<Self, SimError> {
        let plant = Arc::new(model.resolved()?);
        // Both methods check all shapes here.
        let contacts = match method {
            ContactMethod::Direct => Some(Box::new(ContactStepper::new(&model.body, &plant, &obstacles)?)),
            ContactMethod::Engine => {
                for (index, polygon) in obstacles.iter().enumerate() {
                    crate::colliders::obstacle_colliders(polygon, index)?;
                }
                crate::colliders::object_colliders(&model.body)?;
                None
            }
        };
        let radius = outline_radius(&model.body);
        let mut stepper = Self {
            model: Arc::new(model),
            plant,
            propagator: None,
            obstacles: Arc::new(obstacles),
            radius,
            state: State::at_rest([0.0; 3]),
            free_travel: 0.0,
            engine: None,
            engine_active: false,
            contacts,
        };
        stepper.set_state(State::at_rest([0.0; 3]));
        Ok(stepper)
    }

    /// Set the state of the object.
    pub fn set_state(&mut self, state: State<f64>) {
        (self.state, self.engine_active) = (state, false);
        self.free_travel = self.clearance();
    }

    /// Pose and twist of the object frame, and the internal states of the laws.
    pub fn state(&self) -> &State<f64> {
        &self.state
    }

    /// The plant: laws and mass properties.
    pub fn plant(&self) -> &Plant<f64> {
        &self.plant
    }

    /// Mass properties at a time.
    pub fn rigid(&self, clock: Clock) -> Rigid<f64> {
        self.plant.rigid(clock)
    }

    /// Whether the object touches an obstacle.
    pub fn is_touching(&self) -> bool {
        self.engine_active
            && match &self.contacts {
                Some(contacts) => contacts.is_touching(),
                None => self.engine.as_ref().is_some_and(|world| world.is_touching()),
            }
    }

    /// Impulse of obstacles on the object in the last engine step, N·s.
    pub fn contact_impulse(&self) -> f64 {
        if !self.is_touching() {
            return 0.0;
        }
        match &self.contacts {
            Some(contacts) => contacts.contact_impulse(),
            None => self.engine.as_ref().map_or(0.0, |world| world.contact_impulse()),
        }
    }

    /// Advance by `dt` seconds under `applied`, the mean wrench on the object over the step, object axes about the object
    /// origin `[N, N, N·m]`. The heading is not wrapped.
    ///
    /// # Errors
    /// If the engine cannot be created. [`HybridStepper::new`] has checked its shapes and values.
    pub fn step(&mut self, applied: [f64; 3], clock: Clock, dt: f64) -> Result<(), SimError> {
        if self.obstacles.is_empty() {
            self.step_laws(&applied, clock, dt);
            return Ok(());
        }
        if self.contacts.is_some() {
            self.step_direct(applied, clock, dt);
            return Ok(());
        }
        if self.is_touching() {
            return self.step_engine(applied, clock, dt);
        }
        let travel = self.max_travel(dt);
        if self.free_travel < travel {
            self.free_travel = self.clearance();
        }
        let needed = if self.engine_active { travel + HANDOVER_HYSTERESIS_M } else { travel };
        if self.free_travel >= needed || !self.is_finite() {
            self.engine_active = false;
            self.step_laws(&applied, clock, dt);
            // The push may increase the speed within the step.
            self.free_travel -= travel.max(self.max_travel(dt));
            return Ok(());
        }
        self.step_engine(applied, clock, dt)
    }

    /// Advance one step with the laws alone.
    #[inline]
    fn step_laws(&mut self, applied: &[f64; 3], clock: Clock, dt: f64) {
        match &self.propagator {
            Some((length, propagator)) if *length == dt => propagator.step_in_place(&mut self.state, applied),
            _ => self.plant.step_in_place(&mut self.state, applied, clock, dt),
        }
    }

    /// Precompute steps of this length, s, if the model is linear.
    pub fn precompute_step(&mut self, dt: f64) {
        self.propagator = self.plant.linear_propagator(dt).map(|propagator| (dt, propagator));
    }

    /// Advance one step with the engine.
    fn step_engine(&mut self, applied: [f64; 3], clock: Clock, dt: f64) -> Result<(), SimError> {
        let count = (dt / MAX_ENGINE_STEP_S - 1e-9).ceil().max(1.0);
        if self.engine.is_none() {
            self.engine = Some(Box::new(World::new(&self.model, &self.obstacles, MAX_ENGINE_STEP_S)?));
        }
        let Some(world) = self.engine.as_mut() else { return Ok(()) };
        world.set_dt(dt / count);
        if !self.engine_active {
            world.set_state(&self.state, clock);
            self.engine_active = true;
        }
        let mut heading = self.state.pose[2];
        for _ in 0..count as usize {
            world.step(applied, clock);
            self.state = world.state();
            heading += wrap_angle(self.state.pose[2] - heading);
        }
        self.state.pose[2] = heading;
        self.free_travel = 0.0;
        Ok(())
    }

    /// Advance one step with [`ContactMethod::Direct`].
    fn step_direct(&mut self, applied: [f64; 3], clock: Clock, dt: f64) {
        if !self.is_touching() {
            let travel = self.max_travel(dt);
            let needed = (travel - CONTACT_DISTANCE_M).max(0.0);
            if self.free_travel < needed {
                self.free_travel = self.clearance();
            }
            if self.free_travel >= needed || !self.is_finite() {
                self.engine_active = false;
                self.step_laws(&applied, clock, dt);
                // The push may increase the speed within the step.
                self.free_travel -= travel.max(self.max_travel(dt));
                return;
            }
        }
        let count = (dt / MAX_ENGINE_STEP_S - 1e-9).ceil().max(1.0);
        let short = dt / count;
        let rigid = self.plant.rigid(clock);
        let is_new = !std::mem::replace(&mut self.engine_active, true);
        for _ in 0..count as usize {
            let before = self.state;
            let travel = self.max_travel(short);
            self.step_laws(&applied, clock, short);
            let after = std::mem::replace(&mut self.state, before);
            let travel = travel.max(self.max_travel_of(&after, short));
            if let Some(contacts) = &mut self.contacts {
                if is_new {
                    contacts.clear();
                }
                contacts.step(&mut self.state, after, &rigid, travel, short);
            }
        }
        self.free_travel = f64::NEG_INFINITY;
    }

    /// Upper bound on the distance that any point of the outline travels in a step, m.
    fn max_travel(&self, dt: f64) -> f64 {
        self.max_travel_of(&self.state, dt)
    }

    fn max_travel_of(&self, state: &State<f64>, dt: f64) -> f64 {
        let [vx, vy, spin] = state.twist;
        ((vx * vx + vy * vy).sqrt() + spin.abs() * self.radius) * dt
    }

    /// Lower bound on the distance from the outline to the margin of the nearest obstacle, m.
    fn clearance(&mut self) -> f64 {
        match &mut self.contacts {
            Some(contacts) => contacts.clearance(self.state.pose) - CONTACT_DISTANCE_M,
            None => obstacle_distance(&self.obstacles, self.state.pose) - self.radius - ENGINE_MARGIN_M,
        }
    }

    fn is_finite(&self) -> bool {
        self.state.pose.iter().chain(&self.state.twist).all(|v| v.is_finite())
    }

    /// The complete state.
    pub(crate) fn save(&self) -> SavedMotion {
        SavedMotion {
            state: [self.state.pose, self.state.twist],
            inner: self.state.inner,
            free_travel: self.free_travel,
            engine: self.engine.as_ref().map(|world| world.save()),
            engine_active: self.engine_active,
            contacts: self.contacts.as_ref().map(|contacts| contacts.save()),
        }
    }

    /// Restore the state saved by [`HybridStepper::save`] of a stepper with the same model and obstacles.
    ///
    /// # Errors
    /// As [`World::new`].
    pub(crate) fn load(&mut self, motion: SavedMotion) -> Result<(), SimError> {
        let SavedMotion { state: [pose, twist], inner, free_travel, engine, engine_active, contacts } =
            motion;
        self.engine = match engine {
            None => None,
            Some(engine) => {
                let mut world = World::new(&self.model, &self.obstacles, MAX_ENGINE_STEP_S)?;
                world.load(engine);
                Some(Box::new(world))
            }
        };
        if let (Some(contacts), Some(saved)) = (&mut self.contacts, contacts) {
            contacts.load(saved)?;
        }
        self.state = State { pose, twist, inner };
        (self.free_travel, self.engine_active) = (free_travel, engine_active);
        Ok(())
    }
}
