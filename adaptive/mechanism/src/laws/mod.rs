//! Laws of joints. Each is one file, generic over the number type: its entry in the catalogue and its formula.

mod air_drag;
mod backlash;
mod base_tilt;
mod cogging;
mod directional_friction;
mod drive_delay;
mod drive_gain_droop;
mod drive_lag;
mod dry_friction;
mod effort_bias;
mod effort_delay;
mod effort_gain;
mod effort_lag;
mod effort_saturation;
mod elasticity;
mod encoder_offset;
mod law;
mod load_friction;
mod payload;
mod rotor_inertia;
mod spring;
mod stop;
mod viscous_friction;

pub(crate) use backlash::plays;
pub use law::{Applies, Compliance, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec};
pub(crate) use law::{DAMPING_RATIO, magnitude};
pub(crate) use stop::stop_positions;
use trundle_model::Real;

macro_rules! catalogue {
    ($($kind:ident => $module:ident),* $(,)?) => {
        /// Kind of a law.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[allow(missing_docs)]
        pub enum JointKind { $($kind),* }

        impl JointKind {
            /// All kinds.
            pub const ALL: &'static [Self] = &[$(Self::$kind),*];

            /// Whether the drive and the joint move relative to each other.
            pub(crate) fn is_compliance(self) -> bool {
                matches!(self, Self::Backlash | Self::Elasticity)
            }

            /// Entry in the catalogue.
            #[must_use]
            pub fn spec(self) -> &'static Spec {
                match self { $(Self::$kind => &$module::SPEC),* }
            }
        }

        /// Any law with values.
        #[derive(Clone, Copy, Debug)]
        pub(crate) enum Law<T> { $($kind($module::Law<T>)),* }

        impl<T: Real> Law<T> {
            pub fn of(kind: JointKind, values: &[T]) -> Self {
                match kind { $(JointKind::$kind => Self::$kind(JointLaw::new(values))),* }
            }
            pub fn effort(&self, at: &JointSample<T>) -> T {
                match self { $(Self::$kind(law) => law.effort(at)),* }
            }
            pub fn dry_friction(&self, at: &JointSample<T>) -> T {
                match self { $(Self::$kind(law) => law.dry_friction(at)),* }
            }
            pub fn drive(&self, command: T, largest: f64) -> T {
                match self { $(Self::$kind(law) => law.drive(command, largest)),* }
            }
            pub fn correct(&self, reading: T) -> T {
                match self { $(Self::$kind(law) => law.correct(reading)),* }
            }
            pub fn reading_gain(&self) -> Option<T> {
                match self { $(Self::$kind(law) => law.reading_gain()),* }
            }
            pub fn response(&self, at: &JointSample<T>, largest: f64) -> Option<T> {
                match self { $(Self::$kind(law) => law.response(at, largest)),* }
            }
            pub fn delay(&self) -> Option<T> {
                match self { $(Self::$kind(law) => law.delay()),* }
            }
            pub fn lag(&self) -> Option<T> {
                match self { $(Self::$kind(law) => law.lag()),* }
            }
            pub fn clips(&self) -> bool {
                match self { $(Self::$kind(law) => law.clips()),* }
            }
            pub fn gap(&self) -> Option<T> {
                match self { $(Self::$kind(law) => law.gap()),* }
            }
            pub fn reads_external(&self) -> bool {
                match self { $(Self::$kind(law) => law.reads_external()),* }
            }
            pub fn compliance(&self) -> Option<Compliance<T>> {
                match self { $(Self::$kind(law) => law.compliance()),* }
            }
        }
    };
}

catalogue! {
    DryFriction => dry_friction,
    ViscousFriction => viscous_friction,
    DirectionalFriction => directional_friction,
    LoadFriction => load_friction,
    Backlash => backlash,
    Elasticity => elasticity,
    Stop => stop,
    Cogging => cogging,
    Spring => spring,
    RotorInertia => rotor_inertia,
    AirDrag => air_drag,
    EffortGain => effort_gain,
    EffortBias => effort_bias,
    EffortDelay => effort_delay,
    EffortLag => effort_lag,
    DriveDelay => drive_delay,
    DriveLag => drive_lag,
    DriveGainDroop => drive_gain_droop,
    EffortSaturation => effort_saturation,
}

/// Entries of the effects that enter the equations of several joints.
pub(crate) const PAYLOAD: &Spec = &payload::SPEC;
pub(crate) const BASE_TILT: &Spec = &base_tilt::SPEC;
pub(crate) const ENCODER_OFFSET: &Spec = &encoder_offset::SPEC;

/// All entries of the catalogue.
#[must_use]
pub fn catalogue() -> Vec<&'static Spec> {
    let of_joints = JointKind::ALL.iter().map(|kind| kind.spec());
    of_joints.chain([ENCODER_OFFSET, PAYLOAD, BASE_TILT]).collect()
}

/// Effort, level of dry friction and inertia that laws add at a state. Their efforts are linear in the acceleration.
pub(crate) fn law_terms(laws: &[Law<f64>], at: &JointSample<f64>) -> [f64; 3] {
    let effort = |a: f64| laws.iter().map(|law| law.effort(&JointSample { a, ..*at })).sum::<f64>();
    let dry = laws.iter().map(|law| law.dry_friction(at)).sum();
    let free = effort(0.0);
    [free, dry, free - effort(1.0)]
}

#[cfg(test)]
mod tests;
