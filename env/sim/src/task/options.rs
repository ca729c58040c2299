//! Options of a task.

use serde::{Deserialize, Serialize};
use toml::Table;

use super::constants::*;
use crate::SimError;

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

/// Meaning of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ActionMode {
    /// Wrench at the grasp, gripper axes.
    Wrench,
    /// Velocity of the gripper, world axes.
    Velocity,
    /// Push with a fingertip: contact position, push direction and speed.
    Push,
    /// As `Wrench`, followed by the next grasp position, as fractions of half the object's sides, and a request to regrasp.
    Regrasp,
}

impl ActionMode {
    /// Physical values of an action of ones.
    pub fn full_scale(self) -> &'static [f64] {
        match self {
            Self::Wrench => &FULL_WRENCH,
            Self::Velocity => &FULL_VELOCITY,
            Self::Push => &FULL_PUSH,
            Self::Regrasp => &FULL_REGRASP,
        }
    }

    /// Number of entries of an action.
    pub fn width(self) -> usize {
        self.full_scale().len()
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
    /// Kind of task.
    pub task: TaskKind,
    /// Meaning of an action.
    pub action: ActionMode,
    /// Names of household objects, `random`, or object files. Each object is drawn from them.
    pub object: Vec<String>,
    /// Kind of hidden effects.
    pub hidden: HiddenKind,
    /// Additional effects, as in `model.toml`. All values must be given.
    pub effects: Vec<Table>,
    /// Factor on the documented noise.
    pub noise: f64,
    /// Probability that the tracker loses a pose.
    pub drop_out: f64,
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
            task: TaskKind::Pose,
            action: ActionMode::Wrench,
            object: vec!["office_table".to_owned()],
            hidden: HiddenKind::Wheels,
            effects: vec![],
            noise: 1.0,
            drop_out: 0.0,
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
        !matches!(self.object.as_slice(), [one] if one != "random" && one != "household")
    }

    /// Number of entries of an observation.
    pub fn observation_len(&self) -> usize {
        COMMON_ENTRIES + if self.has_varied_objects() { 2 } else { 0 } + self.task.feature_count()
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
        if self.object.is_empty() {
            return Err(SimError::value("object", &self.object, "name at least one object, or \"random\""));
        }
        Ok(())
    }
}
