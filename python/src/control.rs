//! The planner in Python.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray4};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_control::{BatchError, CommandedArm, ControlError, ObstacleMap, Planner, PlanningTask, Settings};
use trundle_model::{Body, Fixture, Plant, State};

use crate::arm::PyArmEstimate;
use crate::baseline::Regression;
use crate::error::{refused, run};
use crate::model::PyModel;
use crate::toml_dict;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyPlanner>()
}

/// Planner of pushes by model predictive path integral control (MPPI).
///
/// Each call starts from the previous plan. The same seed and the same calls give the same plans on any number of
/// threads.
///
/// Parameters
/// ----------
/// lower, upper : sequence of 3 floats
///     Bounds on the wrench at the grasp, object axes, [N, N, N·m].
/// seed : int
///     Seed of the samples.
/// horizon : int
///     Number of actions in a plan, 20 by default.
/// hold : float
///     Duration of each action, 0.1 s by default.
/// samples, iterations : int
///     Number of plans per iteration, 256 by default, and of iterations per call, 6 by default.
/// rollouts : int, optional
///     Maximum number of rollouts per call, each of one plan on one model; unlimited by default. Calls with several models
///     then run fewer iterations with fewer plans.
/// spread, smoothness, temperature : float
///     Properties of the samples: standard deviation in the first iteration as a share of half the range of the
///     bounds (0.6), correlation of successive actions (0.8), and temperature of the weights as a share of the
///     standard deviation of the costs (0.02).
/// curiosity : float
///     Reward for informative plans, s for each metre by which the final states of the models differ (0).
/// cost : dict
///     Weights: `heading` (m per rad, 0.3), `effort` (m for half the range of an action along an axis), `speed_limit`
///     (m/s), `spin_limit` (rad/s), `excess` (m for exceeding a limit by 100 %), `arrival` (s, weight of the final
///     error), `pace` (rad/s, rate at which a remaining rotation can be corrected), `anchor` (s, weight of the error of
///     a point that dry friction holds), `momentum` (m per m/s at that point), `margin` (clearance to obstacles, m) and
///     `collision` (m for touching an obstacle).
///
/// Raises
/// ------
/// TrundleError
///     If bounds are reversed, or a setting is unknown or out of its range.
///
/// Examples
/// --------
/// >>> planner = trundle.Planner([-100, -100, -30], [100, 100, 30], horizon=10, samples=64)
/// >>> planner
/// <trundle.Planner: 10 actions of 0.1 s, 64 plans in each of 6 iterations>
/// >>> model = trundle.Model.read("model.toml")
/// >>> planner.plan(model, pose=[0, 0, 0], twist=[0, 0, 0], goal=[1, 0, 0], grasp=[-0.6, 0]).shape
/// (10, 3)
#[pyclass(name = "Planner", module = "trundle")]
struct PyPlanner {
    planner: Planner,
    /// The obstacle map of the last call, and its inputs.
    map: Option<(MapInputs, Arc<ObstacleMap>)>,
}

/// Inputs of an obstacle map.
#[derive(PartialEq)]
struct MapInputs {
    obstacles: Vec<Vec<[f64; 2]>>,
    goal: [f64; 3],
    fixtures: Vec<Fixture>,
}

#[pymethods]
impl PyPlanner {
    #[new]
    #[pyo3(signature = (lower, upper, *, seed = 0, **settings))]
    fn new(
        lower: Bound<'_, PyAny>,
        upper: Bound<'_, PyAny>,
        seed: u64,
        settings: Option<Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let all = settings.unwrap_or_else(|| PyDict::new(lower.py()));
        all.set_item("lower", lower)?;
        all.set_item("upper", upper)?;
        let settings: Settings = toml_dict::from_dict(&all, "planner")?
            .try_into()
            .map_err(|error: toml::de::Error| refused(format!("planner: {}", error.message())))?;
        Ok(Self { planner: Planner::new(settings, seed).map_err(refused)?, map: None })
    }

    /// Improve the plan for the current state of the object.
    ///
    /// Parameters
    /// ----------
    /// model : Model or sequence of Model
    ///     Models with all values given. The cost of a plan is its mean over several models.
    /// pose, twist : sequence of 3 floats
    ///     Motion of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// goal : sequence of 3 floats
    ///     Target pose, [m, m, rad].
    /// grasp : sequence of 2 floats
    ///     Grasp point, object frame, m.
    /// obstacles : sequence of polygons
    ///     Fixed and simple, corners in order, world, m.
    /// inner : sequence of float
    ///     Inner states of the laws, as `Laws.starts`; their initial values by default.
    /// learnt : regression or callable, optional
    ///     Prediction of the motion. The model then only gives the outline. A callable receives all plans of an iteration,
    ///     shape (n, horizon, 3), and returns one or several motions for each, shape (predictions, n, steps, 6): poses and
    ///     twists, world axes, at the end of each step of at most 50 ms. The cost of a plan is its mean over the
    ///     predictions. With a callable, `arm` has no effect.
    /// arm : estimate, optional
    ///     Response of the arm. `pose` and `twist` are then those at the latest observation, and plans start when the next
    ///     command takes effect. By default the wrench is the command at once.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (horizon, 3)
    ///     Wrenches at the grasp, object axes, [N, N, N·m].
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a number is not finite, or a value of a model is free.
    #[pyo3(signature = (model, pose, twist, goal, grasp, obstacles = vec![], *, inner = vec![], learnt = None, arm = None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn plan<'py>(
        &mut self,
        py: Python<'py>,
        model: Models<'py>,
        pose: [f64; 3],
        twist: [f64; 3],
        goal: [f64; 3],
        grasp: [f64; 2],
        obstacles: Vec<Vec<[f64; 2]>>,
        inner: Vec<f64>,
        learnt: Option<Learnt<'py>>,
        arm: Option<PyRef<'py, PyArmEstimate>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let task =
            PlanningTask { state: model.state(pose, twist, &inner)?, goal, grasp, arm: commanded(arm) };
        let map = self.obstacle_map(py, &model.body()?, obstacles, &task)?;
        let planner = &mut self.planner;
        let flat = |plan: &[[f64; 3]]| plan.iter().flatten().copied().collect::<Vec<f64>>();
        let actions = match learnt {
            Some(Learnt::Regression(learnt)) => {
                let learnt: &Regression = &learnt;
                run(py, || planner.plan(&[learnt], &task, &map).map(flat))?
            }
            Some(Learnt::Simulator(simulate)) => {
                let horizon = planner.settings().horizon;
                let simulate =
                    |plans: &[[f64; 3]]| Python::attach(|py| motions(simulate.bind(py), plans, horizon));
                let work = || Ok::<_, ControlError>(planner.plan_in_batches(&task, &map, simulate).map(flat));
                run(py, work)?.map_err(batch_error)?
            }
            None => {
                let plants = model.plants()?;
                run(py, || planner.plan(&plants, &task, &map).map(flat))?
            }
        };
        PyArray1::from_vec(py, actions).reshape([self.planner.settings().horizon, 3])
    }

    /// Value of knowing which of several models is true, in metre-seconds.
    ///
    /// Parameters
    /// ----------
    /// models : sequence of Model
    ///     Equally probable models.
    /// pose, twist, goal, grasp, obstacles, inner, arm
    ///     As for `plan`.
    ///
    /// Returns
    /// -------
    /// float
    ///     Mean cost of the best common plan minus the mean cost of the best plan for each model.
    #[pyo3(signature = (models, pose, twist, goal, grasp, obstacles = vec![], *, inner = vec![], arm = None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn regret<'py>(
        &mut self,
        py: Python<'py>,
        models: Models<'py>,
        pose: [f64; 3],
        twist: [f64; 3],
        goal: [f64; 3],
        grasp: [f64; 2],
        obstacles: Vec<Vec<[f64; 2]>>,
        inner: Vec<f64>,
        arm: Option<PyRef<'py, PyArmEstimate>>,
    ) -> PyResult<f64> {
        let task =
            PlanningTask { state: models.state(pose, twist, &inner)?, goal, grasp, arm: commanded(arm) };
        let (plants, map) = (models.plants()?, self.obstacle_map(py, &models.body()?, obstacles, &task)?);
        run(py, || self.planner.regret(&plants, &task, &map))
    }

    /// Set the reward for informative plans, s for each metre by which the final states of the models differ.
    fn be_curious(&mut self, curiosity: f64) -> PyResult<()> {
        self.planner.set_curiosity(curiosity).map_err(refused)
    }

    /// Cost of the best plan from each grasp, in metre-seconds, for the choice of a grasp.
    ///
    /// Parameters
    /// ----------
    /// model, pose, twist, goal, obstacles
    ///     As for `plan`, with `inner` and `arm`.
    /// grasps : sequence of pairs of float
    ///     Object frame, m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (len(grasps),)
    ///     Costs; infinite if no plan keeps the motion finite.
    #[pyo3(signature = (model, pose, twist, goal, grasps, obstacles = vec![], *, inner = vec![], arm = None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn compare<'py>(
        &mut self,
        py: Python<'py>,
        model: Models<'py>,
        pose: [f64; 3],
        twist: [f64; 3],
        goal: [f64; 3],
        grasps: Vec<[f64; 2]>,
        obstacles: Vec<Vec<[f64; 2]>>,
        inner: Vec<f64>,
        arm: Option<PyRef<'py, PyArmEstimate>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (state, grasp) = (model.state(pose, twist, &inner)?, [0.0; 2]);
        let task = PlanningTask { state, goal, grasp, arm: commanded(arm) };
        let (plants, map) = (model.plants()?, self.obstacle_map(py, &model.body()?, obstacles, &task)?);
        let costs = run(py, || self.planner.compare(&plants, &task, &map, &grasps))?;
        Ok(PyArray1::from_vec(py, costs))
    }

    /// Advance the plan by some seconds. Its last action continues after its end.
    fn advance(&mut self, seconds: f64) -> PyResult<()> {
        self.planner.advance(seconds).map_err(refused)
    }

    /// Discard the plan and restart the random numbers.
    fn restart(&mut self) {
        self.planner.restart();
        self.map = None;
    }

    fn __repr__(&self) -> String {
        let s = self.planner.settings();
        format!(
            "<trundle.Planner: {} actions of {} s, {} plans in each of {} iterations>",
            s.horizon, s.hold, s.samples, s.iterations
        )
    }

    /// Duration of each action, s.
    #[getter]
    fn hold(&self) -> f64 {
        self.planner.settings().hold
    }
}

impl PyPlanner {
    /// The obstacle map of a task. It is computed again only if goal, obstacles or object change.
    fn obstacle_map(
        &mut self,
        py: Python<'_>,
        body: &Body,
        obstacles: Vec<Vec<[f64; 2]>>,
        task: &PlanningTask,
    ) -> PyResult<Arc<ObstacleMap>> {
        let inputs = MapInputs { obstacles, goal: task.goal, fixtures: body.fixtures.clone() };
        if let Some((_, map)) = self.map.as_ref().filter(|(known, _)| *known == inputs) {
            return Ok(map.clone());
        }
        let (ends, turning) = ([task.goal, task.state.pose], self.planner.settings().cost.heading);
        let map = Arc::new(run(py, || ObstacleMap::new(body, &inputs.obstacles, ends, turning))?);
        self.map = Some((inputs, map.clone()));
        Ok(map)
    }
}

/// The arm of a task; ideal by default.
fn commanded(arm: Option<PyRef<'_, PyArmEstimate>>) -> CommandedArm {
    arm.map(|arm| arm.commanded()).unwrap_or_default()
}

/// What predicts the motion instead of a model.
#[derive(FromPyObject)]
enum Learnt<'py> {
    Regression(PyRef<'py, Regression>),
    Simulator(Py<PyAny>),
}

/// The states that `simulate` returns for plans.
fn motions(simulate: &Bound<'_, PyAny>, plans: &[[f64; 3]], horizon: usize) -> PyResult<Vec<[f64; 6]>> {
    let count = plans.len() / horizon;
    let flat = PyArray1::from_vec(simulate.py(), plans.iter().flatten().copied().collect());
    let states = simulate.call1((flat.reshape([count, horizon, 3])?,))?;
    let states: PyReadonlyArray4<'_, f64> = states
        .extract()
        .map_err(|_| refused("learnt: must return an array (predictions, n, steps, 6) of float64"))?;
    let shape = states.as_array().shape().to_vec();
    let flat: Vec<f64> = states.as_array().iter().copied().collect();
    match flat.as_chunks() {
        (rows, []) if shape[1] == count && shape[3] == 6 => Ok(rows.to_vec()),
        _ => Err(refused(format!(
            "learnt: returned an array of shape {shape:?} for {count} plans; must be (predictions, {count}, steps, 6)"
        ))),
    }
}

fn batch_error(error: BatchError<PyErr>) -> PyErr {
    match error {
        BatchError::Planner(error) => refused(error),
        BatchError::Simulator(error) => error,
    }
}

const NONE: &str = "models: give at least one";

/// One model or several.
#[derive(FromPyObject)]
enum Models<'py> {
    One(PyRef<'py, PyModel>),
    Several(Vec<PyRef<'py, PyModel>>),
}

impl Models<'_> {
    fn all(&self) -> Vec<&PyModel> {
        match self {
            Self::One(model) => vec![model],
            Self::Several(models) => models.iter().map(|model| &**model).collect(),
        }
    }

    fn plants(&self) -> PyResult<Vec<Plant<f64>>> {
        self.all().into_iter().map(|model| model.model.resolved().map_err(refused)).collect()
    }

    /// State of the object. All models have the same laws, so the first one determines the initial inner states.
    fn state(&self, pose: [f64; 3], twist: [f64; 3], inner: &[f64]) -> PyResult<State<f64>> {
        let Some(first) = self.all().into_iter().next() else { return Err(refused(NONE)) };
        Ok(State::moving(pose, twist).with_inner(first.model.inner_with(inner).map_err(refused)?))
    }

    /// Body of the first model. All models have the same body.
    fn body(&self) -> PyResult<Body> {
        let first = self.all().into_iter().next().map(|model| model.model.body.clone());
        first.ok_or_else(|| refused(NONE))
    }
}
