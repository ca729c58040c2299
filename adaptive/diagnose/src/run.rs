//! The whole of a diagnosis, in order.

use crate::adequacy::Remainder;
use crate::answer::{Answer, Figures, Mismatch, Nominal, Pair, Place, Remaining, Verdict};
use crate::engine::{Engine, Own, Tried};
use crate::enough::enough;
use crate::locate::Located;
use crate::naming::{effect_probability, named};
use crate::outlook::Outlook;
use crate::periods;
use crate::platt::calibrated;
use crate::predictions::Predictions;
use crate::rivals::doubts;
use crate::search::{Found, Searcher, probabilities};
use crate::series::{self, Series};
use crate::thresholds::given_margin;
use crate::units;
use crate::unnamed::depends_on;
use crate::verdict::{Choice, Judge, Named, judge, likeness};
use crate::warnings::warnings;
use std::collections::{BTreeMap, BTreeSet};
use trundle_infer::{Fit, InferError, Watch, unscored_time};
use trundle_model::{Model, Scales};
use trundle_record::{Dataset, PrepareOptions, Prepared, Recording, prepare_with};

/// Probability from which on an immaterial effect is mentioned: more likely than not.
const LIKELY: f64 = 0.5;

/// How a diagnosis is made.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seed of every random start.
    pub seed: u64,
    /// The simulation under test; the paper's when not given.
    pub model: Option<Model>,
    /// Names of effects that are not to be tried.
    pub without: Vec<String>,
}

/// All that a diagnosis leaves.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `diagnosis.json`.
    pub answer: Answer,
    /// `model.toml`.
    pub model: String,
    /// `predictions.parquet`.
    pub predictions: Predictions,
    /// What the report draws.
    pub series: Series,
}

/// Diagnose a prepared recording, whose lengths, forces and times are those of furniture.
///
/// # Errors
/// When there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    enough(data)?;
    diagnose_with(&Own::new(data, options.model.as_ref())?, options, watch)
}

/// Diagnose a recording that anything simulates.
///
/// # Errors
/// As [`diagnose`], and where the simulation fails.
pub(crate) fn diagnose_with(
    engine: &dyn Engine,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let decided = decide(engine, options, watch)?;
    explain(engine, decided, watch)
}

/// Diagnose a recording of any size: it is sought and decided in the recording's own units ([`units`]), and explained in SI
/// units. `data` is the recording prepared with `prepare`.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_recording(
    recording: &Recording,
    data: &Dataset,
    prepare: PrepareOptions,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let scales = units::of(data);
    let unscalable = options.model.as_ref().is_some_and(|model| model.unnamed.is_some());
    if scales == Scales::SI || unscalable {
        return diagnose(data, options, watch);
    }
    let prepare = PrepareOptions { gravity: prepare.gravity / scales.acceleration(), ..prepare };
    let reduced =
        prepare_with(&recording.in_units(&scales), prepare).map_err(|error| InferError::NoData {
            recording: data.name.clone(),
            reason: error.to_string(),
            remedy: "check the recording with `trundle check`".to_owned(),
        })?;
    let model = options.model.as_ref().map(|model| units::reduced(model, &scales)).transpose()?;
    enough(&reduced)?;
    let decided = decide(&Own::new(&reduced, model.as_ref())?, options, watch)?;
    let engine = Own::new(data, options.model.as_ref())?;
    explain(&engine, decided.restored(&engine, &scales)?, watch)
}

/// What was decided, before it is explained. Models are indices into what was tried.
struct Decision {
    found: Found,
    base: usize,
    best: usize,
    chances: Vec<f64>,
    rejected: usize,
    immaterial: Vec<(usize, usize, f64)>,
    /// Why models that were tried are not named.
    reasons: BTreeMap<usize, &'static str>,
    /// What the best model leaves.
    left: Option<Remainder>,
    given: Option<Tried>,
    verdict: Verdict,
}

/// Fit, search and decide.
fn decide(engine: &dyn Engine, options: &Options, watch: &dyn Watch) -> Result<Decision, InferError> {
    let searcher = Searcher { engine, without: &options.without, regions: &[], seed: options.seed, watch };
    let mut found = searcher.run()?;
    watch.progress("left-out episodes", 0.0);
    let base = found.tried.iter().position(|t| t.added.is_empty()).unwrap_or(0);
    let slow = engine.is_quasi_static();
    let ahead = |index: usize| if slow { Ok(None) } else { engine.outlook(&found.tried[index]).map(Some) };
    let is_material = |outlook: Option<Outlook>| outlook.is_none_or(|ahead| ahead.is_material());
    let Choice { mut best, mut chances, rejected, immaterial, mut reasons } =
        Judge { engine, found: &found, base, watch }.choose()?;
    let mut left = engine.remainder(&found.tried[best])?;
    let errors = ahead(best)?;
    let gained = found.tried[base].fit.cost - found.tried[best].fit.cost;
    let named = (best != base).then_some(Named { gained, left });
    let mut verdict = judge(engine.observations(), found.before, named, is_material(errors));
    if verdict == Verdict::Explained && errors.is_some_and(|errors| errors.is_poor()) {
        verdict = Verdict::Unexplained;
    }
    if verdict == Verdict::Unexplained {
        reasons.entry(best).or_insert("it leaves more than noise explains");
        (best, chances, left) = (base, vec![], found.before);
    }
    let given = engine.given(watch)?;
    let fitted = &found.tried[base].fit;
    if let (Verdict::Consistent, Some(given)) = (verdict, &given)
        && given.fit.cost - fitted.cost > given_margin(fitted.estimates.len())
    {
        verdict = Verdict::Reparameterised;
    }
    for index in BTreeSet::from([base, best]) {
        let richer: Vec<&Fit> = immaterial.iter().map(|(other, ..)| &found.tried[*other].fit).collect();
        let widened = engine.widened(&found.tried[index])?;
        found.tried[index] = Tried { fit: widened.fit.widened_by(&richer), ..widened };
    }
    Ok(Decision { base, best, chances, rejected, immaterial, reasons, left, given, verdict, found })
}

impl Decision {
    /// The same in SI units, for the recording as it was prepared in them.
    fn restored(self, engine: &Own<'_>, scales: &Scales) -> Result<Self, InferError> {
        let nominal = engine.nominal();
        let base = &self.found.tried[self.base];
        let offset = engine.cost(&units::restored(base, nominal, scales, 0.0)?)? - base.fit.cost;
        let restored = |tried: &Tried| units::restored(tried, nominal, scales, offset);
        let tried = self.found.tried.iter().map(restored).collect::<Result<Vec<_>, _>>()?;
        let before = self.found.before.map(|left| units::remainder(left, scales));
        let located = engine.located(&tried[self.base], before)?;
        let given = match &self.given {
            Some(given) => engine.restored(given, scales, offset)?,
            None => None,
        };
        let left = self.left.map(|left| units::remainder(left, scales));
        Ok(Self { found: Found { tried, before, located }, left, given, ..self })
    }
}

/// Put what was decided into numbers and words.
fn explain(engine: &dyn Engine, decided: Decision, watch: &dyn Watch) -> Result<Outcome, InferError> {
    watch.progress("figures", 0.0);
    let Decision { found, base, best, chances, rejected, immaterial, reasons, left, given, verdict } =
        decided;
    let (data, nominal) = (engine.data(), engine.nominal());
    let (base, best) = (&found.tried[base], &found.tried[best]);
    let (all, probabilities) = (probabilities(&found.tried, 0), probabilities(&found.tried, rejected));
    let before = match (&given, verdict) {
        (Some(given), Verdict::Reparameterised) => given,
        _ => base,
    };
    let mut filled = None;
    if verdict == Verdict::Unexplained {
        watch.progress("an unnamed force", 0.0);
        filled = engine.unnamed(base, found.before, watch)?;
    }
    let after = filled.as_ref().unwrap_or(best);

    let missing_before = engine.missing(before, found.before)?;
    let missing_after = engine.missing(after, left)?;
    let again =
        (verdict == Verdict::Reparameterised).then(|| engine.located(before, found.before)).transpose()?;
    let mut mismatch = again.as_ref().unwrap_or(&found.located).mismatch(engine.channels(before)?);
    if verdict == Verdict::Consistent {
        mismatch = Mismatch { channels: mismatch.channels, ..Mismatch::default() };
    }
    // What a wrench without a name predicts is not explained: there the simulation under test leaves what remains.
    let (leaver, missing_named) =
        if filled.is_some() { (before, &missing_before) } else { (after, &missing_after) };
    let shown = verdict != Verdict::Consistent;
    let remains = if shown { engine.located(leaver, left)? } else { Located::default() };
    let courses = missing_named.training.clone().unwrap_or_default();
    let figures = figures(engine, before, after)?;
    let like = likeness(left, engine.observations());
    let mut missing = Vec::new();
    for (k, chance) in chances.iter().enumerate() {
        let chance = chance.min(effect_probability(&found.tried, &probabilities, best.names()[k])) * like;
        missing.push(named(engine, &found, best, k, calibrated(chance))?);
    }
    let immaterial = immaterial
        .iter()
        .map(|&(index, k, chance)| (&found.tried[index], k, chance))
        .filter(|(tried, k, _)| !best.names().contains(&tried.names()[*k]))
        .map(|(tried, k, chance)| {
            named(
                engine,
                &found,
                tried,
                k,
                calibrated(chance.min(effect_probability(&found.tried, &all, tried.names()[k]))),
            )
        })
        .filter(|effect| effect.as_ref().map_or(true, |effect| effect.probability >= LIKELY))
        .collect::<Result<Vec<_>, InferError>>()?;
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    let place = |key: &str| missing.iter().find_map(|m| m.place.as_ref()?.get(key).cloned());
    if let Some(Place::Point(point)) = place("body_point") {
        mismatch.body_point = Some(point.mean);
    }
    if let Some(Place::Region(corners)) = place("world_region") {
        mismatch.world_region = Some(corners);
    }

    // Where nothing known explains it, a push between things known would tell nothing.
    let designing = matches!(verdict, Verdict::Consistent | Verdict::Explained);
    let doubts = doubts(engine, (&found, &probabilities), best, designing, watch)?;
    let answer = Answer {
        format: "trundle-diagnosis/1",
        recording: data.name.clone(),
        verdict,
        missing,
        tied: doubts.tied,
        tied_sets: doubts.tied_sets,
        immaterial,
        mismatch,
        residual: Remaining {
            windows: remains.windows,
            regime: remains.regime,
            periods: if shown {
                periods::for_answer([&courses, &engine.unsmoothed(after)?], data.dof == [true, false, false])
            } else {
                vec![]
            },
            ..remaining(engine, leaver, [found.before, left], missing_named)?
        },
        warnings: warnings(engine, before, after, verdict == Verdict::Explained)?,
        wrench_pose: data.wrench_pose,
        alternatives: doubts.alternatives,
        certificates: doubts.certificates,
        experiments: doubts.experiments,
        nominal: Nominal {
            given: engine.given_values(given.as_ref()),
            before: engine.parameters(before),
            after: engine.parameters(after),
        },
        fit: figures,
    };
    let quasi = engine.is_quasi_static();
    let series = Series {
        footprint: series::outline(nominal),
        support: nominal.body.feet.clone().unwrap_or_default(),
        dof: ["x", "y", "theta"]
            .into_iter()
            .zip(data.dof)
            .filter(|(_, moves)| *moves)
            .map(|(n, _)| n)
            .collect(),
        quasi_static: quasi,
        unnamed: filled.as_ref().map_or(vec![], |filled| depends_on(&filled.fit)),
        noise: series::Noise {
            pose: if quasi { data.noise.pose } else { after.fit.channels.pose },
            force: after.fit.channels.reading[0],
            torque: after.fit.channels.reading[2],
            stated: data.noise.stated,
        },
        episodes: series::episodes(engine, [before, after], [&missing_before, &missing_after])?,
        candidates: tried(engine.observations(), &found, &probabilities, &reasons),
    };
    Ok(Outcome {
        model: engine.file(after)?,
        predictions: predictions(engine, before, after)?,
        answer,
        series,
    })
}

/// What a model still misses: of the motion the smoothed missing wrench, of wrenches the needed less the recorded.
fn remaining(
    engine: &dyn Engine,
    tried: &Tried,
    [before, after]: [Option<Remainder>; 2],
    missing: &series::Missing,
) -> Result<Remaining, InferError> {
    let along = || missing.training.iter().flatten().flatten().map(|residual| residual.wrench).collect();
    let wrenches: Vec<[f64; 3]> = engine.residual_wrenches(tried)?.unwrap_or_else(along);
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| {
        let sum: f64 = wrenches.iter().map(of).sum();
        (!wrenches.is_empty()).then(|| (sum / wrenches.len() as f64).sqrt())
    };
    let dof = engine.data().dof;
    let share = before.zip(after).filter(|(before, _)| before.misfit() > 0.0);
    Ok(Remaining {
        force_rms: mean(&|w| w[0] * w[0] + if dof[1] { w[1] * w[1] } else { 0.0 }),
        torque_rms: mean(&|w| w[2] * w[2]).filter(|_| dof[2]),
        share: share.map(|(before, after)| (after.misfit() / before.misfit()).min(1.0)),
        ..Remaining::default()
    })
}

fn figures(engine: &dyn Engine, before: &Tried, after: &Tried) -> Result<Figures, InferError> {
    let pair = |episodes: &[Prepared]| {
        Ok::<_, InferError>(Pair {
            before: engine.score(before, after, episodes)?,
            after: engine.score(after, before, episodes)?,
        })
    };
    let data = engine.data();
    let held_out = if data.held_out.is_empty() { None } else { Some(pair(&data.held_out)?) };
    Ok(Figures { held_out, training: pair(&data.training)? })
}

fn tried(
    observations: usize,
    found: &Found,
    probabilities: &[f64],
    reasons: &BTreeMap<usize, &'static str>,
) -> Vec<series::Candidate> {
    let one = |(index, (t, &probability)): (usize, (&Tried, &f64))| series::Candidate {
        effects: t.names().into_iter().map(str::to_owned).collect(),
        log_evidence: t.fit.log_evidence,
        log_score: Some(-t.fit.cost / observations as f64),
        probability,
        reason: reasons.get(&index).copied(),
    };
    found.tried.iter().zip(probabilities).enumerate().map(one).collect()
}

fn predictions(engine: &dyn Engine, before: &Tried, after: &Tried) -> Result<Predictions, InferError> {
    let settling = unscored_time(&before.fit.model).max(unscored_time(&after.fit.model));
    let held_out = &engine.data().held_out;
    let poses = |tried: &Tried| -> Result<Vec<[f64; 3]>, InferError> {
        let mut all = vec![];
        for episode in held_out {
            let simulated = engine.open_loop(tried, episode)?;
            all.extend(simulated.unwrap_or_else(|| vec![[f64::NAN; 3]; episode.pose.len()]));
        }
        Ok(all)
    };
    let groups = vec![("before", poses(before)?), ("after", poses(after)?)];
    Ok(Predictions::simulated(held_out.iter(), groups, settling))
}
