//! The equation of one joint along the measured motion: what its drive and the laws exert, less what the mechanism
//! needs. Its residual ([`residual`]) is zero for the right model.

mod residual;
mod transmission;

use crate::drive::Drive;
use crate::dynamics::{AxisLoad, InverseDynamics};
use crate::laws::{JointSample, Law, law_terms};
use crate::model::{Effect, Kind, Nominal, Role, Slot};
use crate::problem::{JointSetup, Problem};
use crate::series::Series;
use crate::signals::{delayed, lagged};
use trundle_model::Real;

/// Parameters of one joint's equation, and its laws.
#[derive(Clone, Debug)]
pub(crate) struct JointModel<T> {
    inertia: T,
    armature: T,
    damping: T,
    gravity: [T; 2],
    gain: Option<T>,
    drive_damping: Option<T>,
    back_emf: T,
    /// Time by which the drive acts after its record.
    timing: Option<T>,
    offset: T,
    /// Whether no drive acts on this joint of a model.
    is_passive: bool,
    laws: Vec<Law<T>>,
}

impl<T: Real> JointModel<T> {
    /// The model of joint `j`. `value` gives a slot's value, with derivatives or without.
    pub fn new(
        problem: &Problem,
        j: usize,
        effects: &[Effect],
        slots: &[Slot],
        value: impl Fn(usize) -> T,
    ) -> Self {
        let axis = problem.axis;
        let [armature, damping, _] = problem.of_model[j];
        let mut model = Self {
            inertia: T::lift(axis.map_or(0.0, |axis| axis.inertia.unwrap_or(1.0))),
            armature: T::lift(armature),
            damping: T::lift(damping),
            gravity: [T::lift(axis.and_then(|axis| axis.gravity_torque).unwrap_or(0.0)), T::zero()],
            gain: None,
            drive_damping: None,
            back_emf: T::zero(),
            timing: None,
            offset: T::zero(),
            is_passive: axis.is_none() && problem.joints[j].drive == Drive::None,
            laws: vec![],
        };
        let constant = |x: &f64| T::lift(*x);
        let mut values: Vec<Vec<T>> =
            effects.iter().map(|e| e.values.iter().map(constant).collect()).collect();
        for (index, slot) in slots.iter().enumerate().filter(|(_, slot)| slot.joint == Some(j)) {
            let found = value(index);
            match slot.role {
                Role::Nominal(Nominal::Inertia) => model.inertia = found,
                Role::Nominal(Nominal::Armature) => model.armature = found,
                Role::Nominal(Nominal::Damping) => model.damping = found,
                Role::Nominal(Nominal::GravitySin) => model.gravity[0] = found,
                Role::Nominal(Nominal::GravityCos) => model.gravity[1] = found,
                Role::Nominal(Nominal::Gain) => model.gain = Some(found),
                Role::Nominal(Nominal::DriveDamping) => model.drive_damping = Some(found),
                Role::Nominal(Nominal::BackEmf) => model.back_emf = found,
                Role::Nominal(Nominal::Timing) => model.timing = Some(found),
                Role::Nominal(Nominal::Mass(_) | Nominal::Parameter(_)) => {}
                Role::Effect(effect, param) => values[effect][param] = found,
            }
        }
        for (effect, values) in effects.iter().zip(&values) {
            match effect.kind {
                Kind::Joint(kind, joint) if joint == j => model.laws.push(Law::of(kind, values)),
                Kind::EncoderOffset(joint) if joint == j && axis.is_some() => model.offset = values[0],
                _ => {}
            }
        }
        model
    }

    /// Commands after delays and lags, at every time of an episode.
    pub fn commands(&self, series: &Series, dt: f64) -> Vec<T> {
        let mut command: Vec<T> = series.command.iter().map(|c| T::lift(*c)).collect();
        if let Some(delay) = self.laws.iter().filter_map(Law::delay).chain(self.timing).reduce(|a, b| a + b) {
            command = delayed(&series.command, delay / dt);
        }
        for lag in self.laws.iter().filter_map(Law::lag) {
            command = lagged(&command, lag, dt);
        }
        command
    }

    /// The recorded commands for commands that act without delays and lags: the inverse of [`Self::commands`].
    pub fn uncommanded(&self, acting: &[f64], dt: f64) -> Vec<f64> {
        let mut command = acting.to_vec();
        for lag in self.laws.iter().rev().filter_map(Law::lag) {
            command = lagged(&command, -lag.re(), dt);
        }
        let delay: f64 = self.laws.iter().filter_map(Law::delay).map(|delay| delay.re()).sum();
        if delay == 0.0 { command } else { delayed(&command, -delay / dt) }
    }

    /// The same model without delays and lags.
    pub fn without_delays(&self) -> Self {
        let mut found = self.clone();
        found.laws.retain(|law| law.delay().is_none() && law.lag().is_none());
        found
    }

    /// Gain of the drive in an episode.
    pub fn gain_of(&self, series: &Series) -> T {
        series.gain.map(T::lift).or(self.gain).unwrap_or_else(|| T::lift(1.0))
    }

    /// Effort of the drive for the largest command of the training episodes, without other laws.
    fn largest_effort(&self, setup: &JointSetup, series: &Series) -> f64 {
        setup.largest_command * self.gain_of(series).re().abs()
    }

    /// True effort for a recorded one.
    fn corrected(&self, series: &Series, command: T) -> T {
        self.laws.iter().fold(command * self.gain_of(series), |effort, law| law.correct(effort))
    }

    /// Effort of the drive for a command at position `q` and velocity `v`; `on` is whether it is switched on.
    pub fn drive_effort(&self, setup: &JointSetup, series: &Series, command: T, [q, v, on]: [f64; 3]) -> T {
        let gain = self.gain_of(series);
        let largest = self.largest_effort(setup, series);
        let mut effort = match setup.drive {
            Drive::None => return T::zero(),
            Drive::Effort(_) => self.corrected(series, command),
            Drive::Target => {
                let damping =
                    series.drive_damping.map(T::lift).or(self.drive_damping).unwrap_or_else(T::zero);
                gain * (command - q) - damping * v
            }
        };
        effort = self.laws.iter().fold(effort, |effort, law| law.drive(effort, largest));
        if let Some(limit) = series.limit.filter(|limit| effort.re().abs() > *limit) {
            effort = T::lift(limit.copysign(effort.re()));
        }
        effort * on
    }

    /// Whether the derivative of the residual by the needed effort is minus [`residual::Residual::per_effort`], and no law reads the own
    /// inertia.
    pub fn is_linear_in_inverse_dynamics(&self) -> bool {
        let is_linear =
            |law: &Law<T>| !law.reads_external() && law.compliance().is_none() && law.gap().is_none();
        !self.is_passive && self.laws.iter().all(is_linear)
    }

    /// Effort that the links need without armature, damping and friction. `dynamics` is that of a model.
    fn required_effort(
        &self,
        series: &Series,
        load: &AxisLoad,
        dynamics: Option<&InverseDynamics<T>>,
    ) -> Vec<T> {
        let axis = |k: usize| {
            let (sin, cos) = (-self.offset + series.q[k]).sin_cos();
            let own = self.inertia * series.a[k] * load.inertia_factor;
            own + (self.gravity[0] * sin + self.gravity[1] * cos) * load.gravity_factor
                + sin * load.gravity_torque
                + (load.inertia * series.a[k] + load.effort)
        };
        (0..series.q.len()).map(|k| dynamics.map_or_else(|| axis(k), |dynamics| dynamics.effort[k])).collect()
    }
}

impl JointModel<f64> {
    /// Whether its laws can be simulated forward.
    pub fn can_be_simulated(&self) -> bool {
        self.compliance().is_none() && self.gap().is_none()
    }

    /// Torque that gravity exerts on an axis at a position.
    pub fn gravity_at(&self, q: f64) -> f64 {
        let (sin, cos) = (q - self.offset).sin_cos();
        -(self.gravity[0] * sin + self.gravity[1] * cos)
    }

    /// Effort of the laws, level of dry friction, damping, and inertia that they add, at a state.
    pub fn terms(&self, at: &JointSample<f64>, on: f64) -> [f64; 4] {
        let [effort, dry, inertia] = law_terms(&self.laws, at);
        [effort, dry, self.damping + self.back_emf * on, self.armature + inertia]
    }

    /// Position and velocity of an axis after a step of `dt` seconds. Damping and dry friction are implicit.
    pub fn step(&self, at: &JointSample<f64>, known: f64, on: f64, dt: f64) -> [f64; 2] {
        let [laws, dry, damping, inertia] = self.terms(at, on);
        let inertia = (self.inertia + inertia).max(f64::MIN_POSITIVE);
        let force = at.drive.unwrap_or(0.0) + known + self.gravity_at(at.q) + laws;
        let (free, stopping) = (at.v + dt * force / inertia, dt * dry / inertia);
        let sliding = (free - stopping.copysign(free)) / (1.0 + dt * damping / inertia);
        let v = if free.abs() <= stopping { 0.0 } else { sliding };
        [at.q + dt * v, v]
    }
}
