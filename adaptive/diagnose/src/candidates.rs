//! What may have been left out.

use trundle_model::{Acting, Effect, Kind, Model};

/// Kinds of effects that a simulation under test may lack. Slow pushes, judged by the wrench, hold nothing of inertia,
/// of time, or of states of an effect's own.
pub(crate) fn candidates(nominal: &Model, quasi_static: bool) -> Vec<Kind> {
    let rail = nominal.on_rail();
    let offered = |kind: &&Kind| match kind {
        // Building blocks: one wheel and a damping of the spin stand for any viscous friction.
        Kind::ViscousWheel | Kind::SupportDrag => false,
        // On a rail a point is as good as the whole body, and nothing turns.
        Kind::CoulombFriction | Kind::SpinDrag => !rail,
        _ => !(quasi_static && needs_motion(**kind)) && !(rail && is_planar(**kind)),
    };
    let absent = |kind: &&Kind| nominal.effects.iter().all(|e| e.kind != **kind);
    Kind::ALL.iter().filter(offered).filter(absent).copied().collect()
}

/// Whether an effect shows in inertia, in time or in states of its own.
fn needs_motion(kind: Kind) -> bool {
    let spec = kind.spec();
    let timed = spec.params.iter().any(|p| matches!(p.name, "time" | "delay"));
    spec.loads || timed || !spec.inner.is_empty()
}

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
