//! Checks of the data of a regression.

use super::error::BaselineError;
use super::transitions::Transition;

/// Checks that the data are not empty and all numbers are finite.
pub(crate) fn check(data: &[Transition]) -> Result<(), BaselineError> {
    if data.is_empty() {
        return Err(BaselineError::Empty);
    }
    for (index, t) in data.iter().enumerate() {
        let value = |what: &str, value, remedy| BaselineError::Value {
            name: format!("transition {index}: {what}"),
            value,
            remedy,
        };
        if !(t.dt.is_finite() && t.dt > 0.0) {
            return Err(value("dt", t.dt, "must be positive (s)"));
        }
        let parts =
            [("state before", &t.before[..]), ("wrench", &t.wrench[..]), ("state after", &t.after[..])];
        for (what, numbers) in parts {
            if let Some(&bad) = numbers.iter().find(|v| !v.is_finite()) {
                return Err(value(what, bad, "must be finite; leave the transition out"));
            }
        }
    }
    Ok(())
}
