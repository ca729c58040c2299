//! The likelihood that a caller chooses, over one or several recordings.

use pyo3::prelude::*;
use trundle_infer::{
    Comparison, Cut, Fit, FitOptions, InertialLikelihood, InferError, Joint, Likelihood, Loss, Shooting,
    Watch, fit as search, guided_fit, is_quasi_static,
};
use trundle_model::{Model, Stepper};
use trundle_posterior::{SearchExtent, search_modes};
use trundle_record::Dataset;
use trundle_sim::ObstacleStepper;

use crate::error::refused;
use crate::simulator::Simulator;

/// What is compared, and how.
pub(crate) struct Choice {
    /// "filter", "steps", "final", "windows" or "wrench".
    pub name: String,
    window: f64,
    loss: Loss,
    /// Whether known obstacles are taken into account.
    obstacles: bool,
    /// The caller's own simulator.
    simulator: Option<Simulator>,
}

/// Arguments of `trundle.fit` that choose a likelihood; see there.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Arguments {
    likelihood: Option<String>,
    window: f64,
    loss: String,
    obstacles: Option<bool>,
    step: Option<Py<PyAny>>,
}

const NAMES: [&str; 5] = ["filter", "steps", "final", "windows", "wrench"];

/// Intervals of eq. 8 are about this long, s: at a tracker's full rate they would hold little but its noise.
const INTERVAL: f64 = 0.1;

impl Choice {
    /// Check the arguments; without a name the filter, or windows where an obstacle or a simulator asks for them.
    pub fn new(arguments: Arguments, recordings: &[Dataset], model: &Model) -> PyResult<Self> {
        let Arguments { likelihood, window, loss, obstacles, step } = arguments;
        let touching = recordings.iter().any(|data| can_touch(data, model));
        let rolls = touching && obstacles != Some(false) || step.is_some();
        let name = likelihood.unwrap_or_else(|| if rolls { "windows" } else { "filter" }.to_owned());
        let choice = Self {
            window,
            loss: loss_of(&loss)?,
            obstacles: touching && obstacles != Some(false) && step.is_none(),
            simulator: step.map(Simulator::new),
            name,
        };
        choice.check(rolls)?;
        Ok(choice)
    }

    fn check(&self, rolls: bool) -> PyResult<()> {
        let name = &self.name;
        if !NAMES.contains(&name.as_str()) {
            return Err(refused(format!("likelihood = {name:?}: choose one of {}", NAMES.join(", "))));
        }
        if rolls && matches!(name.as_str(), "filter" | "wrench") {
            return Err(refused(format!(
                "likelihood = {name:?} knows of no obstacle and of no simulator but the laws: choose \"windows\", \
                 \"steps\" or \"final\", or obstacles = false"
            )));
        }
        if name == "filter" && self.loss != Loss::Gaussian {
            return Err(refused(
                "loss = \"student\": the filter's residuals are normal; choose another likelihood, \"windows\" say",
            ));
        }
        Ok(())
    }

    /// As the summary names it.
    pub fn loss(&self) -> &'static str {
        if self.loss == Loss::Gaussian { "gaussian" } else { "student" }
    }

    /// Raise what the caller's simulator raised, if it did.
    pub fn raised(&self) -> PyResult<()> {
        self.simulator.as_ref().map_or(Ok(()), Simulator::raised)
    }

    /// Whether the summary's figures are those of slow pushes, judged by the wrench.
    pub fn quasi_static(&self, recordings: &[Dataset]) -> bool {
        matches!(self.name.as_str(), "filter" | "wrench") && recordings.iter().all(is_quasi_static)
    }

    /// Who simulates each recording, where the laws alone do not.
    pub fn engines(&self, recordings: &[Dataset], model: &Model) -> PyResult<Vec<Option<ObstacleStepper>>> {
        let engine = |data: &Dataset| {
            let wanted = self.obstacles && can_touch(data, model);
            wanted.then(|| ObstacleStepper::new(model, data.obstacles.clone())).transpose().map_err(refused)
        };
        recordings.iter().map(engine).collect()
    }

    /// The likelihood of all recordings.
    pub fn likelihood<'a>(
        &'a self,
        recordings: &'a [Dataset],
        engines: &'a [Option<ObstacleStepper>],
    ) -> Result<Box<dyn Likelihood + 'a>, InferError> {
        self.over(recordings, engines, &self.name)
    }

    fn over<'a>(
        &'a self,
        recordings: &'a [Dataset],
        engines: &'a [Option<ObstacleStepper>],
        name: &str,
    ) -> Result<Box<dyn Likelihood + 'a>, InferError> {
        let slow = self.quasi_static(recordings);
        let pairs = recordings.iter().zip(engines);
        let parts = pairs
            .map(|(data, engine)| self.one(data, engine.as_ref(), name, slow).map_err(|e| named(data, e)));
        let mut parts = parts.collect::<Result<Vec<_>, InferError>>()?;
        if parts.len() == 1 { Ok(parts.remove(0)) } else { Ok(Box::new(Joint::new(parts)?)) }
    }

    fn one<'a>(
        &'a self,
        data: &'a Dataset,
        engine: Option<&'a ObstacleStepper>,
        name: &str,
        slow: bool,
    ) -> Result<Box<dyn Likelihood + 'a>, InferError> {
        let how = match name {
            "filter" => return Ok(Box::new(Comparison::of(data)?)),
            "wrench" if slow => return Ok(Box::new(Comparison::of(data)?)),
            "wrench" => {
                let inertial = InertialLikelihood::new(&data.training, &data.noise, data.dof)?;
                return Ok(Box::new(inertial.with_loss(self.loss)));
            }
            "steps" => Cut::Steps { stride: stride(data) },
            "final" => Cut::Final,
            _ => Cut::Windows { length: self.window },
        };
        let shooting = Shooting::new(&data.training, &data.noise, data.dof, how)?.with_loss(self.loss);
        Ok(match (&self.simulator, engine) {
            (Some(simulator), _) => Box::new(shooting.simulated_by(simulator)),
            (None, Some(engine)) => Box::new(shooting.simulated_by(engine as &dyn Stepper)),
            (None, None) => Box::new(shooting),
        })
    }

    /// Fit; final states from where windows lead.
    pub fn fit(
        &self,
        recordings: &[Dataset],
        engines: &[Option<ObstacleStepper>],
        model: &Model,
        start: &[Vec<f64>],
        options: &FitOptions,
        watch: &dyn Watch,
    ) -> Result<Fit, InferError> {
        let likelihood = self.likelihood(recordings, engines)?;
        if self.name == "final" && start.is_empty() {
            // Episodes too short for windows have their ends all the same.
            if let Ok(guide) = self.over(recordings, engines, "windows") {
                return guided_fit(&*guide, &*likelihood, model, options, watch);
            }
        }
        if self.name == "filter" {
            // The same search as that of `trundle.sample`.
            let found = search_modes(&*likelihood, model, start, options, SearchExtent::Best, watch)?;
            return Ok(found.best);
        }
        search(&*likelihood, model, start, options, watch)
    }
}

fn loss_of(name: &str) -> PyResult<Loss> {
    match name {
        "gaussian" => Ok(Loss::Gaussian),
        "student" => Ok(Loss::STUDENT),
        _ => Err(refused(format!("loss = {name:?}: choose \"gaussian\" or \"student\""))),
    }
}

/// Pose samples in an interval of eq. 8.
fn stride(data: &Dataset) -> usize {
    let mut steps: Vec<f64> =
        data.training.iter().flat_map(|e| e.pose.windows(2)).map(|pair| pair[1].t - pair[0].t).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).map_or(1, |step| (INTERVAL / step).round().max(1.0) as usize)
}

/// Whether an object came near enough to a known obstacle to touch it.
fn can_touch(data: &Dataset, model: &Model) -> bool {
    let poses = data.training.iter().flat_map(|e| &e.pose).map(|p| p.pose);
    trundle_sim::can_touch(&model.body, &data.obstacles, poses)
}

fn named(data: &Dataset, error: InferError) -> InferError {
    match error {
        InferError::NoData { recording, reason, remedy } if !recording.starts_with(&data.name) => {
            InferError::NoData { recording: format!("{}: {recording}", data.name), reason, remedy }
        }
        other => other,
    }
}

/// Several recordings of one object: whether they agree on it, and names of episodes that tell them apart.
pub(crate) fn of_one_object(mut recordings: Vec<Dataset>) -> PyResult<Vec<Dataset>> {
    let Some((first, others)) = recordings.split_first() else {
        return Err(refused("no recording is given: name at least one"));
    };
    for other in others {
        agree(first, other)?;
    }
    let weighed = recordings.iter().find_map(|data| data.mass_given.map(|_| data.clone()));
    if recordings.len() > 1 {
        for (index, data) in recordings.iter_mut().enumerate() {
            if let Some(weighed) = &weighed {
                (data.mass_given, data.body.mass) = (weighed.mass_given, weighed.body.mass);
            }
            let prefix = format!("{}#{}", data.name, index + 1);
            for episode in data.training.iter_mut().chain(&mut data.held_out) {
                episode.name = format!("{prefix}/{}", episode.name);
            }
        }
    }
    Ok(recordings)
}

fn agree(a: &Dataset, b: &Dataset) -> PyResult<()> {
    let differ = |what: &str, of_a: String, of_b: String| {
        Err(refused(format!(
            "{:?} and {:?} are not recordings of one object: {what} is {of_a} in the one and {of_b} in the other; \
             correct recording.toml, or fit them apart",
            a.name, b.name
        )))
    };
    if a.body.fixtures != b.body.fixtures {
        let shape = |data: &Dataset| format!("{:?}", data.body.fixtures);
        return differ("the footprint", shape(a), shape(b));
    }
    if a.dof != b.dof {
        return differ("dof", format!("{:?}", a.dof), format!("{:?}", b.dof));
    }
    if a.body.feet != b.body.feet {
        return differ("the support", format!("{:?}", a.body.feet), format!("{:?}", b.body.feet));
    }
    match (a.mass_given, b.mass_given) {
        (Some(x), Some(y)) if x != y => differ("the mass", format!("{x} kg"), format!("{y} kg")),
        _ => Ok(()),
    }
}
