//! Recordings in Python.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyIterator, PyString, PyType};
use trundle_record::{Metadata, Recording, Table};

use crate::error::{refused, run};
use crate::{columns, display, toml_dict};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyRecording>()?;
    module.add_function(wrap_pyfunction!(_replace_folder, module)?)?;
    module.add_function(wrap_pyfunction!(_recover_folder, module)?)?;
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
    /// Arrays by episode and column, created on first access.
    columns: PyOnceLock<Py<PyDict>>,
}

/// `trundle.episode.Episode`.
static EPISODE: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The class, and the arguments that create an equal recording.
type Reduced<'py> = (Bound<'py, PyType>, (Bound<'py, PyDict>, Bound<'py, PyDict>));

impl PyRecording {
    pub(crate) fn wrap(recording: Recording) -> Self {
        Self { inner: Arc::new(recording), columns: PyOnceLock::new() }
    }

    /// Columns by episode and column name.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyDict>> {
        let whole = self.columns.get_or_try_init(py, || {
            let dict = PyDict::new(py);
            for episode in &self.inner.episodes {
                dict.set_item(&episode.name, columns::to_dict(py, episode)?)?;
            }
            Ok::<_, PyErr>(dict.unbind())
        })?;
        Ok(whole.bind(py))
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
///
/// Examples
/// --------
/// >>> recording.write("recordings_run_3")
/// >>> len(trundle.read("recordings_run_3"))
/// 3
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

    /// The episodes by name, in chronological order, as a new dict.
    #[getter]
    fn episodes<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(slf.py());
        for episode in &slf.get().inner.episodes {
            dict.set_item(&episode.name, Self::__getitem__(slf, &episode.name)?)?;
        }
        Ok(dict)
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
        Self::__getitem__(slf, name)?.call_method0("frame")
    }

    /// Names of the episodes.
    fn keys(&self) -> Vec<&str> {
        self.inner.episodes.iter().map(|episode| episode.name.as_str()).collect()
    }

    /// The episodes.
    fn values<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        slf.get().keys().into_iter().map(|name| Self::__getitem__(slf, name)).collect()
    }

    /// Pairs of name and episode.
    fn items<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let pair = |name: &str| Ok((name.to_owned(), Self::__getitem__(slf, name)?));
        slf.get().keys().into_iter().map(pair).collect()
    }

    fn __len__(&self) -> usize {
        self.inner.episodes.len()
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> PyResult<bool> {
        match name.cast::<PyString>() {
            Ok(name) => Ok(self.keys().contains(&name.to_cow()?.as_ref())),
            Err(_) => Ok(false),
        }
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.keys().into_pyobject(py)?.try_iter()
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let (py, this) = (slf.py(), slf.get());
        let Some(columns) = this.columns(py)?.get_item(name)? else {
            let known = this.keys().join(", ");
            return Err(refused(format!("{name:?} is no episode of {}; there are: {known}", this.name())));
        };
        EPISODE.import(py, "trundle.episode", "Episode")?.call1((slf, name, columns))
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
        Ok((slf.get_type(), (this.metadata(py)?, this.columns(py)?.clone())))
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
