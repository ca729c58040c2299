//! What may have been left out.

use trundle_model::{Effect, Kind, Model};

/// Kinds of effects that a simulation under test may lack. `commanded`: whether the recorded wrench is what a drive was
/// told, not what a sensor read.
pub(crate) fn candidates(nominal: &Model, quasi_static: bool, commanded: bool) -> Vec<Kind> {
    let rail = nominal.on_rail();
    let suits = |kind: &&Kind| {
        !kind.is_building_block()
            && (!rail || kind.is_distinct_on_rail())
            && (!quasi_static || kind.is_quasi_static())
            && (commanded && !kind.is_sensor_fault() || !commanded && !kind.is_drive_fault())
    };
    let absent = |kind: &&Kind| nominal.effects.iter().all(|e| e.kind != **kind);
    Kind::ALL.iter().filter(suits).filter(absent).copied().collect()
}

/// Name of an effect in a diagnosis. A wheel beside those of a simulator that may have some is one more.
pub(crate) fn name(effect: &Effect) -> &'static str {
    let kind = if effect.kind.is_damping() { Kind::SpinDrag } else { effect.kind };
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
