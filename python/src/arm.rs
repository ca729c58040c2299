//! The estimate of an arm's response in Python.

use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use trundle_control::{ArmEstimate, AxisResponse, CommandedArm};

use crate::error::refused;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyArmEstimate>()
}

/// Online estimate of an arm that is commanded once per period: delay, lag and compliance.
///
/// Parameters
/// ----------
/// period : float
///     Time between two commands, s.
/// rise : float
///     Time in which the wrench changes from one command to the next without lag, s; at most the period.
/// scale : sequence of 3 floats
///     Full command, [N, N, N·m].
///
/// Raises
/// ------
/// TrundleError
///     If a number is out of its range.
#[pyclass(name = "_ArmEstimate", module = "trundle._native")]
pub(crate) struct PyArmEstimate(ArmEstimate);

impl PyArmEstimate {
    /// The arm at the latest observation.
    pub(crate) fn commanded(&self) -> CommandedArm {
        self.0.commanded()
    }
}

#[pymethods]
impl PyArmEstimate {
    #[new]
    fn new(period: f64, rise: f64, scale: [f64; 3]) -> PyResult<Self> {
        Ok(Self(ArmEstimate::new(period, rise, scale).map_err(refused)?))
    }

    /// Add a period: the command at its start and the reading at its end, gripper axes, [N, N, N·m].
    ///
    /// Parameters
    /// ----------
    /// command, reading : sequence of 3 floats
    /// holds : bool
    ///     Whether the gripper held the object.
    fn observe(&mut self, command: [f64; 3], reading: [f64; 3], holds: bool) {
        self.0.observe(command, reading, holds);
    }

    /// Most probable time from an observation until the command that follows it shows in observations, s.
    #[getter]
    fn delay(&self) -> f64 {
        self.0.response().delay
    }

    /// Most probable response of the forces: `kind` ("exact", "lag" or "compliant") and its parameters.
    #[getter]
    fn force(&self) -> (&'static str, Vec<(&'static str, f64)>) {
        parameters(self.0.response().force)
    }

    /// Most probable response of the torque, as `force`.
    #[getter]
    fn torque(&self) -> (&'static str, Vec<(&'static str, f64)>) {
        parameters(self.0.response().torque)
    }

    fn __repr__(&self) -> String {
        let response = self.0.response();
        let axis = |axis: AxisResponse| match axis {
            AxisResponse::Exact => "exact".to_owned(),
            AxisResponse::Lag { time_constant } => format!("lag {:.0} ms", 1e3 * time_constant),
            AxisResponse::Compliant { frequency, damping_ratio, gain } => {
                let hertz = frequency / std::f64::consts::TAU;
                format!("{hertz:.1} Hz at damping ratio {damping_ratio} and gain {gain}")
            }
        };
        let (force, torque) = (axis(response.force), axis(response.torque));
        let turn = response.turn.to_degrees();
        let delay = 1e3 * response.delay;
        format!(
            "<trundle arm: delay {delay:.0} ms, force {force}, torque {torque}, turn {turn:.2} deg/(N m)>"
        )
    }

    /// Most probable turn of a compliant hand against the object per torque, rad/(N·m).
    #[getter]
    fn turn(&self) -> f64 {
        self.0.response().turn
    }

    /// Times of `wrenches` since the start of a period, s.
    #[getter]
    fn knots(&self) -> Vec<f64> {
        self.0.knots().to_vec()
    }

    /// Wrenches within all periods by the most probable response, consistent with the readings.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (periods, knots, 3), or None
    ///     Gripper axes, [N, N, N·m]; None if the wrench is the command at once.
    fn wrenches<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f64>>>> {
        let Some(wrenches) = self.0.wrenches() else { return Ok(None) };
        let shape = [wrenches.len(), self.0.knots().len(), 3];
        let flat = wrenches.into_iter().flatten().flatten().collect();
        PyArray1::from_vec(py, flat).reshape(shape).map(Some)
    }
}

fn parameters(response: AxisResponse) -> (&'static str, Vec<(&'static str, f64)>) {
    match response {
        AxisResponse::Exact => ("exact", vec![]),
        AxisResponse::Lag { time_constant } => ("lag", vec![("time_constant", time_constant)]),
        AxisResponse::Compliant { frequency, damping_ratio, gain } => {
            ("compliant", vec![("frequency", frequency), ("damping_ratio", damping_ratio), ("gain", gain)])
        }
    }
}
