//! Fits and predictions in Python.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use trundle_infer::{Estimate, Fit, FitOptions, Optimiser, Stage, score};
use trundle_model::{Model, ModelError, Posterior, PriorFile, Slot};
use trundle_record::{Dataset, prepare};

use crate::error::{refused, run};
use crate::identify::identifiability;
use crate::lack_of_fit::Tested;
use crate::likelihood::{Arguments, Choice, of_one_object};
use crate::model::PyModel;
use crate::plain::plain;
use crate::record::recording_of;
use crate::watch::watched;

/// Starts are searched from in rounds, as many as it takes until some agree.
const STAGES: [Stage; 1] = [Stage { name: "fit", end: 1.0, rounds: 3.0 }];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_fit, module)?)?;
    module.add_function(wrap_pyfunction!(_predict, module)?)
}

/// The recording prepared, and the model text read.
pub(crate) fn inputs(
    recording: &Bound<'_, PyAny>,
    model: Option<&str>,
) -> PyResult<(Dataset, Option<Model>)> {
    let source = recording_of(recording)?;
    let data = run(recording.py(), || prepare(&source))?;
    let model = model.map(Model::from_toml).transpose().map_err(refused)?.map(|(model, _)| model);
    Ok((data, model))
}

/// Fit a model's free values to the training episodes; see `trundle.fit`.
#[pyfunction]
#[pyo3(signature = (
    recordings, model=None, *, choice, per_episode=vec![], prior=None, start=None, starts=6, seed=0,
    optimiser="lm", progress=None
))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
fn _fit(
    py: Python<'_>,
    recordings: Vec<Bound<'_, PyAny>>,
    model: Option<&str>,
    choice: Arguments,
    per_episode: Vec<String>,
    prior: Option<(String, String)>,
    start: Option<BTreeMap<String, f64>>,
    starts: usize,
    seed: u64,
    optimiser: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, PyModel)> {
    let prior = prior.map(|(name, text)| PriorFile::from_toml(&text, &name)).transpose().map_err(refused)?;
    let recordings = recordings.iter().map(|r| inputs(r, None).map(|(data, _)| data));
    let recordings = of_one_object(recordings.collect::<PyResult<_>>()?)?;
    let data = together(&recordings);
    let model = model.map(Model::from_toml).transpose().map_err(refused)?.map(|(model, _)| model);
    let mut model = trundle_diagnose::for_recording(&data, model.as_ref());
    let optimiser = optimiser_named(optimiser)?;
    let mut options = FitOptions { starts, seed, optimiser, ..FitOptions::default() };
    if let Some(prior) = prior {
        model = prior.apply(&model).map_err(refused)?;
        options.per_episode = prior.per_episode();
    }
    options.per_episode.extend(per_episode);
    let choice = Choice::new(choice, &recordings, &model)?;
    let engines = choice.engines(&recordings, &model)?;
    let given = start.map(|start| stated(&model, &start)).transpose()?;
    let quasi_static = choice.quasi_static(&recordings);
    let fitted = watched(py, progress, &STAGES, |watch| {
        let found = choice.fit(&recordings, &engines, &model, given.as_slice(), &options, watch)?;
        let testable = choice.name == "filter" && options.per_episode.is_empty();
        let mut tested =
            if testable { Tested::new(&recordings, &model, found)? } else { Tested::untested(found) };
        let nothing_holds = exclude(&mut tested.fit);
        let found = &tested.fit;
        let judge = |episodes| {
            score(&found.model, &found.values, &found.channels, episodes, &data.noise, quasi_static)
        };
        let scores = (judge(&data.training)?, judge(&data.held_out)?);
        let mut summary = summary(&data, &tested, quasi_static, &scores);
        summary["excluded_by_prior"] = found.prior_conflicts.iter().map(ToString::to_string).collect();
        if !nothing_holds {
            summary["identifiability"] = identifiability(found);
        }
        summary["likelihood"] = choice.name.as_str().into();
        summary["loss"] = choice.loss().into();
        Ok((summary, found.model.clone(), of_model(found)))
    });
    choice.raised()?;
    let (summary, model, posterior) = fitted?;
    Ok((plain(py, &summary)?.unbind(), PyModel { model, posterior }))
}

/// All episodes as of one recording, with the noise of the first.
fn together(recordings: &[Dataset]) -> Dataset {
    let mut all = recordings[0].clone();
    for other in &recordings[1..] {
        all.name = format!("{} + {}", all.name, other.name);
        all.training.extend_from_slice(&other.training);
        all.held_out.extend_from_slice(&other.held_out);
    }
    all
}

/// The posterior of the model's parameters, without the noise of the likelihood.
fn of_model(fit: &Fit) -> Option<Posterior> {
    let posterior = fit.posterior()?;
    let kept: Vec<usize> =
        (0..posterior.names.len()).filter(|&k| !posterior.names[k].starts_with("noise.")).collect();
    let row = |i: &usize| kept.iter().map(|&j| posterior.covariance[*i][j]).collect();
    (!kept.is_empty()).then(|| Posterior {
        names: kept.iter().map(|&k| posterior.names[k].clone()).collect(),
        mean: kept.iter().map(|&k| posterior.mean[k]).collect(),
        covariance: kept.iter().map(row).collect(),
    })
}

fn optimiser_named(name: &str) -> PyResult<Optimiser> {
    match name {
        "lm" => Ok(Optimiser::LevenbergMarquardt),
        "lbfgs" => Ok(Optimiser::Lbfgs),
        other => Err(refused(format!("optimiser: '{other}' is neither 'lm' nor 'lbfgs'"))),
    }
}

/// Values of all slots from a start that states every free one.
fn stated(model: &Model, start: &BTreeMap<String, f64>) -> PyResult<Vec<f64>> {
    let slots = model.slots();
    let free =
        || slots.iter().filter(|s| s.value.is_none()).map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    let known = |name: &String| slots.iter().any(|s| s.value.is_none() && s.name == *name);
    if let Some(name) = start.keys().find(|name| !known(name)) {
        return Err(refused(format!("start: `{name}` is not a free parameter; free are {}", free())));
    }
    let one = |slot: &Slot| match slot.value.or_else(|| start.get(&slot.name).copied()) {
        Some(value) if (slot.lower..=slot.upper).contains(&value) => Ok(value),
        Some(value) => Err(refused(ModelError::OutOfBounds {
            name: format!("start: {}", slot.name),
            value,
            lower: slot.lower,
            upper: slot.upper,
            unit: slot.unit,
        })),
        None => {
            Err(refused(format!("start: `{}` is missing; give a value to each of {}", slot.name, free())))
        }
    };
    slots.iter().map(one).collect()
}

/// Whether a prior that the caller set excludes the data. Then no estimate counts as identified: the others make
/// up for the one that is held back.
fn exclude(fit: &mut Fit) -> bool {
    let base = |name: &str| name.split('[').next().unwrap_or(name).to_owned();
    let all = fit.prior_conflicts.iter().any(|strain| fit.model.priors.contains_key(&base(&strain.name)));
    for estimate in &mut fit.estimates {
        estimate.identified &= !all;
    }
    all
}

fn summary(
    data: &Dataset,
    tested: &Tested,
    quasi_static: bool,
    scores: &(trundle_infer::Score, trundle_infer::Score),
) -> serde_json::Value {
    let fit = &tested.fit;
    let parameter = |(k, e): (usize, &Estimate)| {
        let kept = |value: f64| e.identified.then_some(value);
        let [low, high] = fit.interval(k, tested.basis).map(kept);
        serde_json::json!({
            "name": e.name, "mean": kept(e.mean), "sd": kept(e.sd), "low": low, "high": high, "unit": e.unit,
            "identifiable": e.identified,
        })
    };
    let parameters: Vec<_> = fit.estimates.iter().enumerate().map(parameter).collect();
    let (lack_of_fit, intervals) = tested.summary();
    serde_json::json!({
        "recording": data.name,
        "parameters": parameters,
        "log_evidence": fit.log_evidence,
        "converged": fit.converged,
        "quasi_static": quasi_static,
        "lack_of_fit": lack_of_fit,
        "intervals": intervals,
        "noise": {
            "pose": fit.channels.pose, "force": fit.channels.reading[0], "torque": fit.channels.reading[2],
            "stated": data.noise.stated,
        },
        "training": scores.0,
        "held_out": if data.held_out.is_empty() { None } else { Some(&scores.1) },
    })
}

/// Simulate every episode in open loop and write the table `out` (Parquet); see `trundle.predict`.
#[pyfunction]
fn _predict(recording: &Bound<'_, PyAny>, model: &str, out: PathBuf) -> PyResult<()> {
    let (data, model) = inputs(recording, Some(model))?;
    let model = trundle_diagnose::for_recording(&data, model.as_ref());
    let table = run(recording.py(), || trundle_diagnose::predict(data.episodes(), &model))?;
    run(recording.py(), || table.write(&out))
}
