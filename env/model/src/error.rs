//! What can be wrong with a model.

use std::fmt;

use thiserror::Error;

use crate::model::{Model, Slot};

/// A motion that leaves the range of numbers, and the parameter to look at first.
#[derive(Clone, Debug, PartialEq)]
pub struct NotFinite {
    /// When, s after its beginning.
    pub at: f64,
    /// Name, value and unit of the parameter; none where no value is far off.
    pub parameter: Option<(String, f64, &'static str)>,
}

impl NotFinite {
    /// The motion of this model is not finite from a time on, s after its beginning.
    pub fn of(model: &Model, at: f64) -> Self {
        let named = |slot: Slot| Some((slot.name, slot.value?, slot.unit));
        Self { at, parameter: model.most_extreme().and_then(named) }
    }
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the motion is not finite after {:.3} s", self.at)?;
        match &self.parameter {
            Some((name, value, unit)) => {
                write!(f, ": {name} = {value} {unit} is far from what is usual: choose a smaller effect")
            }
            None => {
                f.write_str(": no parameter is far from what is usual; lower the applied wrench or velocity")
            }
        }
    }
}

/// Why a model cannot be built or read.
#[derive(Debug, Error, PartialEq)]
pub enum ModelError {
    /// The mass is not a positive number.
    #[error("body.mass = {0}: a mass must be positive and finite (kg)")]
    Mass(f64),
    /// The shape encloses nothing.
    #[error(
        "the footprint encloses no area: give at least three corners that are not in a line (m, object frame)"
    )]
    NoArea,
    /// Not in the catalogue.
    #[error("effect {index}: unknown kind `{kind}`; known are {known}")]
    UnknownKind {
        /// Position in the file, from 1.
        index: usize,
        /// As written.
        kind: String,
        /// All kinds.
        known: String,
    },
    /// Not a parameter of this effect.
    #[error("effect {index} (`{kind}`): unknown key `{key}`; its parameters are {known}")]
    UnknownParameter {
        /// Position in the file, from 1.
        index: usize,
        /// The effect.
        kind: &'static str,
        /// As written.
        key: String,
        /// The parameters that it has.
        known: String,
    },
    /// A value outside its bounds.
    #[error("{name} = {value}: must lie in [{lower}, {upper}] {unit}")]
    OutOfBounds {
        /// Full name, `effect.parameter`.
        name: String,
        /// As given.
        value: f64,
        /// Smallest legal value.
        lower: f64,
        /// Largest legal value.
        upper: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A motion that is not finite.
    #[error("{0}")]
    NotFinite(NotFinite),
    /// Two lists that must have the same length do not.
    #[error("{what}: {got} values where {expected} are needed")]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length it must have.
        expected: usize,
    },
    /// Too many laws with states of their own.
    #[error("the effects have {got} inner states together, and {max} is the most: leave one out")]
    TooManyInnerStates {
        /// Inner states of all effects.
        got: usize,
        /// As many as there may be.
        max: usize,
    },
    /// A prior that cannot be used.
    #[error("{file}: {place}: {problem}")]
    Prior {
        /// The prior file.
        file: String,
        /// The parameter, as `table.key`.
        place: String,
        /// What is wrong, with the value and the remedy.
        problem: String,
    },
    /// The file is not a model.
    #[error("{0}")]
    Format(String),
}
