//! Estimate of an arm's response from commands and measured wrenches.
//!
//! Every hypothesis is a delay, a response of the forces and one of the torque. Each predicts the next reading from the
//! last one and the commands. The log likelihoods of the prediction errors add up. The noise is Student-t, so that single
//! readings that no hypothesis explains do not decide.

use super::axis::{AxisResponse, AxisStep};
use super::commanded::CommandedArm;
use super::response::{ArmResponse, AxisStates, turned};
use crate::ControlError;

/// Substeps of a period, in which the command is constant.
const SUBSTEPS: usize = 10;
/// Step and number of the delays, substeps.
const DELAY_STEP: usize = 2;
const DELAYS: usize = 36;
/// Substeps after which the wrench within a period is returned.
const KNOTS: [usize; 4] = [2, 4, 6, 8];
/// Hypotheses on the time constant of a lag, s.
const TIME_CONSTANTS_S: [f64; 14] =
    [0.02, 0.03, 0.04, 0.05, 0.065, 0.08, 0.1, 0.125, 0.15, 0.185, 0.225, 0.275, 0.35, 0.5];
/// Hypotheses on natural frequency, rad/s, damping ratio and gain of a compliance.
const FREQUENCIES_RAD_PER_S: [f64; 6] = [20.0, 27.0, 36.0, 48.0, 64.0, 85.0];
const DAMPING_RATIOS: [f64; 3] = [0.45, 0.7, 1.0];
const GAINS: [f64; 3] = [1.0, 0.85, 0.7];
/// Hypotheses on the turn of a compliant hand, rad/(N·m).
const TURNS_RAD_PER_N_M: [f64; 8] = [0.0, 0.004, 0.008, 0.0125, 0.0165, 0.022, 0.03, 0.04];
/// Prior log probability of a turn in comparison with none.
const PRIOR_TURN_NATS: f64 = -2.0;
/// Standard deviation of the direction of a force that has not settled, as a share of a full command.
const DIRECTION_SD: f64 = 0.05;
/// Standard deviation of a prediction error, as a share of a full command.
const ERROR_SD: f64 = 0.015;
/// Degrees of freedom of the distribution of prediction errors.
const DEGREES_OF_FREEDOM: f64 = 4.0;
/// Prior log probability of a lag or a compliance in comparison with none, along the forces and along the torque.
const PRIOR_LAG_NATS: f64 = -2.0;
const PRIOR_COMPLIANCE_NATS: f64 = -4.0;
/// Prior log probability of a delay in comparison with none, and of each step of it. Without a lag, readings do not
/// distinguish all delays; the shortest one then counts.
const PRIOR_DELAY_NATS: f64 = -2.0;
const PRIOR_DELAY_STEP_NATS: f64 = -0.1;

/// Online estimate of the response of an arm that is commanded once per period.
#[derive(Clone, Debug)]
pub struct ArmEstimate {
    /// Time between two commands, s.
    period: f64,
    /// Time in which the arm changes from one command to the next, s.
    rise: f64,
    /// Full command.
    scale: [f64; 3],
    responses: Vec<AxisResponse>,
    /// Step of a substep of each response.
    steps: Vec<AxisStep>,
    /// States and log likelihoods by delay and response: forces, torque.
    hypotheses: Vec<Hypothesis>,
    /// Commands of all substeps, without delay.
    signal: Vec<[f64; 3]>,
    /// Readings at the end of all periods. `None` if the arm did not hold the object.
    readings: Vec<Option<[f64; 3]>>,
    last_command: [f64; 3],
    /// Log likelihoods of [`TURNS_RAD_PER_N_M`].
    turn_nats: [f64; TURNS_RAD_PER_N_M.len()],
}

/// A delay together with the response of an axis.
#[derive(Clone, Copy, Debug, Default)]
struct Hypothesis {
    states: AxisStates,
    force_nats: f64,
    torque_nats: f64,
}

impl ArmEstimate {
    /// An estimate before the first observation.
    ///
    /// # Errors
    /// If `0 < rise <= period` does not hold, or a full command is not positive.
    pub fn new(period: f64, rise: f64, scale: [f64; 3]) -> Result<Self, ControlError> {
        if !(rise > 0.0 && rise <= period && period.is_finite()) {
            return Err(ControlError::value("period, rise", (period, rise), "give 0 < rise <= period (s)"));
        }
        if !scale.iter().all(|full| full.is_finite() && *full > 0.0) {
            return Err(ControlError::value("scale", scale, "must be positive and finite (N, N, N·m)"));
        }
        let responses = responses();
        Ok(Self {
            period,
            rise,
            scale,
            steps: responses.iter().map(|one| one.discretised(period / SUBSTEPS as f64)).collect(),
            hypotheses: vec![Hypothesis::default(); DELAYS * responses.len()],
            responses,
            signal: Vec::new(),
            readings: Vec::new(),
            last_command: [0.0; 3],
            turn_nats: [0.0; TURNS_RAD_PER_N_M.len()],
        })
    }

    /// Add a period: the command at its start and the reading at its end. `holds`: whether the arm held the object.
    pub fn observe(&mut self, command: [f64; 3], reading: [f64; 3], holds: bool) {
        let command = if holds { command } else { [0.0; 3] };
        let substep = self.period / SUBSTEPS as f64;
        for k in 0..SUBSTEPS {
            let share = ((k as f64 + 0.5) * substep / self.rise).min(1.0);
            let between =
                [0, 1, 2].map(|i| self.last_command[i] + share * (command[i] - self.last_command[i]));
            self.signal.push(if holds { between } else { [0.0; 3] });
        }
        self.last_command = command;
        self.readings.push(holds.then_some(reading));
        if holds {
            self.compare_directions(reading);
        }
        let turn = self.turn() * reading[2];
        for number in 0..self.hypotheses.len() {
            self.update(number, reading, holds, turn);
        }
    }

    /// Compare the direction of a reading with that of the command at the end of the period.
    fn compare_directions(&mut self, reading: [f64; 3]) {
        let [delay, ..] = self.best();
        let command = self.delayed(self.signal.len() - 1, delay);
        let size = command[0].hypot(command[1]);
        if size == 0.0 {
            return;
        }
        for (nats, turn) in self.turn_nats.iter_mut().zip(TURNS_RAD_PER_N_M) {
            let [x, y, _] = turned(command, turn * reading[2]);
            *nats +=
                log_likelihood((x * reading[1] - y * reading[0]) / (size * DIRECTION_SD * self.scale[0]));
        }
    }

    /// The most probable turn of a compliant hand, rad/(N·m).
    fn turn(&self) -> f64 {
        let posterior = |k: usize| self.turn_nats[k] + if k > 0 { PRIOR_TURN_NATS } else { 0.0 };
        let best = (1..TURNS_RAD_PER_N_M.len())
            .fold(0, |best, k| if posterior(k) > posterior(best) { k } else { best });
        TURNS_RAD_PER_N_M[best]
    }

    /// Advance a hypothesis over the last period, and compare it with the reading. `turn`: that of a compliant hand, rad.
    fn update(&mut self, number: usize, reading: [f64; 3], holds: bool, turn: f64) {
        let kind = number % self.responses.len();
        let (response, step) = (self.responses[kind], self.steps[kind]);
        let mut hypothesis = self.hypotheses[number];
        if !holds {
            self.hypotheses[number].states = AxisStates::default();
            return;
        }
        let delay = DELAY_STEP * (number / self.responses.len());
        for k in self.signal.len() - SUBSTEPS..self.signal.len() {
            let command = self.delayed(k, delay);
            let command = if response.is_compliant() { turned(command, turn) } else { command };
            for (state, entry) in hypothesis.states.iter_mut().zip(command) {
                step.advance(state, entry);
            }
        }
        let nats = |axis: usize| {
            let error =
                (reading[axis] - response.wrench(hypothesis.states[axis])) / (ERROR_SD * self.scale[axis]);
            log_likelihood(error)
        };
        hypothesis.force_nats += nats(0) + nats(1);
        hypothesis.torque_nats += nats(2);
        hypothesis.states = [0, 1, 2].map(|axis| response.corrected(hypothesis.states[axis], reading[axis]));
        self.hypotheses[number] = hypothesis;
    }

    /// Command in substep `k` after a delay.
    fn delayed(&self, k: usize, delay: usize) -> [f64; 3] {
        k.checked_sub(delay).map_or([0.0; 3], |at| self.signal[at])
    }

    /// The most probable response.
    pub fn response(&self) -> ArmResponse {
        let [delay, force, torque] = self.best();
        ArmResponse {
            delay: delay as f64 * self.period / SUBSTEPS as f64,
            force: self.responses[force],
            torque: self.responses[torque],
            turn: if self.responses[force].is_compliant() { self.turn() } else { 0.0 },
        }
    }

    /// Delay in substeps and numbers of the responses with the highest posterior probability.
    fn best(&self) -> [usize; 3] {
        let count = self.responses.len();
        let mut best = ([0; 3], f64::NEG_INFINITY);
        for (delay, hypotheses) in self.hypotheses.chunks(count).enumerate() {
            let most = |nats: fn(&Hypothesis) -> f64| {
                let posterior = |kind: usize| nats(&hypotheses[kind]) + prior(&self.responses[kind]);
                (0..count).fold((0, f64::NEG_INFINITY), |best: (usize, f64), kind| {
                    if posterior(kind) > best.1 { (kind, posterior(kind)) } else { best }
                })
            };
            let (force, torque) = (most(|one| one.force_nats), most(|one| one.torque_nats));
            let prior_delay = PRIOR_DELAY_NATS + PRIOR_DELAY_STEP_NATS * delay as f64;
            let nats = force.1 + torque.1 + if delay > 0 { prior_delay } else { 0.0 };
            if nats > best.1 {
                best = ([DELAY_STEP * delay, force.0, torque.0], nats);
            }
        }
        best.0
    }

    /// The arm at the latest observation, with the most probable response.
    pub fn commanded(&self) -> CommandedArm {
        let [delay, force, torque] = self.best();
        let first = delay / DELAY_STEP * self.responses.len();
        let (forces, torques) = (&self.hypotheses[first + force], &self.hypotheses[first + torque]);
        let until = self.signal.len();
        CommandedArm {
            response: self.response(),
            states: [forces.states[0], forces.states[1], torques.states[2]],
            pending: (until..until + delay).map(|k| self.delayed(k, delay)).collect(),
            substep: self.period / SUBSTEPS as f64,
        }
    }

    /// Times of the wrenches of [`ArmEstimate::wrenches`] since the start of the period, s.
    pub fn knots(&self) -> [f64; KNOTS.len()] {
        KNOTS.map(|knot| knot as f64 * self.period / SUBSTEPS as f64)
    }

    /// Wrenches at the times [`ArmEstimate::knots`] of every period, by the most probable response, consistent with the
    /// readings. `None` if the arm is ideal.
    pub fn wrenches(&self) -> Option<Vec<[[f64; 3]; KNOTS.len()]>> {
        let response = self.response();
        if response.is_ideal() {
            return None;
        }
        let [delay, ..] = self.best();
        let step = response.discretised(self.period / SUBSTEPS as f64);
        let (axes, mut states) = (response.axes(), AxisStates::default());
        let exerted = |states: &AxisStates| [0, 1, 2].map(|axis| axes[axis].wrench(states[axis]));
        let mut wrenches = Vec::with_capacity(self.readings.len());
        for (number, reading) in self.readings.iter().enumerate() {
            let Some(reading) = reading else {
                states = AxisStates::default();
                wrenches.push([[0.0; 3]; KNOTS.len()]);
                continue;
            };
            let within: [[f64; 3]; SUBSTEPS] = std::array::from_fn(|k| {
                step.advance(&mut states, self.delayed(number * SUBSTEPS + k, delay));
                exerted(&states)
            });
            let error = [0, 1, 2].map(|axis| reading[axis] - within[SUBSTEPS - 1][axis]);
            states = [0, 1, 2].map(|axis| axes[axis].corrected(states[axis], reading[axis]));
            wrenches.push(KNOTS.map(|knot| {
                let share = knot as f64 / SUBSTEPS as f64;
                [0, 1, 2].map(|axis| {
                    // An exact axis jumps between substeps, and has the mean value there.
                    let after = if axes[axis] == AxisResponse::Exact { knot } else { knot - 1 };
                    (within[knot - 1][axis] + within[after][axis]) / 2.0 + share * error[axis]
                })
            }));
        }
        Some(wrenches)
    }
}

/// All hypotheses on the response of an axis, the exact one first.
fn responses() -> Vec<AxisResponse> {
    let lags = TIME_CONSTANTS_S.map(|time_constant| AxisResponse::Lag { time_constant });
    let compliant = FREQUENCIES_RAD_PER_S.into_iter().flat_map(|frequency| {
        DAMPING_RATIOS.into_iter().flat_map(move |damping_ratio| {
            GAINS.map(|gain| AxisResponse::Compliant { frequency, damping_ratio, gain })
        })
    });
    [AxisResponse::Exact].into_iter().chain(lags).chain(compliant).collect()
}

/// Log likelihood of an error in standard deviations.
fn log_likelihood(error: f64) -> f64 {
    -(DEGREES_OF_FREEDOM + 1.0) / 2.0 * (error * error / DEGREES_OF_FREEDOM).ln_1p()
}

/// Prior log probability of a response.
fn prior(response: &AxisResponse) -> f64 {
    match response {
        AxisResponse::Exact => 0.0,
        AxisResponse::Lag { .. } => PRIOR_LAG_NATS,
        AxisResponse::Compliant { .. } => PRIOR_COMPLIANCE_NATS,
    }
}

#[cfg(test)]
mod tests;
