//! Fitted models, and fits to be made.

use crate::black_box::Basis;
use crate::candidates::name;
use trundle_infer::Fit;
use trundle_model::{Effect, Kind};

/// A fitted model: the nominal model with some effects added.
#[derive(Clone)]
pub(crate) struct FittedModel {
    pub added: Vec<Effect>,
    pub fit: Fit,
    /// The linearisation of a black-box simulator for this fit; `None` for trundle's own plant.
    pub basis: Option<Basis>,
    /// Log prior probability of its effects relative to no effect.
    pub log_prior: f64,
    /// Whether a repeated search of its effects' shapes found no better ones.
    pub is_settled: bool,
}

impl FittedModel {
    /// A new fit; the search sets the prior.
    pub fn new(added: Vec<Effect>, fit: Fit, basis: Option<Basis>) -> Self {
        Self { added, fit, basis, log_prior: 0.0, is_settled: false }
    }

    /// Log evidence plus log prior, up to a constant.
    pub fn log_weight(&self) -> f64 {
        self.fit.log_evidence + self.log_prior
    }

    /// Names of the added effects.
    pub fn names(&self) -> Vec<&'static str> {
        self.added.iter().map(name).collect()
    }
}

/// A fit to be made: effects to add, and starting values of all slots.
#[derive(Clone)]
pub(crate) struct Job {
    pub added: Vec<Effect>,
    pub warm: Vec<Vec<f64>>,
    /// Cost of the model that it starts from.
    pub from: f64,
    /// Noise of that model.
    pub channels: trundle_infer::Channels,
    /// Linearisation of that model.
    pub basis: Option<Basis>,
}

impl Job {
    /// A fit that starts from a model.
    pub fn from(model: &FittedModel, added: Vec<Effect>, warm: Vec<Vec<f64>>) -> Self {
        let (fit, basis) = (&model.fit, model.basis.clone());
        Self { added, warm, from: fit.cost, channels: fit.channels, basis }
    }
}

/// Most Levenberg–Marquardt steps of a fit to the optimum, and of a refit that starts a fraction of a
/// standard deviation from its optimum.
pub(crate) const MAX_FIT_STEPS: usize = 60;
pub(crate) const MAX_REFIT_STEPS: usize = 6;

/// How far a fit is continued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// A few steps, to exclude poor models.
    Screening,
    /// One or two more steps, to rank models.
    Ranking,
    /// To the optimum.
    Full,
}

impl Effort {
    /// Most steps.
    pub fn steps(self) -> usize {
        match self {
            Self::Screening => 8,
            Self::Ranking => 2,
            Self::Full => MAX_FIT_STEPS,
        }
    }

    /// Most estimates of the noise, if the recording does not state it. Missing effects count as noise at
    /// first, so that a law that acts briefly gains only after the noise is estimated again.
    pub fn noise_rounds(self) -> usize {
        if self == Self::Full { 2 } else { 1 }
    }
}

/// Sets of kinds in which simpler laws replace one effect. Sets in which a law would act twice are left out.
pub(crate) fn simpler_sets(added: &[Effect]) -> impl Iterator<Item = Vec<Kind>> {
    (0..added.len()).flat_map(move |k| {
        let limits = added[k].kind.limiting_kinds();
        let rest: Vec<Kind> =
            added.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, e)| e.kind).collect();
        let is_new = |limit: &&&[Kind]| limit.iter().all(|kind| !rest.contains(kind));
        limits.iter().filter(is_new).map(|limit| [&rest, *limit].concat()).collect::<Vec<_>>()
    })
}

/// The best fitted model with effects of the given kinds.
pub(crate) fn with_kinds(models: &[FittedModel], mut kinds: Vec<Kind>) -> Option<&FittedModel> {
    kinds.sort();
    models.iter().find(|t| {
        let mut own: Vec<Kind> = t.added.iter().map(|e| e.kind).collect();
        own.sort();
        own == kinds
    })
}

#[cfg(test)]
mod tests {
    use super::simpler_sets;
    use trundle_model::{Effect, Kind};

    #[test]
    fn simpler_laws_replace_one_effect_and_act_once() {
        use Kind::{ComOffset, Latency, MassSpread, SwingingLoad};
        let of = |kinds: &[Kind]| {
            let added: Vec<Effect> = kinds.iter().map(|&kind| Effect::free(kind)).collect();
            simpler_sets(&added).collect::<Vec<_>>()
        };
        let with_delay = [vec![ComOffset], vec![MassSpread], vec![ComOffset, MassSpread]]
            .map(|limit| [vec![Latency], limit].concat());
        assert_eq!(of(&[Latency, SwingingLoad]), with_delay);
        assert_eq!(of(&[ComOffset, SwingingLoad]), [[ComOffset, MassSpread]]);
        assert!(of(&[ComOffset, MassSpread]).is_empty());
    }
}
