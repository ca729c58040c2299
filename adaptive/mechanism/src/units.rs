//! Units of a joint's quantities, which depend on its type and on what fixes the scale of force.

/// Unit of a quantity of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// N·m or N.
    Effort,
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Velocity,
    /// Effort over velocity.
    Damping,
    /// Effort over position.
    Stiffness,
    /// Effort over acceleration.
    Inertia,
    /// Effort over the square of the velocity.
    Drag,
    /// s.
    Time,
    /// kg.
    Mass,
    /// m.
    Length,
    /// rad.
    Angle,
    /// Effort over the unit of the recorded covariate.
    PerLoad,
    /// No unit.
    One,
    /// As stated for a parameter of a simulator.
    Stated(&'static str),
}

/// What an effort is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum EffortUnit {
    /// N·m or N.
    #[default]
    Newton,
    /// The recorded unit: its gain is free and nothing else fixes the scale.
    Recorded,
    /// Position error of the target: the stiffness of the drive is free and nothing else fixes the scale.
    TargetError,
    /// Acceleration: dynamics per unit of inertia.
    PerInertia,
}

impl Unit {
    /// Its text for a hinge or a slide.
    #[must_use]
    pub fn text(self, is_hinge: bool, effort: EffortUnit) -> &'static str {
        let [hinge, slide] = self.texts(effort);
        if is_hinge { hinge } else { slide }
    }

    /// Its texts for a hinge and a slide.
    fn texts(self, effort: EffortUnit) -> [&'static str; 2] {
        match self {
            Self::Position => ["rad", "m"],
            Self::Velocity => ["rad/s", "m/s"],
            Self::Time => ["s"; 2],
            Self::Mass => ["kg"; 2],
            Self::Length => ["m"; 2],
            Self::Angle => ["rad"; 2],
            Self::One => ["1"; 2],
            Self::Stated(unit) => [unit; 2],
            Self::Effort => {
                effort.select([["N·m", "N"], ["rad/s²", "m/s²"], ["rad", "m"], ["recorded unit"; 2]])
            }
            Self::Damping => effort.select([
                ["N·m·s/rad", "N·s/m"],
                ["1/s"; 2],
                ["s"; 2],
                ["recorded unit per velocity"; 2],
            ]),
            Self::Stiffness => {
                effort.select([["N·m/rad", "N/m"], ["1/s²"; 2], ["1"; 2], ["recorded unit per position"; 2]])
            }
            Self::Inertia => {
                effort.select([["kg·m²", "kg"], ["1"; 2], ["s²"; 2], ["recorded unit per acceleration"; 2]])
            }
            Self::Drag => effort.select([
                ["N·m·s²/rad²", "N·s²/m²"],
                ["1/rad", "1/m"],
                ["s²/rad", "s²/m"],
                ["recorded unit per squared velocity"; 2],
            ]),
            Self::PerLoad => effort.select([
                ["N·m per unit of load", "N per unit of load"],
                ["rad/s² per unit of load", "m/s² per unit of load"],
                ["rad per unit of load", "m per unit of load"],
                ["recorded unit per unit of load"; 2],
            ]),
        }
    }
}

impl EffortUnit {
    /// The entry for this unit of efforts, in the order newton, acceleration, position error, recorded.
    fn select<T>(self, [newton, per_inertia, target_error, recorded]: [T; 4]) -> T {
        match self {
            Self::Newton => newton,
            Self::PerInertia => per_inertia,
            Self::TargetError => target_error,
            Self::Recorded => recorded,
        }
    }
}
