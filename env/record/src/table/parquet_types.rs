//! Supported Parquet types, and the interpretation of integers.

use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::schema::types::ColumnDescriptor;

use crate::fault::Fault;

/// Interpretation of the integers of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Content {
    /// Signed, or not an integer.
    Plain,
    /// Unsigned, stored in the bits of a signed integer.
    Unsigned,
}

impl Content {
    pub(super) fn int32(self, value: i32) -> f64 {
        match self {
            Self::Plain => f64::from(value),
            Self::Unsigned => f64::from(value.cast_unsigned()),
        }
    }

    pub(super) fn int64(self, value: i64) -> f64 {
        match self {
            Self::Plain => value as f64,
            Self::Unsigned => value.cast_unsigned() as f64,
        }
    }

    /// Exact decimal text, also for integers beyond 2^53.
    pub(super) fn int64_text(self, value: i64) -> String {
        match self {
            Self::Plain => value.to_string(),
            Self::Unsigned => value.cast_unsigned().to_string(),
        }
    }
}

/// Determines the interpretation of a column.
///
/// # Errors
/// If the column contains dates, durations, decimals, lists or structures, or if a number column contains text.
pub(super) fn content(column: &ColumnDescriptor, note: bool) -> Result<Content, Fault> {
    let refused = |found: String| Err(Fault::ColumnType { found });
    if column.path().parts().len() > 1 || column.max_rep_level() > 0 {
        return refused("lists or structures".to_owned());
    }
    let physical = column.physical_type();
    let number = matches!(physical, Physical::DOUBLE | Physical::FLOAT | Physical::INT32 | Physical::INT64);
    if !number && !note {
        return refused(match column.logical_type_ref() {
            Some(logical) => format!("{logical:?} values"),
            None => format!("{physical} values"),
        });
    }
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Integer(integer)), _) if !integer.is_signed => Ok(Content::Unsigned),
        (Some(LogicalType::Integer(_) | LogicalType::Unknown), _) => Ok(Content::Plain),
        (Some(LogicalType::String | LogicalType::Enum | LogicalType::Json), _) if note => Ok(Content::Plain),
        (Some(other), _) => refused(format!("{other:?} values")),
        (None, unsigned) if UNSIGNED.contains(&unsigned) => Ok(Content::Unsigned),
        (None, plain) if PLAIN.contains(&plain) || note => Ok(Content::Plain),
        (None, other) => refused(format!("{other} values")),
    }
}

/// Legacy type annotations of older writers.
const UNSIGNED: [ConvertedType; 4] =
    [ConvertedType::UINT_8, ConvertedType::UINT_16, ConvertedType::UINT_32, ConvertedType::UINT_64];
const PLAIN: [ConvertedType; 5] = [
    ConvertedType::NONE,
    ConvertedType::INT_8,
    ConvertedType::INT_16,
    ConvertedType::INT_32,
    ConvertedType::INT_64,
];
