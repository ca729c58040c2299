//! What may have been left out.

use trundle_model::{Effect, Kind, Model};

/// Effects tried beside a simulation under test, one at a time, then in pairs.
pub(crate) fn candidates(nominal: &Model) -> Vec<Effect> {
    let rail = nominal.on_rail();
    let offered = |kind: &Kind| match kind {
        // The building block of the simulation under test, not an effect that goes missing.
        Kind::ViscousWheel => false,
        // On a rail a point is as good as the whole body, and drag is what the wheel has already.
        Kind::CoulombFriction | Kind::SupportDrag => !rail,
        _ => true,
    };
    let absent = |kind: &Kind| nominal.effects.iter().all(|e| e.kind != *kind);
    Kind::ALL.iter().filter(|k| offered(k) && absent(k)).map(|&k| Effect::free(k)).collect()
}

/// Name of an effect in a diagnosis.
pub(crate) fn name(effect: &Effect) -> &'static str {
    effect.kind.spec().effect
}
