//! A simulator that nothing is known of, with a recording.

use super::likelihood::Along;
use super::nominal::settle;
use super::path::Path;
use super::rollout::Rollout;
use super::simulator::Foreign;
use crate::engine::Tried;
use crate::enough::enough;
use std::sync::Arc;
use trundle_infer::{Channels as Noise, InferError, Quiet, Residual, Watch, is_quasi_static};
use trundle_model::{Acting, Kind, Model, Plant};
use trundle_record::Dataset;

/// What the simulator was replaced by for a fit.
#[derive(Clone)]
pub(crate) struct Basis {
    pub(super) along: Arc<Along>,
    /// Values of the simulator's parameters in the fit.
    pub(super) own: Vec<f64>,
    /// Whether those are biased by what is missing, so that effects are not tried around them.
    pub(super) biased: bool,
}

/// A simulator that nothing is known of, with a recording.
#[derive(Clone)]
pub(crate) struct BlackBox<'a> {
    pub(super) data: &'a Dataset,
    pub(super) foreign: &'a Foreign<'a>,
    pub(super) paths: Arc<[Path]>,
    /// The simulator, linearised where effects are tried.
    pub(super) along: Arc<Along>,
    /// The body that laws know, without laws.
    pub(super) bare: Model,
    pub(super) seed: u64,
    /// Asked in every step of a simulation on the calling thread whether to go on.
    pub(super) watch: &'a dyn Watch,
}

impl<'a> BlackBox<'a> {
    /// The simulator with its parameters refitted.
    ///
    /// # Errors
    /// When there is not enough data, or the simulator fails.
    pub fn new(
        data: &'a Dataset,
        foreign: &'a Foreign<'a>,
        seed: u64,
        watch: &'a dyn Watch,
    ) -> Result<Self, InferError> {
        enough(data)?;
        if is_quasi_static(data) {
            return Err(InferError::NoData {
                recording: data.name.clone(),
                reason: "the pushes are so slow that their force says nothing of the motion to come"
                    .to_owned(),
                remedy: "a simulator is driven by force: push faster, or diagnose a model instead of `step`"
                    .to_owned(),
            });
        }
        let paths: Vec<Path> =
            data.training.iter().map(|e| Path::new(e, &data.noise)).collect::<Result<_, InferError>>()?;
        let body = body(data, None);
        let noise = Noise::of(&data.noise);
        let along = settle(foreign, &paths, &foreign.start, noise, &body, seed, watch)?;
        let bare = self::body(data, along.felt_mass());
        Ok(Self { data, foreign, paths: paths.into(), along: Arc::new(along), bare, seed, watch })
    }

    /// The linearised simulator of a model.
    pub(super) fn along<'t>(&'t self, tried: &'t Tried) -> &'t Arc<Along> {
        tried.basis.as_ref().map_or(&self.along, |basis| &basis.along)
    }

    /// The same, trusting the model's laws as far as the seen motion tells what they do.
    pub(super) fn doubting(&self, tried: &Tried) -> Result<Along, InferError> {
        let along = self.along(tried);
        if !on_object(&tried.fit.model) {
            return Ok((**along).clone());
        }
        Ok(along.doubting(&plant(tried)?, &along.own(&tried.fit)))
    }

    pub(super) fn own(&self, tried: &Tried) -> Vec<f64> {
        self.along(tried).own(&tried.fit)
    }

    pub(super) fn rollout<'s>(&'s self, tried: &Tried, values: &'s [f64]) -> Result<Rollout<'s>, InferError> {
        let plant = plant(tried)?;
        // A watch is asked on the calling thread only; work on other threads asks between its parts.
        let watch = if rayon::current_thread_index().is_some() { &Quiet } else { self.watch };
        Ok(Rollout { foreign: self.foreign, values, plant, data: self.data, watch })
    }

    pub(super) fn residuals(&self, tried: &Tried, channels: Noise) -> Result<Vec<Vec<Residual>>, InferError> {
        let plant = plant(tried)?;
        Ok(self.doubting(tried)?.residuals(&plant, &self.own(tried), channels))
    }
}

/// The laws of a model.
pub(super) fn plant(tried: &Tried) -> Result<Plant<f64>, InferError> {
    Ok(tried.fit.model.plant(&tried.fit.values)?)
}

/// The body as laws know it.
pub(super) fn body(data: &Dataset, felt: Option<f64>) -> Model {
    let mass = data.mass_given.or(felt).unwrap_or(data.body.mass);
    let mut model = Model::nominal(data.body.clone(), Some(mass), data.dof);
    model.body.mass = mass;
    model.effects.clear();
    model
}

/// Whether a model has laws that act on the object.
pub(super) fn on_object(model: &Model) -> bool {
    model.effects.iter().any(|e| e.kind.spec().acting != Acting::Instrument)
}

/// An event of a wheel that only the simulator knows is not tried.
pub(super) fn usable(kind: &Kind) -> bool {
    !kind.changes_wheels()
}
