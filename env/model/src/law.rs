//! The interface of an effect: its entry in the catalogue, its parameters, and the law that implements it.

use crate::generalised_force::GeneralisedForce;
use crate::{Body, Real};

/// Largest number of inner states of all laws of a model together: a caster's angle and a swinging load.
pub const MAX_INNER_STATES: usize = 5;

/// Prior distribution of a parameter. It also determines how the parameter is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// Normal, for parameters of either sign.
    Normal {
        /// Mean, in the parameter's unit.
        mean: f64,
        /// Standard deviation, in the parameter's unit.
        sd: f64,
    },
    /// Log-normal, for positive parameters.
    LogNormal {
        /// Median, in the parameter's unit.
        median: f64,
        /// Standard deviation of the natural logarithm.
        sd: f64,
    },
    /// Uniform between the lower and the upper bound.
    Uniform,
    /// Uniform over the footprint; the index is the coordinate (0: x, 1: y), m.
    OnBody(usize),
    /// Uniform on the circle with this period, rad.
    Angle(f64),
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// Name in `model.toml`.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
    /// Prior distribution.
    pub prior: Prior,
    /// Default of a refinement, at which the law takes its simpler form. A file may omit a refinement.
    /// `None`: the parameter is essential, and free if a file omits it.
    pub refinement: Option<f64>,
    /// Whether the parameter has a meaning for an object on a rail.
    pub on_rail: bool,
    /// Whether it scales the unknown pressure under a flat face. It is fixed to one if the feet are known.
    pub scales_face_pressure: bool,
    /// Whether it is identifiable only if the mass is given. It is fixed to one if the mass is free.
    pub needs_known_mass: bool,
    /// Whether it belongs to a group, such as forces along axes, of which one identifiable member suffices for the
    /// effect.
    pub is_alternative: bool,
    /// Role in the law.
    pub role: Role,
    /// Description for users.
    pub help: &'static str,
}

/// Role of a parameter in its law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Strength of the effect: a force, a mass, a gain, a delay.
    Amplitude,
    /// Shape of the law: an exponent, a damping ratio, a transition speed.
    Shape,
    /// Coordinate of a point of the body, object frame; its axis.
    BodyPoint(usize),
    /// Coordinate of a point in the world; its axis.
    WorldPoint(usize),
    /// Size or distance of a region of the world.
    Region,
    /// Time of an event.
    Time,
    /// A direction.
    Angle,
    /// Spatial period.
    Period,
    /// A discrete choice, such as an event's episode: always given, never searched.
    Choice,
}

impl Role {
    /// Whether the parameter is never searched.
    pub fn is_choice(self) -> bool {
        self == Self::Choice
    }

    /// Whether the parameter is a location, an extent or a direction.
    pub fn is_place(self) -> bool {
        matches!(self, Self::BodyPoint(_) | Self::WorldPoint(_) | Self::Region | Self::Angle)
    }
}

/// An inner state of a law, such as a caster's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnerState {
    /// Name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Candidate initial values of an episode. The estimator chooses the one that fits the start of the episode best.
    pub starts: &'static [f64],
    /// Standard deviation around each candidate.
    pub sd: f64,
}

/// What an effect acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectTarget {
    /// The object: the effect is a wrench or a change of mass.
    Object,
    /// The instruments: the effect changes their readings.
    Instrument,
}

/// Placeholder for a neutral value that is a property of the body, such as its mass centre.
pub const BODY_VALUE: f64 = f64::NAN;

/// An effect's entry in the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Name in `model.toml`.
    pub kind: &'static str,
    /// Name in a diagnosis. Several kinds may share it if they are building blocks of one effect.
    pub effect: &'static str,
    /// One-line description for `trundle effects`.
    pub summary: &'static str,
    /// Source in the literature.
    pub source: &'static str,
    /// What the effect acts on.
    pub target: EffectTarget,
    /// Whether the effect can only remove energy from the motion.
    pub is_dissipative: bool,
    /// Whether the effect changes the mass, the mass centre or the inertia.
    pub changes_mass: bool,
    /// Inner states of the law.
    pub inner_states: &'static [InnerState],
    /// Parameters, in the order of a law's values.
    pub params: &'static [Param],
    /// Parameters and values at which the effect vanishes; [`BODY_VALUE`] stands for the body's own value.
    pub neutral: &'static [(&'static str, f64)],
    /// Sentence of a diagnosis; `{name}` is replaced by the parameter's value with its interval.
    pub sentence: &'static str,
    /// Push that identifies the effect best.
    pub suggested_push: &'static str,
}

/// Time, grasp and reading trend of the step at which a law is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Time since contact began, s; negative before.
    pub since_contact: f64,
    /// Time in the recording at the middle of the step, s.
    pub t: f64,
    /// Duration of the step, s.
    pub dt: f64,
    /// Index of the episode in the recording, from 0; held-out episodes count.
    pub episode: f64,
    /// Grasp point: origin of the reading's frame in the object frame, m.
    pub grasp: [f64; 2],
    /// Time derivative of the reading, reading axes, N/s, N/s, N·m/s; zero if there is no reading.
    pub trend: [f64; 3],
    /// Noise standard deviations of the mean reading over the step and of the trend; zero if unknown.
    pub noise: [[f64; 3]; 2],
}

impl Clock {
    /// Clock of a single episode whose times count from contact.
    pub const fn since_contact(since_contact: f64) -> Self {
        let (grasp, trend, noise) = ([0.0; 2], [0.0; 3], [[0.0; 3]; 2]);
        Self { since_contact, t: since_contact, dt: 0.0, episode: 0.0, grasp, trend, noise }
    }

    /// Whether contact has begun.
    pub fn in_contact(&self) -> bool {
        self.since_contact >= 0.0
    }

    /// Fraction of the step after a permanent event at `time` of `episode`. It is linear in the time within the step,
    /// so that the time has a gradient.
    pub fn fraction_after<T: Real>(&self, episode: f64, time: T) -> T {
        if self.episode != episode {
            return T::lift(f64::from(u8::from(self.episode > episode)));
        }
        let end = self.t + self.dt / 2.0;
        if time.re() >= end {
            T::zero()
        } else if self.dt == 0.0 || time.re() <= end - self.dt {
            T::lift(1.0)
        } else {
            (-time + end) / self.dt
        }
    }
}

/// Mass properties of a rigid body.
#[derive(Clone, Copy, Debug)]
pub struct Rigid<T> {
    /// Mass, kg.
    pub mass: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// Inertia about the mass centre, kg·m².
    pub inertia: T,
}

impl<T: Real> Rigid<T> {
    /// Add a point mass at a point of the object frame, m.
    pub fn add_point_mass(&mut self, mass: T, at: [T; 2]) {
        let [dx, dy] = [0, 1].map(|k| at[k] - self.com[k]);
        let total = self.mass + mass;
        let share = mass / total;
        self.inertia += self.mass * share * (dx.squared() + dy.squared());
        self.com = [self.com[0] + share * dx, self.com[1] + share * dy];
        self.mass = total;
    }
}

/// Time constants of first-order lags between a wrench and its reading, s; zero without a lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lags<T> {
    /// Lag of the reading behind the wrench: `τ ṙ + r = w`.
    pub sensor: T,
    /// Lag of the wrench behind the recorded command: `τ ẇ + w = r`.
    pub drive: T,
}

impl<T: Real> Lags<T> {
    /// Two lags in series, approximated by one lag whose time constant is their sum.
    pub(crate) fn in_series(self, other: Self) -> Self {
        Self { sensor: self.sensor + other.sensor, drive: self.drive + other.drive }
    }
}

/// Inputs of a law's constructor in addition to its parameter values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawSetup<'a, T> {
    /// Body that the law acts on.
    pub body: &'a Body,
    /// The model's first viscous wheel, `[x, y, angle, mu_x, mu_y]`.
    pub wheel: Option<[T; 5]>,
}

/// State of the object at which a law is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct LawContext<'a, T> {
    /// Position of the object frame in the world, m.
    pub position: [T; 2],
    /// Sine and cosine of the heading.
    pub heading: (T, T),
    /// Twist of the object frame's origin, object axes, `[m/s, m/s, rad/s]`.
    pub twist: [T; 3],
    /// Moving mass, kg.
    pub mass: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// Time and grasp.
    pub clock: Clock,
    /// Inner states of the law, in the order of [`Spec::inner_states`].
    pub inner: &'a [T],
}

impl<T: Real> LawContext<'_, T> {
    /// Velocity of a body point, object axes, m/s (the bracket of eq. 1).
    #[inline]
    pub fn point_velocity(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [vx, vy, spin] = self.twist;
        [vx - spin * y, vy + spin * x]
    }
}

/// A law with parameter values. A law implements the methods that its effect needs; the defaults have no effect.
pub(crate) trait EffectLaw<T: Real>: Sized {
    /// Whether the law is independent of the pose: neither [`EffectLaw::add_force`] nor [`EffectLaw::advance`] reads
    /// [`LawContext::position`] or [`LawContext::heading`]. A filter then omits derivatives with respect to the pose.
    const IS_POSE_INVARIANT: bool = false;

    /// Whether [`EffectLaw::correct`] reads [`Clock::trend`]. A simulation of readings must then compute the trend.
    const USES_TREND: bool = false;

    /// Create the law from the values of [`Spec::params`], in that order.
    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self;

    /// Generalised force that does not depend on any state, if the law is of that form. The plant then does not call
    /// [`EffectLaw::add_force`].
    #[inline]
    fn constant_force(&self) -> Option<&GeneralisedForce<T>> {
        None
    }

    /// Add the generalised force on the object to `sum`.
    #[inline]
    fn add_force(&self, _at: &LawContext<'_, T>, _sum: &mut GeneralisedForce<T>) {}

    /// Points of the object, object frame, m, each with a constant friction, N, against its velocity, if the law is friction of
    /// that form spread over the body.
    fn sliding_points(&self) -> Option<Vec<([T; 2], T)>> {
        None
    }

    /// Correct a reading to the wrench that acted, `[N, N, N·m]`, reading axes about the reading's reference point.
    #[inline]
    fn correct(&self, reading: [T; 3], _clock: Clock) -> [T; 3] {
        reading
    }

    /// Change the mass properties, if [`Spec::changes_mass`]. `grasp`: grasp point, object frame, m.
    #[inline]
    fn change_mass(&self, _clock: Clock, _grasp: [f64; 2], _rigid: &mut Rigid<T>) {}

    /// Delay of the reading, s.
    #[inline]
    fn delay(&self, _clock: Clock) -> Option<T> {
        None
    }

    /// First-order lags between wrench and reading.
    #[inline]
    fn lags(&self) -> Option<Lags<T>> {
        None
    }

    /// Pose of the tracked frame in the object frame, m, m, rad, if they differ.
    #[inline]
    fn mount(&self) -> Option<[T; 3]> {
        None
    }

    /// Advance the inner states by `dt` seconds. `at` describes the middle of the step, except that `at.inner` holds
    /// the inner states at its start.
    #[inline]
    fn advance(&self, _at: &LawContext<'_, T>, _dt: f64, _inner: &mut [T]) {}
}

/// The first `N` values of a law. The model checks their number beforehand.
pub(crate) fn take<T: Real, const N: usize>(values: &[T]) -> [T; N] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or_else(T::zero))
}
