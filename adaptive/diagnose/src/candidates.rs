//! What may have been left out.

use trundle_model::{Effect, Kind, Model};

/// Effects tried beside a simulation under test, one at a time, then in pairs.
pub(crate) fn candidates(nominal: &Model) -> Vec<Effect> {
    let rail = nominal.on_rail();
    let offered = |kind: &Kind| match kind {
        // Building blocks: one wheel and a damping of the spin stand for any viscous friction.
        Kind::ViscousWheel | Kind::SupportDrag => false,
        // On a rail a point is as good as the whole body, and nothing turns.
        Kind::CoulombFriction | Kind::SpinDrag => !rail,
        _ => true,
    };
    let absent = |kind: &Kind| nominal.effects.iter().all(|e| e.kind != *kind);
    Kind::ALL.iter().filter(|k| offered(k) && absent(k)).map(|&k| Effect::free(k)).collect()
}

/// Name of an effect in a diagnosis.
pub(crate) fn name(effect: &Effect) -> &'static str {
    effect.kind.spec().effect
}
