//! Trying laws on a foreign simulator: alone, then one more on top of the best while the data ask for more.

use super::likelihood::Along;
use super::path::Path;
use super::simulator::Foreign;
use crate::candidates::{candidates, name};
use crate::thresholds::matters;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::sync::Arc;
use trundle_infer::{Channels, Coordinates, Fit, FitOptions, InferError, Likelihood, Watch, carried, fit};
use trundle_model::{Acting, Effect, Kind, Model, Prior};

/// A set of laws that was tried.
#[derive(Clone)]
pub(crate) struct Trial {
    pub added: Vec<Effect>,
    pub fit: Fit,
    /// −log density of each interval, episode by episode.
    costs: Vec<Vec<f64>>,
    /// The simulator as it was linearised for this fit.
    pub along: Arc<Along>,
    /// Whether that was about where the fit has its parameters.
    settled: bool,
}

impl Trial {
    /// Log evidence plus log prior: an effect is missing in one simulation of twenty, an event in any of the episodes.
    pub fn log_weight(&self) -> f64 {
        let events = self.added.iter().filter(|e| e.kind.spec().params.iter().any(|p| p.choice)).count();
        let episodes = self.costs.len().max(1) as f64;
        self.fit.log_evidence + self.added.len() as f64 * (0.05f64 / 0.95).ln()
            - events as f64 * episodes.ln()
    }

    pub fn names(&self) -> Vec<&'static str> {
        self.added.iter().map(called).collect()
    }
}

/// Random starts for an added effect that has a place or a time, beside the middle of its prior.
const EXTRA_STARTS: u64 = 3;
/// Fits of a law on the object, each trusting it as far as the one before says.
const ROUNDS: usize = 2;
/// Effects that are tried in combinations: those that do best alone.
const COMBINED: usize = 8;
/// Effects that are tried with every other one, beside the best.
const LEADING: usize = 2;

/// Trials that are settled, whatever becomes of the others.
const SETTLED: usize = 5;
/// Linearisations of one trial at most.
const TURNS: usize = 6;
/// Change of the logarithm of a parameter below which a trial is settled.
const STILL: f64 = 0.03;

pub(crate) struct Hunt<'a> {
    pub foreign: &'a Foreign<'a>,
    pub paths: &'a [Path],
    /// The body without laws.
    pub bare: &'a Model,
    pub seed: u64,
    pub watch: &'a dyn Watch,
}

impl Hunt<'_> {
    /// The simulator alone, linearised about its best values.
    pub fn base(&self, along: &Arc<Along>) -> Result<Trial, InferError> {
        Ok(Trial { settled: true, ..self.fit(along, vec![])? })
    }

    /// The simulator alone, as it was fitted, and with each effect, best first; linearised about `along` first.
    pub fn singles(&self, base: Trial, along: &Arc<Along>) -> Result<Vec<Trial>, InferError> {
        let offered = self.offered(along);
        let mut tried = vec![base];
        for (k, effect) in offered.iter().enumerate() {
            self.watch.progress("single effects", k as f64 / offered.len() as f64);
            tried.push(self.fit(along, vec![effect.clone()])?);
        }
        self.settle(&mut tried)?;
        Ok(tried)
    }

    /// One more effect on top of the best, where the data ask for more.
    pub fn combine(&self, mut tried: Vec<Trial>) -> Result<Vec<Trial>, InferError> {
        if !remainder(&tried[0])?.matters(tried[0].along.observations()) {
            return Ok(tried);
        }
        let singles: Vec<Trial> =
            tried.iter().filter(|t| t.added.len() == 1).take(COMBINED).cloned().collect();
        for (k, from) in singles.iter().take(LEADING).enumerate() {
            self.watch.progress("pairs", k as f64 / LEADING as f64);
            for other in singles.iter().filter(|t| t.names() != from.names()) {
                let added = vec![from.added[0].clone(), other.added[0].clone()];
                if tried.iter().all(|t| keys(&t.added) != keys(&added)) {
                    // Each from where it was found alone.
                    tried.push(self.from(&from.along, added, [Some(from), Some(other)], 0)?);
                }
            }
        }
        self.settle(&mut tried)?;
        Ok(tried)
    }

    /// Sort, best first, with the best linearised about where they are.
    fn settle(&self, tried: &mut [Trial]) -> Result<(), InferError> {
        sort(tried);
        let mut turn = 0;
        loop {
            let Some(k) =
                tried.iter().take(if turn < SETTLED { SETTLED } else { 1 }).position(|t| !t.settled)
            else {
                return Ok(());
            };
            self.watch.progress("once more", 0.1 * turn as f64);
            tried[k] = self.settled(&tried[k])?;
            sort(tried);
            turn += 1;
        }
    }

    fn settled(&self, trial: &Trial) -> Result<Trial, InferError> {
        let mut trial = trial.clone();
        for _ in 0..TURNS {
            let along = &trial.along;
            let values = along.trusted(&trial.fit);
            let still = |(a, b): (&f64, &f64)| (a - b).abs() < STILL * b.abs().max(1e-9);
            if values.iter().zip(&along.values).all(still) {
                break;
            }
            let along =
                Along::new(self.foreign, &values, self.paths, along.channels, self.bare.dof, self.watch)?;
            trial = self.from(&Arc::new(along), trial.added.clone(), [Some(&trial), None], 0)?;
        }
        Ok(Trial { settled: true, ..trial })
    }

    fn offered(&self, along: &Along) -> Vec<Effect> {
        let episodes =
            along.paths.iter().filter_map(|p| Some(p.intervals.first()?.pieces.first()?.clock.episode));
        let episodes: Vec<f64> = episodes.collect();
        let one = |kind: Kind| match kind.spec().params.iter().find(|p| p.choice) {
            Some(event) => episodes.iter().map(|&e| Effect::free(kind).with(event.name, Some(e))).collect(),
            None => vec![Effect::free(kind)],
        };
        let wheel = (!self.bare.on_rail()).then_some(Kind::ViscousWheel);
        candidates(self.bare, false, false).into_iter().chain(wheel).flat_map(one).filter(usable).collect()
    }

    fn fit(&self, along: &Arc<Along>, added: Vec<Effect>) -> Result<Trial, InferError> {
        let sought = added.last().is_some_and(is_placed);
        self.from(along, added, [None, None], if sought { EXTRA_STARTS } else { 0 })
    }

    /// Fit some laws together with the simulator's parameters, from a simpler fit; the last law from that of another
    /// fit, or else from random values.
    fn from(
        &self,
        along: &Arc<Along>,
        added: Vec<Effect>,
        [from, last]: [Option<&Trial>; 2],
        extra: u64,
    ) -> Result<Trial, InferError> {
        use rand::SeedableRng;
        let model = Model { effects: added.clone(), ..self.bare.clone() };
        let coordinates = Coordinates::new(&model);
        let own = along.values.clone();
        let start = |z: Vec<f64>| {
            let mut fill = coordinates.values(&z).0;
            // The last law's values are the last.
            let known = last.into_iter().flat_map(|trial| trial.fit.values.iter().skip(1).rev());
            for (place, value) in fill.iter_mut().rev().zip(known) {
                *place = *value;
            }
            let laws = from.map_or_else(|| fill.clone(), |from| carried(&from.fit, &model, &fill));
            laws.into_iter().chain(own.iter().copied()).collect::<Vec<f64>>()
        };
        let mut warm = vec![start(vec![0.0; coordinates.free().len()])];
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed);
        for _ in 0..extra {
            warm.push(start(coordinates.draw(&mut rng)));
        }
        let options = FitOptions { starts: 0, seed: self.seed, from_afar: false, ..FitOptions::default() };
        let mut found = fit(&**along, &model, &warm, &options, self.watch)?;
        if added.iter().all(|e| e.kind.spec().acting == Acting::Instrument) {
            let costs = along.costs(&found.model.plant(&found.values)?, &along.own(&found));
            return Ok(Trial { added, fit: found, costs, along: along.clone(), settled: false });
        }
        let mut doubting = along.doubting(&found.model.plant(&found.values)?);
        for _ in 0..ROUNDS {
            let at: Vec<f64> = found.values.iter().copied().chain(along.own(&found)).collect();
            found = fit(&doubting, &model, &[at], &options, self.watch)?;
            doubting = along.doubting(&found.model.plant(&found.values)?);
        }
        let costs = doubting.costs(&found.model.plant(&found.values)?, &doubting.own(&found));
        Ok(Trial { added, fit: found, costs, along: along.clone(), settled: false })
    }
}

/// What tells sets of effects apart: the kinds, and the episode of one that is an event.
fn keys(effects: &[Effect]) -> Vec<(Kind, u64)> {
    let key = |effect: &Effect| {
        let event = effect.kind.spec().params.iter().position(|p| p.choice);
        (effect.kind, event.and_then(|k| effect.values[k]).unwrap_or(0.0).to_bits())
    };
    let mut keys: Vec<_> = effects.iter().map(key).collect();
    keys.sort();
    keys
}

/// Name of an effect in a diagnosis. A wheel beside those of a simulator that may have some is one more.
pub(crate) fn called(effect: &Effect) -> &'static str {
    if effect.kind == Kind::ViscousWheel { Kind::SpinDrag.spec().effect } else { name(effect) }
}

/// Laws with states of their own are not tried: along the seen motion they would need a start in every episode. Nor is
/// an event of a wheel that only the simulator knows, nor what looks at readings before and after the moment.
fn usable(effect: &Effect) -> bool {
    let remembers = matches!(effect.kind, Kind::SensorLag | Kind::SensorPlay);
    effect.kind.spec().inner.is_empty() && effect.kind != Kind::WheelEvent && !remembers
}

/// Whether an effect's place or moment has to be sought: from the middle of its prior the way may be barred.
fn is_placed(effect: &Effect) -> bool {
    let named = |name: &str| matches!(name, "x" | "y" | "time") || name.ends_with("_x") && name != "accel_x";
    effect.kind.spec().params.iter().any(|p| matches!(p.prior, Prior::OnBody(_)) || named(p.name))
}

fn sort(tried: &mut [Trial]) {
    tried.sort_by(|a, b| b.log_weight().total_cmp(&a.log_weight()));
}

/// Probability of each trial among those tried.
pub(crate) fn probabilities(tried: &[Trial]) -> Vec<f64> {
    let best = tried.iter().map(Trial::log_weight).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = tried.iter().map(|t| (t.log_weight() - best).exp()).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

/// The trial that lacks just one of another's effects.
pub(crate) fn without<'a>(tried: &'a [Trial], full: &Trial, dropped: usize) -> Option<&'a Trial> {
    let mut rest = full.added.clone();
    rest.remove(dropped);
    tried.iter().find(|t| keys(&t.added) == keys(&rest))
}

/// What a wandering wrench would gain over a trial.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Remainder {
    pub gain: f64,
    pub channels: Channels,
}

/// Sizes of the walk that are tried, N/√s.
const SIZES: [f64; 10] = [1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

impl Remainder {
    /// Whether something is missing.
    pub fn matters(&self, observations: usize) -> bool {
        matters(self.gain, observations)
    }
}

pub(crate) fn remainder(trial: &Trial) -> Result<Remainder, InferError> {
    let model = &trial.fit.model;
    let along = &trial.along.doubting(&model.plant(&trial.fit.values)?);
    let values: Vec<f64> = trial.fit.values.iter().copied().chain(along.own(&trial.fit)).collect();
    let wandering =
        |size: f64| Channels { wander: [size, size, size * model.body.gyration], ..along.channels };
    let still = along.cost(model, &values)?;
    let mut best = Remainder { gain: 0.0, channels: wandering(SIZES[0]) };
    for size in SIZES {
        let channels = wandering(size);
        let gain = still - along.with_channels(channels).cost(model, &values)?;
        if gain > best.gain {
            best = Remainder { gain, channels };
        } else if gain < best.gain - 50.0 {
            break;
        }
    }
    Ok(best)
}

/// Blocks into which an episode is cut.
const BLOCKS: usize = 5;

/// Probability, from paired differences of blocks, that a fuller trial predicts better than a simpler one.
pub(crate) fn holds_up(fuller: &Trial, simpler: &Trial) -> f64 {
    let blocks = |trial: &Trial| -> Vec<f64> {
        let cut = |episode: &Vec<f64>| {
            let size = episode.len().div_ceil(BLOCKS).max(1);
            episode.chunks(size).map(|c| c.iter().sum()).collect::<Vec<f64>>()
        };
        trial.costs.iter().flat_map(cut).collect()
    };
    let differences: Vec<f64> = blocks(simpler).iter().zip(&blocks(fuller)).map(|(a, b)| a - b).collect();
    let n = differences.len() as f64;
    if differences.len() < 3 {
        return 0.5;
    }
    let bought = 0.5 * (fuller.fit.estimates.len().saturating_sub(simpler.fit.estimates.len())) as f64;
    let mean = (differences.iter().sum::<f64>() - bought) / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let t = mean / (variance / n).sqrt().max(1e-12);
    StudentsT::new(0.0, 1.0, n - 1.0).map_or(0.5, |d| d.cdf(t))
}
