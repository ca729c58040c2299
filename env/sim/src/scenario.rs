//! Scenario files in TOML. Unknown keys are errors.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Table;
use trundle_model::Model;

use crate::task::read_object;
use crate::toml_file::{expect_format, in_file, parse, parse_text};
use crate::{Coupling, Excitation, Object, Push, Sensor, SimError, Tracker};

const SCENARIO_FORMAT: &str = "trundle-scenario/1";

/// The scenario of the demo. Its object is a household object.
const DEMO: &str = include_str!("../scenarios/demo.toml");

/// Largest simulation step, s. The gripper's coupling and the sensor's clock limit it.
const MAX_STEP_S: f64 = 0.01;

/// Largest number of steps of all pushes. A step takes about a microsecond, so this takes a few minutes.
const MAX_STEPS: f64 = 1e8;
/// Largest number of samples of all instruments. A sample takes up to 250 bytes in memory, so this takes 1 GB.
const MAX_SAMPLES: f64 = 4e6;

/// A scenario: an object with hidden effects, and the pushes to record.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    format: String,
    /// Name of the recording.
    pub name: String,
    /// Object file, relative to the scenario.
    pub object: PathBuf,
    /// Name of the object's configuration, whose effects are also hidden.
    #[serde(default)]
    pub configuration: Option<String>,
    /// Simulation step, s.
    #[serde(default = "default_step")]
    pub step: f64,
    /// Whether the recording states the object's mass.
    #[serde(default)]
    pub weighed: bool,
    /// Number of held-out episodes, at the end of the recording.
    #[serde(default)]
    pub held_out: usize,
    /// Hidden effects, as in `model.toml`. The recording does not contain them.
    #[serde(default, rename = "effect")]
    pub effects: Vec<Table>,
    /// Fixed obstacles. The recording contains them.
    #[serde(default, rename = "obstacle")]
    pub obstacles: Vec<ObstacleTable>,
    /// Coupling between gripper and object.
    #[serde(default)]
    pub gripper: Coupling,
    /// Wrist sensor.
    #[serde(default)]
    pub sensor: Sensor,
    /// Pose tracker.
    #[serde(default)]
    pub tracker: Tracker,
    /// Explicit pushes, one episode each. They precede the random ones.
    #[serde(default, rename = "push")]
    pub pushes: Vec<Push>,
    /// Random pushes.
    pub random: Option<Excitation>,
}

/// A fixed obstacle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleTable {
    /// Corners in order, m, world frame.
    pub polygon: Vec<[f64; 2]>,
}

/// Default simulation step, s. Dry friction with stops and reversals requires it: after a push of 6 s the position error is
/// 1 mm with steps of 1 ms, and 0.1 mm with this one.
fn default_step() -> f64 {
    2.5e-4
}

impl Scenario {
    /// Read a scenario and its object. Returns the scenario and the model with all effects.
    ///
    /// # Errors
    /// If a file cannot be read or a value is invalid. The message names file and key.
    pub fn read(path: &Path) -> Result<(Self, Model), SimError> {
        let scenario: Self = parse(path, SCENARIO_FORMAT)?;
        scenario.check_file(path)?;
        let object_path = path.parent().unwrap_or(Path::new("")).join(&scenario.object);
        let object = Object::read(&object_path)?;
        scenario.with_model(path, &object)
    }

    /// The scenario of the demo, which needs no file: an office table with a locked wheel and dry friction.
    ///
    /// # Errors
    /// None: a test parses it.
    pub fn demo() -> Result<(Self, Model), SimError> {
        let path = Path::new("demo.toml");
        let scenario: Self = parse_text(path, DEMO, SCENARIO_FORMAT)?;
        scenario.check_file(path)?;
        let name = scenario.object.file_stem().unwrap_or_default().to_string_lossy();
        let object = read_object(&name)?;
        scenario.with_model(path, &object)
    }

    /// Check the values of a scenario file.
    fn check_file(&self, path: &Path) -> Result<(), SimError> {
        expect_format(path, &self.format, SCENARIO_FORMAT)?;
        self.check().map_err(|error| in_file(path, &error))
    }

    /// The scenario and the model of its object with all effects.
    fn with_model(self, path: &Path, object: &Object) -> Result<(Self, Model), SimError> {
        let model = object
            .model_with(self.configuration.as_deref(), &self.effects)
            .map_err(|error| in_file(path, &error))?;
        model.resolved().map_err(|error| in_file(path, &error.into()))?;
        Ok((self, model))
    }

    /// Number of episodes.
    pub fn episodes(&self) -> usize {
        self.pushes.len() + self.random.as_ref().map_or(0, |excitation| excitation.count)
    }

    fn check(&self) -> Result<(), SimError> {
        if !(self.step > 0.0 && self.step <= MAX_STEP_S) {
            return Err(SimError::value("step", self.step, "must lie in (0, 0.01] s"));
        }
        self.gripper.check()?;
        self.sensor.check()?;
        self.tracker.check()?;
        for (key, rate) in [("sensor.rate", self.sensor.rate), ("tracker.rate", self.tracker.rate)] {
            if rate * self.step > 1.0 {
                return Err(SimError::value(key, rate, "must not exceed 1 / step: shorten `step`"));
            }
        }
        if let Some(excitation) = &self.random {
            excitation.check()?;
        }
        if self.episodes() == 0 {
            return Err(SimError::value("push", 0, "give [[push]] tables, or [random] with a count"));
        }
        self.check_length()?;
        if self.held_out >= self.episodes() {
            let remedy = "must leave at least one episode to fit";
            return Err(SimError::value("held_out", self.held_out, remedy));
        }
        Ok(())
    }
}

impl Scenario {
    /// Limit the computing time and the memory.
    fn check_length(&self) -> Result<(), SimError> {
        let ends = self.pushes.iter().filter_map(|push| push.knots.last()).map(|knot| knot[0]);
        let drawn =
            self.random.as_ref().map_or(0.0, |excitation| excitation.count as f64 * excitation.duration);
        let seconds = ends.sum::<f64>() + drawn + self.episodes() as f64 * self.sensor.precontact;
        let rate = self.sensor.rate + self.tracker.rate;
        for (what, requested, limit, remedy) in [
            ("steps", seconds / self.step, MAX_STEPS, "lengthen `step`"),
            ("samples", seconds * rate, MAX_SAMPLES, "lower `sensor.rate` and `tracker.rate`"),
        ] {
            if requested > limit {
                return Err(SimError::ScenarioTooLong { seconds, what, requested, limit, remedy });
            }
        }
        Ok(())
    }
}
