//! Trying effects: alone, in pairs, and one more on top of the best, while the data ask for more.

use crate::adequacy::{Remainder, remainder};
use crate::candidates::{candidates, name};
use std::collections::BTreeSet;
use trundle_infer::{Comparison, Coordinates, Fit, FitOptions, InferError, Watch, carried, fit};
use trundle_model::{Effect, Model};

/// A model that was tried: the simulation under test with some effects added.
#[derive(Clone)]
pub(crate) struct Tried {
    pub added: Vec<Effect>,
    pub fit: Fit,
}

impl Tried {
    /// Log evidence plus log prior: an effect is missing in one simulation of twenty.
    pub fn log_weight(&self) -> f64 {
        self.fit.log_evidence + self.added.len() as f64 * (0.05f64 / 0.95).ln()
    }

    /// Names of the added effects.
    pub fn names(&self) -> Vec<&'static str> {
        self.added.iter().map(name).collect()
    }
}

/// What the search found, best first.
pub(crate) struct Found {
    pub tried: Vec<Tried>,
    /// What the simulation under test leaves.
    pub before: Option<Remainder>,
}

/// At most this many effects are added.
const MOST: usize = 4;

/// Random starts for each added effect, beside the carried-over one.
const EXTRA_STARTS: usize = 3;

pub(crate) struct Searcher<'a> {
    pub comparison: &'a Comparison,
    pub nominal: &'a Model,
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

impl Searcher<'_> {
    /// Try everything worth trying.
    pub fn run(&self) -> Result<Found, InferError> {
        let base = self.fit(vec![], None)?;
        // Where the noise is not stated, the next searches start from what suits the simulation under test.
        let comparison = self.comparison.with_channels(base.fit.channels);
        let tuned = Searcher { comparison: &comparison, ..*self };
        tuned.beyond(base)
    }

    fn beyond(&self, base: Tried) -> Result<Found, InferError> {
        let before = remainder(self.comparison, &base.fit)?;
        let offered = candidates(self.nominal);
        let mut tried = vec![base.clone()];
        for (k, effect) in offered.iter().enumerate() {
            self.watch.progress("single effects", k as f64 / offered.len() as f64);
            tried.push(self.fit(vec![effect.clone()], Some(&base))?);
        }
        sort(&mut tried);
        self.refine(&mut tried)?;
        if self.asks_for_more(&tried[0])? {
            self.pairs(&mut tried, &offered, &base)?;
            self.refine(&mut tried)?;
        }
        let mut size = 2;
        while size < MOST && tried[0].added.len() == size && self.asks_for_more(&tried[0])? {
            self.one_more(&mut tried, &offered)?;
            self.refine(&mut tried)?;
            size += 1;
        }
        Ok(Found { tried, before })
    }

    /// Fit the simulation under test with effects added, starting from a simpler fit.
    pub fn fit(&self, added: Vec<Effect>, from: Option<&Tried>) -> Result<Tried, InferError> {
        let mut model = self.nominal.clone();
        model.effects.extend(added.iter().cloned());
        let coordinates = Coordinates::new(&model);
        let fill = coordinates.values(&vec![0.0; coordinates.free().len()]).0;
        let mut warm = Vec::new();
        let mut starts = FitOptions::default().starts;
        if let Some(from) = from {
            warm = self.warm(from, &model, &coordinates, &fill);
            starts = 0;
        }
        let options =
            FitOptions { starts, seed: self.seed, from_afar: from.is_none(), ..FitOptions::default() };
        Ok(Tried { added, fit: fit(self.comparison, &model, &warm, &options, self.watch)? })
    }

    /// The simpler fit's values, with the new effects' drawn from their priors a few times.
    fn warm(&self, from: &Tried, model: &Model, coordinates: &Coordinates, fill: &[f64]) -> Vec<Vec<f64>> {
        use rand::SeedableRng;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed);
        let mut starts = vec![carried(&from.fit, model, fill)];
        for _ in 0..EXTRA_STARTS {
            let draw = coordinates.values(&coordinates.draw(&mut rng)).0;
            starts.push(carried(&from.fit, model, &draw));
        }
        starts
    }

    fn pairs(&self, tried: &mut Vec<Tried>, offered: &[Effect], base: &Tried) -> Result<(), InferError> {
        let singles: Vec<Tried> = tried.iter().filter(|t| t.added.len() == 1).cloned().collect();
        for (i, first) in offered.iter().enumerate() {
            for second in offered[i + 1..].iter().filter(|second| name(second) != name(first)) {
                self.watch.progress("pairs", i as f64 / offered.len() as f64);
                // From the better of the two single fits.
                let kinds = [first.kind, second.kind];
                let from = singles.iter().find(|t| kinds.contains(&t.added[0].kind)).unwrap_or(base);
                let pair = vec![first.clone(), second.clone()];
                tried.push(self.fit(pair, Some(from))?);
            }
        }
        sort(tried);
        Ok(())
    }

    fn one_more(&self, tried: &mut Vec<Tried>, offered: &[Effect]) -> Result<(), InferError> {
        let best = tried[0].clone();
        let present: BTreeSet<_> = best.added.iter().map(name).collect();
        for effect in offered.iter().filter(|e| !present.contains(name(e))) {
            self.watch.progress("one more effect", 0.5);
            let mut added = best.added.clone();
            added.push(effect.clone());
            tried.push(self.fit(added, Some(&best))?);
        }
        sort(tried);
        Ok(())
    }

    /// Where the best model leaves something, try the finer forms of its effects: stiction, a drift. Not for slow
    /// pushes: nothing says there that more is needed, and one speed does not tell stiction from sliding.
    fn refine(&self, tried: &mut Vec<Tried>) -> Result<(), InferError> {
        let best = tried[0].clone();
        if best.added.is_empty() || self.comparison.is_quasi_static() || !self.asks_for_more(&best)? {
            return Ok(());
        }
        for (k, effect) in best.added.iter().enumerate() {
            let Some(finer) = finer(effect) else { continue };
            self.watch.progress("finer forms", k as f64 / best.added.len() as f64);
            let mut added = best.added.clone();
            added[k] = finer;
            if tried.iter().all(|t| t.added != added) {
                tried.push(self.fit(added, Some(&best))?);
            }
        }
        sort(tried);
        Ok(())
    }

    fn asks_for_more(&self, best: &Tried) -> Result<bool, InferError> {
        let observations = self.comparison.observations();
        Ok(match remainder(self.comparison, &best.fit)? {
            Some(remainder) => remainder.matters(observations),
            None => true,
        })
    }
}

/// The effect with its refinements free, if it has any that are not.
fn finer(effect: &Effect) -> Option<Effect> {
    let free: Vec<_> = effect.kind.spec().params.iter().filter(|p| p.refinement.is_some()).collect();
    let finer = free.iter().fold(effect.clone(), |e, param| e.with(param.name, None));
    (finer != *effect).then_some(finer)
}

fn sort(tried: &mut [Tried]) {
    tried.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
}

/// Probability of each model among those tried.
pub(crate) fn probabilities(tried: &[Tried]) -> Vec<f64> {
    let best = tried.iter().map(Tried::log_weight).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = tried.iter().map(|t| (t.log_weight() - best).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}
