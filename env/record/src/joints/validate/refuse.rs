//! Errors about values of the metadata.

use crate::error::{Error, Place};
use crate::fault::Fault;

/// The error of the invalid `value` of `key`.
pub(super) fn refuse(
    key: &str,
    value: String,
    problem: &'static str,
    remedy: &'static str,
) -> Result<(), Error> {
    Err(Fault::Value { value, problem, remedy }.at(Place::field(key)))
}
