//! Recordings in Python.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyType};
use trundle_record::{AnyRecording, JointRecording, Metadata, Recording};

use crate::episodes::{EpisodeColumns, RecordingClass};
use crate::error::{refused, run};
use crate::joint_record::PyJointRecording;
use crate::{display, episodes, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyRecording>()?;
    module.add_function(wrap_pyfunction!(_replace_folder, module)?)?;
    module.add_function(wrap_pyfunction!(_recover_folder, module)?)?;
    module.add_function(wrap_pyfunction!(_pushed, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)
}

/// A recording: metadata and episodes.
///
/// A recording is validated when it is created, and is immutable. It is a mapping of names to episodes, in
/// chronological order: ``len(recording)``, ``recording["episode_00"]``, ``"episode_00" in recording``, and iteration
/// over names, values and items.
///
/// Parameters
/// ----------
/// metadata : Mapping
///     Content of ``recording.toml``.
/// episodes : Mapping of str to Mapping of str to array_like, or to pandas.DataFrame
///     Columns by episode name and column name: one-dimensional float64 in SI units, NaN for an empty cell.
///     Columns whose names begin with ``note_`` contain text.
///
/// Raises
/// ------
/// TrundleError
///     If the recording is invalid. The message names the place and the remedy.
///
/// Examples
/// --------
/// >>> list(recording)
/// ['episode_00', 'episode_01', 'episode_02']
/// >>> wrench = recording["episode_00"].wrench
/// >>> wrench["force_x"].shape == wrench.t.shape
/// True
/// >>> shorter = trundle.Recording(recording.metadata, recording.episodes)
/// >>> shorter == recording
/// True
#[pyclass(name = "Recording", module = "trundle", frozen)]
pub(crate) struct PyRecording {
    inner: Arc<Recording>,
    columns: EpisodeColumns,
}

impl RecordingClass for PyRecording {
    const EPISODE: (&'static str, &'static str) = ("trundle.episode", "Episode");

    fn name(&self) -> &str {
        &self.inner.metadata.name
    }

    fn episodes(&self) -> &[trundle_record::Episode] {
        &self.inner.episodes
    }

    fn columns(&self) -> &EpisodeColumns {
        &self.columns
    }
}

/// Arguments that create an equal recording.
type Arguments<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

impl PyRecording {
    pub(crate) fn wrap(recording: Recording) -> Self {
        Self { inner: Arc::new(recording), columns: EpisodeColumns::new() }
    }
}

/// A recording of a pushed object, or the path of one.
///
/// # Errors
/// `TrundleError` for a recording of joints.
pub(crate) fn recording_of(argument: &Bound<'_, PyAny>) -> PyResult<Arc<Recording>> {
    match any_recording_of(argument)? {
        AnyRecordingOf::Object(recording) => Ok(recording),
        AnyRecordingOf::Joints(recording) => Err(refused(format!(
            "{}: is a recording of joints (trundle-recording/2), but this needs one of a pushed object \
             (trundle-recording/1); `trundle info` and `trundle check` read both",
            argument
                .extract::<PathBuf>()
                .map_or(recording.metadata.name.clone(), |path| path.display().to_string())
        ))),
    }
}

/// A recording of joints, or the path of one.
///
/// # Errors
/// `TrundleError` for a recording of a pushed object.
pub(crate) fn joint_recording_of(argument: &Bound<'_, PyAny>) -> PyResult<Arc<JointRecording>> {
    match any_recording_of(argument)? {
        AnyRecordingOf::Joints(recording) => Ok(recording),
        AnyRecordingOf::Object(recording) => Err(refused(format!(
            "{}: is a recording of a pushed object (trundle-recording/1), but this needs one of joints",
            recording.metadata.name
        ))),
    }
}

/// A recording of either format.
pub(crate) enum AnyRecordingOf {
    Object(Arc<Recording>),
    Joints(Arc<JointRecording>),
}

/// A recording of either format, or the path of one.
pub(crate) fn any_recording_of(argument: &Bound<'_, PyAny>) -> PyResult<AnyRecordingOf> {
    if let Ok(recording) = argument.cast::<PyRecording>() {
        return Ok(AnyRecordingOf::Object(recording.get().inner.clone()));
    }
    if let Ok(recording) = argument.cast::<PyJointRecording>() {
        return Ok(AnyRecordingOf::Joints(recording.get().inner.clone()));
    }
    let path: PathBuf = argument.extract()?;
    Ok(match run(argument.py(), || AnyRecording::read(&path))? {
        AnyRecording::Object(recording) => AnyRecordingOf::Object(Arc::new(*recording)),
        AnyRecording::Joints(recording) => AnyRecordingOf::Joints(Arc::new(*recording)),
    })
}

/// Metadata from a mapping.
pub(crate) fn metadata_of(mapping: &Bound<'_, PyAny>) -> PyResult<Metadata> {
    Metadata::from_table(toml_dict::from_dict(mapping, "metadata")?).map_err(refused)
}

/// Read and validate a recording.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     Folder with ``recording.toml`` and one ``NAME.csv`` or ``NAME.parquet`` per episode.
///
/// Returns
/// -------
/// Recording or JointRecording
///     By the `format` in ``recording.toml``.
///
/// Raises
/// ------
/// TrundleError
///     If the recording is invalid. The message names file, row, column, value and remedy.
///
/// Examples
/// --------
/// >>> recording.write("recordings_run_3")
/// >>> len(trundle.read("recordings_run_3"))
/// 3
#[pyfunction]
fn read(py: Python<'_>, path: PathBuf) -> PyResult<Py<PyAny>> {
    Ok(match run(py, || AnyRecording::read(&path))? {
        AnyRecording::Object(recording) => Py::new(py, PyRecording::wrap(*recording))?.into_any(),
        AnyRecording::Joints(recording) => Py::new(py, PyJointRecording::wrap(*recording))?.into_any(),
    })
}

/// Return a recording of a pushed object; a path is read.
#[pyfunction]
fn _pushed(recording: &Bound<'_, PyAny>) -> PyResult<Py<PyRecording>> {
    if let Ok(recording) = recording.cast::<PyRecording>() {
        return Ok(recording.clone().unbind());
    }
    let inner = recording_of(recording)?;
    Py::new(recording.py(), PyRecording { inner, columns: EpisodeColumns::new() })
}

/// Exchange two folders atomically.
#[pyfunction]
fn _replace_folder(new: PathBuf, path: PathBuf) -> PyResult<()> {
    Ok(trundle_record::replace_folder(&new, &path)?)
}

/// Restore the folder that a killed process was about to replace.
#[pyfunction]
fn _recover_folder(path: PathBuf) -> PyResult<()> {
    Ok(trundle_record::recover_folder(&path)?)
}

#[pymethods]
impl PyRecording {
    #[new]
    fn new(metadata: &Bound<'_, PyAny>, episodes: &Bound<'_, PyAny>) -> PyResult<Self> {
        let metadata = metadata_of(metadata)?;
        let tables = episodes::from_mapping(episodes)?;
        run(episodes.py(), || Recording::new(metadata, tables)).map(Self::wrap)
    }

    /// Name of the recording.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.metadata.name
    }

    /// Content of ``recording.toml`` as a new dict.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        toml_dict::to_dict(py, &self.inner.metadata.to_table().map_err(refused)?)
    }

    /// The episodes by name, in chronological order, as a new dict.
    #[getter]
    fn episodes<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        episodes::dict(slf)
    }

    /// One episode as a data frame: a copy of the columns, ``t`` first, NaN for an empty cell.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     The episode.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     As ``recording[name].frame()``.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If there is no such episode, or the extra `trundle[pandas]` is not installed.
    fn frame<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        episodes::item(slf, name)?.call_method0("frame")
    }

    /// Names of the episodes.
    fn keys(&self) -> Vec<&str> {
        episodes::keys(self)
    }

    /// The episodes.
    fn values<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        Ok(episodes::items(slf)?.into_iter().map(|(_, episode)| episode).collect())
    }

    /// Pairs of name and episode.
    fn items<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        episodes::items(slf)
    }

    fn __len__(&self) -> usize {
        self.inner.episodes.len()
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> PyResult<bool> {
        episodes::contains(self, name)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        episodes::iterate(py, self)
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        episodes::item(slf, name)
    }

    /// Write the recording as a folder, atomically.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The folder. An earlier recording there is replaced; other content is an error.
    /// table : {"csv", "parquet"}
    ///     Format of the tables.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If the folder cannot be written.
    #[pyo3(signature = (path, table = "csv"))]
    fn write(&self, py: Python<'_>, path: PathBuf, table: &str) -> PyResult<()> {
        let kind = episodes::table_of(table)?;
        run(py, || self.inner.write(&path, kind))
    }

    /// For `copy` and `pickle`.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyType>, Arguments<'py>)> {
        let (py, this) = (slf.py(), slf.get());
        Ok((slf.get_type(), (this.metadata(py)?, this.columns.get(py, &this.inner.episodes)?.clone())))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::text(slf, "recording_card")
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf, "recording_card")
    }
}
