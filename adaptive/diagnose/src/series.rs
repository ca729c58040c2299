//! Curves for the report.

use crate::missing_wrenches::{MissingWrenches, Wrench};
use serde::Serialize;
use trundle_infer::{Fit, InferError};
use trundle_model::{Fixture, Model};
use trundle_record::{Dataset, Prepared};

use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::locate::Residuals;

/// All curves and tables that the report draws.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// Polygons of the shape, object frame, m.
    pub footprint: Vec<Vec<[f64; 2]>>,
    /// Support points, object frame, m.
    pub support: Vec<[f64; 2]>,
    /// Directions in which the object moves.
    pub dof: Vec<&'static str>,
    /// Whether wrenches are compared because inertia is negligible.
    pub quasi_static: bool,
    /// Inputs of the model discrepancy, as phrases, if the model "after" contains one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unnamed: Vec<&'static str>,
    /// The stated or estimated noise.
    pub noise: Noise,
    /// Curves of each episode.
    pub episodes: Vec<Episode>,
    /// The fitted models, best first.
    pub candidates: Vec<Candidate>,
}

/// Noise, one standard deviation.
#[derive(Clone, Debug, Serialize)]
pub struct Noise {
    /// m, m, rad.
    pub pose: [f64; 3],
    /// N.
    pub force: f64,
    /// N·m.
    pub torque: f64,
    /// Whether the recording states it.
    pub stated: bool,
}

/// Curves of one episode.
#[derive(Clone, Debug, Serialize)]
pub struct Episode {
    /// Name of the episode.
    pub name: String,
    /// Whether it is held out.
    pub held_out: bool,
    /// Time of first contact, s.
    pub contact: f64,
    /// Times of the poses, s.
    pub t: Vec<f64>,
    /// Recorded poses.
    pub observed: Vec<[f64; 3]>,
    /// Open-loop simulation of the refitted nominal model.
    pub before: Option<Vec<[f64; 3]>>,
    /// Open-loop simulation with the named effects or a model discrepancy.
    pub after: Option<Vec<[f64; 3]>>,
    /// The missing wrench.
    pub residual: Residual,
    /// Wrenches, if they are compared.
    pub wrench: Option<Wrench>,
}

/// The missing wrench on the object, object axes, N, N, N·m.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Residual {
    /// Times, s.
    pub t: Vec<f64>,
    /// Missing wrench of the nominal model.
    pub before: Option<Vec<[f64; 3]>>,
    /// Missing wrench of the model with the named effects.
    pub after: Option<Vec<[f64; 3]>>,
    /// Standard deviation of `before`.
    pub sd: Option<Vec<[f64; 3]>>,
    /// Standard deviation of `after`.
    pub sd_after: Option<Vec<[f64; 3]>>,
}

/// A fitted model.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Effects added to the nominal model.
    pub effects: Vec<String>,
    /// Log evidence by Laplace's approximation.
    pub log_evidence: f64,
    /// Mean log density of a training sample.
    pub log_score: Option<f64>,
    /// Probability among the fitted models.
    pub probability: f64,
    /// Reason for not naming it, if it was tested.
    pub reason: Option<&'static str>,
}

/// Outline of a body as polygons; a disc has 48 corners.
pub(crate) fn outline(model: &Model) -> Vec<Vec<[f64; 2]>> {
    const CORNERS: usize = 48;
    let one = |fixture: &Fixture| match fixture {
        Fixture::Polygon { vertices, .. } => vertices.clone(),
        Fixture::Disc { center, radius, .. } => (0..CORNERS)
            .map(|k| {
                let (sin, cos) = (k as f64 * std::f64::consts::TAU / CORNERS as f64).sin_cos();
                [center[0] + radius * cos, center[1] + radius * sin]
            })
            .collect(),
    };
    model.body.fixtures.iter().map(one).collect()
}

/// Curves of every episode.
pub(crate) fn episodes(
    engine: &dyn Engine,
    [before, after]: [&FittedModel; 2],
    [missing_before, missing_after]: [&MissingWrenches; 2],
) -> Result<Vec<Episode>, InferError> {
    let part = |episodes: &[Prepared], held_out: bool, b: &Option<Residuals>, a: &Option<Residuals>| {
        let one = |(k, episode): (usize, &Prepared)| -> Result<Episode, InferError> {
            Ok(Episode {
                name: episode.name.clone(),
                held_out,
                contact: episode.contact,
                t: episode.pose.iter().map(|p| p.t).collect(),
                observed: episode.pose.iter().map(|p| p.pose).collect(),
                before: engine.open_loop(before, episode)?,
                after: engine.open_loop(after, episode)?,
                residual: residual(b.as_ref().and_then(|r| r.get(k)), a.as_ref().and_then(|r| r.get(k))),
                wrench: engine.wrenches(episode, [before, after])?,
            })
        };
        episodes.iter().enumerate().map(one).collect::<Result<Vec<_>, InferError>>()
    };
    let data = engine.data();
    let mut all = part(&data.held_out, true, &missing_before.held_out, &missing_after.held_out)?;
    all.extend(part(&data.training, false, &missing_before.training, &missing_after.training)?);
    Ok(all)
}

/// The wrenches that two models need in an episode.
pub(crate) fn wrenches(
    data: &Dataset,
    episode: &Prepared,
    [before, after]: [&Fit; 2],
) -> Result<Option<Wrench>, InferError> {
    let samples = trundle_infer::wrench_samples(episode, &data.noise);
    let (plant_before, plant_after) =
        (before.model.plant(&before.values)?, after.model.plant(&after.values)?);
    Ok((!samples.is_empty()).then(|| Wrench {
        t: samples.iter().map(|s| s.t).collect(),
        recorded: samples.iter().map(|s| s.recorded(&plant_after)).collect(),
        before: samples.iter().map(|s| s.needed(&plant_before)).collect(),
        after: samples.iter().map(|s| s.needed(&plant_after)).collect(),
    }))
}

fn residual(
    before: Option<&Vec<trundle_infer::Residual>>,
    after: Option<&Vec<trundle_infer::Residual>>,
) -> Residual {
    let Some(before) = before else { return Residual::default() };
    let deviations = |course: &Vec<trundle_infer::Residual>| {
        course.iter().map(|r| [0, 1, 2].map(|k| r.covariance[(k, k)].max(0.0).sqrt())).collect()
    };
    Residual {
        t: before.iter().map(|r| r.t).collect(),
        before: Some(before.iter().map(|r| r.wrench).collect()),
        after: after.map(|a| a.iter().map(|r| r.wrench).collect()),
        sd: Some(deviations(before)),
        sd_after: after.map(deviations),
    }
}
