//! Options of a task.

use serde::{Deserialize, Serialize};
use toml::Table;

use super::action_mode::ActionMode;
use super::arm::ArmOptions;
use super::constants::*;
use super::costs::Costs;
use super::object_sets::{Level, Split};
use crate::{ContactMethod, SimError};

/// Kind of task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TaskKind {
    /// Push the object to a pose.
    Pose,
    /// Push the object along a path.
    Path,
    /// Push the object to a pose behind an obstacle.
    Around,
    /// Push the object to a pose behind a doorway.
    Door,
}

impl TaskKind {
    /// Number of entries of the scene layout in an observation.
    pub fn feature_count(self) -> usize {
        match self {
            Self::Pose => 0,
            // Path: two points after the target. Around: centre, heading and half sides. Door: centre, normal and width.
            Self::Path => 4,
            Self::Around => 6,
            Self::Door => 5,
        }
    }
}

/// Kind of hidden effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HiddenKind {
    /// One wheel is locked and the others roll without friction, as in the paper.
    Locked,
    /// One wheel is locked, fixed or a caster, and the others roll with low friction. An object without wheels is in one of
    /// its configurations.
    Wheels,
    /// One of the configurations in the object's file.
    Configuration,
    /// As `Wheels`, with one random effect of the catalogue.
    Catalogue,
    /// No effects.
    None,
}

/// Options of a task. Missing options have the values of [`Options::default`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Version of observations, costs and clipping: 0 or 1.
    pub version: u32,
    /// Kind of task.
    pub task: TaskKind,
    /// Meaning of an action.
    pub action: ActionMode,
    /// Names of household objects, `random`, or object files. Each object is drawn from them.
    pub object: Vec<String>,
    /// Level of difficulty. Objects are then drawn from its set, not from `object`.
    pub level: Option<Level>,
    /// Set of the level from which objects are drawn.
    pub split: Split,
    /// Range of the mass of random objects, kg.
    pub mass: Option<[f64; 2]>,
    /// Range of the friction of a locked wheel, N·s/m.
    pub friction: Option<[f64; 2]>,
    /// Whether observations contain the outline.
    pub outline: bool,
    /// Kind of hidden effects.
    pub hidden: HiddenKind,
    /// Additional effects, as in `model.toml`. All values must be given.
    pub effects: Vec<Table>,
    /// Factor on the documented noise.
    pub noise: f64,
    /// Probability that the tracker loses a pose.
    pub drop_out: f64,
    /// Properties of the arm.
    pub arm: ArmOptions,
    /// Delay of all measurements, s, rounded to simulation steps.
    pub sensor_delay: f64,
    /// Stated decision time, s, rounded to simulation steps. The previous command acts meanwhile.
    pub decision_time: f64,
    /// Whether the caller measures and gives the decision time of each step.
    pub measures_decisions: bool,
    /// Cost of each second; `None` for the default of the version.
    pub time_cost: Option<f64>,
    /// Cost of each second at full effort; `None` for the default of the version.
    pub effort_cost: Option<f64>,
    /// Cost of each second of contact with an obstacle; `None` for the default of the version.
    pub touch_cost: Option<f64>,
    /// Distance tolerance of the goal, m.
    pub reach: f64,
    /// Heading tolerance of the goal, rad.
    pub facing: f64,
    /// Whether reaching the goal ends the episode.
    pub ends: bool,
    /// Number of steps after which an episode is truncated; 0 for no limit.
    pub horizon: u32,
    /// Simulation step, s.
    pub step: f64,
    /// Simulation steps per [`CONTROL_PERIOD_S`]. A push has proportionally more.
    pub substeps: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            version: 0,
            task: TaskKind::Pose,
            action: ActionMode::Wrench,
            object: vec!["office_table".to_owned()],
            level: None,
            split: Split::Train,
            mass: None,
            friction: None,
            outline: false,
            hidden: HiddenKind::Wheels,
            effects: vec![],
            noise: 1.0,
            drop_out: 0.0,
            arm: ArmOptions::default(),
            sensor_delay: 0.0,
            decision_time: 0.0,
            measures_decisions: false,
            time_cost: None,
            effort_cost: None,
            touch_cost: None,
            reach: 0.05,
            facing: 0.1,
            ends: true,
            horizon: 300,
            step: CONTROL_PERIOD_S / f64::from(DEFAULT_SUBSTEPS),
            substeps: DEFAULT_SUBSTEPS,
        }
    }
}

impl Options {
    /// Parse options from TOML.
    ///
    /// # Errors
    /// If a key is unknown or a value is out of range. The message names it.
    pub fn from_toml(text: &str) -> Result<Self, SimError> {
        let options: Self = toml::from_str(text).map_err(|e| {
            // Quote the line, because the parser's message does not name the key.
            let line = e.span().and_then(|span| text.get(..span.start)).map_or("", |before| {
                let start = before.rfind('\n').map_or(0, |at| at + 1);
                text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or("")
            });
            SimError::Options(format!("{line}: {}", e.message()))
        })?;
        options.check()?;
        Ok(options)
    }

    /// Simulation steps between two actions.
    pub fn substeps_per_action(&self) -> u32 {
        match self.action {
            ActionMode::Push => (f64::from(self.substeps) * PUSH_PERIOD_S / CONTROL_PERIOD_S).round() as u32,
            _ => self.substeps,
        }
    }

    /// Time between two actions, s.
    pub fn control_period(&self) -> f64 {
        f64::from(self.substeps_per_action()) * self.step
    }

    /// Simulation steps of a regrasp, a whole number of actions.
    pub fn regrasp_substeps(&self) -> u32 {
        let actions = (REGRASP_S / self.control_period()).round().max(1.0);
        actions as u32 * self.substeps_per_action()
    }

    /// Whether the object can differ between episodes.
    pub fn has_varied_objects(&self) -> bool {
        self.level.is_some()
            || !matches!(self.object.as_slice(), [one] if one != "random" && one != "household")
    }

    /// Whether actions outside [−1, 1] are clipped. Otherwise they are errors.
    pub fn clips_actions(&self) -> bool {
        self.version > 0
    }

    /// Solver of contacts with obstacles. Version 0 keeps the engine, so that its episodes stay the same.
    pub fn contact_method(&self) -> ContactMethod {
        if self.version == 0 { ContactMethod::Engine } else { ContactMethod::Direct }
    }

    /// Costs per second.
    pub fn costs(&self) -> Costs {
        let default = Costs::of_version(self.version);
        Costs {
            time: self.time_cost.unwrap_or(default.time),
            effort: self.effort_cost.unwrap_or(default.effort),
            touch: self.touch_cost.unwrap_or(default.touch),
            ..default
        }
    }

    /// Range of the friction of a locked wheel, N·s/m.
    pub fn locked_friction(&self) -> (f64, f64) {
        let of_level = self.level.map(|level| level.object_set(self.split).friction);
        self.friction.map(|[low, high]| (low, high)).or(of_level).unwrap_or(LOCKED_FRICTION_N_S_PER_M)
    }

    /// Simulation steps in a time, s.
    pub fn steps_in(&self, seconds: f64) -> u32 {
        (seconds / self.step).round() as u32
    }

    /// Number of entries of an observation.
    pub fn observation_len(&self) -> usize {
        COMMON_ENTRIES + self.shape_entries() + self.task.feature_count()
    }

    /// Number of entries of an observation that describe the object.
    fn shape_entries(&self) -> usize {
        match (self.version, self.has_varied_objects(), self.outline) {
            (0, false, _) => 0,
            (0, true, _) => 2,
            (_, _, false) => BOUNDS_ENTRIES,
            (_, _, true) => BOUNDS_ENTRIES + OUTLINE_ENTRIES,
        }
    }

    /// Largest magnitude of each entry of an observation.
    pub fn observation_bounds(&self) -> Vec<f64> {
        let mut bounds = COMMON_BOUNDS.to_vec();
        bounds.resize(self.observation_len(), MAX_FEATURE_M);
        bounds
    }

    /// Check the values.
    ///
    /// # Errors
    /// If an option is out of range. The message names option, value and remedy.
    pub fn check(&self) -> Result<(), SimError> {
        let within = |key: &str, value: f64, low: f64, high: f64, remedy| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(SimError::value(key, value, remedy)) }
        };
        within("noise", self.noise, 0.0, MAX_NOISE_FACTOR, "must lie in [0, 10]; 1 is as documented")?;
        within("drop_out", self.drop_out, 0.0, 0.999, "must lie in [0, 1)")?;
        within("reach", self.reach, 1e-3, ARENA_HALF_SIDE_M, "must lie in [0.001, 2.5] m")?;
        within("facing", self.facing, 1e-3, 4.0, "must lie in [0.001, 4] rad")?;
        within("step", self.step, 1e-5, 0.01, "must lie in [0.00001, 0.01] s")?;
        within("substeps", f64::from(self.substeps), 1.0, 1e4, "must lie in 1..10000")?;
        within("version", f64::from(self.version), 0.0, 1.0, "must be 0 or 1")?;
        within("sensor_delay", self.sensor_delay, 0.0, MAX_DELAY_S, "must lie in [0, 1] s")?;
        within("realtime", self.decision_time, 0.0, MAX_DELAY_S, "must lie in [0, 1] s, or be \"measured\"")?;
        for (key, value) in [
            ("time_cost", self.time_cost),
            ("effort_cost", self.effort_cost),
            ("touch_cost", self.touch_cost),
        ] {
            within(key, value.unwrap_or(0.0), 0.0, 1e4, "must lie in [0, 10000] per second")?;
        }
        for (key, range, low, high, remedy) in [
            ("mass", self.mass, 0.5, 500.0, "give two masses in [0.5, 500] kg, the smaller one first"),
            (
                "friction",
                self.friction,
                0.1,
                1e4,
                "give two values in [0.1, 10000] N s/m, the smaller one first",
            ),
        ] {
            if let Some([a, b]) = range.filter(|[a, b]| !(low <= *a && a <= b && *b <= high)) {
                return Err(SimError::value(key, [a, b], remedy));
            }
        }
        self.arm.check(self.action)?;
        self.check_objects()
    }

    fn check_objects(&self) -> Result<(), SimError> {
        let has_random = self.object.iter().any(|name| name == "random");
        if let Some(level) = self.level.filter(|_| self.mass.is_some()) {
            return Err(SimError::value("mass", level, "the level states the range: remove mass, or level"));
        }
        if let Some(mass) = self.mass.filter(|_| !has_random) {
            return Err(SimError::value(
                "mass",
                mass,
                "only random objects have a range: set object to \"random\"",
            ));
        }
        if self.outline && self.version == 0 {
            return Err(SimError::value(
                "outline",
                true,
                "observations of version 0 have none: use an id ending in -v1",
            ));
        }
        if self.object.is_empty() {
            return Err(SimError::value("object", &self.object, "name at least one object, or \"random\""));
        }
        Ok(())
    }
}
