//! Columns of recordings of joints: `STREAM_JOINT`.

use crate::fault::Fault;

/// Prefixes of the columns, in the order in which they are written.
pub(crate) const STREAMS: [&str; 7] = ["q", "v", "effort", "target", "known", "on", "load"];

/// Rank of a column by its stream, for the order of columns in a table.
pub(crate) fn stream_rank(title: &str) -> usize {
    let stream = title.split_once('_').map_or(title, |(stream, _)| stream);
    STREAMS.iter().position(|known| *known == stream).unwrap_or(STREAMS.len())
}

/// Title of the column of `stream` and `joint`.
pub(crate) fn title(stream: &str, joint: &str) -> String {
    format!("{stream}_{joint}")
}

/// Refuses a title that is not a stream of one of `joints`.
pub(crate) fn check_title(title: &str, joints: &[String]) -> Result<(), Fault> {
    let is_known = title.split_once('_').is_some_and(|(stream, joint)| {
        STREAMS.contains(&stream) && joints.iter().any(|known| known == joint)
    });
    if is_known {
        return Ok(());
    }
    let streams = STREAMS.map(|stream| format!("{stream}_JOINT")).join(", ");
    let known = format!("t, {streams}, where JOINT is one of mechanism.joints: {}", joints.join(", "));
    Err(Fault::unknown_column(title, known))
}
