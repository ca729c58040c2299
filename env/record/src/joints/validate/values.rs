//! Validation of the values in `[effort]`, `[target]`, `[encoder]`, `[noise]`, `[delay]` and `[episode.NAME]`.

use super::refuse::refuse;
use crate::error::Error;
use crate::joints::drive::{EffortMeta, Payload, TargetMeta};
use crate::joints::metadata::JointMetadata;
use crate::joints::per_joint::{FreeOr, PerJoint};

/// Whether a number is valid, why not, and what to do.
type Rule = (fn(f64) -> bool, &'static str, &'static str);

const GAIN: Rule = (
    |x| x.is_finite() && x != 0.0,
    "is zero or not finite",
    "give N m or N per recorded unit, negative if the sign is reversed, or \"free\"",
);
const STIFFNESS: Rule = (
    |x| x.is_finite() && x > 0.0,
    "is not a positive, finite number",
    "give N m/rad or N/m, or \"free\" if it is unknown",
);
const DAMPING: Rule = (
    |x| x.is_finite() && x >= 0.0,
    "is negative or not finite",
    "give N m s/rad or N s/m, or \"free\" if it is unknown",
);
const LIMIT: Rule = (
    |x| x.is_finite() && x > 0.0,
    "is not a positive, finite number",
    "give the largest effort in N m or N, or remove the key",
);
const NOISE: Rule = (
    |x| x.is_finite() && x > 0.0,
    "is not a positive, finite number",
    "give one standard deviation (position_step: the step) in SI units, or remove the key to estimate the noise",
);
const DELAY: Rule = (f64::is_finite, "is not finite", "give by how much the stream is late, in seconds");

pub(super) fn check(metadata: &JointMetadata) -> Result<(), Error> {
    let scope = Scope { joints: &metadata.mechanism.joints, prefix: String::new() };
    scope.effort(&metadata.effort)?;
    scope.target(&metadata.target)?;
    scope.names("encoder.side", metadata.encoder.side.as_ref())?;
    if let Some(noise) = &metadata.noise {
        scope.numbers("noise.position", noise.position.as_ref(), NOISE)?;
        scope.numbers("noise.position_step", noise.position_step.as_ref(), NOISE)?;
        scope.numbers("noise.velocity", noise.velocity.as_ref(), NOISE)?;
        scope.numbers("noise.effort", noise.effort.as_ref(), NOISE)?;
    }
    let delay = &metadata.delay;
    let streams = [("q", &delay.q), ("v", &delay.v), ("effort", &delay.effort), ("target", &delay.target)];
    for (stream, values) in streams {
        scope.numbers(&format!("delay.{stream}"), values.as_ref(), DELAY)?;
    }
    metadata.episode.keys().try_for_each(|name| check_episode(metadata, name))
}

fn check_episode(metadata: &JointMetadata, name: &str) -> Result<(), Error> {
    let Some(meta) = metadata.episode.get(name) else { return Ok(()) };
    let scope = Scope { joints: &metadata.mechanism.joints, prefix: format!("episode.{name}.") };
    scope.effort(&meta.effort)?;
    scope.target(&meta.target)?;
    let has_model = metadata.mechanism.model.is_some();
    if let (Some(model), false) = (&meta.model, has_model) {
        let problem = "is the model of an episode of an axis without a model";
        let remedy = "give mechanism.model instead of axis, or remove the key";
        return refuse(&format!("episode.{name}.model"), format!("{model:?}"), problem, remedy);
    }
    match &meta.payload {
        Some(payload) => check_payload(&format!("episode.{name}.payload"), payload, has_model),
        None => Ok(()),
    }
}

fn check_payload(key: &str, payload: &Payload, has_model: bool) -> Result<(), Error> {
    if !has_model || payload.body.is_empty() {
        let problem = if has_model {
            "does not name a body"
        } else {
            "is a body, but an axis without a model has none"
        };
        let remedy = "name a body of mechanism.model, or remove the payload";
        return refuse(&format!("{key}.body"), format!("{:?}", payload.body), problem, remedy);
    }
    if !(payload.mass >= 0.0 && payload.mass.is_finite()) {
        let problem = "is negative or not finite";
        return refuse(&format!("{key}.mass"), payload.mass.to_string(), problem, "give the mass in kg");
    }
    match payload.com.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => {
            let value = format!("{:?}", payload.com);
            refuse(&format!("{key}.com"), value, "is not finite", "give the place in the body's axes, in m")
        }
    }
}

/// Checks of tables whose keys begin with `prefix`.
struct Scope<'a> {
    joints: &'a [String],
    prefix: String,
}

impl Scope<'_> {
    fn group(&self, name: &str) -> String {
        // The keys of an episode are flat.
        if self.prefix.is_empty() { format!("{name}.") } else { self.prefix.clone() }
    }

    fn effort(&self, meta: &EffortMeta) -> Result<(), Error> {
        let group = self.group("effort");
        self.names(&format!("{group}source"), meta.source.as_ref())?;
        self.free_numbers(&format!("{group}gain"), meta.gain.as_ref(), GAIN)?;
        self.names(&format!("{group}signed"), meta.signed.as_ref())
    }

    fn target(&self, meta: &TargetMeta) -> Result<(), Error> {
        let group = self.group("target");
        self.free_numbers(&format!("{group}stiffness"), meta.stiffness.as_ref(), STIFFNESS)?;
        self.free_numbers(&format!("{group}damping"), meta.damping.as_ref(), DAMPING)?;
        self.numbers(&format!("{group}limit"), meta.limit.as_ref(), LIMIT)
    }

    /// Refuses a table by joint that names a joint which was not recorded.
    fn names<T>(&self, key: &str, values: Option<&PerJoint<T>>) -> Result<(), Error> {
        let named = values.into_iter().flat_map(|values| values.entries()).filter_map(|(joint, _)| joint);
        let mut unknown = named.filter(|joint| !self.joints.iter().any(|known| known == joint));
        match unknown.next() {
            None => Ok(()),
            Some(joint) => {
                let value = format!("{joint:?} (the recorded joints are {})", self.joints.join(", "));
                refuse(key, value, "is not a recorded joint", "name joints of mechanism.joints")
            }
        }
    }

    fn numbers(&self, key: &str, values: Option<&PerJoint<f64>>, rule: Rule) -> Result<(), Error> {
        self.names(key, values)?;
        let entries = values.into_iter().flat_map(|values| values.entries());
        entries
            .map(|(joint, value)| (joint, *value))
            .try_for_each(|(joint, value)| number(key, joint, value, rule))
    }

    fn free_numbers(&self, key: &str, values: Option<&PerJoint<FreeOr>>, rule: Rule) -> Result<(), Error> {
        self.names(key, values)?;
        let entries = values.into_iter().flat_map(|values| values.entries());
        let mut given = entries.filter_map(|(joint, value)| Some((joint, value.value()?)));
        given.try_for_each(|(joint, value)| number(key, joint, value, rule))
    }
}

fn number(
    key: &str,
    joint: Option<&str>,
    value: f64,
    (is_valid, problem, remedy): Rule,
) -> Result<(), Error> {
    let key = joint.map_or(key.to_owned(), |joint| format!("{key}.{joint}"));
    if is_valid(value) { Ok(()) } else { refuse(&key, value.to_string(), problem, remedy) }
}
