//! Recordings of joints in Python.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyIterator, PyType};
use trundle_record::{Episode, JointMetadata, JointRecording};

use crate::episodes::{EpisodeColumns, RecordingClass};
use crate::error::{refused, run};
use crate::{display, episodes, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyJointRecording>()
}

/// A recording of a mechanism with hinge and slide joints: metadata, episodes, and the documents of its models.
///
/// A recording is validated when it is created, and is immutable. It is a mapping of names to episodes, in
/// chronological order, as `Recording`.
///
/// Parameters
/// ----------
/// metadata : Mapping
///     Content of ``recording.toml`` (format ``trundle-recording/2``).
/// episodes : Mapping of str to Mapping of str to array_like, or to pandas.DataFrame
///     Columns by episode name and column name: one-dimensional float64 in SI units, NaN for an empty cell. A column
///     is ``t`` or ``STREAM_JOINT``, such as ``q_elbow``. Columns whose names begin with ``note_`` contain text.
/// files : Mapping of str to str or bytes
///     Content of the MJCF or URDF documents by their paths inside the folder, such as ``robot.xml``.
///
/// Raises
/// ------
/// TrundleError
///     If the recording is invalid. The message names the place and the remedy.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> t = np.arange(0.0, 2.0, 0.01)
/// >>> metadata = {
/// ...     "format": "trundle-recording/2",
/// ...     "name": "bench",
/// ...     "mechanism": {"axis": "hinge", "joints": ["arm"]},
/// ... }
/// >>> bench = trundle.JointRecording(metadata, {"sine": {"t": t, "q_arm": np.sin(t), "effort_arm": np.cos(t)}})
/// >>> bench["sine"].stream("q", "arm")[1].shape
/// (200,)
#[pyclass(name = "JointRecording", module = "trundle", frozen)]
pub(crate) struct PyJointRecording {
    pub(crate) inner: Arc<JointRecording>,
    columns: EpisodeColumns,
}

impl RecordingClass for PyJointRecording {
    const EPISODE: (&'static str, &'static str) = ("trundle.joint_episode", "JointEpisode");

    fn name(&self) -> &str {
        &self.inner.metadata.name
    }

    fn episodes(&self) -> &[Episode] {
        &self.inner.episodes
    }

    fn columns(&self) -> &EpisodeColumns {
        &self.columns
    }
}

/// Arguments that create an equal recording.
type Arguments<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyDict>);

impl PyJointRecording {
    pub(crate) fn wrap(recording: JointRecording) -> Self {
        Self { inner: Arc::new(recording), columns: EpisodeColumns::new() }
    }
}

/// Documents by path; text is encoded as UTF-8.
fn documents(files: Option<&Bound<'_, PyAny>>) -> PyResult<BTreeMap<String, Vec<u8>>> {
    let mut found = BTreeMap::new();
    let Some(files) = files else { return Ok(found) };
    for item in files.call_method0("items")?.try_iter()? {
        let (path, content): (String, Bound<'_, PyAny>) = item?.extract()?;
        let bytes = match content.extract::<String>() {
            Ok(text) => text.into_bytes(),
            Err(_) => content
                .cast::<PyBytes>()
                .map_err(|_| {
                    refused(format!("files[{path:?}]: give the content of the document as str or bytes"))
                })?
                .as_bytes()
                .to_vec(),
        };
        found.insert(path, bytes);
    }
    Ok(found)
}

#[pymethods]
impl PyJointRecording {
    #[new]
    #[pyo3(signature = (metadata, episodes, files = None))]
    fn new(
        metadata: &Bound<'_, PyAny>,
        episodes: &Bound<'_, PyAny>,
        files: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let metadata =
            JointMetadata::from_table(toml_dict::from_dict(metadata, "metadata")?).map_err(refused)?;
        let (tables, files) = (episodes::from_mapping(episodes)?, documents(files)?);
        run(episodes.py(), || JointRecording::new(metadata, tables, files)).map(Self::wrap)
    }

    /// Name of the recording.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.metadata.name
    }

    /// Names of the recorded joints.
    #[getter]
    fn joints(&self) -> Vec<&str> {
        self.inner.metadata.mechanism.joints.iter().map(String::as_str).collect()
    }

    /// Content of ``recording.toml`` as a new dict.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        toml_dict::to_dict(py, &self.inner.metadata.to_table().map_err(refused)?)
    }

    /// Documents of the models by their paths inside the folder, as a new dict of bytes.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (path, content) in &self.inner.files {
            dict.set_item(path, PyBytes::new(py, content))?;
        }
        Ok(dict)
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

    /// Write the recording as a folder with the documents of its models, atomically.
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
        let columns = this.columns.get(py, &this.inner.episodes)?.clone();
        Ok((slf.get_type(), (this.metadata(py)?, columns, this.files(py)?)))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::text(slf, "joint_recording_card")
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf, "joint_recording_card")
    }
}
