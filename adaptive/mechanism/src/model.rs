//! A nominal mechanism with added effects, and its parameters.

use crate::drive::Drive;
use crate::laws::{Applies, BASE_TILT, ENCODER_OFFSET, JointKind, PAYLOAD, ParamSpec, Spec, stop_positions};
use crate::prior::Prior;
use crate::problem::{AxisSetup, JointSetup, Problem};
use crate::units::{EffortUnit, Unit};
use std::collections::BTreeMap;
use trundle_record::EffortSource;

/// Standard deviation of a parameter's prior, in units of its scale.
const PRIOR_SD: f64 = 10.0;
/// Standard deviation of the logarithm of the masses of a model (MECHANISM.md).
const LOG_MASS_SD: f64 = 0.3;
/// Smallest mass as a share of the model's. The prior excludes smaller ones.
const MIN_MASS_SHARE: f64 = 0.01;

/// Standard deviation of the timing of a drive between samples, as a share of its largest value.
const TIMING_SD: f64 = 0.5;

/// Least limit of a drive, in rms efforts, where no inertia is given: an effort that is always at its limit could be
/// balanced by dry friction alone.
const MIN_UNSCALED_LIMIT: f64 = 1.2;

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

    /// All effects that may be added to a mechanism.
    #[must_use]
    pub fn candidates(problem: &Problem) -> Vec<Self> {
        let mut all = vec![];
        for j in 0..problem.joints.len() {
            if problem.samples(j) == 0 {
                continue;
            }
            all.extend(
                JointKind::ALL.iter().filter(|k| applies(problem, **k, j)).map(|k| Self::Joint(*k, j)),
            );
            let has_gravity = problem.axis.is_none_or(|axis| axis.gravity_torque.is_some());
            if has_gravity {
                all.push(Self::EncoderOffset(j));
            }
        }
        if problem.axis.is_none() {
            all.extend((0..problem.bodies.len()).map(Self::Payload));
        }
        if problem.axis.is_none() && problem.simulator.is_none() {
            all.push(Self::BaseTilt);
        }
        all
    }
}

/// Whether a law can act on a joint and is not part of the nominal model.
fn applies(problem: &Problem, kind: JointKind, j: usize) -> bool {
    let joint = &problem.joints[j];
    let (is_measured, is_commanded) = match joint.drive {
        Drive::None => (false, false),
        Drive::Effort(EffortSource::Commanded | EffortSource::Voltage) => (false, true),
        Drive::Effort(_) => (true, false),
        Drive::Target => (false, true),
    };
    let is_effort = matches!(joint.drive, Drive::Effort(_));
    let has_fixed_gain = problem.episodes.iter().all(|e| e.joints[j].gain.is_some());
    let is_free =
        |key: &str| slots(problem, &[]).iter().any(|s| s.joint == Some(j) && s.name.starts_with(key));
    match kind {
        JointKind::ViscousFriction => {
            !is_free("damping") && (joint.switches_off || !is_free("drive_damping"))
        }
        JointKind::RotorInertia => {
            let has_inertia = problem.axis.is_none_or(|axis| axis.inertia.is_some());
            has_inertia && !is_free("armature") && !is_free("inertia")
        }
        // A common gain is the scale of all forces: something else must fix it.
        JointKind::EffortGain => is_effort && has_fixed_gain && scale_is_known(problem),
        JointKind::EffortBias => is_effort,
        // Without a known inertia, a play that never closes would explain any motion.
        JointKind::Backlash => joint.drive != Drive::None && scale_is_known(problem),
        _ => match kind.spec().applies {
            Applies::Always => true,
            Applies::Driven => joint.drive != Drive::None,
            Applies::MeasuredEffort => is_measured,
            Applies::CommandedEffort => is_commanded,
            Applies::Loaded => joint.drive != Drive::None || joint.has_load,
        },
    }
}

/// Whether masses, an inertia or a gravity torque are given, so that a gain has a meaning.
fn scale_is_known(problem: &Problem) -> bool {
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

/// The free parameters of the nominal mechanism, then those of the effects.
pub(crate) fn slots(problem: &Problem, effects: &[Effect]) -> Vec<Slot> {
    let mut found = vec![];
    for j in 0..problem.joints.len() {
        found.extend(joint_slots(problem, j));
    }
    for (b, (body, mass)) in problem.bodies.iter().enumerate() {
        if *mass > 0.0 && is_free(problem, "mass", body) {
            found.push(Slot {
                name: format!("mass:{body}"),
                unit: Unit::Mass,
                joint: None,
                role: Role::Nominal(Nominal::Mass(b)),
                start: *mass,
                bounds: [MIN_MASS_SHARE * mass, f64::INFINITY],
                prior: Prior::LogNormal { median: *mass, log_sd: LOG_MASS_SD },
            });
        }
    }
    for (k, parameter) in problem.simulator.iter().flat_map(|s| &s.parameters).enumerate() {
        found.push(Slot {
            name: parameter.name.clone(),
            unit: Unit::Stated(parameter.unit),
            joint: None,
            role: Role::Nominal(Nominal::Parameter(k)),
            start: parameter.start,
            bounds: parameter.bounds,
            prior: Prior::Normal { mean: parameter.start, sd: parameter.sd },
        });
    }
    for (k, effect) in effects.iter().enumerate() {
        for (i, param) in effect.kind.params().iter().enumerate() {
            if param.is_choice || effect.values[i].is_nan() {
                continue;
            }
            found.push(effect_slot(problem, effect, (k, i), param));
        }
    }
    found
}

fn effect_slot(problem: &Problem, effect: &Effect, (k, i): (usize, usize), param: &ParamSpec) -> Slot {
    let scale = match effect.kind {
        Kind::Joint(_, j) | Kind::EncoderOffset(j) => param.scale.of(&problem.joints[j].scales),
        Kind::Payload(body) if param.unit == Unit::Mass => problem.bodies[body].1.max(f64::MIN_POSITIVE),
        Kind::Payload(body) => problem.farthest_payload[body],
        Kind::BaseTilt => 1.0,
    };
    let joint = match effect.kind {
        Kind::Joint(_, j) => Some(j),
        Kind::EncoderOffset(j) if problem.axis.is_some() => Some(j),
        _ => None,
    };
    let mut bounds = param.bounds.map(|bound| bound * scale);
    match effect.kind {
        Kind::Joint(JointKind::EffortSaturation, _) if !scale_is_known(problem) => {
            bounds[0] = MIN_UNSCALED_LIMIT * scale;
        }
        Kind::Joint(JointKind::Stop, j) if param.is_limit => {
            bounds = stop_positions(&problem.joints[j].scales, &effect.values);
        }
        _ => {}
    }
    let centre = match param.unit {
        Unit::Position if param.bounds[0] < 0.0 => effect.values[i],
        _ => 0.0,
    };
    let sd = match param.unit {
        Unit::Length => scale,
        _ => PRIOR_SD * scale.max(effect.values[i].abs()),
    };
    Slot {
        name: format!("{}.{}", label(problem, effect.kind), param.name),
        unit: param.unit,
        joint,
        role: Role::Effect(k, i),
        start: effect.values[i],
        bounds,
        prior: Prior::Normal { mean: centre, sd },
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

fn is_free(problem: &Problem, key: &str, name: &str) -> bool {
    problem.free.as_ref().is_none_or(|free| {
        free.iter().any(|entry| entry == key || entry.split_once(':') == Some((key, name)))
    })
}

/// The slots of the nominal model at one joint.
fn joint_slots(problem: &Problem, j: usize) -> Vec<Slot> {
    let mut found = JointSlots { problem, j, slots: vec![] };
    found.add_timing();
    match problem.axis {
        Some(axis) => found.add_axis(axis),
        None => found.add_armature(),
    }
    found.add_damping();
    match problem.joints[j].drive {
        Drive::Effort(source) => found.add_effort_drive(source),
        Drive::Target => found.add_position_drive(),
        Drive::None => {}
    }
    found.slots
}

/// Slots of the nominal model at a joint, as they are added.
struct JointSlots<'a> {
    problem: &'a Problem,
    j: usize,
    slots: Vec<Slot>,
}

impl JointSlots<'_> {
    fn joint(&self) -> &JointSetup {
        &self.problem.joints[self.j]
    }

    fn is_free(&self, key: &str) -> bool {
        is_free(self.problem, key, &self.joint().name)
    }

    /// Effort over the scale of another quantity, or 1 if it is not defined.
    fn effort_over(&self, divisor: f64) -> f64 {
        let ratio = self.joint().scales.effort / divisor;
        if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
    }

    fn inertia_scale(&self) -> f64 {
        self.effort_over(self.joint().scales.acceleration)
    }

    fn damping_scale(&self) -> f64 {
        self.effort_over(self.joint().scales.velocity)
    }

    fn add(&mut self, key: &str, unit: Unit, role: Nominal, start: f64, lower: f64, scale: f64) {
        self.slots.push(Slot {
            name: format!("{key}:{}", self.joint().name),
            unit,
            joint: Some(self.j),
            role: Role::Nominal(role),
            start,
            bounds: [lower, f64::INFINITY],
            prior: Prior::Normal { mean: start, sd: PRIOR_SD * scale.max(start.abs()) },
        });
    }

    fn add_timing(&mut self) {
        let timing = self.joint().timing;
        if timing[0] < timing[1] {
            self.slots.push(Slot {
                name: format!("timing:{}", self.joint().name),
                unit: Unit::Time,
                joint: Some(self.j),
                role: Role::Nominal(Nominal::Timing),
                start: 0.0,
                bounds: timing,
                prior: Prior::Normal { mean: 0.0, sd: TIMING_SD * timing[1].max(-timing[0]) },
            });
        }
    }

    /// Inertia, armature and gravity of an axis without a model.
    fn add_axis(&mut self, axis: AxisSetup) {
        let inertia = self.inertia_scale();
        if axis.inertia.is_none() && self.problem.effort_unit != EffortUnit::PerInertia {
            self.add("inertia", Unit::Inertia, Nominal::Inertia, inertia, 0.0, inertia);
        }
        if self.problem.free.is_some() && axis.inertia.is_some() && self.is_free("armature") {
            self.add("armature", Unit::Inertia, Nominal::Armature, 0.0, 0.0, inertia);
        }
        if axis.gravity && axis.gravity_torque.is_none() {
            let scale = self.joint().scales.effort.max(f64::MIN_POSITIVE);
            self.add("gravity_sin", Unit::Effort, Nominal::GravitySin, 0.0, f64::NEG_INFINITY, scale);
            self.add("gravity_cos", Unit::Effort, Nominal::GravityCos, 0.0, f64::NEG_INFINITY, scale);
        }
    }

    /// Armature of a joint of a model.
    fn add_armature(&mut self) {
        if self.is_free("armature") {
            let [armature, _, _] = self.problem.of_model[self.j];
            let scale = self.inertia_scale();
            self.add("armature", Unit::Inertia, Nominal::Armature, armature, 0.0, scale);
        }
    }

    fn add_damping(&mut self) {
        if self.is_free("damping") {
            let [_, damping, _] = self.problem.of_model[self.j];
            let scale = self.damping_scale();
            self.add("damping", Unit::Damping, Nominal::Damping, damping, 0.0, scale);
        }
    }

    /// Whether the gain of the drive is free, and something else fixes the scale of efforts.
    fn has_free_gain(&self) -> bool {
        let fixes_scale = matches!(self.problem.effort_unit, EffortUnit::Recorded | EffortUnit::TargetError);
        self.problem.episodes.iter().any(|e| e.joints[self.j].gain.is_none()) && !fixes_scale
    }

    fn add_effort_drive(&mut self, source: EffortSource) {
        if self.has_free_gain() {
            let start = self.joint().reference_gain;
            self.add("gain", Unit::One, Nominal::Gain, start, f64::NEG_INFINITY, start);
        }
        if source == EffortSource::Voltage && self.joint().switches_off {
            let scale = self.damping_scale();
            self.add("back_emf", Unit::Damping, Nominal::BackEmf, 0.0, 0.0, scale);
        }
    }

    fn add_position_drive(&mut self) {
        if self.has_free_gain() {
            let start = self.joint().reference_gain;
            self.add("drive_stiffness", Unit::Stiffness, Nominal::Gain, start, 0.0, start);
        }
        // While the drive is on, its damping cannot be distinguished from that of the joint.
        let is_distinct = self.joint().switches_off || !self.is_free("damping");
        let is_unknown = self.problem.episodes.iter().any(|e| e.joints[self.j].drive_damping.is_none());
        if is_unknown && is_distinct {
            let scale = self.damping_scale();
            self.add("drive_damping", Unit::Damping, Nominal::DriveDamping, 0.0, 0.0, scale);
        }
    }
}
