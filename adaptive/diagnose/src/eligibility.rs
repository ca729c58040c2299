//! Which other models may be named if the best model contains an immaterial effect.

use crate::candidates::name;
use crate::fitted_model::FittedModel;
use trundle_model::Effect;

/// Reason for not testing a model.
pub(crate) const INELIGIBLE: &str = "a model that fits better contains an immaterial effect";

/// The best model with an immaterial effect. Until a test rejects its other effects, only models with those
/// effects may be named.
pub(crate) struct Eligibility<'a> {
    /// Index among the fitted models.
    pub index: usize,
    pub candidate: &'a FittedModel,
    /// Indices of its immaterial effects.
    pub immaterial: Vec<usize>,
}

impl Eligibility<'_> {
    /// Whether another model contains only effects of this one, or simpler laws in their place.
    pub fn allows(&self, other: &FittedModel) -> bool {
        let simpler = self
            .candidate
            .added
            .iter()
            .flat_map(|e| e.kind.limiting_kinds().concat())
            .map(|kind| name(&Effect::free(kind)));
        let names: Vec<&str> = self.candidate.names().into_iter().chain(simpler).collect();
        other.names().iter().all(|name| names.contains(name))
    }

    /// Whether another model has the same effects except for the immaterial ones.
    pub fn is_reduced_to(&self, other: &FittedModel) -> bool {
        let names = self.candidate.names().into_iter().enumerate();
        let mut kept: Vec<_> =
            names.filter(|(k, _)| !self.immaterial.contains(k)).map(|(_, name)| name).collect();
        let mut own = other.names();
        kept.sort_unstable();
        own.sort_unstable();
        kept == own
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::Eligibility;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::fitted_model::FittedModel;
    use trundle_fixtures::{World, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind};

    #[test]
    fn models_with_other_effects_are_ineligible() {
        let data = World::of(locked()).recording(1);
        let engine = PlantEngine::new(&data, None).unwrap();
        let comparison = Comparison::of(&data).unwrap();
        let fitted = fit(&comparison, engine.nominal(), &[], &FitOptions::default(), &Quiet).unwrap();
        let of = |kinds: &[Kind]| {
            FittedModel::new(kinds.iter().map(|&kind| Effect::free(kind)).collect(), fitted.clone(), None)
        };
        let candidate = of(&[Kind::AxisFriction, Kind::SwingingLoad, Kind::FloorPatch]);
        let eligibility = Eligibility { index: 0, candidate: &candidate, immaterial: vec![1] };
        assert!(eligibility.allows(&of(&[Kind::FloorPatch])) && eligibility.allows(&of(&[Kind::ComOffset])));
        assert!(eligibility.allows(&of(&[Kind::ComOffset, Kind::MassSpread])));
        assert!(!eligibility.allows(&of(&[Kind::AxisFriction, Kind::SpinDrag])));
        assert!(eligibility.is_reduced_to(&of(&[Kind::FloorPatch, Kind::AxisFriction])));
        assert!(
            !eligibility.is_reduced_to(&of(&[Kind::AxisFriction])) && !eligibility.is_reduced_to(&candidate)
        );
    }
}
