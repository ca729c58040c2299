//! Properties of kinds of effects that guide their search in recordings.

use crate::catalogue::Kind;
use crate::effects::floor_patch::patch_outline;
use crate::law::Role;

/// Source of the starting points (locations, times, shapes) from which an effect is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proposal {
    /// Random draws from the prior.
    Random,
    /// Contact candidates: obstacles that the object may have touched.
    ContactCandidate,
    /// Floor regions with a residual drag, in addition to random draws.
    Region,
    /// Lines across the floor at which a force is missing.
    Ridge,
    /// Spatial periods of the residual force, in addition to random draws.
    Period,
    /// Range of the readings.
    ReadingRange,
    /// A sequence of event times.
    EventTime,
}

impl Kind {
    /// Source of the starting points.
    pub fn proposal(self) -> Proposal {
        match self {
            Self::ObstacleContact => Proposal::ContactCandidate,
            Self::FloorPatch => Proposal::Region,
            Self::Doorsill => Proposal::Ridge,
            Self::Cogging => Proposal::Period,
            Self::Saturation => Proposal::ReadingRange,
            _ if self.spec().params.iter().any(|p| p.role == Role::Time) => Proposal::EventTime,
            _ => Proposal::Random,
        }
    }

    /// Whether a model may contain several effects of this kind: a body may rub at several points.
    pub fn may_repeat(self) -> bool {
        self == Self::CoulombFriction
    }

    /// Simpler laws to which this kind reduces at a limit of its parameters, in sets that act together: thinning drag
    /// is dry friction at exponent zero, and a load on stiff springs only changes the mass centre and the inertia. A set is
    /// listed after its subsets.
    pub fn limiting_kinds(self) -> &'static [&'static [Self]] {
        match self {
            Self::ThinningDrag => &[&[Self::SupportFriction]],
            Self::SwingingLoad => {
                &[&[Self::ComOffset], &[Self::MassSpread], &[Self::ComOffset, Self::MassSpread]]
            }
            _ => &[],
        }
    }

    /// Whether it is a building block of a more general effect: one wheel and a spin damping represent any viscous
    /// friction.
    pub fn is_building_block(self) -> bool {
        matches!(self, Self::ViscousWheel | Self::SupportDrag)
    }

    /// Whether it is viscous friction at a point or of the spin. Together these form any damping matrix.
    pub fn is_damping(self) -> bool {
        matches!(self, Self::ViscousWheel | Self::SpinDrag)
    }

    /// Whether its location is a mass centre. A mass centre lies in the convex hull of the body, not always in its
    /// shape.
    pub fn is_mass_centre(self) -> bool {
        self == Self::ComOffset
    }

    /// Whether it is a fault of a sensor, which commanded wrenches cannot have.
    pub fn is_sensor_fault(self) -> bool {
        use Kind::{CrossTalk, DeadBand, Saturation, SensorLag, SensorPlay};
        matches!(self, SensorLag | SensorPlay | CrossTalk | Saturation | DeadBand)
    }

    /// Whether it is a fault of a drive, which only commanded wrenches can have.
    pub fn is_drive_fault(self) -> bool {
        self == Self::DriveLag
    }

    /// Whether it modifies an existing wheel of the model.
    pub fn changes_wheels(self) -> bool {
        self == Self::WheelEvent
    }

    /// Whether it is identifiable from quasi-static recordings, of which only the wrench is compared. These contain no
    /// information on inertia, time or inner states. A sensor gain or a floor pattern is confounded with an unknown
    /// pressure distribution.
    pub fn is_quasi_static(self) -> bool {
        use Kind::{AxisFriction, BodyAxisFriction, CoulombFriction, DirectionalFriction};
        use Kind::{FloorSlope, ForceBias, SpinDrag, SupportFriction};
        matches!(
            self,
            CoulombFriction
                | SupportFriction
                | SpinDrag
                | DirectionalFriction
                | AxisFriction
                | BodyAxisFriction
                | ForceBias
                | FloorSlope
        )
    }

    /// Whether it differs on a rail from every simpler effect. On a rail, friction at a point or along an axis equals
    /// friction of the whole body, and there is no rotation.
    pub fn is_distinct_on_rail(self) -> bool {
        use Kind::{AxisFriction, BodyAxisFriction, CoulombFriction, SpinDrag};
        let spec = self.spec();
        let on_rail = |name: &str| spec.params.iter().any(|p| p.name == name && p.on_rail);
        !matches!(self, CoulombFriction | SpinDrag | AxisFriction | BodyAxisFriction)
            && spec.neutral.iter().any(|(name, _)| on_rail(name))
    }

    /// Region of the floor on which it acts: a convex polygon, world, m; `None` for other effects.
    pub fn region(self, values: &[f64]) -> Option<Vec<[f64; 2]>> {
        (self == Self::FloorPatch).then(|| patch_outline(values))
    }
}
