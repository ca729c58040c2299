//! Validation of the metadata against the episodes.

use super::name::check_name;
use crate::episode::Episode;
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Precontact, Split};
use crate::recording::Recording;

pub(super) fn check(recording: &Recording) -> Result<(), Error> {
    let episodes = &recording.episodes;
    check_names(episodes)?;
    if let Some(Precontact::ByEpisode(table)) = &recording.metadata.wrench.precontact {
        table.keys().try_for_each(|name| known(episodes, name, "wrench.precontact"))?;
    }
    check_training(episodes, &recording.metadata.split)
}

/// Checks that all names of episodes are valid file names and different.
pub(crate) fn check_names(episodes: &[Episode]) -> Result<(), Error> {
    for (i, episode) in episodes.iter().enumerate() {
        check_name(&episode.name).map_err(|fault| fault.at(Place::episode(&episode.name)))?;
        if episodes[..i].iter().any(|earlier| earlier.name == episode.name) {
            return Err(Fault::EpisodeTwice.at(Place::episode(&episode.name)));
        }
    }
    Ok(())
}

/// Checks that the episode `name`, to which `key` refers, exists.
pub(crate) fn known(episodes: &[Episode], name: &str, key: &str) -> Result<(), Error> {
    if episodes.iter().any(|episode| episode.name == name) {
        return Ok(());
    }
    let known: Vec<&str> = episodes.iter().map(|episode| episode.name.as_str()).collect();
    Err(Fault::NoSuchEpisode { name: name.to_owned(), known: known.join(", ") }.at(Place::field(key)))
}

/// Checks that the held-out episodes exist, and that there is a training episode.
pub(crate) fn check_training(episodes: &[Episode], split: &Split) -> Result<(), Error> {
    split.held_out.iter().try_for_each(|name| known(episodes, name, "split.held_out"))?;
    let (problem, remedy, key) = if episodes.is_empty() {
        ("the recording has no episodes", "add a table NAME.csv or NAME.parquet", "")
    } else if episodes.iter().all(|episode| split.held_out.contains(&episode.name)) {
        ("every episode is held out", "remove at least one name from split.held_out", "split.held_out")
    } else {
        return Ok(());
    };
    Err(Fault::NothingToFit { problem, remedy }.at(Place::field(key)))
}

/// Checks the intervals without contact. A raw reading requires one with at least two samples in each episode.
pub(super) fn check_precontact(recording: &Recording) -> Result<(), Error> {
    let wrench = &recording.metadata.wrench;
    for episode in &recording.episodes {
        let reason = match wrench.precontact(&episode.name) {
            None if wrench.raw => Some(format!(
                "raw = true requires an interval without contact, but episode {} has none",
                episode.name
            )),
            None => None,
            Some([start, end]) if !(start < end && start.is_finite() && end.is_finite()) => {
                Some(format!("[{start}, {end}] is not an interval with start before end"))
            }
            Some(interval) if wrench.raw => too_few_readings(interval, episode),
            Some(_) => None,
        };
        if let Some(reason) = reason {
            return Err(Fault::Precontact { reason }.at(Place::field("wrench.precontact")));
        }
    }
    Ok(())
}

/// Why the mean over `[start, end]` cannot serve as the tare of `episode`; `None` if it can. The bounds may lie outside
/// the table, because streams may begin late.
fn too_few_readings([start, end]: [f64; 2], episode: &Episode) -> Option<String> {
    let readings = episode.wrench().map_or(Vec::new(), |wrench| wrench.t);
    let (first, last) = (*episode.t.first()?, *episode.t.last()?);
    match readings.iter().filter(|&&t| start <= t && t <= end).count() {
        count @ 0..2 => Some(format!(
            "[{start}, {end}] contains {count} wrench readings of episode {}, which lasts from {first} to {last} s; the \
             tare requires at least two",
            episode.name
        )),
        _ => None,
    }
}
