//! What a task can be told once and for all.

use serde::{Deserialize, Serialize};
use toml::Table;

use super::room::Room;
use super::rules::*;
use crate::SimError;

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// To a pose.
    Pose,
    /// Along a path.
    Path,
    /// To a pose behind an obstacle.
    Around,
    /// To a pose behind a doorway.
    Door,
}

/// What an action means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The wrench at the grasp, gripper axes.
    Wrench,
    /// The gripper's velocity, world axes.
    Velocity,
    /// A push: where the tip touches, which way it leans, how fast.
    Push,
    /// As `Wrench`; then where to hold next, as shares of half the object's sides, and whether to let go and go there.
    Regrasp,
}

impl Mode {
    /// What a full action stands for.
    pub fn full(self) -> &'static [f64] {
        match self {
            Self::Wrench => &FULL_WRENCH,
            Self::Velocity => &FULL_VELOCITY,
            Self::Push => &FULL_PUSH,
            Self::Regrasp => &FULL_REGRASP,
        }
    }

    /// Entries of an action.
    pub fn width(self) -> usize {
        self.full().len()
    }
}

/// What is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Secret {
    /// One wheel is locked and the others roll without friction: the paper's object.
    Locked,
    /// One wheel is locked, fixed or a caster, the others roll with a little friction; an object without wheels is in
    /// one of its configurations.
    Wheels,
    /// One of the configurations in the object's file.
    Configuration,
    /// As `Wheels`, and any one effect of the catalogue.
    Catalogue,
    /// Nothing acts.
    None,
}

/// All options; what is left out is as in [`Options::default`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// What is to be done.
    pub task: Goal,
    /// What an action means.
    pub action: Mode,
    /// Names of household objects, `random`, or object files; one is drawn with each object.
    pub object: Vec<String>,
    /// What is hidden.
    pub hidden: Secret,
    /// Effects beside that, as in `model.toml`, all values given.
    pub effects: Vec<Table>,
    /// Factor on all noise; 1: as documented.
    pub noise: f64,
    /// Probability that the tracker loses a pose.
    pub drop_out: f64,
    /// Distance within which the goal is reached, m.
    pub reach: f64,
    /// Heading error within which the goal is reached, rad.
    pub facing: f64,
    /// Whether reaching the goal ends the episode.
    pub ends: bool,
    /// Steps after which an episode is cut; 0: never.
    pub horizon: u32,
    /// Simulation step, s.
    pub step: f64,
    /// Simulation steps from one action to the next; a push has as many more as it is longer.
    pub substeps: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            task: Goal::Pose,
            action: Mode::Wrench,
            object: vec!["office_table".to_owned()],
            hidden: Secret::Wheels,
            effects: vec![],
            noise: 1.0,
            drop_out: 0.0,
            reach: 0.05,
            facing: 0.1,
            ends: true,
            horizon: 300,
            step: CONTROL / f64::from(STEPS),
            substeps: STEPS,
        }
    }
}

impl Options {
    /// From TOML.
    ///
    /// # Errors
    /// When a key is unknown or a value makes no sense; the message names it.
    pub fn from_toml(text: &str) -> Result<Self, SimError> {
        let options: Self = toml::from_str(text).map_err(|e| {
            // The line, because the message alone does not name the key.
            let line = e.span().and_then(|span| text.get(..span.start)).map_or("", |before| {
                let start = before.rfind('\n').map_or(0, |at| at + 1);
                text.get(start..).and_then(|rest| rest.lines().next()).unwrap_or("")
            });
            SimError::Options(format!("{line}: {}", e.message()))
        })?;
        options.check()?;
        Ok(options)
    }

    /// Simulation steps from one action to the next.
    pub fn ticks(&self) -> u32 {
        match self.action {
            Mode::Push => (f64::from(self.substeps) * PUSH / CONTROL).round() as u32,
            _ => self.substeps,
        }
    }

    /// Time from one action to the next, s.
    pub fn control(&self) -> f64 {
        f64::from(self.ticks()) * self.step
    }

    /// Simulation steps that the gripper takes from one place on the object to another: whole actions.
    pub fn travel(&self) -> u32 {
        let actions = (REGRASP / self.control()).round().max(1.0);
        actions as u32 * self.ticks()
    }

    /// Whether episodes are of different objects.
    pub fn varied(&self) -> bool {
        !matches!(self.object.as_slice(), [one] if one != "random" && one != "household")
    }

    /// Entries of an observation.
    pub fn entries(&self) -> usize {
        COMMON + if self.varied() { 2 } else { 0 } + Room::entries(self.task)
    }

    /// Largest magnitude of each entry of an observation.
    pub fn bounds(&self) -> Vec<f64> {
        let mut bounds = BOUNDS.to_vec();
        bounds.resize(self.entries(), ROOM);
        bounds
    }

    /// Refuse what cannot be.
    ///
    /// # Errors
    /// Names the option, its value and the remedy.
    pub fn check(&self) -> Result<(), SimError> {
        let within = |key: &str, value: f64, low: f64, high: f64, remedy| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(SimError::value(key, value, remedy)) }
        };
        within("noise", self.noise, 0.0, NOISIEST, "must lie in [0, 10]; 1 is as documented")?;
        within("drop_out", self.drop_out, 0.0, 0.999, "must lie in [0, 1)")?;
        within("reach", self.reach, 1e-3, ARENA, "must lie in [0.001, 2.5] m")?;
        within("facing", self.facing, 1e-3, 4.0, "must lie in [0.001, 4] rad")?;
        within("step", self.step, 1e-5, 0.01, "must lie in [0.00001, 0.01] s")?;
        within("substeps", f64::from(self.substeps), 1.0, 1e4, "must lie in 1..10000")?;
        if self.object.is_empty() {
            return Err(SimError::value("object", &self.object, "name at least one object, or \"random\""));
        }
        Ok(())
    }
}
