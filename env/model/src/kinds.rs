//! What sets kinds of effects apart for those who seek them in recordings.

use crate::catalogue::Kind;
use crate::effects::floor_patch::patch_outline;
use crate::law::Role;

/// Where the places, moments and forms come from at which an effect is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proposal {
    /// Drawn at random.
    Drawn,
    /// Things that may have been touched.
    Touched,
    /// Parts of the floor that seem to drag; beside draws.
    Region,
    /// Periods of the missing force in position; beside draws.
    Period,
    /// The range of the readings.
    Readings,
    /// Moments, one after the other.
    Moment,
}

impl Kind {
    /// Where its places, moments and forms are proposed.
    pub fn proposal(self) -> Proposal {
        match self {
            Self::ObstacleContact => Proposal::Touched,
            Self::FloorPatch => Proposal::Region,
            Self::Cogging => Proposal::Period,
            Self::Saturation => Proposal::Readings,
            _ if self.spec().params.iter().any(|p| p.role == Role::Time) => Proposal::Moment,
            _ => Proposal::Drawn,
        }
    }

    /// Whether a second effect of this kind may be missing: a body may rub at several points.
    pub fn repeats(self) -> bool {
        self == Self::CoulombFriction
    }

    /// The simpler law that it becomes at an end of its range: drag that thins with speed is dry friction where its exponent
    /// is nought; a load on stiff springs only moves the mass centre.
    pub fn simpler(self) -> Option<Self> {
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
    pub fn is_of_sensor(self) -> bool {
        use Kind::{CrossTalk, DeadBand, Saturation, SensorLag, SensorPlay};
        matches!(self, SensorLag | SensorPlay | CrossTalk | Saturation | DeadBand)
    }

    /// Whether it is a fault that only a drive has, which is told what to do.
    pub fn is_of_drive(self) -> bool {
        self == Self::DriveLag
    }

    /// Whether the reading that it falsifies depends on those before.
    pub fn remembers(self) -> bool {
        matches!(self, Self::SensorLag | Self::SensorPlay)
    }

    /// Whether it changes the wheels of the simulation rather than adding to them.
    pub fn changes_wheels(self) -> bool {
        self == Self::WheelEvent
    }

    /// Whether slow pushes, judged by the wrench alone, can show it. They hold nothing of inertia, time or an effect's own
    /// states; and a gain of the sensor or a pattern of the floor takes the place of a pressure that is not known.
    pub fn is_slow(self) -> bool {
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
    pub fn is_on_rail(self) -> bool {
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
