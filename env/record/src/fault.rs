//! Every way in which a recording is refused, with its value and the remedy.

use crate::episode::known_columns;
use crate::error::{Error, Place, Shown};

/// What is wrong, with the value that is, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The operating system said no.
    #[error("cannot be {action}: {source}")]
    Io {
        /// "read", "written" or "listed".
        action: &'static str,
        /// The reason.
        source: std::io::Error,
    },
    /// The path does not lead to a folder.
    #[error(
        "{problem}; a recording is a folder that holds recording.toml and one table per episode, NAME.csv or NAME.parquet"
    )]
    NotARecording {
        /// What is there instead.
        problem: &'static str,
    },
    /// Two tables for one episode.
    #[error("there is {} as well; keep one table per episode", Shown(other))]
    TwoTables {
        /// File name of the other.
        other: String,
    },
    /// The episode's name cannot be a file's name.
    #[error(
        "{name:?} is no name for an episode; use letters, digits, '_', '-' or '.', and begin with no '.'"
    )]
    EpisodeName {
        /// As given.
        name: String,
    },
    /// Two episodes of one name.
    #[error(
        "there are two episodes of this name; episodes happened in the order of their names, so each needs its own"
    )]
    EpisodeTwice,
    /// Not TOML.
    #[error("line {line}: {message}")]
    Syntax {
        /// Line of the file, from 1.
        line: usize,
        /// What the parser expected.
        message: String,
    },
    /// A key that is unknown, missing or of the wrong type.
    #[error("{message}")]
    Key {
        /// Which, and what is known.
        message: String,
    },
    /// A value that its key cannot have.
    #[error("{value} {problem}; {remedy}")]
    Value {
        /// As given.
        value: String,
        /// Why not.
        problem: &'static str,
        /// What to write.
        remedy: &'static str,
    },
    /// An outline that encloses no single region.
    #[error("{problem}; list the corners of a simple polygon in order, at least three, none twice")]
    Polygon {
        /// Which edges or corners.
        problem: String,
    },
    /// `raw` in axes in which a sensor's offset is not constant.
    #[error(
        "raw = true with frame = \"{frame}\": offset and weight can be taken off in the sensor's own axes alone; record with frame = \"sensor\", or take them off and set raw = false"
    )]
    RawFrame {
        /// The other frame.
        frame: &'static str,
    },
    /// An interval without contact is wrong.
    #[error("{reason}; give [start, end] in the table's time, s, where nothing touches")]
    Precontact {
        /// Which episode and which bound.
        reason: String,
    },
    /// A name that is no episode's.
    #[error("{name:?} is no episode of this recording; there are: {known}")]
    NoSuchEpisode {
        /// As given.
        name: String,
        /// The names of the episodes.
        known: String,
    },
    /// All episodes are held out, or there is none.
    #[error("{problem}, so nothing is left to fit; {remedy}")]
    NothingToFit {
        /// Why.
        problem: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A column that the format does not know.
    #[error(
        "unknown column; rename it note_{} to keep it uninterpreted, or use a column of the format ({known})",
        Shown(name)
    )]
    UnknownColumn {
        /// The column.
        name: String,
        /// What the format knows.
        known: String,
    },
    /// A header twice.
    #[error("the column appears twice; leave one of the two")]
    DuplicateColumn,
    /// A column that the metadata or the stream's other columns ask for.
    #[error("the column is missing; add it: {needed_by}")]
    MissingColumn {
        /// Who needs it.
        needed_by: String,
    },
    /// A stream of which there is no sample.
    #[error("no {stream} sample in this episode, but {needed_by}; fill its columns, or take the episode out")]
    MissingStream {
        /// "object", "gripper" or "wrench".
        stream: &'static str,
        /// Who needs it.
        needed_by: &'static str,
    },
    /// A table without rows.
    #[error("the table has no rows; take the episode out, or export it again")]
    NoRows,
    /// A column that is shorter or longer than `t`.
    #[error(
        "{found} cells where t has {expected}; give one for each time, empty (NaN) where there is no sample"
    )]
    Length {
        /// Cells in the column.
        found: usize,
        /// Cells in `t`.
        expected: usize,
    },
    /// A row of the wrong width.
    #[error(
        "{found} cells under a header of {expected}; give each column a cell, empty where there is no sample"
    )]
    Ragged {
        /// Cells in the row.
        found: usize,
        /// Columns.
        expected: usize,
    },
    /// Text that is not UTF-8.
    #[error("the text is not UTF-8; save it as UTF-8")]
    Encoding,
    /// A cell that is not a number.
    #[error(
        "{value:?} is not a number; write one like -1.5e-3, or leave the cell empty where there is no sample"
    )]
    NotANumber {
        /// The cell.
        value: String,
    },
    /// A cell that is infinite.
    #[error("the value {value} is infinite; leave the cell empty where there is no sample")]
    Infinite {
        /// The cell.
        value: f64,
    },
    /// A row without a time.
    #[error("the cell is empty; every row needs its time in seconds")]
    NoTime,
    /// Time stands still or runs back.
    #[error("time {value} s does not come after {previous} s; sort the rows and keep one for each time")]
    NotIncreasing {
        /// This row's time.
        value: f64,
        /// The row before's.
        previous: f64,
    },
    /// Some of a stream's cells are empty in a row, others not.
    #[error(
        "the cell is empty while {other} = {value}; fill all of {columns} in a row or none, and leave out a column that nothing measures"
    )]
    HalfSample {
        /// The stream.
        stream: &'static str,
        /// A filled column.
        other: String,
        /// Its value.
        value: f64,
        /// All its columns.
        columns: String,
    },
    /// A row without any sample.
    #[error("at t = {t} s the row holds no sample of any stream; leave the row out")]
    EmptyRow {
        /// The row's time.
        t: f64,
    },
    /// A quaternion that is no attitude.
    #[error(
        "the quaternion [w, x, y, z] = {value:?} has length {length:.6}, not 1; normalise it at its source, and check the order w, x, y, z"
    )]
    NotUnit {
        /// w, x, y, z.
        value: [f64; 4],
        /// Its length.
        length: f64,
    },
    /// A Parquet file that cannot be decoded.
    #[error(
        "not a readable Parquet file: {message}; export it again (uncompressed, snappy, gzip, lz4 or zstd)"
    )]
    Parquet {
        /// The decoder's reason.
        message: String,
    },
    /// A table that unpacks to more than it may.
    #[error(
        "unpacked it takes more than {limit} MiB, the limit for this recording ({base} MiB and {factor} times the size of its tables); store it without compression or as CSV"
    )]
    TooLarge {
        /// What the recording may take, MiB.
        limit: u64,
        /// What any recording may take, MiB.
        base: u64,
        /// How many times the size of its tables.
        factor: u64,
    },
    /// A Parquet column of a type that holds no numbers.
    #[error("the column holds {found}; store it as float64 (times in seconds)")]
    ColumnType {
        /// The type.
        found: String,
    },
    /// Writing would destroy something else.
    #[error("is already there and {problem}; choose another path, or move it away")]
    Occupied {
        /// What it is.
        problem: String,
    },
    /// The episode holds too little for what is asked of it.
    #[error("{reason}; {remedy}")]
    Unusable {
        /// What is missing or contradictory, with its figures.
        reason: String,
        /// What the person who records can do.
        remedy: String,
    },
}

impl Fault {
    /// A column of this name, which the format does not know.
    pub(crate) fn unknown_column(name: &str) -> Self {
        Self::UnknownColumn { name: name.to_owned(), known: known_columns().collect::<Vec<_>>().join(", ") }
    }

    /// This fault at the place where it is.
    pub fn at(self, place: Place) -> Error {
        Error { place: Box::new(place), fault: Box::new(self) }
    }
}
