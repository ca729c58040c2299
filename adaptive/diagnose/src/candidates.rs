//! What may have been left out.

use trundle_model::{Acting, Effect, Kind, Model};

/// Kinds of effects that a simulation under test may lack.
pub(crate) fn candidates(nominal: &Model, quasi_static: bool) -> Vec<Kind> {
    let rail = nominal.on_rail();
    let offered = |kind: &&Kind| match kind {
        // Building blocks: one wheel and a damping of the spin stand for any viscous friction.
        Kind::ViscousWheel | Kind::SupportDrag => false,
        // On a rail a point is as good as the whole body, and nothing turns.
        Kind::CoulombFriction | Kind::SpinDrag => !rail,
        _ => (!quasi_static || SLOW.contains(kind)) && !(rail && is_planar(**kind)),
    };
    let absent = |kind: &&Kind| nominal.effects.iter().all(|e| e.kind != **kind);
    Kind::ALL.iter().filter(offered).filter(absent).copied().collect()
}

/// What slow pushes, judged by the wrench alone, are asked for. They hold nothing of inertia, time or an effect's own
/// states; and a gain of the sensor or a pattern of the floor takes the place of a pressure that is not known.
const SLOW: [Kind; 6] = [
    Kind::CoulombFriction,
    Kind::SupportFriction,
    Kind::SpinDrag,
    Kind::DirectionalFriction,
    Kind::ForceBias,
    Kind::FloorSlope,
];

/// Whether an effect means nothing on a rail: none of its amplitudes does.
fn is_planar(kind: Kind) -> bool {
    let spec = kind.spec();
    let on_rail = |name: &str| spec.params.iter().any(|p| p.name == name && p.on_rail);
    spec.acting == Acting::Object && !spec.neutral.iter().any(|(name, _)| on_rail(name))
}

/// Name of an effect in a diagnosis.
pub(crate) fn name(effect: &Effect) -> &'static str {
    effect.kind.spec().effect
}
