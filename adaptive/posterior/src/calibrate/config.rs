//! Calibration file: `trundle-calibration/1`.

use crate::{Method, PosteriorError};
use serde::Deserialize;
use trundle_infer::{Coordinates, InferError};
use trundle_model::{Model, PriorFile};
use trundle_record::Noise;

/// Value of `format` in the file.
const FORMAT: &str = "trundle-calibration/1";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    name: String,
    #[serde(default)]
    method: Method,
    #[serde(default = "default_chains")]
    chains: usize,
    #[serde(default = "default_warmup")]
    warmup: usize,
    #[serde(default = "default_starts")]
    starts: usize,
    model: toml::Table,
    prior: toml::Table,
    push: Push,
    noise: NoiseFile,
    #[serde(default = "default_shrink")]
    shrink: f64,
}

fn default_chains() -> usize {
    4
}

fn default_starts() -> usize {
    6
}

fn default_warmup() -> usize {
    300
}

fn default_shrink() -> f64 {
    1.0
}

/// Settings of the simulated pushes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Push {
    /// Number of pushes in one recording.
    pub episodes: usize,
    /// Duration of each push, s.
    pub duration: f64,
    /// Standard deviation of the amplitudes of the force's four waves, N.
    pub force: f64,
    /// Position of the grasp, object frame, m.
    pub grasp: [f64; 2],
    /// Standard deviation of the grasp along the object's y, m.
    pub scatter: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseFile {
    /// Position, m; angle, rad.
    position: f64,
    angle: f64,
    /// One wrench sample, N and N·m.
    force: f64,
    torque: f64,
    /// Error of the tare, N and N·m.
    tare_force: f64,
    tare_torque: f64,
}

/// A calibration study: model, priors, pushes and sampling method.
pub struct Calibration {
    /// Name of the study.
    pub name: String,
    /// Names of the free parameters, in order.
    pub parameters: Vec<String>,
    pub(crate) method: Method,
    pub(crate) chains: usize,
    pub(crate) warmup: usize,
    pub(crate) starts: usize,
    pub(crate) model: Model,
    pub(crate) coordinates: Coordinates,
    pub(crate) push: Push,
    pub(crate) noise: Noise,
    pub(crate) tare: [f64; 3],
    /// Factor on the distance of the draws from their mean. Other values than one show that the test detects
    /// a wrong posterior.
    pub(crate) shrink: f64,
}

impl Calibration {
    /// Reads a calibration file.
    ///
    /// # Errors
    /// When the text is not a valid file, a name is unknown, or a setting cannot be simulated.
    pub fn from_toml(text: &str) -> Result<Self, PosteriorError> {
        let wrong = |reason: String| PosteriorError::Config { what: "calibration".to_owned(), reason };
        let file: File = toml::from_str(text).map_err(|e| wrong(e.to_string()))?;
        if file.format != FORMAT {
            return Err(wrong(format!("format = {:?}: must be {FORMAT:?}", file.format)));
        }
        let model = toml::to_string(&file.model).map_err(|e| wrong(e.to_string()))?;
        let model = Model::from_toml(&model).map_err(InferError::from)?.0;
        if model.body.fixtures.is_empty() {
            return Err(wrong(
                "model.body.footprint is missing: give the corners of the footprint, m".to_owned(),
            ));
        }
        validate(&file)?;
        let prior = toml::to_string(&file.prior).map_err(|e| wrong(e.to_string()))?;
        let prior = PriorFile::from_toml(&prior, "[prior]").map_err(InferError::from)?;
        if !prior.per_episode().is_empty() {
            return Err(wrong("[prior]: scope = \"episode\" is not supported; remove it".to_owned()));
        }
        let model = prior.apply(&model).map_err(InferError::from)?;
        let coordinates = Coordinates::new(&model);
        let free = coordinates.free().len();
        let parameters: Vec<String> = (0..free).map(|k| coordinates.slot(k).name.clone()).collect();
        let n = file.noise;
        Ok(Self {
            name: file.name,
            parameters,
            method: file.method,
            chains: file.chains,
            warmup: file.warmup,
            starts: file.starts,
            model,
            coordinates,
            push: file.push,
            noise: Noise {
                pose: [n.position, n.position, n.angle],
                force: n.force,
                torque: n.torque,
                time: 0.0,
                stated: true,
            },
            tare: [n.tare_force, n.tare_force, n.tare_torque],
            shrink: file.shrink,
        })
    }

    /// The same study with another method.
    #[must_use]
    pub fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The sampling method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The same study with draws scaled towards their mean by a factor, to check that calibration detects it.
    #[must_use]
    pub fn shrunk(self, shrink: f64) -> Self {
        Self { shrink, ..self }
    }
}

/// Checks the settings of the simulation.
fn validate(file: &File) -> Result<(), PosteriorError> {
    let refuse = |what: &'static str, value: f64| {
        Err(PosteriorError::Setting { what, value: value.to_string(), remedy: "give a number above zero" })
    };
    let n = &file.noise;
    let noise = [("noise.position", n.position), ("noise.angle", n.angle), ("noise.force", n.force)];
    let more = [("noise.torque", n.torque), ("push.force", file.push.force), ("shrink", file.shrink)];
    for (what, value) in noise.into_iter().chain(more).chain([("push.episodes", file.push.episodes as f64)]) {
        if !(value > 0.0 && value.is_finite()) {
            return refuse(what, value);
        }
    }
    if !(1.0..=60.0).contains(&file.push.duration) {
        let value = file.push.duration.to_string();
        return Err(PosteriorError::Setting { what: "push.duration", value, remedy: "give 1 to 60 s" });
    }
    Ok(())
}
