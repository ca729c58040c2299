//! Recordings in Python.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};
use trundle_record::{Metadata, Recording, Table};

use crate::error::{refused, run};
use crate::{columns, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyRecording>()?;
    module.add_function(wrap_pyfunction!(_replace_folder, module)?)?;
    module.add_function(wrap_pyfunction!(_recover_folder, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)
}

/// A recording: metadata and episodes.
///
/// A recording is validated when it is created, and is immutable.
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
#[pyclass(name = "Recording", module = "trundle", frozen)]
pub(crate) struct PyRecording {
    inner: Arc<Recording>,
    /// Arrays, created on first access.
    episodes: PyOnceLock<Py<PyDict>>,
}

/// The class, and the arguments that create an equal recording.
type Reduced<'py> = (Bound<'py, PyType>, (Bound<'py, PyDict>, Bound<'py, PyDict>));

impl PyRecording {
    pub(crate) fn wrap(recording: Recording) -> Self {
        Self { inner: Arc::new(recording), episodes: PyOnceLock::new() }
    }
}

/// A recording, or the path of one.
pub(crate) fn recording_of(argument: &Bound<'_, PyAny>) -> PyResult<Arc<Recording>> {
    if let Ok(recording) = argument.cast::<PyRecording>() {
        return Ok(recording.get().inner.clone());
    }
    let path: PathBuf = argument.extract()?;
    run(argument.py(), || Recording::read(&path)).map(Arc::new)
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
/// Recording
///
/// Raises
/// ------
/// TrundleError
///     If the recording is invalid. The message names file, row, column, value and remedy.
#[pyfunction]
fn read(py: Python<'_>, path: PathBuf) -> PyResult<PyRecording> {
    run(py, || Recording::read(&path)).map(PyRecording::wrap)
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
        let mut tables = Vec::new();
        for item in episodes.call_method0("items")?.try_iter()? {
            let (name, table): (String, Bound<'_, PyAny>) = item?.extract()?;
            tables.push(columns::from_mapping(&name, &table)?);
        }
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

    /// Columns by episode name and column name. Episodes are in chronological order.
    ///
    /// Columns are read-only float64 arrays, NaN for an empty cell; ``note_`` columns are lists of strings.
    #[getter]
    fn episodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let whole = self.episodes.get_or_try_init(py, || {
            let dict = PyDict::new(py);
            for episode in &self.inner.episodes {
                dict.set_item(&episode.name, columns::to_dict(py, episode)?)?;
            }
            Ok::<_, PyErr>(dict.unbind())
        })?;
        let fresh = PyDict::new(py);
        for (name, episode) in whole.bind(py) {
            fresh.set_item(name, episode.cast::<PyDict>()?.copy()?)?;
        }
        Ok(fresh)
    }

    /// One episode as a data frame.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     The episode.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     A copy of the columns, ``t`` first.
    ///
    /// Raises
    /// ------
    /// TrundleError
    ///     If there is no such episode, or the extra `trundle[pandas]` is not installed.
    fn frame<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(episode) = self.episodes(py)?.get_item(name)? else {
            let known: Vec<&str> = self.inner.episodes.iter().map(|episode| episode.name.as_str()).collect();
            return Err(refused(format!(
                "{name:?} is no episode of {}; there are: {}",
                self.name(),
                known.join(", ")
            )));
        };
        let pandas =
            py.import("trundle._optional")?.call_method1("require", ("pandas", "pandas", "data frames"))?;
        pandas.call_method1("DataFrame", (episode,))
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
        let Some(kind) = Table::ALL.into_iter().find(|kind| kind.extension() == table) else {
            return Err(refused(format!("table = {table:?}: choose \"csv\" or \"parquet\"")));
        };
        run(py, || self.inner.write(&path, kind))
    }

    /// For `copy` and `pickle`.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let (py, this) = (slf.py(), slf.get());
        Ok((slf.get_type(), (this.metadata(py)?, this.episodes(py)?)))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __repr__(&self) -> String {
        format!("<trundle.Recording {:?}: {} episodes>", self.name(), self.inner.episodes.len())
    }
}
