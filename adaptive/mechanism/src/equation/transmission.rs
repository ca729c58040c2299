//! Plays and elastic transmissions in the equation of a joint.

use super::JointModel;
use crate::backlash::{Side, SideMotion, unmeasured_side};
use crate::deflection::{Unmeasured, deflections, noise_share};
use crate::laws::{Compliance, Law};
use crate::problem::Problem;
use crate::residual_scaling::passed_share;
use crate::signals::{curvature, slope};
use trundle_model::Real;

impl<T: Real> JointModel<T> {
    /// The elastic transmission, if there is one.
    pub fn compliance(&self) -> Option<Compliance<T>> {
        self.laws.iter().find_map(Law::compliance)
    }

    /// The play, if there is one.
    pub fn gap(&self) -> Option<T> {
        self.laws.iter().find_map(Law::gap)
    }

    /// Effort by which an elastic transmission changes the equation, and the share of the effort's changes that it passes;
    /// `None` without one. `rigid` is the effort that a rigid one would transmit.
    pub(super) fn elastic_correction(
        &self,
        len: usize,
        encoder_on_drive: bool,
        rigid: &dyn Fn(usize) -> T,
        resistance: &dyn Fn(usize) -> Unmeasured<T>,
        dt: f64,
    ) -> Option<(Vec<T>, T)> {
        let compliance = self.compliance()?;
        let rigid: Vec<T> = (0..len).map(rigid).collect();
        let found: Vec<T> =
            deflections(&rigid, compliance, resistance, dt).iter().map(|state| state.effort).collect();
        let change = |(found, rigid): (&T, &T)| {
            if encoder_on_drive { *rigid - *found } else { *found - *rigid }
        };
        let passed = if encoder_on_drive { T::lift(1.0) } else { passed_share(&|k| rigid[k], &found) };
        Some((found.iter().zip(&rigid).map(change).collect(), passed))
    }

    /// See [`noise_share`]; with the mean own inertia of an episode.
    pub(super) fn noise_share(
        &self,
        problem: &Problem,
        encoder_on_drive: bool,
        own_inertia: &dyn Fn(usize) -> T,
        len: usize,
    ) -> Option<T> {
        let compliance = self.compliance()?;
        let mut own = T::zero();
        (0..len).for_each(|k| own += own_inertia(k) / len as f64);
        let drive = Unmeasured { inertia: self.armature, damping: self.damping, stiffness: T::zero() };
        let (other, measured) = match encoder_on_drive {
            true => (Unmeasured { inertia: own, damping: T::zero(), stiffness: T::zero() }, self.armature),
            false => (drive, own),
        };
        Some(noise_share(compliance, other, measured, problem.stages))
    }

    /// Effort by which a play between drive and joint changes the equation; `None` without one. `seen` are the positions of
    /// the measured side; `side` is the other one.
    pub(super) fn backlash_correction(
        &self,
        seen: &[f64],
        encoder_on_drive: bool,
        side: &dyn Fn(usize) -> Side<T>,
        dt: f64,
    ) -> Option<Vec<T>> {
        let gap = self.gap()?;
        let unseen = unmeasured_side(seen, gap, dt, side);
        let one = |(k, motion): (usize, &SideMotion<T>)| {
            let velocity = slope(seen, k, dt);
            let Side { friction, resistance: Unmeasured { inertia, damping, stiffness }, .. } = side(k);
            let change = inertia * (-motion.acceleration + curvature(seen, k, dt));
            if encoder_on_drive {
                return change - stiffness * (motion.position - seen[k]);
            }
            // While it moves freely, dry friction opposes the velocity of the drive, not that of the joint.
            let other = motion.friction.map_or_else(T::zero, |own| friction * velocity.signum() - own);
            change + damping * (-motion.velocity + velocity) + other
        };
        Some(unseen.iter().enumerate().map(one).collect())
    }
}
