//! Candidates: kinds of effects that may be missing.

use trundle_model::{Effect, Kind, Model};

/// Kinds of effects that may be missing from a nominal model. `commanded`: the recorded wrench is a drive's
/// command and not a sensor's reading.
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

/// Name of an effect in a diagnosis. A viscous wheel that is added to a black-box simulator is a second
/// wheel.
pub(crate) fn name(effect: &Effect) -> &'static str {
    let kind = if effect.kind.is_damping() { Kind::SpinDrag } else { effect.kind };
    kind.spec().effect
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::candidates;
    use trundle_fixtures::table;
    use trundle_model::{Body, Kind, Model};

    #[test]
    fn drive_effects_need_commands_and_sensor_effects_need_readings() {
        let nominal = Model::nominal(table(), None, [true; 3]);
        let (read, commanded) = (candidates(&nominal, false, false), candidates(&nominal, false, true));
        assert!(commanded.contains(&Kind::DriveLag) && !read.contains(&Kind::DriveLag));
        assert!(read.contains(&Kind::SensorLag) && !commanded.contains(&Kind::SensorLag));
        assert!(candidates(&nominal, true, true).iter().all(|kind| *kind != Kind::DriveLag));
    }

    #[test]
    fn effects_that_mix_axes_are_excluded_on_a_rail() {
        let rail = Model::nominal(Body::point(90.0).unwrap(), None, [true, false, false]);
        let offered = candidates(&rail, false, false);
        for kind in [Kind::CrossTalk, Kind::TrackerOffset, Kind::AxisFriction] {
            assert!(!offered.contains(&kind), "{kind:?}");
        }
        assert!(offered.contains(&Kind::SensorLag) && offered.contains(&Kind::ForceBias));
    }
}
