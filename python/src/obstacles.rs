//! Detours around obstacles in Python.

use pyo3::prelude::*;
use trundle_control::ObstacleMap;
use trundle_model::Body;

use crate::error::{refused, run};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyObstacleMap>()
}

/// Map of obstacles with the detours of an object to a goal pose.
///
/// Parameters
/// ----------
/// outline : sequence of pairs of float
///     Corners of the object, object frame, m.
/// obstacles : sequence of polygons
///     Corners in order, world, m.
/// goal, start : sequence of 3 floats
///     Poses that the map contains, [m, m, rad].
/// turn_cost : float
///     Cost of a turn, m/rad.
#[pyclass(name = "ObstacleMap", module = "trundle._native", frozen)]
struct PyObstacleMap {
    map: ObstacleMap,
}

#[pymethods]
impl PyObstacleMap {
    #[new]
    fn new(
        py: Python<'_>,
        outline: Vec<[f64; 2]>,
        obstacles: Vec<Vec<[f64; 2]>>,
        goal: [f64; 3],
        start: [f64; 3],
        turn_cost: f64,
    ) -> PyResult<Self> {
        let body = Body::from_footprint(&outline, 1.0).map_err(refused)?;
        let map = run(py, || ObstacleMap::new(&body, &obstacles, [goal, start], turn_cost))?;
        Ok(Self { map })
    }

    /// By how much the shortest path from a pose to the goal is longer than without obstacles, m.
    fn detour(&self, pose: [f64; 3]) -> f64 {
        self.map.detour(pose)
    }
}
