//! Faults of recordings. Each message contains the offending value and the remedy.

use crate::escaped::Escaped;

/// What is wrong with a recording.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// A file operation failed.
    #[error("cannot be {action}: {source}")]
    Io {
        /// Past participle of the operation: "read", "written", "listed" or "recovered".
        action: &'static str,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The path is not the folder of a recording.
    #[error(
        "{problem}; a recording is a folder with recording.toml and one table per episode (NAME.csv or NAME.parquet)"
    )]
    NotARecording {
        /// What the path is instead.
        problem: &'static str,
    },
    /// An episode has two tables.
    #[error("the folder also contains {}; keep one table per episode", Escaped(other))]
    TwoTables {
        /// File name of the other table.
        other: String,
    },
    /// The episode's name cannot be used as a file name.
    #[error(
        "{name:?} is not a valid episode name; use letters, digits, spaces, '_', '-' or '.', and do not start with '.'"
    )]
    EpisodeName {
        /// The invalid name.
        name: String,
    },
    /// Two episodes have the same name.
    #[error(
        "two episodes have this name; give each episode its own name (the names define the order of the episodes)"
    )]
    EpisodeTwice,
    /// The file is not valid TOML.
    #[error("line {line}: invalid TOML: {message}")]
    Syntax {
        /// Line of the file, counted from 1.
        line: usize,
        /// Message of the parser.
        message: String,
    },
    /// The document has the other format.
    #[error("{format:?} is the format of {what}; read it with {reader}")]
    OtherFormat {
        /// The stated format.
        format: &'static str,
        /// What has this format.
        what: &'static str,
        /// What reads it.
        reader: &'static str,
    },
    /// A key is unknown or missing, or its value has the wrong type.
    #[error("{message}")]
    Key {
        /// The key and what was expected.
        message: String,
    },
    /// A key has an invalid value.
    #[error("{value} {problem}; {remedy}")]
    Value {
        /// The invalid value.
        value: String,
        /// Why it is invalid, as a predicate.
        problem: &'static str,
        /// What to write instead.
        remedy: &'static str,
    },
    /// A document that a model includes is invalid.
    #[error("the model includes {path:?}: {fault}")]
    Included {
        /// Path of the included document inside the folder.
        path: String,
        /// What is wrong with it.
        fault: Box<Fault>,
    },
    /// A list of corners is not a simple polygon.
    #[error("{problem}; list the corners of a simple polygon in order: at least three, all different")]
    Polygon {
        /// The edges or corners at fault.
        problem: String,
    },
    /// `raw = true` in axes in which the sensor's offset is not constant.
    #[error(
        "raw = true requires frame = \"sensor\", not \"{frame}\": the offset and the gripper's weight can only be subtracted in sensor axes; record in sensor axes, or subtract both and set raw = false"
    )]
    RawFrame {
        /// The stated frame.
        frame: &'static str,
    },
    /// An interval without contact is missing or invalid.
    #[error("{reason}; give [start, end] in seconds of the table's time, while nothing touches the gripper")]
    Precontact {
        /// The episode or the interval, and the problem.
        reason: String,
    },
    /// A key refers to an episode that does not exist.
    #[error("{name:?} is not an episode of this recording; the episodes are: {known}")]
    NoSuchEpisode {
        /// The unknown name.
        name: String,
        /// The names of the episodes.
        known: String,
    },
    /// The recording has no training episode.
    #[error("{problem}, so there is no episode to fit; {remedy}")]
    NothingToFit {
        /// Why there is none.
        problem: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// The format does not define this column.
    #[error(
        "unknown column; rename it to note_{} to keep it as a note, or to a column of the format ({known})",
        Escaped(name)
    )]
    UnknownColumn {
        /// Name of the column.
        name: String,
        /// The columns of the format.
        known: String,
    },
    /// Two columns have the same name.
    #[error("the column appears twice; remove one of the two")]
    DuplicateColumn,
    /// A column that the metadata or the other columns require is missing.
    #[error("the column is missing; add it: {reason}")]
    MissingColumn {
        /// Why it is required.
        reason: String,
    },
    /// A required stream has no sample.
    #[error(
        "the episode has no {stream} sample, but {reason}; fill the columns of the {stream}, or remove the episode"
    )]
    MissingStream {
        /// "object", "gripper" or "wrench".
        stream: &'static str,
        /// Why it is required.
        reason: &'static str,
    },
    /// A joint has no position.
    #[error("the column is empty; fill in the positions of the joint, or remove the episode")]
    NoPosition,
    /// The table has no rows.
    #[error("the table has no rows; export it again, or remove the file")]
    NoRows,
    /// A column and `t` differ in length.
    #[error(
        "the column has {found} cells, but t has {expected}; give one cell per time, empty (NaN) where there is no sample"
    )]
    Length {
        /// Cells in the column.
        found: usize,
        /// Cells in `t`.
        expected: usize,
    },
    /// A row and the header differ in length.
    #[error(
        "the row has {found} cells, but the header has {expected}; give every column a cell, empty where there is no sample"
    )]
    Ragged {
        /// Cells in the row.
        found: usize,
        /// Columns in the header.
        expected: usize,
    },
    /// The text is not UTF-8.
    #[error("the text is not UTF-8; save it as UTF-8")]
    Encoding,
    /// A cell is not a number.
    #[error(
        "{value:?} is not a number; write numbers like -1.5e-3, or leave the cell empty where there is no sample"
    )]
    NotANumber {
        /// The cell.
        value: String,
    },
    /// A cell is infinite.
    #[error("the value {value} is infinite; leave the cell empty where there is no sample")]
    Infinite {
        /// The cell.
        value: f64,
    },
    /// A row has no time.
    #[error("the cell is empty; give every row a time in seconds")]
    NoTime,
    /// The times do not increase strictly.
    #[error("time {value} s does not follow {previous} s; sort the rows by time, and keep one row per time")]
    NotIncreasing {
        /// Time of this row, s.
        value: f64,
        /// Time of the previous row, s.
        previous: f64,
    },
    /// A row fills only some of the columns of a stream.
    #[error(
        "the cell is empty, but {other} = {value}; in each row fill all of {columns} or none, and remove columns that are not measured"
    )]
    HalfSample {
        /// The stream.
        stream: &'static str,
        /// A column of the stream that the row fills.
        other: String,
        /// Its value.
        value: f64,
        /// All columns of the stream.
        columns: String,
    },
    /// A row has no sample.
    #[error("the row at t = {t} s has no sample of any stream; remove the row")]
    EmptyRow {
        /// Time of the row, s.
        t: f64,
    },
    /// A quaternion is not a unit quaternion.
    #[error(
        "the quaternion [w, x, y, z] = {value:?} has norm {length:.6}, not 1; normalise it, and check the order w, x, y, z"
    )]
    NotUnit {
        /// w, x, y, z.
        value: [f64; 4],
        /// Its norm.
        length: f64,
    },
    /// A Parquet file cannot be decoded.
    #[error(
        "not a readable Parquet file: {message}; export it again (uncompressed, snappy, gzip, lz4 or zstd)"
    )]
    Parquet {
        /// Message of the decoder.
        message: String,
    },
    /// A table unpacks to more memory than the limit.
    #[error(
        "the table unpacks to more than {limit} MiB, the limit for this recording ({base} MiB plus {factor} times the size of its tables); store it without compression or as CSV"
    )]
    TooLarge {
        /// Limit for this recording, MiB.
        limit: u64,
        /// Part of the limit that does not depend on the size, MiB.
        base: u64,
        /// Part of the limit as a multiple of the size of the tables.
        factor: u64,
    },
    /// A Parquet column has an unsupported type.
    #[error("the column contains {found}; store it as float64 (times in seconds)")]
    ColumnType {
        /// The type, as a plural noun.
        found: String,
    },
    /// Writing would overwrite something that is not a recording.
    #[error("already exists and {problem}; choose another path, or move it")]
    Occupied {
        /// Why it must not be replaced, as a predicate.
        problem: String,
    },
    /// The recording is valid but cannot be prepared.
    #[error("{reason}; {remedy}")]
    Unusable {
        /// What is missing or contradictory, with its numbers.
        reason: String,
        /// How to correct the recording.
        remedy: String,
    },
}

impl Fault {
    /// The fault of a column `name` that is none of `known`.
    pub(crate) fn unknown_column(name: &str, known: String) -> Self {
        Self::UnknownColumn { name: name.to_owned(), known }
    }
}
