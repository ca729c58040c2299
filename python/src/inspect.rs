//! Inspection of recordings: summary, findings, prepared and smoothed streams.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trundle_record::{Dataset, Motion, PrepareOptions, Prepared, TareMethod, WrenchPose};

use crate::error::{refused, run};
use crate::plain::plain;
use crate::record::{AnyRecordingOf, any_recording_of, recording_of};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_inspect, module)?)?;
    module.add_function(wrap_pyfunction!(_check, module)?)?;
    module.add_function(wrap_pyfunction!(prepare, module)?)?;
    module.add_function(wrap_pyfunction!(smooth, module)?)
}

/// Summary of a recording; see `trundle.inspect`.
#[pyfunction]
fn _inspect<'py>(recording: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = recording.py();
    match any_recording_of(recording)? {
        AnyRecordingOf::Object(recording) => plain(py, &run(py, || trundle_record::inspect(&recording))?),
        AnyRecordingOf::Joints(recording) => plain(
            py,
            &run(py, || Ok::<_, trundle_record::Error>(trundle_record::inspect_joints(&recording)))?,
        ),
    }
}

/// Findings about a recording, most severe first; see `trundle.check`.
#[pyfunction]
fn _check<'py>(recording: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let (py, recording) = (recording.py(), any_recording_of(recording)?);
    let findings = run(py, || {
        Ok::<_, trundle_record::Error>(match &recording {
            AnyRecordingOf::Object(recording) => trundle_record::check(recording),
            AnyRecordingOf::Joints(recording) => trundle_record::check_joints(recording),
        })
    })?;
    plain(py, &findings)
}

/// Tare, mask and transform a recording, as for an estimation.
///
/// Parameters
/// ----------
/// recording : Recording or path-like
///     The recording, or its folder.
/// tare : {"separated", "equation_12"}
///     How a raw reading is tared: offset and weight separately, or by the paper's equation 12, which rotates the
///     whole first reading with the gripper and is exact if the offset is zero.
/// wrench_pose : {"own_time", "latest"}
///     The pose that transforms each wrench to the object: the smoothed pose at the time of the wrench, or the
///     latest recorded pose (equation 13 of the paper).
///
/// Returns
/// -------
/// dict of str to dict
///     By episode: ``held_out``, ``contact`` (s), ``tare_sd`` (3,), ``wrench_t`` (n,), ``reading`` (n, 3) in N and
///     N m in reading axes, ``frame`` (n, 3), the pose of these axes in the object frame, ``on_object`` (n, 3), the
///     wrench in object axes about the object's origin, ``pose_t`` (m,), ``pose`` (m, 3), world frame.
///
/// Raises
/// ------
/// TrundleError
///     If a raw reading cannot be tared, or a stream is missing.
///
/// Examples
/// --------
/// >>> prepared = trundle.prepare(recording)["episode_00"]
/// >>> prepared["on_object"].shape == (len(prepared["wrench_t"]), 3)
/// True
#[pyfunction]
#[pyo3(signature = (recording, tare = "separated", wrench_pose = "own_time"))]
fn prepare<'py>(
    recording: &Bound<'py, PyAny>,
    tare: &str,
    wrench_pose: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let tare = match tare {
        "separated" => TareMethod::Separated,
        "equation_12" => TareMethod::Equation12,
        _ => return Err(refused(format!("tare = {tare:?}: choose \"separated\" or \"equation_12\""))),
    };
    let options =
        PrepareOptions { tare, wrench_pose: wrench_pose_of(wrench_pose)?, ..PrepareOptions::default() };
    let (py, recording) = (recording.py(), recording_of(recording)?);
    let dataset = run(py, || trundle_record::prepare_with(&recording, options))?;
    by_episode(py, &dataset, |episode, held_out| {
        let dict = PyDict::new(py);
        dict.set_item("held_out", held_out)?;
        dict.set_item("contact", episode.contact)?;
        dict.set_item("tare_sd", episode.tare_sd.to_vec().into_pyarray(py))?;
        dict.set_item("wrench_t", column(py, &episode.wrench, |w| w.t))?;
        dict.set_item("reading", table(py, &episode.wrench, |w| w.reading)?)?;
        dict.set_item("frame", table(py, &episode.wrench, |w| w.frame)?)?;
        dict.set_item("on_object", table(py, &episode.wrench, |w| w.on_object())?)?;
        dict.set_item("pose_t", column(py, &episode.pose, |p| p.t))?;
        dict.set_item("pose", table(py, &episode.pose, |p| p.pose)?)?;
        Ok(dict)
    })
}

/// The rule of this name.
pub(crate) fn wrench_pose_of(name: &str) -> PyResult<WrenchPose> {
    match name {
        "own_time" => Ok(WrenchPose::OwnTime),
        "latest" => Ok(WrenchPose::Latest),
        _ => Err(refused(format!("wrench_pose = {name:?}: choose \"own_time\" or \"latest\""))),
    }
}

/// Estimate twist and acceleration from the object's poses.
///
/// Parameters
/// ----------
/// recording : Recording or path-like
///     The recording, or its folder.
/// causal : bool
///     Use the poses up to each time only; otherwise also those after it.
///
/// Returns
/// -------
/// dict of str to dict
///     By episode: ``t`` (n,), ``pose``, ``twist``, ``accel`` (n, 3) of the object frame's origin in world axes,
///     ``cov`` (n, 3, 3, 3): for each axis x, y, theta the covariance of (pose, twist, accel). No rows for an
///     episode with fewer than five poses.
///
/// Examples
/// --------
/// >>> motion = trundle.smooth(recording)["episode_00"]
/// >>> motion["twist"].shape == motion["pose"].shape
/// True
#[pyfunction]
#[pyo3(signature = (recording, causal = false))]
fn smooth<'py>(recording: &Bound<'py, PyAny>, causal: bool) -> PyResult<Bound<'py, PyDict>> {
    let (py, recording) = (recording.py(), recording_of(recording)?);
    let dataset = run(py, || trundle_record::prepare(&recording))?;
    by_episode(py, &dataset, |episode, _| {
        let motion = run(py, || {
            let noise = &dataset.noise;
            Ok::<_, trundle_record::Error>(if causal {
                episode.filtered_motion(noise)
            } else {
                episode.motion(noise)
            })
        })?;
        let dict = PyDict::new(py);
        dict.set_item("t", column(py, &motion, |m| m.t))?;
        dict.set_item("pose", table(py, &motion, |m| m.pose)?)?;
        dict.set_item("twist", table(py, &motion, |m| m.twist)?)?;
        dict.set_item("accel", table(py, &motion, |m| m.accel)?)?;
        dict.set_item("cov", covariances(py, &motion)?)?;
        Ok(dict)
    })
}

fn by_episode<'py>(
    py: Python<'py>,
    dataset: &Dataset,
    convert: impl Fn(&Prepared, bool) -> PyResult<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (episodes, held_out) in [(&dataset.training, false), (&dataset.held_out, true)] {
        for episode in episodes {
            dict.set_item(&episode.name, convert(episode, held_out)?)?;
        }
    }
    Ok(dict)
}

fn column<'py, T>(py: Python<'py>, rows: &[T], value: impl Fn(&T) -> f64) -> Bound<'py, PyAny> {
    rows.iter().map(value).collect::<Vec<f64>>().into_pyarray(py).into_any()
}

fn table<'py, T>(py: Python<'py>, rows: &[T], value: impl Fn(&T) -> [f64; 3]) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f64> = rows.iter().flat_map(value).collect();
    Ok(flat.into_pyarray(py).reshape([rows.len(), 3])?.into_any())
}

fn covariances<'py>(py: Python<'py>, motion: &[Motion]) -> PyResult<Bound<'py, PyAny>> {
    let flat: Vec<f64> = motion.iter().flat_map(|m| m.cov.as_flattened().as_flattened().to_vec()).collect();
    Ok(flat.into_pyarray(py).reshape([motion.len(), 3, 3, 3])?.into_any())
}
