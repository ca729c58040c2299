//! The whole of a diagnosis of a foreign simulation, in order.

use super::hunt::{Hunt, Remainder, Trial, called, probabilities, remainder, without};
use super::nominal::settle;
use super::path::Path;
use super::rollout::Rollout;
use super::simulator::Foreign;
use super::told::{alternatives, choose, judge, line_of_action, ties, windows};
use crate::answer::{
    Answer, Channels, Figures, Mismatch, Missing, Nominal, Pair, Parameter, Remaining, Verdict,
};
use crate::place::Named;
use crate::predictions::Predictions;
use crate::run::Outcome;
use crate::series::{self, Series};
use crate::thresholds::given_margin;
use crate::words::statement;
use std::collections::BTreeMap;
use std::sync::Arc;
use trundle_infer::{Channels as Noises, Estimate, InferError, Residual, Score, Watch, quasi_static};
use trundle_model::{Model, Posterior};
use trundle_record::{Dataset, Prepared};

/// Share of the motion that a simulation with the right laws leaves in open loop at most, where some of the wrench is
/// still missing.
const ASTRAY: f64 = 0.03;
/// Diagnose a recording that a foreign simulator is to reproduce.
///
/// # Errors
/// When there is not enough data, the simulator fails, or the user interrupts.
pub fn diagnose(
    data: &Dataset,
    foreign: &Foreign<'_>,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    if quasi_static(data) {
        return Err(InferError::NoData {
            recording: data.name.clone(),
            reason: "the pushes are so slow that their force says nothing of the motion to come".to_owned(),
            remedy: "a simulator is driven by force: push faster, or diagnose a model instead of `step`"
                .to_owned(),
        });
    }
    let case = Case { data, foreign, watch };
    let paths =
        data.training.iter().map(|e| Path::new(e, &data.noise)).collect::<Result<Vec<_>, InferError>>()?;
    let plain = Noises::of(&data.noise);
    let settled =
        |start: &[f64], channels, bare: &Model| settle(foreign, &paths, start, channels, bare, seed, watch);
    let alone = settled(&foreign.start, plain, &case.body(None))?;
    let bare = &case.body(alone.felt_mass());
    let hunt = |bare| Hunt { foreign, paths: &paths, bare, seed, watch };
    let alone = Arc::new(alone);
    let base = hunt(bare).base(&alone)?;
    let before = remainder(&base)?;
    // Where something is missing, its parameters have bent to make up for it; laws are tried about where they are
    // when the missing wrench may be anything.
    let mut along = alone.clone();
    if before.matters(alone.observations()) {
        let unbent = settled(&alone.values, before.channels, bare)?;
        along = Arc::new(unbent.with_channels(plain).sketched());
    }
    let bare = &case.body(along.felt_mass());
    let tried = hunt(bare).singles(base, &along)?;
    let tried = hunt(bare).combine(tried)?;
    case.answer(before, &tried)
}

struct Case<'a> {
    data: &'a Dataset,
    foreign: &'a Foreign<'a>,
    watch: &'a dyn Watch,
}

impl Case<'_> {
    /// The body as the laws know it.
    fn body(&self, felt: Option<f64>) -> Model {
        let mass = self.data.mass_given.or(felt).unwrap_or(self.data.body.mass);
        let mut model = Model::nominal(self.data.body.clone(), Some(mass), self.data.dof);
        model.body.mass = mass;
        model.effects.clear();
        model
    }

    /// The answer; the simulator alone is judged as it was linearised at its own best values.
    fn answer(&self, before: Remainder, tried: &[Trial]) -> Result<Outcome, InferError> {
        let base = tried.iter().find(|t| t.added.is_empty()).unwrap_or(&tried[0]);
        let (mut best, mut chances) = choose(tried);
        let mut left = remainder(best)?;
        let mut verdict = judge(base.along.observations(), before, best, left);
        if verdict == Verdict::Explained && left.matters(base.along.observations()) && self.is_poor(best)? {
            verdict = Verdict::Unexplained;
        }
        if verdict == Verdict::Unexplained {
            (best, chances, left) = (base, vec![], before);
        }
        if verdict == Verdict::Consistent && self.given_costs(base)? {
            verdict = Verdict::Reparameterised;
        }
        let probabilities = probabilities(tried);
        let residuals = self.residuals(base, before)?;
        let after_residuals = self.residuals(best, left)?;
        let shown = verdict != Verdict::Consistent;
        let mismatch = Mismatch {
            windows: if shown { windows(&residuals, &base.along) } else { vec![] },
            channels: self.channels(base)?,
            body_point: line_of_action(&residuals, &base.fit.model).filter(|_| shown),
            ..Mismatch::default()
        };
        let figures = self.figures(base, best)?;
        let mut missing = Vec::new();
        for (k, chance) in chances.iter().enumerate() {
            let named: f64 = tried
                .iter()
                .zip(&probabilities)
                .filter(|(t, _)| t.names().contains(&best.names()[k]))
                .map(|(_, p)| p)
                .sum();
            missing.push(self.named(tried, best, k, chance.min(named))?);
        }
        missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
        let answer = Answer {
            format: "trundle-diagnosis/1",
            recording: self.data.name.clone(),
            verdict,
            missing,
            tied: ties(tried, best),
            tied_sets: vec![],
            immaterial: vec![],
            mismatch,
            residual: Remaining::default(),
            warnings: vec![],
            wrench_pose: self.data.wrench_pose,
            alternatives: alternatives(tried, &probabilities, best),
            certificates: vec![],
            experiments: vec![],
            nominal: Nominal {
                given: self.given(),
                before: self.parameters(base),
                after: self.parameters(best),
            },
            fit: figures,
        };
        let series = self.series(tried, [base, best], [&residuals, &after_residuals])?;
        Ok(Outcome {
            model: best.fit.model.to_toml(self.posterior(best).as_ref())?,
            predictions: self.predictions(base, best)?,
            answer,
            series,
        })
    }

    /// Whether what is simulated with the laws found, to which something is missing, goes astray: the best of bad
    /// explanations can win by a wide margin.
    fn is_poor(&self, best: &Trial) -> Result<bool, InferError> {
        Ok(self.score(best, &self.data.training)?.r2.is_none_or(|r2| 1.0 - r2 > ASTRAY))
    }

    /// Whether the values that the simulation is used with cost more than chance.
    fn given_costs(&self, base: &Trial) -> Result<bool, InferError> {
        if !self.foreign.given {
            return Ok(false);
        }
        let given = base.along.exactly(self.foreign, &self.foreign.start, self.watch)?;
        Ok(given - base.fit.cost > given_margin(base.fit.estimates.len()))
    }

    fn residuals(&self, trial: &Trial, remainder: Remainder) -> Result<Vec<Vec<Residual>>, InferError> {
        let plant = trial.fit.model.plant(&trial.fit.values)?;
        let along = trial.along.doubting(&plant);
        Ok(along.residuals(&plant, &trial.along.own(&trial.fit), remainder.channels))
    }

    /// Shares of the whitened innovations.
    fn channels(&self, trial: &Trial) -> Result<Channels, InferError> {
        let plant = trial.fit.model.plant(&trial.fit.values)?;
        let mut sum = [0.0; 3];
        for (k, innovation) in
            trial.along.innovations(&plant, &trial.along.own(&trial.fit)).iter().enumerate()
        {
            sum[k % 3] += innovation * innovation;
        }
        let total: f64 = sum.iter().sum();
        let [x, y, theta] = sum.map(|s| if total > 0.0 { s / total } else { 0.0 });
        Ok(Channels { x, y, theta })
    }

    fn rollout<'s>(&'s self, trial: &Trial, values: &'s [f64]) -> Result<Rollout<'s>, InferError> {
        let plant = trial.fit.model.plant(&trial.fit.values)?;
        Ok(Rollout { foreign: self.foreign, values, plant, watch: self.watch })
    }

    fn score(&self, trial: &Trial, episodes: &[Prepared]) -> Result<Score, InferError> {
        let values = trial.along.own(&trial.fit);
        let gyration = trial.fit.model.body.gyration;
        self.rollout(trial, &values)?.score(episodes, &self.data.noise, self.data.dof, gyration)
    }

    fn figures(&self, base: &Trial, best: &Trial) -> Result<Figures, InferError> {
        let pair = |episodes: &[Prepared]| -> Result<Pair, InferError> {
            let before = self.score(base, episodes)?;
            let after = if best.added.is_empty() { before.clone() } else { self.score(best, episodes)? };
            Ok(Pair { before, after })
        };
        self.watch.progress("figures", 0.0);
        let held_out = &self.data.held_out;
        let held_out = if held_out.is_empty() { None } else { Some(pair(held_out)?) };
        Ok(Figures { held_out, training: pair(&self.data.training)? })
    }

    fn named(
        &self,
        tried: &[Trial],
        best: &Trial,
        k: usize,
        probability: f64,
    ) -> Result<Missing, InferError> {
        let own = &best.fit.model.effect_names()[k];
        let episodes = if self.data.held_out.is_empty() { &self.data.training } else { &self.data.held_out };
        let misfit = |trial: &Trial| -> Result<Option<f64>, InferError> {
            Ok(self.score(trial, episodes)?.r2.map(|r2| 1.0 - r2))
        };
        let with = misfit(best)?;
        let dropped = without(tried, best, k).map_or(Ok(None), misfit)?;
        let effect = &best.added[k];
        let told = Named { fit: &best.fit, kind: effect.kind, name: own };
        Ok(Missing {
            effect: called(effect).to_owned(),
            probability,
            statement: statement(effect, own, &best.fit),
            parameters: told.parameters(),
            place: told.place(self.data),
            explains: with.zip(dropped).filter(|(_, d)| *d > 0.0).map(|(w, d)| 1.0 - w / d),
        })
    }

    fn given(&self) -> BTreeMap<String, f64> {
        let pairs = self.foreign.parameters.iter().zip(&self.foreign.start);
        let told = pairs.filter(|(p, _)| self.foreign.given || p.value.is_some());
        told.map(|(p, v)| (p.name.clone(), *v)).collect()
    }

    /// The simulator's own parameters in a fit.
    fn parameters(&self, trial: &Trial) -> BTreeMap<String, Parameter> {
        let own = |e: &&Estimate| self.foreign.parameters.iter().any(|p| p.name == e.name);
        let one = |e: &Estimate| {
            let kept = |value: f64| e.identified.then_some(value);
            let parameter =
                Parameter { mean: kept(e.mean), sd: kept(e.sd), unit: e.unit, identifiable: e.identified };
            (e.name.clone(), parameter)
        };
        trial.fit.estimates.iter().filter(own).map(one).collect()
    }

    /// The posterior of the laws' parameters: the simulator's are not the model's.
    fn posterior(&self, trial: &Trial) -> Option<Posterior> {
        let all = trial.fit.posterior()?;
        let kept: Vec<usize> = (0..all.names.len())
            .filter(|&k| self.foreign.parameters.iter().all(|p| p.name != all.names[k]))
            .collect();
        (!kept.is_empty()).then(|| Posterior {
            names: kept.iter().map(|&k| all.names[k].clone()).collect(),
            mean: kept.iter().map(|&k| all.mean[k]).collect(),
            covariance: kept.iter().map(|&i| kept.iter().map(|&j| all.covariance[i][j]).collect()).collect(),
        })
    }

    fn predictions(&self, base: &Trial, best: &Trial) -> Result<Predictions, InferError> {
        let poses = |trial: &Trial| -> Result<Vec<[f64; 3]>, InferError> {
            let values = trial.along.own(&trial.fit);
            let rollout = self.rollout(trial, &values)?;
            let all = self.data.held_out.iter().map(|e| rollout.open_loop(e));
            Ok(all.collect::<Result<Vec<_>, InferError>>()?.concat())
        };
        let groups = vec![("before", poses(base)?), ("after", poses(best)?)];
        Ok(Predictions::simulated(self.data.held_out.iter(), groups))
    }

    fn series(
        &self,
        tried: &[Trial],
        [base, best]: [&Trial; 2],
        [before, after]: [&[Vec<Residual>]; 2],
    ) -> Result<Series, InferError> {
        let (data, along) = (self.data, &base.along);
        let (own_before, own_after) = (base.along.own(&base.fit), best.along.own(&best.fit));
        let rolls = [self.rollout(base, &own_before)?, self.rollout(best, &own_after)?];
        let mut episodes = Vec::new();
        for (episode, held_out) in
            data.held_out.iter().map(|e| (e, true)).chain(data.training.iter().map(|e| (e, false)))
        {
            let at = along.paths.iter().position(|p| p.name == episode.name);
            let missing = at.and_then(|k| Some((before.get(k)?, after.get(k)?)));
            episodes.push(series::Episode {
                name: episode.name.clone(),
                held_out,
                contact: episode.contact,
                t: episode.pose.iter().map(|p| p.t).collect(),
                observed: episode.pose.iter().map(|p| p.pose).collect(),
                before: Some(rolls[0].open_loop(episode)?),
                after: Some(rolls[1].open_loop(episode)?),
                residual: missing.map_or_else(series::Residual::default, |(b, a)| curves(b, a)),
                wrench: None,
            });
        }
        let count = along.observations() as f64;
        let weights = probabilities(tried);
        Ok(Series {
            footprint: series::outline(&best.fit.model),
            support: data.body.feet.clone().unwrap_or_default(),
            dof: ["x", "y", "theta"].into_iter().zip(data.dof).filter(|(_, m)| *m).map(|(n, _)| n).collect(),
            quasi_static: false,
            unnamed: vec![],
            noise: series::Noise {
                pose: along.channels.pose,
                force: along.channels.reading[0],
                torque: along.channels.reading[2],
                stated: data.noise.stated,
            },
            episodes,
            candidates: tried
                .iter()
                .zip(&weights)
                .map(|(t, &probability)| series::Candidate {
                    effects: t.names().into_iter().map(str::to_owned).collect(),
                    log_evidence: t.fit.log_evidence,
                    log_score: Some(-t.fit.cost / count),
                    probability,
                })
                .collect(),
        })
    }
}

fn curves(before: &[Residual], after: &[Residual]) -> series::Residual {
    series::Residual {
        t: before.iter().map(|r| r.t).collect(),
        before: Some(before.iter().map(|r| r.wrench).collect()),
        after: Some(after.iter().map(|r| r.wrench).collect()),
        sd: Some(before.iter().map(|r| [0, 1, 2].map(|k| r.covariance[(k, k)].max(0.0).sqrt())).collect()),
    }
}
