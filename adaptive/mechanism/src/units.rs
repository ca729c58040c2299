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
        use EffortUnit::{Newton, PerInertia, Recorded, TargetError};
        match (self, effort) {
            (Self::Position, _) => {
                if is_hinge {
                    "rad"
                } else {
                    "m"
                }
            }
            (Self::Velocity, _) => {
                if is_hinge {
                    "rad/s"
                } else {
                    "m/s"
                }
            }
            (Self::Time, _) => "s",
            (Self::Mass, _) => "kg",
            (Self::Length, _) => "m",
            (Self::Angle, _) => "rad",
            (Self::One, _) => "1",
            (Self::Stated(unit), _) => unit,
            (Self::Effort, Newton) => {
                if is_hinge {
                    "N·m"
                } else {
                    "N"
                }
            }
            (Self::Damping, Newton) => {
                if is_hinge {
                    "N·m·s/rad"
                } else {
                    "N·s/m"
                }
            }
            (Self::Stiffness, Newton) => {
                if is_hinge {
                    "N·m/rad"
                } else {
                    "N/m"
                }
            }
            (Self::Inertia, Newton) => {
                if is_hinge {
                    "kg·m²"
                } else {
                    "kg"
                }
            }
            (Self::Drag, Newton) => {
                if is_hinge {
                    "N·m·s²/rad²"
                } else {
                    "N·s²/m²"
                }
            }
            (Self::PerLoad, Newton) => {
                if is_hinge {
                    "N·m per unit of load"
                } else {
                    "N per unit of load"
                }
            }
            (Self::Effort, PerInertia) => {
                if is_hinge {
                    "rad/s²"
                } else {
                    "m/s²"
                }
            }
            (Self::Damping, PerInertia) => "1/s",
            (Self::Stiffness, PerInertia) => "1/s²",
            (Self::Inertia, PerInertia) => "1",
            (Self::Drag, PerInertia) => {
                if is_hinge {
                    "1/rad"
                } else {
                    "1/m"
                }
            }
            (Self::PerLoad, PerInertia) => {
                if is_hinge {
                    "rad/s² per unit of load"
                } else {
                    "m/s² per unit of load"
                }
            }
            (Self::Effort, TargetError) => {
                if is_hinge {
                    "rad"
                } else {
                    "m"
                }
            }
            (Self::Damping, TargetError) => "s",
            (Self::Stiffness, TargetError) => "1",
            (Self::Inertia, TargetError) => "s²",
            (Self::Drag, TargetError) => {
                if is_hinge {
                    "s²/rad"
                } else {
                    "s²/m"
                }
            }
            (Self::PerLoad, TargetError) => {
                if is_hinge {
                    "rad per unit of load"
                } else {
                    "m per unit of load"
                }
            }
            (Self::Effort, Recorded) => "recorded unit",
            (Self::Damping, Recorded) => "recorded unit per velocity",
            (Self::Stiffness, Recorded) => "recorded unit per position",
            (Self::Inertia, Recorded) => "recorded unit per acceleration",
            (Self::Drag, Recorded) => "recorded unit per squared velocity",
            (Self::PerLoad, Recorded) => "recorded unit per unit of load",
        }
    }
}
