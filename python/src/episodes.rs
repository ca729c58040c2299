//! Episodes of a recording as Python objects, which both classes of recordings share.

use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyIterator, PyString, PyType};
use trundle_record::{Episode, Table};

use crate::columns;
use crate::error::refused;

/// Arrays by episode and column, created on first access.
pub(crate) struct EpisodeColumns(PyOnceLock<Py<PyDict>>);

impl EpisodeColumns {
    pub fn new() -> Self {
        Self(PyOnceLock::new())
    }

    /// Columns by episode and column name.
    pub fn get<'py>(&self, py: Python<'py>, episodes: &[Episode]) -> PyResult<&Bound<'py, PyDict>> {
        let whole = self.0.get_or_try_init(py, || {
            let dict = PyDict::new(py);
            for episode in episodes {
                dict.set_item(&episode.name, columns::to_dict(py, episode)?)?;
            }
            Ok::<_, PyErr>(dict.unbind())
        })?;
        Ok(whole.bind(py))
    }
}

/// A Python class of recordings.
pub(crate) trait RecordingClass: PyClass {
    /// Module and name of the class of its episodes.
    const EPISODE: (&'static str, &'static str);

    /// Display name.
    fn name(&self) -> &str;

    /// The episodes in chronological order.
    fn episodes(&self) -> &[Episode];

    /// Arrays of the episodes.
    fn columns(&self) -> &EpisodeColumns;
}

/// Names of the episodes.
pub(crate) fn keys<R: RecordingClass>(this: &R) -> Vec<&str> {
    this.episodes().iter().map(|episode| episode.name.as_str()).collect()
}

/// One episode.
///
/// # Errors
/// `TrundleError` if there is no such episode.
pub(crate) fn item<'py, R: RecordingClass>(slf: &Bound<'py, R>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let (py, this) = (slf.py(), slf.borrow());
    let Some(columns) = this.columns().get(py, this.episodes())?.get_item(name)? else {
        let known = keys(&*this).join(", ");
        return Err(refused(format!("{name:?} is no episode of {}; there are: {known}", this.name())));
    };
    let (module, class) = R::EPISODE;
    py.import(module)?.getattr(class)?.cast_into::<PyType>()?.call1((slf, name, columns))
}

/// Pairs of name and episode.
pub(crate) fn items<'py, R: RecordingClass>(
    slf: &Bound<'py, R>,
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let names: Vec<String> = keys(&*slf.borrow()).into_iter().map(str::to_owned).collect();
    names.into_iter().map(|name| item(slf, &name).map(|episode| (name, episode))).collect()
}

/// The episodes by name, as a new dict.
pub(crate) fn dict<'py, R: RecordingClass>(slf: &Bound<'py, R>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(slf.py());
    items(slf)?.into_iter().try_for_each(|(name, episode)| dict.set_item(name, episode))?;
    Ok(dict)
}

/// Whether there is an episode of this name; false for other objects.
pub(crate) fn contains<R: RecordingClass>(this: &R, name: &Bound<'_, PyAny>) -> PyResult<bool> {
    match name.cast::<PyString>() {
        Ok(name) => Ok(keys(this).contains(&name.to_cow()?.as_ref())),
        Err(_) => Ok(false),
    }
}

/// An iterator over the names.
pub(crate) fn iterate<'py, R: RecordingClass>(py: Python<'py>, this: &R) -> PyResult<Bound<'py, PyIterator>> {
    keys(this).into_pyobject(py)?.try_iter()
}

/// Episodes from a mapping of names to columns or data frames.
pub(crate) fn from_mapping(episodes: &Bound<'_, PyAny>) -> PyResult<Vec<Episode>> {
    let mut tables = Vec::new();
    for item in episodes.call_method0("items")?.try_iter()? {
        let (name, table): (String, Bound<'_, PyAny>) = item?.extract()?;
        tables.push(columns::from_mapping(&name, &table)?);
    }
    Ok(tables)
}

/// The format of tables of this name.
pub(crate) fn table_of(name: &str) -> PyResult<Table> {
    let found = Table::ALL.into_iter().find(|table| table.extension() == name);
    found.ok_or_else(|| refused(format!("table = {name:?}: choose \"csv\" or \"parquet\"")))
}
