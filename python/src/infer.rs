//! Fits and predictions in Python.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use trundle_infer::{Comparison, Fit, FitOptions, Target, fit as search, score};
use trundle_model::{Model, ModelError, PriorFile, Slot};
use trundle_record::{Dataset, prepare};

use crate::error::{refused, run};
use crate::record::recording_of;
use crate::watch::watched;

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
#[pyo3(signature = (recording, model=None, *, prior=None, start=None, starts=6, seed=0, progress=None))]
fn _fit(
    recording: &Bound<'_, PyAny>,
    model: Option<&str>,
    prior: Option<(String, String)>,
    start: Option<BTreeMap<String, f64>>,
    starts: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let prior = prior.map(|(name, text)| PriorFile::from_toml(&text, &name)).transpose().map_err(refused)?;
    let (data, model) = inputs(recording, model)?;
    let mut model = trundle_diagnose::for_recording(&data, model.as_ref());
    let mut options = FitOptions { starts, seed, ..FitOptions::default() };
    if let Some(prior) = prior {
        model = prior.apply(&model).map_err(refused)?;
        options.per_episode = prior.per_episode();
    }
    let given = start.map(|start| stated(&model, &start)).transpose()?;
    let fitted = watched(recording.py(), progress, |watch| {
        let comparison = Comparison::of(&data)?;
        let mut found = search(&comparison, &model, given.as_slice(), &options, watch)?;
        let excluded = exclude(&Target::new(&comparison, &model, &options.per_episode)?, &mut found);
        let quasi_static = comparison.is_quasi_static();
        let judge = |episodes| {
            score(&found.model, &found.values, &found.channels, episodes, &data.noise, quasi_static)
        };
        let scores = (judge(&data.training)?, judge(&data.held_out)?);
        let mut summary = summary(&data, &found, quasi_static, &scores);
        summary["excluded_by_prior"] = excluded.into();
        Ok((summary, found.model.to_toml(found.posterior().as_ref())?))
    })?;
    Ok((fitted.0.to_string(), fitted.1))
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

/// Sentences on the estimates that their priors exclude; these count as not identified from here on, and with
/// them all others if the prior is one that the caller set: they make up for it.
fn exclude(target: &Target<'_>, fit: &mut Fit) -> Vec<String> {
    let (mut sentences, mut all) = (vec![], false);
    for (k, estimate) in fit.estimates.iter_mut().enumerate() {
        let (z, information) = (fit.point[k], fit.information[(k, k)]);
        if let Some(strain) = target.coordinates().strain(target.parameter(k), z, information) {
            estimate.identified = false;
            all |= target.model().priors.contains_key(&strain.name);
            sentences.push(trundle_infer::Strain { name: estimate.name.clone(), ..strain }.to_string());
        }
    }
    for estimate in &mut fit.estimates {
        estimate.identified &= !all;
    }
    sentences
}

fn summary(
    data: &Dataset,
    fit: &Fit,
    quasi_static: bool,
    scores: &(trundle_infer::Score, trundle_infer::Score),
) -> serde_json::Value {
    let parameters: Vec<_> = fit
        .estimates
        .iter()
        .map(|e| {
            let kept = |value: f64| e.identified.then_some(value);
            serde_json::json!({
                "name": e.name, "mean": kept(e.mean), "sd": kept(e.sd), "unit": e.unit, "identifiable": e.identified,
            })
        })
        .collect();
    serde_json::json!({
        "recording": data.name,
        "parameters": parameters,
        "log_evidence": fit.log_evidence,
        "converged": fit.converged,
        "quasi_static": quasi_static,
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
