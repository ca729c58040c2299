//! The planner in Python.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_control::{ObstacleMap, Planner, PlanningTask, Settings};
use trundle_model::{Body, Fixture, Plant, State};

use crate::baseline::Regression;
use crate::error::{refused, run};
use crate::model::PyModel;
use crate::toml_dict;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyPlanner>()
}

/// Plans pushes by model predictive path integral control (MPPI) over a model's motion.
///
/// Each plan starts from the one before. The same seed and calls give the same plans, on any number of
/// threads.
///
/// Parameters
/// ----------
/// lower, upper : sequence of 3 floats
///     Bounds on the wrench at the grasp, object axes, [N, N, N·m].
/// seed : int
///     Seed of the samples.
/// horizon : int
///     Actions in a plan, 20 by default.
/// hold : float
///     Time for which each action is held, 0.1 s by default.
/// samples, iterations : int
///     Plans rolled out in each iteration, 256, and iterations of each call, 6 by default.
/// spread, smoothness, temperature : float
///     Of the samples: standard deviation of the first iteration as a share of half the range of the bounds
///     (0.6), correlation of successive actions (0.9), and how far costs above the least count, as a share of
///     their standard deviation (0.02).
/// curiosity : float
///     Seconds that a plan is credited for each metre by which the models' ends differ (0).
/// cost : dict
///     Weights: `heading` (m for each rad, 0.3), `effort` (m for half the range of an action along an axis), `speed_limit`
///     (m/s), `spin_limit` (rad/s), `excess` (m for exceeding a limit by all of it), `arrival` (s for which the
///     error at the end is charged), `pace` (rad/s at which a turn that is left is undone), `anchor` (s for which it is
///     charged that what dry friction holds is off), `momentum` (m for each m/s there), `margin` (room that should
///     be left to obstacles, m) and `collision` (m for touching one).
///
/// Raises
/// ------
/// TrundleError
///     If bounds are reversed, or a setting is unknown or out of its range.
#[pyclass(name = "Planner", module = "trundle")]
struct PyPlanner {
    planner: Planner,
    /// The room of the last call, and what it was made of.
    room: Option<(Surroundings, Arc<ObstacleMap>)>,
}

/// What a room is made of.
#[derive(PartialEq)]
struct Surroundings {
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
        Ok(Self { planner: Planner::new(settings, seed).map_err(refused)?, room: None })
    }

    /// Improve the plan for where the object is now.
    ///
    /// Parameters
    /// ----------
    /// model : Model or sequence of Model
    ///     With all values given; of several, a plan costs what it does on average.
    /// pose, twist : sequence of 3 floats
    ///     Motion of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// goal : sequence of 3 floats
    ///     Pose at which it should be, [m, m, rad].
    /// grasp : sequence of 2 floats
    ///     Where it is held, object frame, m.
    /// obstacles : sequence of polygons
    ///     Fixed and simple, corners in order, world, m.
    /// inner : sequence of float
    ///     The laws' own states, as `Laws.starts`; where they start by default.
    /// learnt : regression, optional
    ///     Moves the object in the place of the model's laws; then the model says the outline alone.
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
    #[pyo3(signature = (model, pose, twist, goal, grasp, obstacles = vec![], *, inner = vec![], learnt = None))]
    #[expect(clippy::too_many_arguments, reason = "what a task is made of")]
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
        learnt: Option<PyRef<'py, Regression>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let task = PlanningTask { state: model.state(pose, twist, &inner)?, goal, grasp };
        let room = self.furnish(py, &model.body()?, obstacles, &task)?;
        let planner = &mut self.planner;
        let flat = |plan: &[[f64; 3]]| plan.iter().flatten().copied().collect::<Vec<f64>>();
        let actions = if let Some(learnt) = learnt {
            let learnt: &Regression = &learnt;
            run(py, || planner.plan(&[learnt], &task, &room).map(flat))?
        } else {
            let plants = model.plants()?;
            run(py, || planner.plan(&plants, &task, &room).map(flat))?
        };
        PyArray1::from_vec(py, actions).reshape([self.planner.settings().horizon, 3])
    }

    /// What it would be worth to know which of several models is true, in metre-seconds.
    ///
    /// Parameters
    /// ----------
    /// models : sequence of Model
    ///     Equally probable.
    /// pose, twist, goal, grasp, obstacles, inner
    ///     As for `plan`.
    ///
    /// Returns
    /// -------
    /// float
    ///     What the best plan for all of them costs on average more than each one's own.
    #[pyo3(signature = (models, pose, twist, goal, grasp, obstacles = vec![], *, inner = vec![]))]
    #[expect(clippy::too_many_arguments, reason = "what a task is made of")]
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
    ) -> PyResult<f64> {
        let task = PlanningTask { state: models.state(pose, twist, &inner)?, goal, grasp };
        let (plants, room) = (models.plants()?, self.furnish(py, &models.body()?, obstacles, &task)?);
        run(py, || self.planner.regret(&plants, &task, &room))
    }

    /// Credit plans, from now on, with so many seconds for each metre by which the models' ends differ.
    fn be_curious(&mut self, curiosity: f64) -> PyResult<()> {
        self.planner.set_curiosity(curiosity).map_err(refused)
    }

    /// What the best plan found from each grasp costs, in metre-seconds: where to hold the object.
    ///
    /// Parameters
    /// ----------
    /// model, pose, twist, goal, obstacles
    ///     As for `plan`, with `inner`.
    /// grasps : sequence of pairs of float
    ///     Object frame, m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (len(grasps),)
    ///     Infinite where no plan keeps the motion finite.
    #[pyo3(signature = (model, pose, twist, goal, grasps, obstacles = vec![], *, inner = vec![]))]
    #[expect(clippy::too_many_arguments, reason = "what a task is made of")]
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
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let task = PlanningTask { state: model.state(pose, twist, &inner)?, goal, grasp: [0.0; 2] };
        let (plants, room) = (model.plants()?, self.furnish(py, &model.body()?, obstacles, &task)?);
        let costs = run(py, || self.planner.compare(&plants, &task, &room, &grasps))?;
        Ok(PyArray1::from_vec(py, costs))
    }

    /// Move the plan on by so many seconds; its last action is held beyond its end.
    fn advance(&mut self, seconds: f64) -> PyResult<()> {
        self.planner.advance(seconds).map_err(refused)
    }

    /// Forget the plan, and start the draws again.
    fn restart(&mut self) {
        self.planner.restart();
        self.room = None;
    }

    /// Time for which each action is held, s.
    #[getter]
    fn hold(&self) -> f64 {
        self.planner.settings().hold
    }
}

impl PyPlanner {
    /// The room of a task; the ways in it are found anew only where goal, obstacles or object are others.
    fn furnish(
        &mut self,
        py: Python<'_>,
        body: &Body,
        obstacles: Vec<Vec<[f64; 2]>>,
        task: &PlanningTask,
    ) -> PyResult<Arc<ObstacleMap>> {
        let made_of = Surroundings { obstacles, goal: task.goal, fixtures: body.fixtures.clone() };
        if let Some((_, room)) = self.room.as_ref().filter(|(known, _)| *known == made_of) {
            return Ok(room.clone());
        }
        let (ends, turning) = ([task.goal, task.state.pose], self.planner.settings().cost.heading);
        let room = Arc::new(run(py, || ObstacleMap::new(body, &made_of.obstacles, ends, turning))?);
        self.room = Some((made_of, room.clone()));
        Ok(room)
    }
}

const NONE: &str = "models: give one at least";

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

    /// Where the object is; the first model says where its laws' own states start, all are of the same laws.
    fn state(&self, pose: [f64; 3], twist: [f64; 3], inner: &[f64]) -> PyResult<State<f64>> {
        let Some(first) = self.all().into_iter().next() else { return Err(refused(NONE)) };
        let starts = crate::laws::starts(&first.model);
        Ok(State::moving(pose, twist).with_inner(crate::laws::own(&starts, inner)?))
    }

    /// Of the first; all are of one object.
    fn body(&self) -> PyResult<Body> {
        let first = self.all().into_iter().next().map(|model| model.model.body.clone());
        first.ok_or_else(|| refused(NONE))
    }
}
