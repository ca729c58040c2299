//! The PyO3 border: conversion only, one file a topic.
use pyo3::prelude::*;

mod columns;
mod error;
mod record;
mod toml_dict;

/// The compiled half of the `trundle` package.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    error::register(module)?;
    record::register(module)?;
    Ok(())
}
