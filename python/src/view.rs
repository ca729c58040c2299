//! Views of a pushing task for pictures and oracles.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_model::Rigid;
use trundle_sim::PushTask;
use trundle_sim::task::{TaskKind, TaskObject};

/// Number of hidden values: mass, mass centre, radius of gyration, and total damping of the viscous wheels about the
/// object's origin.
pub(crate) const HIDDEN_VALUES: usize = 10;

pub(crate) fn hidden_values(task: &PushTask) -> [f64; HIDDEN_VALUES] {
    let (Some(rigid), Some(hidden)) = (task.rigid(), task.hidden()) else { return [f64::NAN; HIDDEN_VALUES] };
    let Rigid { mass, com: [x, y], inertia } = rigid;
    let [xx, xy, yy, tx, ty, tt] = hidden.total_damping();
    [mass, x, y, (inertia / mass).sqrt(), xx, xy, yy, tx, ty, tt]
}

/// Visible state for drawing; None before the first reset.
pub(crate) fn view<'py>(py: Python<'py>, task: &PushTask) -> PyResult<Option<Bound<'py, PyDict>>> {
    let (Some(([object, goal, gripper, wrench], holds)), Some(layout), Some(task_object)) =
        (task.view(), task.layout(), task.task_object())
    else {
        return Ok(None);
    };
    let dict = PyDict::new(py);
    dict.set_item("object", object)?;
    dict.set_item("goal", if task.options().task == TaskKind::Path { layout.goal } else { goal })?;
    dict.set_item("gripper", gripper)?;
    dict.set_item("wrench", wrench)?;
    dict.set_item("holds", holds)?;
    dict.set_item("obstacles", layout.obstacles.clone())?;
    dict.set_item("path", layout.path.iter().map(|[x, y, _]| [*x, *y]).collect::<Vec<_>>())?;
    dict.set_item("fixtures", fixtures(task_object))?;
    dict.set_item("wheels", task_object.feet.clone())?;
    Ok(Some(dict))
}

/// Corners of a polygon, or centre and radius of a disc.
#[derive(IntoPyObject)]
enum Part {
    Polygon(Vec<[f64; 2]>),
    Disc(([f64; 2], f64)),
}

fn fixtures(task_object: &TaskObject) -> Vec<Part> {
    let part = |fixture: &trundle_model::Fixture| match fixture {
        trundle_model::Fixture::Polygon { vertices, .. } => Part::Polygon(vertices.clone()),
        trundle_model::Fixture::Disc { center, radius, .. } => Part::Disc((*center, *radius)),
    };
    task_object.body.fixtures.iter().map(part).collect()
}
