//! A nominal mechanism with added effects, and its parameters.

use crate::laws::{BASE_TILT, ENCODER_OFFSET, JointKind, PAYLOAD, ParamSpec, Spec};
use crate::prior::Prior;
use crate::problem::Problem;
use crate::units::Unit;
use std::collections::BTreeMap;

/// Standard deviation of a parameter's prior, in units of its scale.
pub(crate) const PRIOR_SD: f64 = 10.0;

/// Kind of an added effect, with the place where it acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A law of a joint.
    Joint(JointKind, usize),
    /// A point mass on a body.
    Payload(usize),
    /// Gravity that is turned about the world's axes.
    BaseTilt,
    /// An offset of a joint's encoder.
    EncoderOffset(usize),
}

impl Kind {
    /// Entry in the catalogue.
    #[must_use]
    pub fn spec(self) -> &'static Spec {
        match self {
            Self::Joint(kind, _) => kind.spec(),
            Self::Payload(_) => PAYLOAD,
            Self::BaseTilt => BASE_TILT,
            Self::EncoderOffset(_) => ENCODER_OFFSET,
        }
    }

    /// Name of the effect in a diagnosis.
    #[must_use]
    pub fn effect(self) -> &'static str {
        self.spec().effect
    }

    /// Parameters.
    #[must_use]
    pub fn params(self) -> &'static [ParamSpec] {
        self.spec().params
    }

    /// The joint on which it acts.
    #[must_use]
    pub fn joint(self) -> Option<usize> {
        match self {
            Self::Joint(_, joint) | Self::EncoderOffset(joint) => Some(joint),
            Self::Payload(_) | Self::BaseTilt => None,
        }
    }

    /// Starting values of a fit.
    #[must_use]
    pub fn starts(self, problem: &Problem) -> Vec<Vec<f64>> {
        match self {
            Self::Joint(kind, joint) => (kind.spec().starts)(&problem.joints[joint].scales),
            Self::Payload(body) => vec![vec![0.1 * problem.bodies[body].1, 0.0, 0.0, 0.0]],
            Self::BaseTilt => vec![vec![0.01, 0.01]],
            Self::EncoderOffset(joint) => vec![vec![0.01 * problem.joints[joint].scales.span()]],
        }
    }
}

/// Whether masses, an inertia or a gravity torque are given, so that a gain has a meaning.
pub(crate) fn scale_is_known(problem: &Problem) -> bool {
    problem.axis.is_none_or(|axis| axis.inertia.is_some() || axis.gravity_torque.is_some())
}

/// An added effect with its values. NaN leaves a refinement at its default.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Kind and place.
    pub kind: Kind,
    /// Values in the order of its parameters.
    pub values: Vec<f64>,
}

/// A parameter of the nominal mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Nominal {
    Inertia,
    Armature,
    Damping,
    GravitySin,
    GravityCos,
    Gain,
    DriveDamping,
    BackEmf,
    Timing,
    /// Mass of a body.
    Mass(usize),
    /// Parameter of the user's own simulator.
    Parameter(usize),
}

/// What a slot belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Nominal(Nominal),
    /// Index of the effect, and of its parameter.
    Effect(usize, usize),
}

/// A free parameter.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// `damping:elbow`, `joint_dry_friction:elbow.effort`, …
    pub name: String,
    pub unit: Unit,
    /// The joint whose equation it enters; `None` if it enters all.
    pub joint: Option<usize>,
    pub role: Role,
    pub start: f64,
    pub bounds: [f64; 2],
    pub prior: Prior,
}

impl Slot {
    /// Whether it is the timing of a drive between samples.
    pub fn is_timing(&self) -> bool {
        self.role == Role::Nominal(Nominal::Timing)
    }
}

/// Where an effect acts, as in `diagnosis.json`.
pub(crate) fn place(problem: &Problem, kind: Kind) -> Option<BTreeMap<&'static str, String>> {
    match kind {
        Kind::Payload(body) => Some(BTreeMap::from([("body", problem.bodies[body].0.clone())])),
        _ => kind.joint().map(|j| BTreeMap::from([("joint", problem.joints[j].name.clone())])),
    }
}

/// `effect:joint`, `payload:body`, or the effect's name.
pub(crate) fn label(problem: &Problem, kind: Kind) -> String {
    let place = match kind {
        Kind::Joint(_, j) | Kind::EncoderOffset(j) => Some(&problem.joints[j].name),
        Kind::Payload(body) => Some(&problem.bodies[body].0),
        Kind::BaseTilt => None,
    };
    place.map_or_else(|| kind.effect().to_owned(), |place| format!("{}:{place}", kind.effect()))
}
