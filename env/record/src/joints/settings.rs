//! Values of the metadata for one joint in one episode, with the defaults of the format.

use super::drive::{EffortMeta, EffortSource, EncoderSide};
use super::metadata::JointMetadata;
use super::per_joint::{FreeOr, PerJoint};

/// Meaning of the effort of one joint in one episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortSettings {
    /// Origin of the effort.
    pub source: EffortSource,
    /// N m or N per recorded unit.
    pub gain: FreeOr,
    /// Whether the effort has a sign.
    pub signed: bool,
}

/// Drive of one joint with a target in one episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetSettings {
    /// N m/rad or N/m.
    pub stiffness: FreeOr,
    /// N m s/rad or N s/m.
    pub damping: FreeOr,
    /// Largest effort, N m or N; `None`: not limited.
    pub limit: Option<f64>,
}

impl JointMetadata {
    /// Whether `episode` is held out: predicted, never fitted.
    pub fn is_held_out(&self, episode: &str) -> bool {
        self.split.held_out.iter().any(|name| name == episode)
    }

    /// Path of the model in `episode`, inside the folder; `None` for an axis without a model.
    pub fn model_of(&self, episode: &str) -> Option<&str> {
        let own = self.episode.get(episode).and_then(|meta| meta.model.as_deref());
        own.or(self.mechanism.model.as_deref())
    }

    /// Meaning of the effort of `joint` in `episode`. The gain is 1 where none is given.
    pub fn effort_of(&self, episode: &str, joint: &str) -> EffortSettings {
        let own = self.episode.get(episode).map(|meta| &meta.effort);
        EffortSettings {
            source: value(own, &self.effort, joint, |meta| &meta.source).unwrap_or_default(),
            gain: value(own, &self.effort, joint, |meta| &meta.gain).unwrap_or(FreeOr::Value(1.0)),
            signed: value(own, &self.effort, joint, |meta| &meta.signed).unwrap_or(true),
        }
    }

    /// Whether a gain is given for the effort of `joint` in `episode`.
    pub(crate) fn has_gain(&self, episode: &str, joint: &str) -> bool {
        let own = self.episode.get(episode).map(|meta| &meta.effort);
        value(own, &self.effort, joint, |meta: &EffortMeta| &meta.gain).is_some()
    }

    /// Drive of `joint` in `episode`, if it has a target and no effort.
    pub fn target_of(&self, episode: &str, joint: &str) -> TargetSettings {
        let own = self.episode.get(episode).map(|meta| &meta.target);
        TargetSettings {
            stiffness: value(own, &self.target, joint, |meta| &meta.stiffness).unwrap_or(FreeOr::Free),
            damping: value(own, &self.target, joint, |meta| &meta.damping).unwrap_or(FreeOr::Free),
            limit: value(own, &self.target, joint, |meta| &meta.limit),
        }
    }

    /// Side of the encoder of `joint`.
    pub fn encoder_side_of(&self, joint: &str) -> EncoderSide {
        self.encoder.side.as_ref().and_then(|side| side.of(joint)).copied().unwrap_or_default()
    }

    /// By how much the stream `prefix` (`q`, `v`, `effort`, `target`) of `joint` is late, s; 0 if it is not stated.
    pub fn delay_of(&self, prefix: &str, joint: &str) -> f64 {
        let stated = match prefix {
            "q" => &self.delay.q,
            "v" => &self.delay.v,
            "effort" => &self.delay.effort,
            "target" => &self.delay.target,
            _ => &None,
        };
        stated.as_ref().and_then(|delay| delay.of(joint)).copied().unwrap_or(0.0)
    }
}

/// The value of the episode `own`, otherwise that of all episodes.
fn value<M, T: Copy>(
    own: Option<&M>,
    all: &M,
    joint: &str,
    key: impl Fn(&M) -> &Option<PerJoint<T>>,
) -> Option<T> {
    let of = |meta: &M| key(meta).as_ref().and_then(|values| values.of(joint)).copied();
    own.and_then(of).or_else(|| of(all))
}
