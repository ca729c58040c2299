//! Comparisons of effect lists, and refinements.

use trundle_model::{Effect, Kind};

/// Whether two models have the same effects, with the same multiplicity.
pub(super) fn have_same_effects(a: &[Effect], b: &[Effect]) -> bool {
    let count = |of: &[Effect], effect: &Effect| of.iter().filter(|e| *e == effect).count();
    a.len() == b.len() && a.iter().all(|effect| count(a, effect) == count(b, effect))
}

/// Kinds of some effects in the order of the catalogue, with multiplicity.
pub(super) fn kinds(effects: &[Effect]) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = effects.iter().map(|e| e.kind).collect();
    kinds.sort_unstable();
    kinds
}

/// The effect with its refinements free; `None` if they are free already or there are none.
pub(super) fn with_refinements(effect: &Effect) -> Option<Effect> {
    let free: Vec<_> =
        effect.kind.spec().params.iter().filter(|p| p.refinement.is_some() && !p.role.is_choice()).collect();
    let with_refinements = free.iter().fold(effect.clone(), |e, param| e.with(param.name, None));
    (with_refinements != *effect).then_some(with_refinements)
}

#[cfg(test)]
mod tests {
    use super::{have_same_effects, kinds};
    use trundle_model::{Effect, Kind};

    #[test]
    fn multiplicity_of_effects_counts() {
        let [friction, slope] = [Kind::CoulombFriction, Kind::FloorSlope].map(Effect::free);
        let (twice, mixed) = ([friction.clone(), friction.clone()], [slope, friction]);
        assert!(
            !have_same_effects(&twice, &mixed)
                && !have_same_effects(&mixed, &twice)
                && have_same_effects(&twice, &twice)
        );
        assert!(have_same_effects(&mixed, &[mixed[1].clone(), mixed[0].clone()]));
        assert_eq!(kinds(&twice), [Kind::CoulombFriction; 2]);
    }
}
