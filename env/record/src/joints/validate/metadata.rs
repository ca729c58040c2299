//! Validation of the values of the metadata.

use super::refuse::refuse;
use super::{mechanism, values};
use crate::error::Error;
use crate::joints::metadata::{JOINT_FORMAT, JointMetadata};
use crate::validate::is_printable;

/// Checks all values that do not depend on the tables and models.
pub(crate) fn check_metadata(metadata: &JointMetadata) -> Result<(), Error> {
    check_header(&metadata.format, &metadata.name)?;
    mechanism::check(&metadata.mechanism)?;
    values::check(metadata)
}

fn check_header(format: &str, name: &str) -> Result<(), Error> {
    if format != JOINT_FORMAT {
        let remedy = "set format = \"trundle-recording/2\"";
        return refuse("format", format!("{format:?}"), "is not a supported format", remedy);
    }
    if !name.chars().all(is_printable) {
        let problem = "contains control or invisible characters";
        let remedy = "use one line of letters, digits, spaces and punctuation";
        return refuse("name", format!("{name:?}"), problem, remedy);
    }
    Ok(())
}
