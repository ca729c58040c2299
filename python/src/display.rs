//! Representations of native objects, which `trundle.display` formats.

use pyo3::prelude::*;

const MODULE: &str = "trundle.display.native";

/// The text for `__repr__`; `card` is a function of `trundle.display.native`.
pub(crate) fn text<T>(object: &Bound<'_, T>, card: &str) -> PyResult<String> {
    show(object, card, "text")
}

/// The HTML for `_repr_html_`.
pub(crate) fn html<T>(object: &Bound<'_, T>, card: &str) -> PyResult<String> {
    show(object, card, "html")
}

fn show<T>(object: &Bound<'_, T>, card: &str, form: &str) -> PyResult<String> {
    object.py().import(MODULE)?.call_method1(card, (object.as_any(),))?.call_method0(form)?.extract()
}
