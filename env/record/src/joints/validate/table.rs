//! Validation of the table of one episode.

use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::joints::columns::{check_title, title};
use crate::joints::drive::EffortSource;
use crate::joints::metadata::JointMetadata;
use crate::validate::cells;

pub(super) fn check(episode: &Episode, metadata: &JointMetadata) -> Result<(), Error> {
    let joints = &metadata.mechanism.joints;
    cells::check_columns(episode, &|title| check_title(title, joints))?;
    cells::check_numbers(episode)?;
    cells::check_rows(episode)?;
    for joint in joints {
        check_positions(episode, joint)?;
        check_switch(episode, joint)?;
        check_gain(episode, joint, metadata)?;
    }
    Ok(())
}

fn check_positions(episode: &Episode, joint: &str) -> Result<(), Error> {
    let column = title("q", joint);
    let place = Place::episode(&episode.name).column(&column);
    match (episode.columns.contains_key(&column), episode.joint_stream("q", joint)) {
        (true, Some(_)) => Ok(()),
        (true, None) => Err(Fault::NoPosition.at(place)),
        (false, _) => {
            let reason = format!("the positions of joint {joint} in rad or m are needed");
            Err(Fault::MissingColumn { reason }.at(place))
        }
    }
}

fn check_switch(episode: &Episode, joint: &str) -> Result<(), Error> {
    let column = title("on", joint);
    let cells = episode.columns.get(&column);
    let is_other = |cell: &f64| !cell.is_nan() && *cell != 0.0 && *cell != 1.0;
    match cells.and_then(|cells| Some((cells.iter().position(is_other)?, cells))) {
        None => Ok(()),
        Some((row, cells)) => Err(Fault::Value {
            value: cells[row].to_string(),
            problem: "is neither 0 nor 1",
            remedy: "write 1 while the drive is on, 0 while it is off, and leave the cell empty where there is no sample",
        }
        .at(Place::episode(&episode.name).row(row + 1).column(&column))),
    }
}

/// A current or voltage needs a gain. Magnitudes are never used as an effort and need none.
fn check_gain(episode: &Episode, joint: &str, metadata: &JointMetadata) -> Result<(), Error> {
    let effort = metadata.effort_of(&episode.name, joint);
    let unit = match effort.source {
        EffortSource::Measured | EffortSource::Commanded => return Ok(()),
        EffortSource::Current => "\"current\"",
        EffortSource::Voltage => "\"voltage\"",
    };
    let is_used = effort.signed && episode.columns.contains_key(&title("effort", joint));
    if !is_used || metadata.has_gain(&episode.name, joint) {
        return Ok(());
    }
    Err(Fault::Value {
        value: format!("the source {unit} of joint {joint} in episode {}", episode.name),
        problem: "has no gain",
        remedy: "set effort.gain in N m or N per recorded unit, or gain = \"free\" to estimate it",
    }
    .at(Place::field("effort.gain")))
}
