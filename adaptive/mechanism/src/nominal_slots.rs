//! The free parameters of the nominal mechanism.

use crate::drive::Drive;
use crate::model::{Nominal, PRIOR_SD, Role, Slot};
use crate::prior::Prior;
use crate::problem::{AxisSetup, JointSetup, Problem};
use crate::units::{EffortUnit, Unit};
use trundle_record::EffortSource;

/// Standard deviation of the logarithm of the masses of a model (MECHANISM.md).
const LOG_MASS_SD: f64 = 0.3;
/// Smallest mass as a share of the model's. The prior excludes smaller ones.
const MIN_MASS_SHARE: f64 = 0.01;

/// Standard deviation of the timing of a drive between samples, as a share of its largest value.
const TIMING_SD: f64 = 0.5;

/// The free parameters of the nominal mechanism: of the joints, masses, and parameters of a simulator.
pub(crate) fn nominal_slots(problem: &Problem) -> Vec<Slot> {
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
    found
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
