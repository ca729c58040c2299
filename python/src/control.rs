//! The planner in Python.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_control::{ControlError, Planner, Settings, Task};
use trundle_model::State;

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
///     (0.4), correlation of successive actions (0.8), and how far costs above the least count, as a share of
///     their standard deviation (0.02).
/// cost : dict
///     Weights: `heading` (m for each rad, 0.3), `effort` (m for a full action along an axis), `speed_limit`
///     (m/s), `spin_limit` (rad/s), `excess` (m for exceeding a limit by all of it), `arrival` (s for which the
///     error at the end is charged) and `momentum` (m for each m/s there).
///
/// Raises
/// ------
/// TrundleError
///     If bounds are reversed, or a setting is unknown or out of its range.
#[pyclass(name = "Planner", module = "trundle")]
struct PyPlanner {
    planner: Planner,
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
        Ok(Self { planner: Planner::new(settings, seed).map_err(refused)? })
    }

    /// Improve the plan for where the object is now.
    ///
    /// Parameters
    /// ----------
    /// model : Model
    ///     With all values given.
    /// pose, twist : sequence of 3 floats
    ///     Motion of the object frame, world axes, [m, m, rad] and [m/s, m/s, rad/s].
    /// goal : sequence of 3 floats
    ///     Pose at which it should be, [m, m, rad].
    /// grasp : sequence of 2 floats
    ///     Where it is held, object frame, m.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (horizon, 3)
    ///     Wrenches at the grasp, object axes, [N, N, N·m].
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If a number is not finite, or a value of the model is free.
    fn plan<'py>(
        &mut self,
        py: Python<'py>,
        model: &PyModel,
        pose: [f64; 3],
        twist: [f64; 3],
        goal: [f64; 3],
        grasp: [f64; 2],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let plant = model.model.resolved().map_err(refused)?;
        let task = Task { state: State::moving(pose, twist), goal, grasp };
        let actions: Vec<f64> = run(py, || {
            let plan = self.planner.plan(&plant, &task)?;
            Ok::<_, ControlError>(plan.iter().flatten().copied().collect())
        })?;
        PyArray1::from_vec(py, actions).reshape([self.planner.settings().horizon, 3])
    }

    /// Move the plan on by so many seconds; its last action is held beyond its end.
    fn advance(&mut self, seconds: f64) -> PyResult<()> {
        self.planner.advance(seconds).map_err(refused)
    }

    /// Forget the plan, and start the draws again.
    fn restart(&mut self) {
        self.planner.restart();
    }

    /// Time for which each action is held, s.
    #[getter]
    fn hold(&self) -> f64 {
        self.planner.settings().hold
    }
}
