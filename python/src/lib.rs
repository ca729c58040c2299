//! Python bindings: conversions only, one file per topic.

use pyo3::prelude::*;

mod actions;
mod arm;
mod background;
mod baseline;
mod black_box;
mod columns;
mod control;
mod decision_time;
mod design;
mod diagnose;
mod display;
mod episodes;
mod error;
mod identify;
mod infer;
mod inputs;
mod inspect;
mod joint_design;
mod joint_record;
mod laws;
mod mechanism;
mod model;
mod obstacles;
mod online;
mod paper;
mod plain;
mod pool;
mod posterior;
mod push;
mod push_batch;
mod record;
mod sim;
mod simulator;
mod table;
mod toml_dict;
mod view;
mod watch;

/// The compiled half of the `trundle` package.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::register(module)?;
    mechanism::register(module)?;
    joint_design::register(module)?;
    table::register(module)?;
    model::register(module)?;
    record::register(module)?;
    joint_record::register(module)?;
    push::register(module)?;
    push_batch::register(module)?;
    sim::register(module)?;
    inspect::register(module)?;
    laws::register(module)?;
    infer::register(module)?;
    identify::register(module)?;
    online::register(module)?;
    baseline::register(module)?;
    diagnose::register(module)?;
    black_box::register(module)?;
    design::register(module)?;
    arm::register(module)?;
    background::register(module)?;
    control::register(module)?;
    obstacles::register(module)?;
    paper::register(module)?;
    posterior::register(module)?;
    Ok(())
}
