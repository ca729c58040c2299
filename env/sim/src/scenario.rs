//! Scenario files: what is simulated, in TOML. Unknown keys are errors.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};
use trundle_model::{Effect, Model};

use crate::{Coupling, Excitation, Object, Push, Sensor, SimError, Tracker};

const SCENARIO: &str = "trundle-scenario/1";

/// Longest step, s: the gripper's coupling and the sensor's clock need one that is short.
const LONGEST_STEP: f64 = 0.01;

/// Most steps of all pushes together. A step takes about a microsecond: so many take a few minutes.
const MAX_STEPS: f64 = 1e8;
/// Most samples of all instruments together. One takes up to 250 bytes until it is written: so many take 1 GB.
const MAX_SAMPLES: f64 = 4e6;

/// A scenario: an object with hidden effects, and the pushes that are recorded of it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    format: String,
    /// The recording's name.
    pub name: String,
    /// Object file, relative to the scenario.
    pub object: PathBuf,
    /// Name of the object's configuration, whose effects are hidden too.
    #[serde(default)]
    pub configuration: Option<String>,
    /// Simulation step, s.
    #[serde(default = "fine_step")]
    pub step: f64,
    /// Whether the recording says what the object weighs.
    #[serde(default)]
    pub weighed: bool,
    /// How many of the last episodes are held out.
    #[serde(default)]
    pub held_out: usize,
    /// Hidden effects, as in `model.toml`; the recording has no word of them.
    #[serde(default, rename = "effect")]
    pub effects: Vec<Table>,
    /// Fixed obstacles, which the recording shows.
    #[serde(default, rename = "obstacle")]
    pub obstacles: Vec<ObstacleTable>,
    /// Between gripper and object.
    #[serde(default)]
    pub gripper: Coupling,
    /// Wrist sensor.
    #[serde(default)]
    pub sensor: Sensor,
    /// Pose tracker.
    #[serde(default)]
    pub tracker: Tracker,
    /// Pushes written down, one episode each; they come first.
    #[serde(default, rename = "push")]
    pub pushes: Vec<Push>,
    /// Pushes drawn by seed.
    pub random: Option<Excitation>,
}

/// One fixed obstacle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleTable {
    /// Corners in order, m, world frame.
    pub polygon: Vec<[f64; 2]>,
}

/// Dry friction that stops and reverses needs it: at 1 ms a push of 6 s ends 1 mm off, at this 0.1 mm.
fn fine_step() -> f64 {
    2.5e-4
}

impl Scenario {
    /// Read a scenario and its object: the scenario, and the model with all effects.
    ///
    /// # Errors
    /// Names the file, the key and what is wrong.
    pub fn read(path: &Path) -> Result<(Self, Model), SimError> {
        let scenario: Self = parse(path, SCENARIO)?;
        expect_format(path, &scenario.format, SCENARIO)?;
        scenario.check().map_err(|error| in_file(path, &error))?;
        let object_path = path.parent().unwrap_or(Path::new("")).join(&scenario.object);
        let object = Object::read(&object_path)?;
        let model = object
            .with(scenario.configuration.as_deref(), &scenario.effects)
            .map_err(|error| in_file(path, &error))?;
        model.resolved().map_err(|error| in_file(path, &error.into()))?;
        Ok((scenario, model))
    }

    /// How many episodes there will be.
    pub fn episodes(&self) -> usize {
        self.pushes.len() + self.random.as_ref().map_or(0, |random| random.count)
    }

    fn check(&self) -> Result<(), SimError> {
        if !(self.step > 0.0 && self.step <= LONGEST_STEP) {
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
        if let Some(random) = &self.random {
            random.check()?;
        }
        if self.episodes() == 0 {
            return Err(SimError::value("push", 0, "give [[push]] tables, or [random] with a count"));
        }
        self.check_length()?;
        if self.held_out >= self.episodes() {
            let remedy = "must leave an episode to fit";
            return Err(SimError::value("held_out", self.held_out, remedy));
        }
        Ok(())
    }
}

impl Scenario {
    /// Refuse what would take hours or more memory than there is.
    fn check_length(&self) -> Result<(), SimError> {
        let ends = self.pushes.iter().filter_map(|push| push.knots.last()).map(|knot| knot[0]);
        let drawn = self.random.as_ref().map_or(0.0, |random| random.count as f64 * random.duration);
        let seconds = ends.sum::<f64>() + drawn + self.episodes() as f64 * self.sensor.precontact;
        let rate = self.sensor.rate + self.tracker.rate;
        for (what, got, most, remedy) in [
            ("steps", seconds / self.step, MAX_STEPS, "lengthen `step`"),
            ("samples", seconds * rate, MAX_SAMPLES, "lower `sensor.rate` and `tracker.rate`"),
        ] {
            if got > most {
                return Err(SimError::TooLong { seconds, what, got, most, remedy });
            }
        }
        Ok(())
    }
}

/// Body and effects as a model: the same tables, keys and messages as `model.toml`.
pub(crate) fn model(body: Table, effects: Vec<Table>) -> Result<Model, SimError> {
    let effects = effects.into_iter().map(Value::Table).collect();
    let file = Table::from_iter([
        ("format".to_owned(), Value::String("trundle-model/1".to_owned())),
        ("body".to_owned(), Value::Table(body)),
        ("effect".to_owned(), Value::Array(effects)),
    ]);
    Ok(Model::from_toml(&file.to_string())?.0)
}

/// Effects by themselves, all values given.
pub(crate) fn effects(tables: &[Table]) -> Result<Vec<Effect>, SimError> {
    let body = Table::from_iter([("mass".to_owned(), Value::Float(1.0))]);
    let model = model(body, tables.to_vec())?;
    model.resolved()?;
    Ok(model.effects)
}

/// Reads a file of the format `known`; the keys of one of another format would be called unknown.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, known: &str) -> Result<T, SimError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| SimError::Io { path: path.to_owned(), source })?;
    if let Some(Value::String(found)) = text.parse::<Table>().ok().and_then(|mut file| file.remove("format"))
    {
        expect_format(path, &found, known)?;
    }
    toml::from_str(&text)
        .map_err(|error| SimError::File { path: path.to_owned(), message: error.to_string() })
}

pub(crate) fn expect_format(path: &Path, found: &str, known: &str) -> Result<(), SimError> {
    if found == known {
        return Ok(());
    }
    let message = format!("format = \"{found}\": this reader knows \"{known}\"");
    Err(SimError::File { path: path.to_owned(), message })
}

pub(crate) fn in_file(path: &Path, error: &SimError) -> SimError {
    SimError::File { path: path.to_owned(), message: error.to_string() }
}
