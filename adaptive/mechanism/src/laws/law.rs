//! The interface of a law of a joint, and its entry in the catalogue.

use crate::units::Unit;
use trundle_model::Real;

/// Sizes of a joint's signals, from which starting values and priors are derived.
#[derive(Clone, Copy, Debug)]
pub struct JointScales {
    /// Root mean square of the effort, or of the inertial effort if nothing drives the joint.
    pub effort: f64,
    /// Smallest and largest position.
    pub range: [f64; 2],
    /// Root mean square of the velocity.
    pub velocity: f64,
    /// Root mean square of the acceleration.
    pub acceleration: f64,
    /// Root mean square of the recorded covariate `load_JOINT`, if it has one.
    pub load: Option<f64>,
    /// Standard deviation of the low-pass filter, s: the shortest time that the data resolve.
    pub resolution: f64,
}

impl JointScales {
    /// Range of the positions.
    #[must_use]
    pub fn span(&self) -> f64 {
        (self.range[1] - self.range[0]).max(f64::MIN_POSITIVE)
    }
}

/// A joint at one time.
#[derive(Clone, Copy, Debug)]
pub struct JointSample<T> {
    /// Position, rad or m.
    pub q: f64,
    /// Velocity.
    pub v: f64,
    /// Acceleration.
    pub a: f64,
    /// Effort of the drive; `None` if the joint is not driven.
    pub drive: Option<T>,
    /// Effort that gravity, velocity terms, the other joints and known efforts exert on the joint.
    pub external: T,
    /// Recorded covariate, if any.
    pub load: Option<f64>,
}

/// Damping ratio of a transmission whose damping is not fitted, with the inertia of the side without encoder. Geared joints
/// have 0.02 to 0.3.
pub(crate) const DAMPING_RATIO: f64 = 0.1;

/// Compliance between drive and joint.
#[derive(Clone, Copy, Debug)]
pub struct Compliance<T> {
    /// Stiffness.
    pub stiffness: T,
    /// Damping; `None` if it is not fitted.
    pub damping: Option<T>,
}

/// A law with parameter values. The defaults have no effect.
pub trait JointLaw<T: Real>: Sized {
    /// Create the law from the values of [`Spec::params`].
    fn new(values: &[T]) -> Self;

    /// Effort on the joint.
    fn effort(&self, _at: &JointSample<T>) -> T {
        T::zero()
    }

    /// Level of dry friction: its effort opposes the velocity, and holds the joint at rest.
    fn dry_friction(&self, _at: &JointSample<T>) -> T {
        T::zero()
    }

    /// Effort of the drive for a command; `largest` is the largest command of the training episodes.
    fn drive(&self, command: T, _largest: f64) -> T {
        command
    }

    /// True effort for its reading.
    fn correct(&self, reading: T) -> T {
        reading
    }

    /// Gain of the reading, the same for every motion. Residuals are multiplied by it: they are errors of the reading. A gain
    /// below one would otherwise be charged for the larger errors of the motion in units of effort.
    fn reading_gain(&self) -> Option<T> {
        None
    }

    /// Change of the equation by a change of the drive's effort, where it is less than one. Residuals are divided by it.
    /// Otherwise a law could reduce all residuals by weakening the drive.
    fn response(&self, _at: &JointSample<T>, _largest: f64) -> Option<T> {
        None
    }

    /// Whether it clips commands.
    fn clips(&self) -> bool {
        false
    }

    /// Time by which the drive acts after its command, s; negative if the reading is late instead.
    fn delay(&self) -> Option<T> {
        None
    }

    /// Time constant of the drive's lag behind its command, s; negative if the reading lags instead.
    fn lag(&self) -> Option<T> {
        None
    }

    /// Width of the play between drive and joint.
    fn gap(&self) -> Option<T> {
        None
    }

    /// Whether it reads the external effort.
    fn reads_external(&self) -> bool {
        false
    }

    /// Compliance between drive and joint.
    fn compliance(&self) -> Option<Compliance<T>> {
        None
    }
}

/// Drives to which an effect applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applies {
    /// Every joint.
    Always,
    /// Joints with a drive whose effort is known, or modelled from its target.
    Driven,
    /// Joints whose effort is a measurement.
    MeasuredEffort,
    /// Joints whose effort follows a command.
    CommandedEffort,
    /// Joints with a drive, or a recorded covariate.
    Loaded,
}

/// Prior of a parameter, in units of the joint's scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// The effort.
    Effort,
    /// Effort over velocity.
    Damping,
    /// Effort over the range of the positions.
    Stiffness,
    /// Effort over acceleration.
    Inertia,
    /// Effort over the square of the velocity.
    Drag,
    /// The velocity.
    Velocity,
    /// The range of the positions.
    Position,
    /// The resolution in time.
    Time,
    /// Reciprocal of the load.
    PerLoad,
    /// One.
    One,
}

impl Scale {
    /// Its value for a joint.
    #[must_use]
    pub fn of(self, scales: &JointScales) -> f64 {
        let found = match self {
            Self::Effort => scales.effort,
            Self::Damping => scales.effort / scales.velocity,
            Self::Stiffness => scales.effort / scales.span(),
            Self::Inertia => scales.effort / scales.acceleration,
            Self::Drag => scales.effort / (scales.velocity * scales.velocity),
            Self::Velocity => scales.velocity,
            Self::Position => scales.span(),
            Self::Time => scales.resolution,
            Self::PerLoad => scales.load.map_or(1.0, |load| scales.effort / load),
            Self::One => 1.0,
        };
        if found.is_finite() && found > 0.0 { found } else { 1.0 }
    }
}

/// A parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamSpec {
    /// Name in a diagnosis.
    pub name: &'static str,
    /// Unit, which depends on the type of the joint.
    pub unit: Unit,
    /// Scale of its size.
    pub scale: Scale,
    /// Bounds in units of the scale.
    pub bounds: [f64; 2],
    /// Whether it refines the law: by default it has the value that [`JointLaw::new`] documents for NaN.
    pub refines: bool,
    /// Whether it is a period of the position, whose starting values are those with the largest periodogram.
    pub is_period: bool,
    /// Whether the law acts only beyond it: other samples tell nothing about it.
    pub is_limit: bool,
    /// Whether it is a choice: given by the starting point, never fitted.
    pub is_choice: bool,
}

/// A parameter of either sign.
pub(crate) const fn signed(name: &'static str, unit: Unit, scale: Scale) -> ParamSpec {
    ParamSpec {
        name,
        unit,
        scale,
        bounds: [f64::NEG_INFINITY, f64::INFINITY],
        refines: false,
        is_period: false,
        is_limit: false,
        is_choice: false,
    }
}

/// A positive parameter.
pub(crate) const fn positive(name: &'static str, unit: Unit, scale: Scale) -> ParamSpec {
    ParamSpec { bounds: [0.0, f64::INFINITY], ..signed(name, unit, scale) }
}

/// An effect's entry in the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Name in a diagnosis.
    pub effect: &'static str,
    /// One-line description.
    pub summary: &'static str,
    /// Source in the literature.
    pub source: &'static str,
    /// Joints to which it applies.
    pub applies: Applies,
    /// Parameters, in the order of a law's values.
    pub params: &'static [ParamSpec],
    /// Sentence of a diagnosis; `{name}` is replaced by the parameter's value with its interval, `{joint}` by the
    /// joint's name. A part in brackets is left out if its parameter has no value. What follows a `|` replaces the sentence if
    /// all values are negative; it gives their sizes.
    pub sentence: &'static str,
    /// Motion or rig that identifies the effect best.
    pub experiment: &'static str,
    /// Starting values of a fit; NaN leaves a refinement at its default.
    pub starts: fn(&JointScales) -> Vec<Vec<f64>>,
}

/// The first `N` values of a law.
pub(crate) fn take<T: Real, const N: usize>(values: &[T]) -> [T; N] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or_else(T::zero))
}

/// The absolute value.
pub(crate) fn magnitude<T: Real>(value: T) -> T {
    if value.re() < 0.0 { -value } else { value }
}
