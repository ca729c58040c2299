//! Identifiability and profiles in Python.

use pyo3::prelude::*;
use serde_json::{Value, json};
use trundle_infer::{
    Combination, Comparison, Fit, FitOptions, Identifiability, InferError, Profile, Shape, Stage, Target,
    fit as search, profile,
};
use trundle_model::PriorFile;

use crate::error::refused;
use crate::infer::inputs;
use crate::plain::plain;
use crate::watch::watched;

/// The model is fitted, then the parameter is held at one value after the other.
const STAGES: [Stage; 2] =
    [Stage { name: "fit", end: 0.3, rounds: 3.0 }, Stage { name: "profile", end: 1.0, rounds: 1.0 }];

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_profile, module)?)
}

/// The part `identifiability` of a fit's summary.
pub(crate) fn identifiability(fit: &Fit) -> Value {
    let Identifiability { directions, identified: held, combinations, unknown } = fit.identifiability();
    let (agree, starts) = fit.agreement;
    let direction = |d: &trundle_infer::Direction| json!({"information": d.information, "sd": d.sd, "held": d.identified, "parts": parts(&d.parts)});
    json!({
        "held": held,
        "of": directions.len(),
        "directions": directions.iter().map(direction).collect::<Vec<_>>(),
        "combinations": combinations.iter().map(combination).collect::<Vec<_>>(),
        "unknown": unknown,
        "agreement": {"starts": starts, "at_the_optimum": agree},
    })
}

fn parts(parts: &[(String, f64)]) -> Value {
    parts.iter().map(|(name, weight)| json!({"name": name, "weight": weight})).collect()
}

fn combination(combination: &Combination) -> Value {
    let text = combination.to_string();
    match combination {
        Combination::Ratio(p) | Combination::Product(p) => {
            let kind = if matches!(combination, Combination::Ratio(_)) { "ratio" } else { "product" };
            json!({"kind": kind, "names": p.names, "value": p.value, "relative_sd": p.relative_sd, "text": text})
        }
        Combination::Sum { parts: terms, sd } => {
            let names: Vec<&String> = terms.iter().map(|(name, _)| name).collect();
            json!({"kind": "sum", "names": names, "parts": parts(terms), "sd": sd, "text": text})
        }
    }
}

/// Profile one free parameter; see `trundle.profile`.
#[pyfunction]
#[pyo3(signature = (recording, parameter, model=None, *, prior=None, grid=None, starts=6, seed=0, progress=None))]
#[allow(clippy::too_many_arguments)]
fn _profile(
    recording: &Bound<'_, PyAny>,
    parameter: &str,
    model: Option<&str>,
    prior: Option<(String, String)>,
    grid: Option<Vec<f64>>,
    starts: usize,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let prior = prior.map(|(name, text)| PriorFile::from_toml(&text, &name)).transpose().map_err(refused)?;
    let (data, model) = inputs(recording, model)?;
    let mut model = trundle_diagnose::for_recording(&data, model.as_ref());
    let mut options = FitOptions { starts, seed, ..FitOptions::default() };
    if let Some(prior) = prior {
        model = prior.apply(&model).map_err(refused)?;
        options.per_episode = prior.per_episode();
    }
    let found = watched(recording.py(), progress, &STAGES, |watch| {
        let comparison = Comparison::of(&data)?;
        // Before the fit: a wrong name should not cost its time.
        let k = place(&Target::new(&comparison, &model, &options.per_episode)?, parameter)?;
        let found = search(&comparison, &model, &[], &options, watch)?;
        let comparison = comparison.with_channels(found.channels);
        let target = Target::new(&comparison, &model, &options.per_episode)?;
        let seen = profile(&target, &found, k, grid.as_deref(), watch)?;
        Ok(answer(&seen, &found, k))
    })?;
    Ok(plain(recording.py(), &found)?.unbind())
}

/// Which coordinate is named so.
fn place(target: &Target<'_>, name: &str) -> Result<usize, InferError> {
    let n = trundle_infer::Density::dimension(target);
    let names: Vec<String> = (0..n).map(|k| target.slot(k).name).collect();
    names
        .iter()
        .position(|n| n == name)
        .ok_or_else(|| InferError::NotFree { name: name.to_owned(), free: names.join(", ") })
}

fn answer(seen: &Profile, fit: &Fit, k: usize) -> Value {
    let estimate = &fit.estimates[k];
    let kept = |value: f64| estimate.identified.then_some(value);
    json!({
        "name": seen.name,
        "unit": seen.unit,
        "values": seen.values,
        "deviance": seen.deviance,
        "interval": seen.interval,
        "shape": match seen.shape {
            Shape::TwoSided => "two-sided",
            Shape::AtLeast => "at least",
            Shape::AtMost => "at most",
            Shape::Flat => "flat",
        },
        "modes": seen.modes,
        "mean": kept(estimate.mean),
        "sd": kept(estimate.sd),
    })
}
