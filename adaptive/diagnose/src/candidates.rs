//! What may have been left out.

use trundle_model::{Effect, Kind, Model};

/// Kinds of effects that a simulation under test may lack. `commanded`: whether the recorded wrench is what a drive was
/// told, not what a sensor read.
pub(crate) fn candidates(nominal: &Model, quasi_static: bool, commanded: bool) -> Vec<Kind> {
    let rail = nominal.on_rail();
    let offered = |kind: &&Kind| match kind {
        // Building blocks: one wheel and a damping of the spin stand for any viscous friction.
        Kind::ViscousWheel | Kind::SupportDrag => false,
        // On a rail a point or an axis is as good as the whole body, and nothing turns.
        Kind::CoulombFriction | Kind::SpinDrag | Kind::AxisFriction | Kind::BodyAxisFriction => !rail,
        Kind::DriveLag => commanded && !quasi_static,
        _ if commanded && SENSING.contains(kind) => false,
        _ => (!quasi_static || SLOW.contains(kind)) && !(rail && is_planar(**kind)),
    };
    let absent = |kind: &&Kind| nominal.effects.iter().all(|e| e.kind != **kind);
    Kind::ALL.iter().filter(offered).filter(absent).copied().collect()
}

/// Whether a second effect of this kind may be missing: a body may rub at several points.
pub(crate) fn repeats(kind: Kind) -> bool {
    kind == Kind::CoulombFriction
}

/// The simpler law that a kind becomes at an end of its range: drag that thins with speed is dry friction where its exponent
/// is nought.
pub(crate) fn limit(kind: Kind) -> Option<Kind> {
    (kind == Kind::ThinningDrag).then_some(Kind::SupportFriction)
}

/// Faults that only a sensor has, not a command.
const SENSING: [Kind; 5] =
    [Kind::SensorLag, Kind::SensorPlay, Kind::CrossTalk, Kind::Saturation, Kind::DeadBand];

/// What slow pushes, judged by the wrench alone, are asked for. They hold nothing of inertia, time or an effect's own
/// states; and a gain of the sensor or a pattern of the floor takes the place of a pressure that is not known.
const SLOW: [Kind; 8] = [
    Kind::CoulombFriction,
    Kind::SupportFriction,
    Kind::SpinDrag,
    Kind::DirectionalFriction,
    Kind::AxisFriction,
    Kind::BodyAxisFriction,
    Kind::ForceBias,
    Kind::FloorSlope,
];

/// Whether an effect means nothing on a rail: none of its amplitudes does.
fn is_planar(kind: Kind) -> bool {
    let spec = kind.spec();
    let on_rail = |name: &str| spec.params.iter().any(|p| p.name == name && p.on_rail);
    !spec.neutral.iter().any(|(name, _)| on_rail(name))
}

/// Name of an effect in a diagnosis. A wheel beside those of a simulator that may have some is one more.
pub(crate) fn name(effect: &Effect) -> &'static str {
    let kind = if effect.kind == Kind::ViscousWheel { Kind::SpinDrag } else { effect.kind };
    kind.spec().effect
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::candidates;
    use crate::common::table;
    use trundle_model::{Body, Kind, Model};

    #[test]
    fn a_lag_of_the_drive_is_for_commands_and_faults_of_a_sensor_are_for_readings() {
        let nominal = Model::nominal(table(), None, [true; 3]);
        let (read, told) = (candidates(&nominal, false, false), candidates(&nominal, false, true));
        assert!(told.contains(&Kind::DriveLag) && !read.contains(&Kind::DriveLag));
        assert!(read.contains(&Kind::SensorLag) && !told.contains(&Kind::SensorLag));
        assert!(candidates(&nominal, true, true).iter().all(|kind| *kind != Kind::DriveLag));
    }

    #[test]
    fn what_mixes_axes_means_nothing_on_a_rail() {
        let rail = Model::nominal(Body::point(90.0).unwrap(), None, [true, false, false]);
        let offered = candidates(&rail, false, false);
        for kind in [Kind::CrossTalk, Kind::TrackerOffset, Kind::AxisFriction] {
            assert!(!offered.contains(&kind), "{kind:?}");
        }
        assert!(offered.contains(&Kind::SensorLag) && offered.contains(&Kind::ForceBias));
    }
}
