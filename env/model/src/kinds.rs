//! What sets kinds of effects apart for those who seek them in recordings.

use crate::catalogue::Kind;
use crate::effects::floor_patch::patch_outline;
use crate::law::Role;

/// Where the places, moments and forms come from at which an effect is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proposal {
    /// Drawn at random.
    Random,
    /// Things that may have been touched.
    ContactCandidate,
    /// Parts of the floor that seem to drag; beside draws.
    Region,
    /// Periods of the missing force in position; beside draws.
    Period,
    /// The range of the readings.
    ReadingRange,
    /// Moments, one after the other.
    EventTime,
}

impl Kind {
    /// Where its places, moments and forms are proposed.
    pub fn proposal(self) -> Proposal {
        match self {
            Self::ObstacleContact => Proposal::ContactCandidate,
            Self::FloorPatch => Proposal::Region,
            Self::Cogging => Proposal::Period,
            Self::Saturation => Proposal::ReadingRange,
            _ if self.spec().params.iter().any(|p| p.role == Role::Time) => Proposal::EventTime,
            _ => Proposal::Random,
        }
    }

    /// Whether a second effect of this kind may be missing: a body may rub at several points.
    pub fn may_repeat(self) -> bool {
        self == Self::CoulombFriction
    }

    /// The simpler law that it becomes at an end of its range: drag that thins with speed is dry friction where its exponent
    /// is nought; a load on stiff springs only moves the mass centre.
    pub fn limiting_kind(self) -> Option<Self> {
        match self {
            Self::ThinningDrag => Some(Self::SupportFriction),
            Self::SwingingLoad => Some(Self::ComOffset),
            _ => None,
        }
    }

    /// Whether it is one of several building blocks of an effect: one wheel and a damping of the spin stand for any viscous
    /// friction.
    pub fn is_building_block(self) -> bool {
        matches!(self, Self::ViscousWheel | Self::SupportDrag)
    }

    /// Whether it is viscous friction at a point or of the spin, which together make any damping matrix.
    pub fn is_damping(self) -> bool {
        matches!(self, Self::ViscousWheel | Self::SpinDrag)
    }

    /// Whether its place is a mass centre, which lies within the convex hull of the body and not always within its shape.
    pub fn is_mass_centre(self) -> bool {
        self == Self::ComOffset
    }

    /// Whether it is a fault that only a sensor has, not a command.
    pub fn is_sensor_fault(self) -> bool {
        use Kind::{CrossTalk, DeadBand, Saturation, SensorLag, SensorPlay};
        matches!(self, SensorLag | SensorPlay | CrossTalk | Saturation | DeadBand)
    }

    /// Whether it is a fault that only a drive has, which is told what to do.
    pub fn is_drive_fault(self) -> bool {
        self == Self::DriveLag
    }

    /// Whether the reading that it falsifies depends on those before.
    pub fn has_memory(self) -> bool {
        matches!(self, Self::SensorLag | Self::SensorPlay)
    }

    /// Whether it changes the wheels of the simulation rather than adding to them.
    pub fn changes_wheels(self) -> bool {
        self == Self::WheelEvent
    }

    /// Whether slow pushes, judged by the wrench alone, can show it. They hold nothing of inertia, time or an effect's own
    /// states; and a gain of the sensor or a pattern of the floor takes the place of a pressure that is not known.
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

    /// Whether it means something on a rail that no simpler effect does: there a point or an axis is as good as the whole
    /// body, and nothing turns.
    pub fn is_distinct_on_rail(self) -> bool {
        use Kind::{AxisFriction, BodyAxisFriction, CoulombFriction, SpinDrag};
        let spec = self.spec();
        let on_rail = |name: &str| spec.params.iter().any(|p| p.name == name && p.on_rail);
        !matches!(self, CoulombFriction | SpinDrag | AxisFriction | BodyAxisFriction)
            && spec.neutral.iter().any(|(name, _)| on_rail(name))
    }

    /// The part of the floor on which it acts: a convex polygon, world, m; `None` where it acts elsewhere.
    pub fn region(self, values: &[f64]) -> Option<Vec<[f64; 2]>> {
        (self == Self::FloorPatch).then(|| patch_outline(values))
    }
}
