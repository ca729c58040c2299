//! Properties of a real arm: delay, rate limit, lag, saturation, noise and a soft wrist.

use serde::{Deserialize, Serialize};

use super::action_mode::ActionMode;
use super::constants::*;
use crate::gripper::Hand;
use crate::{Coupling, SimError};

/// Properties of the arm between a command and the end effector. The default is an ideal arm.
///
/// A command passes noise, saturation, delay, rate limit, lag and wrist, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArmOptions {
    /// Time constant of the first-order lag, s.
    pub lag: f64,
    /// Largest rate of change of the command, full actions per second.
    pub rate: f64,
    /// Delay of every command, s, rounded to simulation steps.
    pub delay: f64,
    /// Largest command, as a fraction of a full action.
    pub saturation: f64,
    /// Standard deviation of the noise of every command, as a fraction of a full action.
    pub noise: f64,
    /// Soft wrist between the arm and the end effector.
    pub wrist: Option<WristOptions>,
}

impl Default for ArmOptions {
    fn default() -> Self {
        Self { lag: 0.0, rate: f64::INFINITY, delay: 0.0, saturation: 1.0, noise: 0.0, wrist: None }
    }
}

/// Spring and damper of a soft wrist, and the mass of the arm's hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WristOptions {
    /// Translational stiffness, N/m.
    pub stiffness: f64,
    /// Translational damping, N·s/m.
    pub damping: f64,
    /// Rotational stiffness, N·m/rad.
    pub twist_stiffness: f64,
    /// Rotational damping, N·m·s/rad.
    pub twist_damping: f64,
    /// Mass that a commanded wrench accelerates in front of the wrist, kg. Unused if velocities are commanded.
    pub mass: f64,
    /// Moment of inertia of that mass, kg·m².
    pub inertia: f64,
}

impl Default for WristOptions {
    /// A wrist that yields 25 mm at 50 N.
    fn default() -> Self {
        Self {
            stiffness: 2000.0,
            damping: 60.0,
            twist_stiffness: 60.0,
            twist_damping: 2.0,
            mass: 2.0,
            inertia: 0.02,
        }
    }
}

/// Remedy for a wrist out of range.
const WRIST_REMEDY: &str = "must lie in [10, 1e6] N/m, [0, 1e5] N s/m, [0.1, 1e5] N m/rad, [0, 1e4] N m s/rad, \
                            [0.01, 100] kg, [1e-5, 10] kg m^2 for stiffness, damping, twist_stiffness, twist_damping, \
                            mass, inertia";

impl WristOptions {
    /// Spring and damper.
    pub fn coupling(&self) -> Coupling {
        let Self { stiffness, damping, twist_stiffness, twist_damping, .. } = *self;
        Coupling { stiffness, damping, twist_stiffness, twist_damping }
    }

    /// The hand at rest.
    pub fn hand(&self) -> Hand {
        Hand { mass: self.mass, inertia: self.inertia, twist: [0.0; 3] }
    }

    fn check(&self) -> Result<(), SimError> {
        for (key, value, low, high) in [
            ("arm.wrist.stiffness", self.stiffness, 10.0, 1e6),
            ("arm.wrist.damping", self.damping, 0.0, 1e5),
            ("arm.wrist.twist_stiffness", self.twist_stiffness, 0.1, 1e5),
            ("arm.wrist.twist_damping", self.twist_damping, 0.0, 1e4),
            ("arm.wrist.mass", self.mass, 0.01, 100.0),
            ("arm.wrist.inertia", self.inertia, 1e-5, 10.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(SimError::value(key, value, WRIST_REMEDY));
            }
        }
        Ok(())
    }
}

impl ArmOptions {
    /// Whether every command acts at once and exactly.
    pub fn is_ideal(&self) -> bool {
        *self == Self::default()
    }

    /// Check the values.
    ///
    /// # Errors
    /// If a value is out of range, or the mode has no wrist. The message names value and remedy.
    pub fn check(&self, mode: ActionMode) -> Result<(), SimError> {
        let within = |key: &str, value: f64, low: f64, high: f64, remedy| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(SimError::value(key, value, remedy)) }
        };
        within("arm.lag", self.lag, 0.0, MAX_ARM_LAG_S, "must lie in [0, 2] s")?;
        within("arm.delay", self.delay, 0.0, MAX_DELAY_S, "must lie in [0, 1] s")?;
        within("arm.rate", self.rate, 0.1, f64::INFINITY, "must be at least 0.1 full actions per second")?;
        within("arm.saturation", self.saturation, 0.01, 1.0, "must lie in [0.01, 1] of a full action")?;
        within("arm.noise", self.noise, 0.0, 1.0, "must lie in [0, 1] of a full action")?;
        match &self.wrist {
            Some(_) if mode == ActionMode::Push => {
                let remedy = "a fingertip has no wrist: choose another action or remove arm.wrist";
                Err(SimError::value("action", "push", remedy))
            }
            wrist => wrist.as_ref().map_or(Ok(()), WristOptions::check),
        }
    }
}

/// Rate limit and first-order lag of a command.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Actuator {
    /// Largest change of each entry per second.
    max_rates: [f64; 3],
    /// Time constant, s.
    lag: f64,
    limited: [f64; 3],
    lagged: [f64; 3],
}

impl Actuator {
    /// The actuator of an arm at rest; `None` if the arm neither lags nor limits rates.
    pub fn new(arm: &ArmOptions, mode: ActionMode) -> Option<Self> {
        let full = if mode == ActionMode::Push { [2.0 * FULL_PUSH[2]; 3] } else { first_three(mode) };
        (arm.lag > 0.0 || arm.rate.is_finite()).then(|| Self {
            max_rates: full.map(|full| arm.rate * full),
            lag: arm.lag,
            limited: [0.0; 3],
            lagged: [0.0; 3],
        })
    }

    /// Return to rest.
    pub fn rest(&mut self) {
        (self.limited, self.lagged) = ([0.0; 3], [0.0; 3]);
    }

    /// Advance by one step of `dt`, s, towards a command. Returns what the arm exerts.
    pub fn step(&mut self, command: [f64; 3], dt: f64) -> [f64; 3] {
        let gain = if self.lag > 0.0 { -(-dt / self.lag).exp_m1() } else { 1.0 };
        self.limited = [0, 1, 2].map(|k| {
            let most = self.max_rates[k] * dt;
            self.limited[k] + (command[k] - self.limited[k]).clamp(-most, most)
        });
        self.lagged = [0, 1, 2].map(|k| self.lagged[k] + gain * (self.limited[k] - self.lagged[k]));
        self.lagged
    }
}

fn first_three(mode: ActionMode) -> [f64; 3] {
    let full = mode.full_scale();
    [full[0], full[1], full[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exerted(arm: &ArmOptions, seconds: f64) -> f64 {
        let mut actuator = Actuator::new(arm, ActionMode::Wrench).unwrap();
        (0..(seconds / 1e-3).round() as u32).fold(0.0, |_, _| actuator.step([100.0, 0.0, 0.0], 1e-3)[0])
    }

    #[test]
    fn a_lag_reaches_63_percent_after_its_time_constant() {
        let arm = ArmOptions { lag: 0.08, ..ArmOptions::default() };
        assert!((exerted(&arm, 0.08) - 100.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-9);
    }

    #[test]
    fn a_rate_limit_bounds_the_change_per_second() {
        let arm = ArmOptions { rate: 2.0, ..ArmOptions::default() };
        assert!((exerted(&arm, 0.1) - 20.0).abs() < 1e-9);
        assert!((exerted(&arm, 1.0) - 100.0).abs() < 1e-9);
    }

    #[test]
    fn an_ideal_arm_has_no_actuator() {
        assert!(Actuator::new(&ArmOptions::default(), ActionMode::Wrench).is_none());
    }
}
