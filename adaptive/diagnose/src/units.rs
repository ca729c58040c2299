//! A recording's own units, in which the search and the decision are made.
//!
//! Priors and thresholds are those of furniture that is pushed. A recording with lengths, forces or times of
//! another magnitude is rescaled by whole powers of [`SCALE_BASE`], which is exact in binary arithmetic. A
//! recording in other units, or of another size, is therefore judged like the same recording in metres.

use trundle_infer::{Channels, Estimate, Fit, InferError, PriorConflict};
use trundle_model::{Body, Effect, Fixture, Model, Scales};
use trundle_record::{Dataset, Prepared};

use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;

/// Base of the scale factors, so that a rescaled recording is within a factor of 32 of a table. A power of
/// two makes rescaling exact. Instrument times such as drop-outs are in seconds, so that a finer base would
/// shift them for ordinary recordings.
const SCALE_BASE: f64 = 1024.0;
/// Reference scales: radius of gyration, force, and time to move a radius of gyration, of the office table in
/// `configs/experiments/demo.toml`, rounded.
const TABLE_SCALES: Scales = Scales { length: 0.4, force: 15.0, time: 2.0 };

/// Scales of a recording from its training episodes; SI if it shows no motion or no force.
pub(crate) fn of(data: &Dataset) -> Scales {
    let gyration = data.body.gyration;
    let length = if data.dof[2] && gyration > 0.0 { gyration } else { travel(data) };
    let squares =
        |w: &Prepared| w.wrench.iter().map(|s| s.reading[0].powi(2) + s.reading[1].powi(2)).collect();
    let force = mean(data.training.iter().flat_map(|e| -> Vec<f64> { squares(e) })).sqrt();
    let time = length / speed(data, if data.dof[2] { gyration } else { 0.0 });
    let near = |size: f64, table: f64| {
        let power = ((size / table).ln() / SCALE_BASE.ln()).round();
        if power.is_finite() { SCALE_BASE.powi(power as i32) } else { 1.0 }
    };
    Scales {
        length: near(length, TABLE_SCALES.length),
        force: near(force, TABLE_SCALES.force),
        time: near(time, TABLE_SCALES.time),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

/// Root mean square distance from the middle of an episode, m.
fn travel(data: &Dataset) -> f64 {
    let one = |episode: &Prepared| {
        let middle = mean(episode.pose.iter().map(|p| p.pose[0]));
        episode.pose.iter().map(|p| (p.pose[0] - middle).powi(2)).collect::<Vec<f64>>()
    };
    mean(data.training.iter().flat_map(one)).sqrt()
}

/// Mean speed along the path of an episode, with angles at the radius of gyration, m/s. The path consists of
/// ten segments, so that the tracker's noise does not lengthen it.
fn speed(data: &Dataset, gyration: f64) -> f64 {
    let one = |episode: &Prepared| {
        let size = episode.pose.len().div_ceil(10).max(1);
        let marks: Vec<_> = episode.pose.iter().step_by(size).chain(episode.pose.last()).collect();
        let step = |a: [f64; 3], b: [f64; 3]| {
            ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (gyration * (a[2] - b[2])).powi(2)).sqrt()
        };
        let length: f64 = marks.windows(2).map(|pair| step(pair[0].pose, pair[1].pose)).sum();
        let time = marks.last().zip(marks.first()).map_or(0.0, |(last, first)| last.t - first.t);
        (length, time)
    };
    let all: Vec<(f64, f64)> = data.training.iter().map(one).collect();
    all.iter().map(|(length, _)| length).sum::<f64>() / all.iter().map(|(_, time)| time).sum::<f64>()
}

/// A model in SI units, converted to other units.
pub(crate) fn reduced(model: &Model, scales: &Scales) -> Result<Model, InferError> {
    let mut scaled = model.clone();
    scaled.mass = model.mass.map(|mass| mass / scales.mass());
    scaled.body = body(&model.body, scales)?;
    for effect in &mut scaled.effects {
        *effect = resized(effect, scales, f64::recip);
    }
    for (name, belief) in &mut scaled.priors {
        let unit = model.slots().into_iter().find(|slot| slot.name == *name).map(|slot| slot.unit);
        let size = unit.and_then(|unit| scales.of(unit)).unwrap_or(1.0);
        *belief = belief.rescaled(size.recip());
    }
    Ok(scaled)
}

fn body(body: &Body, scales: &Scales) -> Result<Body, InferError> {
    let mut scaled = body.clone();
    let length = scales.length;
    let point = |p: &mut [f64; 2]| *p = p.map(|v| v / length);
    for fixture in &mut scaled.fixtures {
        match fixture {
            Fixture::Polygon { vertices, .. } => vertices.iter_mut().for_each(point),
            Fixture::Disc { center, radius, .. } => {
                point(center);
                *radius /= length;
            }
        }
    }
    point(&mut scaled.com);
    scaled.support.iter_mut().for_each(|s| point(&mut s.point));
    scaled.feet.iter_mut().flatten().for_each(point);
    scaled.gyration /= length;
    scaled.mass /= scales.mass();
    Ok(scaled)
}

/// An effect's values, multiplied by `factor` of the size of their units.
fn resized(effect: &Effect, scales: &Scales, factor: impl Fn(f64) -> f64) -> Effect {
    let mut resized = effect.clone();
    for (param, value) in effect.kind.spec().params.iter().zip(&mut resized.values) {
        let size = scales.of(param.unit).unwrap_or(1.0);
        *value = value.map(|value| value * factor(size));
    }
    resized
}

/// A fitted model converted to SI units. `nominal` is the nominal model in SI units, and `offset` is the
/// change of the cost with the units.
pub(crate) fn restored(
    fitted: &FittedModel,
    nominal: &Model,
    scales: &Scales,
    offset: f64,
) -> Result<FittedModel, InferError> {
    let added: Vec<Effect> = fitted.added.iter().map(|effect| resized(effect, scales, |size| size)).collect();
    let fit = fit(&fitted.fit, nominal, &added, scales, offset)?;
    Ok(FittedModel { added, fit, ..fitted.clone() })
}

/// A fit of the nominal model with some effects, converted to SI units.
pub(crate) fn fit(
    fit: &Fit,
    nominal: &Model,
    added: &[Effect],
    scales: &Scales,
    offset: f64,
) -> Result<Fit, InferError> {
    let mut model = nominal.clone();
    model.effects.extend(added.iter().cloned());
    let size = |unit: &str| scales.of(unit).unwrap_or(1.0);
    let sizes: Vec<f64> = fit.estimates.iter().map(|e| size(e.unit)).collect();
    let values: Vec<f64> =
        fit.model.slots().iter().zip(&fit.values).map(|(slot, value)| value * size(slot.unit)).collect();
    let estimates = fit.estimates.iter().zip(&sizes);
    let free = model.slots();
    Ok(Fit {
        model: model.with_values(&values)?,
        estimates: estimates
            .map(|(e, size)| Estimate { mean: e.mean * size, sd: e.sd * size, ..e.clone() })
            .collect(),
        prior_conflicts: fit.prior_conflicts.iter().map(|s| strain(s, size(s.unit))).collect(),
        slots: fit
            .slots
            .iter()
            .map(|slot| free.iter().find(|own| own.name == slot.name).unwrap_or(slot).clone())
            .collect(),
        covariance: nalgebra::DMatrix::from_fn(sizes.len(), sizes.len(), |i, j| {
            fit.covariance[(i, j)] * sizes[i] * sizes[j]
        }),
        values,
        cost: fit.cost + offset,
        log_evidence: fit.log_evidence - offset,
        channels: channels(&fit.channels, scales),
        ..fit.clone()
    })
}

fn strain(strain: &PriorConflict, size: f64) -> PriorConflict {
    PriorConflict { value: strain.value * size, range: strain.range.map(|v| v * size), ..strain.clone() }
}

fn channels(channels: &Channels, scales: &Scales) -> Channels {
    let pose = [scales.length, scales.length, 1.0];
    let wrench = [scales.force, scales.force, scales.torque()];
    let root = scales.time.sqrt();
    Channels {
        pose: [0, 1, 2].map(|k| channels.pose[k] * pose[k]),
        reading: [0, 1, 2].map(|k| channels.reading[k] * wrench[k]),
        wander: [0, 1, 2].map(|k| channels.wander[k] * wrench[k] / root),
    }
}

/// A lack of fit converted to SI units.
pub(crate) fn lack_of_fit(lack: LackOfFit, scales: &Scales) -> LackOfFit {
    LackOfFit { channels: channels(&lack.channels, scales), ..lack }
}
