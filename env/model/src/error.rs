//! Errors of models.

use std::fmt;

use thiserror::Error;

/// A motion that diverges, and the likely cause.
#[derive(Clone, Debug, PartialEq)]
pub struct NotFinite {
    /// Time since the start of the motion, s.
    pub at: f64,
    /// Name, value and unit of the most extreme parameter; `None` if no value is extreme.
    pub parameter: Option<(String, f64, &'static str)>,
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the motion is not finite after {:.3} s", self.at)?;
        match &self.parameter {
            Some((name, value, unit)) => {
                write!(f, ": {name} = {value} {unit} is extreme: choose a smaller effect")
            }
            None => f.write_str(": no parameter is extreme; reduce the applied wrench or the velocity"),
        }
    }
}

/// Errors when a model is built or read.
#[derive(Debug, Error, PartialEq)]
pub enum ModelError {
    /// The mass is not a positive number.
    #[error("body.mass = {0}: must be positive and finite (kg)")]
    Mass(f64),
    /// The shape has no area.
    #[error(
        "the footprint has no area: give at least three corners that are not collinear (m, object frame)"
    )]
    NoArea,
    /// A kind that is not in the catalogue.
    #[error("effect {index}: unknown kind `{kind}`; choose from {known}")]
    UnknownKind {
        /// Position in the file, from 1.
        index: usize,
        /// As written.
        kind: String,
        /// Known kinds.
        known: String,
    },
    /// A key that is not a parameter of the effect.
    #[error("effect {index} (`{kind}`): unknown key `{key}`; choose from {known}")]
    UnknownParameter {
        /// Position in the file, from 1.
        index: usize,
        /// Kind of the effect.
        kind: &'static str,
        /// As written.
        key: String,
        /// Parameters of the effect.
        known: String,
    },
    /// A value outside its bounds.
    #[error("{name} = {value}: must lie in [{lower}, {upper}] {unit}")]
    OutOfBounds {
        /// Full name, `effect.parameter`.
        name: String,
        /// As given.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A motion that is not finite.
    #[error("{0}")]
    NotFinite(NotFinite),
    /// A list of the wrong length.
    #[error("{what}: got {got} values, expected {expected}")]
    Length {
        /// Name of the list.
        what: &'static str,
        /// Its length.
        got: usize,
        /// Expected length.
        expected: usize,
    },
    /// Too many inner states.
    #[error("the effects have {got} inner states in total, at most {max} are supported: remove an effect")]
    TooManyInnerStates {
        /// Inner states of all effects.
        got: usize,
        /// Largest number of inner states.
        max: usize,
    },
    /// A prior that cannot be used.
    #[error("{file}: {place}: {problem}")]
    Prior {
        /// Name of the prior file.
        file: String,
        /// The parameter, as `table.key`.
        place: String,
        /// Problem, with the value and the remedy.
        problem: String,
    },
    /// A file that is not a valid model.
    #[error("{0}")]
    Format(String),
}
