//! Residual of a joint's equation along an episode.

use super::JointModel;
use crate::backlash::Side;
use crate::deflection::Unmeasured;
use crate::drive::Drive;
use crate::dynamics::InverseDynamics;
use crate::laws::{JointSample, Law, magnitude};
use crate::problem::{EpisodeData, JointSetup, Problem};
use crate::residual_scaling::{at_least_small, delivered_share, inertia_share, passed_share};
use crate::series::Series;
use crate::signals::slope;
use trundle_model::Real;

/// The residual of a joint's equation over an episode.
#[derive(Clone, Debug)]
pub(crate) struct Residual<T> {
    /// Its values.
    pub values: Vec<T>,
    /// Its derivative by the effort on the joint; zero where friction holds the joint.
    pub per_effort: Vec<f64>,
    /// Level of the dry friction, effort.
    pub friction: Vec<f64>,
}

impl<T: Real> JointModel<T> {
    /// Residual at every time of an episode. `dynamics` is that of a model, if there is one.
    pub fn residual(
        &self,
        problem: &Problem,
        j: usize,
        episode: &EpisodeData,
        dynamics: Option<&InverseDynamics<T>>,
    ) -> Residual<T> {
        let signals = JointSignals::new(self, problem, j, episode, dynamics);
        let (elastic, passed) = signals.elastic_correction().unzip();
        let backlash = signals.backlash_correction();
        let factor = signals.residual_factor(passed, backlash.as_deref());
        let correction = elastic.or(backlash);
        let largest = self.largest_effort(signals.setup, signals.series);
        let len = signals.series.q.len();
        let (mut per_effort, mut friction) = (vec![0.0; len], vec![0.0; len]);
        let one = |k: usize| {
            let at = signals.sample(k);
            let (net, response) = signals.net_effort(k, &at, correction.as_deref(), largest);
            let level = signals.dry_friction(&at);
            friction[k] = level.re().abs();
            let Some(error) = signals.error(at.v, net, level) else { return T::zero() };
            // A law that strengthens the drive must not reduce the errors of the motion either.
            let factor = if response.re() >= 1.0 { factor } else { factor / at_least_small(response) };
            per_effort[k] = factor.re();
            error * factor
        };
        let values = (0..len).map(one).collect();
        Residual { values, per_effort, friction }
    }
}

/// Signals of a joint along an episode, from which its residual follows.
struct JointSignals<'a, T> {
    model: &'a JointModel<T>,
    problem: &'a Problem,
    joint: usize,
    episode: &'a EpisodeData,
    setup: &'a JointSetup,
    series: &'a Series,
    dynamics: Option<&'a InverseDynamics<T>>,
    /// Commands after delays and lags; empty without a drive.
    commands: Vec<T>,
    /// Effort of the drive before the filter; empty without a drive.
    unfiltered: Vec<T>,
    /// Effort of the drive; `None` without a drive.
    drive: Option<Vec<T>>,
    /// Known further efforts.
    known: Vec<f64>,
    /// Effort that the links need without armature, damping and friction.
    required: Vec<T>,
}

impl<'a, T: Real> JointSignals<'a, T> {
    fn new(
        model: &'a JointModel<T>,
        problem: &'a Problem,
        joint: usize,
        episode: &'a EpisodeData,
        dynamics: Option<&'a InverseDynamics<T>>,
    ) -> Self {
        let (setup, series) = (&problem.joints[joint], &episode.joints[joint]);
        let is_driven = setup.drive != Drive::None;
        let commands = if is_driven { model.commands(series, episode.dt) } else { vec![] };
        let drive_effort = |(k, command): (usize, &T)| {
            let at = [series.raw[k], slope(&series.raw, k, episode.dt), series.on[k]];
            model.drive_effort(setup, series, *command, at)
        };
        let unfiltered: Vec<T> = commands.iter().enumerate().map(drive_effort).collect();
        let drive = is_driven.then(|| episode.first_stage.filtered(&unfiltered));
        let known = episode.first_stage.filtered(&series.known);
        let required = model.required_effort(series, &episode.load, dynamics);
        Self {
            model,
            problem,
            joint,
            episode,
            setup,
            series,
            dynamics,
            commands,
            unfiltered,
            drive,
            known,
            required,
        }
    }
}

/// Values at one time.
impl<T: Real> JointSignals<'_, T> {
    /// What the laws read.
    fn sample(&self, k: usize) -> JointSample<T> {
        let series = self.series;
        JointSample {
            q: series.q[k],
            v: series.v[k],
            a: series.a[k],
            drive: self.drive.as_ref().map(|drive| drive[k]),
            external: self.own_inertia(k) * series.a[k] - self.required[k] + self.known[k],
            load: series.load.as_ref().map(|load| load[k]),
        }
    }

    /// Inertia of the links that the joint moves.
    fn own_inertia(&self, k: usize) -> T {
        let axis = || self.model.inertia * self.episode.load.inertia_factor + self.episode.load.inertia;
        let given = || {
            let dynamics = self.episode.dynamics.as_ref();
            dynamics.map_or_else(axis, |given| T::lift(given.own_inertia(self.joint)[k]))
        };
        let of_model = self.dynamics.and_then(|dynamics| dynamics.own_inertia.as_ref());
        of_model.map_or_else(given, |own| own[k])
    }

    /// Derivative by the position of the effort that the links need.
    fn stiffness(&self, k: usize) -> T {
        match &self.episode.dynamics {
            Some(given) => T::lift(given.by_offset[self.joint][self.joint][0][k]),
            None => {
                let (sin, cos) = (-self.model.offset + self.series.q[k]).sin_cos();
                let gravity = self.model.gravity;
                (gravity[0] * cos - gravity[1] * sin) * self.episode.load.gravity_factor
            }
        }
    }

    /// Effort that a rigid transmission would transmit.
    fn rigid_effort(&self, k: usize) -> T {
        match (&self.drive, self.setup.encoder_on_drive) {
            // The measured acceleration would let a compliance filter the noise of the positions.
            (Some(drive), false) => {
                drive[k] - self.model.armature * self.series.a[k] - self.model.damping * self.series.v[k]
            }
            _ => self.required[k] - self.known[k],
        }
    }

    /// What resists the motion of the side without encoder.
    fn resistance(&self, k: usize) -> Unmeasured<T> {
        match self.setup.encoder_on_drive {
            true => {
                Unmeasured { inertia: self.own_inertia(k), damping: T::zero(), stiffness: self.stiffness(k) }
            }
            false => {
                Unmeasured { inertia: self.model.armature, damping: self.model.damping, stiffness: T::zero() }
            }
        }
    }

    /// What moves the side without encoder, and how it resists.
    fn unmeasured_side(&self, k: usize) -> Side<T> {
        let at = self.sample(k);
        let (effort, friction) = match self.setup.encoder_on_drive {
            true => (at.external, T::zero()),
            false => (at.drive.unwrap_or_else(T::zero), self.dry_friction(&at)),
        };
        Side { effort, friction, resistance: self.resistance(k) }
    }

    /// Level of dry friction of the model and the laws.
    fn dry_friction(&self, at: &JointSample<T>) -> T {
        let [_, _, loss] = self.problem.of_model[self.joint];
        self.model.laws.iter().fold(T::lift(loss), |level, law| level + law.dry_friction(at))
    }

    /// Sum of all efforts but dry friction, and the response of the equation to the recorded effort. `correction` is the effort by
    /// which a transmission changes the equation.
    fn net_effort(&self, k: usize, at: &JointSample<T>, correction: Option<&[T]>, largest: f64) -> (T, T) {
        let (model, on) = (self.model, self.series.on[k]);
        let mut net =
            at.drive.unwrap_or_else(T::zero) + self.known[k] - self.required[k] - model.armature * at.a;
        net -= (model.damping + model.back_emf * on) * at.v;
        if let Some(correction) = correction {
            net += correction[k];
        }
        let mut response = T::lift(1.0);
        for law in &model.laws {
            if let Some(factor) = law.response(at, largest) {
                response = response * factor;
            }
            net += law.effort(at);
        }
        (net, response)
    }

    /// Error of a net effort with dry friction; `None` if friction holds the joint.
    fn error(&self, v: f64, net: T, level: T) -> Option<T> {
        let is_at_rest = v.abs() < self.setup.rest_speed;
        if is_at_rest && net.re().abs() <= level.re() {
            return None;
        }
        let direction = if v.abs() >= self.setup.rest_speed { v } else { net.re() };
        Some(if direction > 0.0 { net - level } else { net + level })
    }
}

/// Transmissions, and the shares by which residuals are divided.
impl<T: Real> JointSignals<'_, T> {
    /// Effort by which an elastic transmission changes the equation, and the share of the effort's changes that it passes.
    fn elastic_correction(&self) -> Option<(Vec<T>, T)> {
        self.model.elastic_correction(
            self.series.q.len(),
            self.setup.encoder_on_drive,
            &|k| self.rigid_effort(k),
            &|k| self.resistance(k),
            self.episode.dt,
        )
    }

    /// Effort by which a play between drive and joint changes the equation.
    fn backlash_correction(&self) -> Option<Vec<T>> {
        let side = |k: usize| self.unmeasured_side(k);
        self.model.backlash_correction(&self.series.q, self.setup.encoder_on_drive, &side, self.episode.dt)
    }

    /// Factor from net efforts to residuals: the inverse of the reading's gain and of all shares. `passed` is the share that an
    /// elastic transmission passes.
    fn residual_factor(&self, passed: Option<T>, backlash: Option<&[T]>) -> T {
        let shares = [
            self.unclipped_share(),
            self.share_after_lag(),
            passed,
            self.share_through_backlash(backlash),
            self.noise_share(),
            self.inertia_share(),
        ];
        shares.into_iter().flatten().fold(self.reading_gain(), |size, share| size * share).recip()
    }

    /// Residuals are compared in units of the reading: no gain makes them smaller.
    fn reading_gain(&self) -> T {
        let relative = |gain: T| at_least_small(magnitude(gain / self.setup.reference_gain));
        let gain = self.model.gain.map_or_else(|| T::lift(1.0), relative);
        self.model.laws.iter().filter_map(Law::reading_gain).fold(gain, |gain, reading| gain / reading)
    }

    /// Share of the wanted effort that a limited drive delivers.
    fn unclipped_share(&self) -> Option<T> {
        let series = self.series;
        self.model.laws.iter().any(Law::clips).then(|| {
            let wanted = |k: usize| match self.setup.drive {
                Drive::Target => self.model.gain_of(series) * (self.commands[k] - series.raw[k]),
                _ => self.model.corrected(series, self.commands[k]),
            };
            delivered_share(&|k| wanted(k) * series.on[k], &self.unfiltered)
        })
    }

    /// Share of the commands' changes that lags pass.
    fn share_after_lag(&self) -> Option<T> {
        let is_slow = self.model.laws.iter().filter_map(Law::lag).any(|lag| lag.re() > 0.0);
        (self.drive.is_some() && is_slow)
            .then(|| passed_share(&|k| T::lift(self.series.command[k]), &self.commands))
    }

    /// Share of the drive's effort that a play transmits to a joint with the encoder.
    fn share_through_backlash(&self, backlash: Option<&[T]>) -> Option<T> {
        let (drive, backlash) = self.drive.as_ref().zip(backlash).filter(|_| !self.setup.encoder_on_drive)?;
        let sum: Vec<T> = drive.iter().zip(backlash).map(|(drive, change)| *drive + *change).collect();
        Some(delivered_share(&|k| drive[k], &sum))
    }

    /// Share of the noise that an elastic transmission passes.
    fn noise_share(&self) -> Option<T> {
        let own_inertia = |k: usize| self.own_inertia(k);
        self.model.noise_share(self.problem, self.setup.encoder_on_drive, &own_inertia, self.series.q.len())
    }

    /// Inertia relative to the given one, for a joint without drive.
    fn inertia_share(&self) -> Option<T> {
        let given = self.episode.dynamics.as_ref().filter(|_| self.model.is_passive)?;
        let given_armature = self.problem.of_model[self.joint][0];
        let own_inertia = |k: usize| self.own_inertia(k);
        inertia_share((&own_inertia, self.model.armature), (given.own_inertia(self.joint), given_armature))
    }
}
