//! The catalogue of effects. A new effect needs a file in `effects/` and one line at the end of this file.

use crate::Real;
use crate::effects;
use crate::generalised_force::GeneralisedForce;
use crate::law::{Clock, EffectLaw, Lags, LawContext, LawSetup, Rigid, Spec};

macro_rules! catalogue {
    ($($module:ident :: $Law:ident),* $(,)?) => {
        /// Kind of an effect.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Kind { $(
            #[doc = concat!("`", stringify!($module), "`")]
            $Law
        ),* }

        impl Kind {
            /// All kinds, in the order of the catalogue.
            pub const ALL: &'static [Kind] = &[$(Kind::$Law),*];

            /// Entry in the catalogue.
            pub fn spec(self) -> &'static Spec {
                match self { $(Kind::$Law => &effects::$module::SPEC),* }
            }
        }

        /// A law with parameter values.
        #[derive(Clone, Debug)]
        pub enum Law<T> { $(
            #[doc = concat!("`", stringify!($module), "`")]
            $Law(effects::$module::$Law<T>)
        ),* }

        impl<T: Real> Law<T> {
            /// Create a law from values in the order of its parameters.
            pub(crate) fn new(kind: Kind, values: &[T], site: &LawSetup<'_, T>) -> Self {
                match kind { $(Kind::$Law => Law::$Law(EffectLaw::new(values, site))),* }
            }

            /// Add the generalised force on the object to `sum`.
            #[inline]
            pub(crate) fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
                match self { $(Law::$Law(law) => law.add_force(at, sum)),* }
            }

            /// Correct a reading to the wrench that acted.
            #[inline]
            pub(crate) fn correct(&self, reading: [T; 3], clock: Clock) -> [T; 3] {
                match self { $(Law::$Law(law) => law.correct(reading, clock)),* }
            }

            /// Change the mass properties.
            #[inline]
            pub(crate) fn change_mass(&self, clock: Clock, rigid: &mut Rigid<T>) {
                match self { $(Law::$Law(law) => law.change_mass(clock, clock.grasp, rigid)),* }
            }

            /// Delay of the reading, s.
            #[inline]
            pub(crate) fn delay(&self, clock: Clock) -> Option<T> {
                match self { $(Law::$Law(law) => law.delay(clock)),* }
            }

            /// First-order lags between wrench and reading.
            #[inline]
            pub(crate) fn lags(&self) -> Option<Lags<T>> {
                match self { $(Law::$Law(law) => law.lags()),* }
            }

            /// Pose of the tracked frame in the object frame, if the law moves it.
            #[inline]
            pub(crate) fn mount(&self) -> Option<[T; 3]> {
                match self { $(Law::$Law(law) => law.mount()),* }
            }

            /// Advance the inner states of the law.
            #[inline]
            pub(crate) fn advance(&self, at: &LawContext<'_, T>, dt: f64, inner: &mut [T]) {
                match self { $(Law::$Law(law) => law.advance(at, dt, inner)),* }
            }

            /// Generalised force that does not depend on any state, if the law is of that form.
            #[inline]
            pub(crate) fn constant_force(&self) -> Option<&GeneralisedForce<T>> {
                match self { $(Law::$Law(law) => law.constant_force()),* }
            }

            /// Points with a constant friction against their velocity, if the law is of that form.
            pub(crate) fn sliding_points(&self) -> Option<Vec<([T; 2], T)>> {
                match self { $(Law::$Law(law) => law.sliding_points()),* }
            }

            /// Whether the law is independent of the pose.
            pub(crate) fn is_pose_invariant(&self) -> bool {
                match self { $(Law::$Law(_) => <effects::$module::$Law<T> as EffectLaw<T>>::IS_POSE_INVARIANT),* }
            }

            /// Whether its correction depends on the trend of the reading.
            pub(crate) fn uses_trend(&self) -> bool {
                match self { $(Law::$Law(_) => <effects::$module::$Law<T> as EffectLaw<T>>::USES_TREND),* }
            }

            /// Entry in the catalogue.
            pub fn spec(&self) -> &'static Spec {
                match self { $(Law::$Law(_) => &effects::$module::SPEC),* }
            }
        }
    };
}

/// Entries of all effects, in the order of the catalogue.
pub fn catalogue() -> impl Iterator<Item = &'static Spec> {
    Kind::ALL.iter().map(|kind| kind.spec())
}

impl Kind {
    /// Kind with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.spec().kind == name)
    }
}

catalogue! {
    viscous_wheel::ViscousWheel,
    coulomb_friction::CoulombFriction,
    support_friction::SupportFriction,
    support_drag::SupportDrag,
    spin_drag::SpinDrag,
    directional_friction::DirectionalFriction,
    force_bias::ForceBias,
    floor_slope::FloorSlope,
    com_offset::ComOffset,
    mass_change::MassChange,
    wheel_event::WheelEvent,
    gripper_inertia::GripperInertia,
    force_scale::ForceScale,
    latency::Latency,
    tracker_offset::TrackerOffset,
    cogging::Cogging,
    quadratic_drag::QuadraticDrag,
    floor_patch::FloorPatch,
    floor_grain::FloorGrain,
    tether::Tether,
    obstacle_contact::ObstacleContact,
    caster_swivel::CasterSwivel,
    swinging_load::SwingingLoad,
    doorsill::Doorsill,
    axis_friction::AxisFriction,
    body_axis_friction::BodyAxisFriction,
    thinning_drag::ThinningDrag,
    cross_talk::CrossTalk,
    saturation::Saturation,
    dead_band::DeadBand,
    sensor_play::SensorPlay,
    clock_drift::ClockDrift,
    sensor_lag::SensorLag,
    drive_lag::DriveLag,
    mass_spread::MassSpread,
}
