//! Check that a recording contains enough pushing for a diagnosis.
//!
//! Within about a second of pushing, the parameters of a wheel, a mass and one further effect can compensate
//! each other. A diagnosis would then name an effect without evidence.

use trundle_infer::InferError;
use trundle_record::{Dataset, Prepared};

/// Least total pushing time of the training episodes, s.
const MIN_PUSHING_TIME_S: f64 = 3.0;

/// Refuse recordings with too little pushing.
///
/// # Errors
/// If the total time from contact to the last pose of the training episodes is too short.
pub(crate) fn require_pushing_time(data: &Dataset) -> Result<(), InferError> {
    let pushing_time: f64 = data.training.iter().map(pushing_time).sum();
    if pushing_time >= MIN_PUSHING_TIME_S {
        return Ok(());
    }
    Err(InferError::NoData {
        recording: data.name.clone(),
        reason: format!(
            "the training episodes contain only {pushing_time:.1} s of pushing; at least {MIN_PUSHING_TIME_S:.0} s \
             are needed to distinguish a missing effect from a parameter error"
        ),
        remedy: "record longer pushes or more episodes".to_owned(),
    })
}

/// Time from contact to the last pose, s.
fn pushing_time(episode: &Prepared) -> f64 {
    episode.pose.last().map_or(0.0, |last| (last.t - episode.contact).max(0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::require_pushing_time;
    use trundle_fixtures::{World, locked};

    #[test]
    fn a_second_of_pushing_is_refused() {
        let mut data = World::of(locked()).recording(1);
        assert!(require_pushing_time(&data).is_ok());
        for episode in &mut data.training {
            episode.pose.retain(|p| p.t < 0.9);
            episode.wrench.retain(|w| w.t < 0.9);
            episode.motion_cache = Default::default();
        }
        let message = require_pushing_time(&data).unwrap_err().to_string();
        assert!(
            message.contains("1.9 s of pushing") && message.contains("record longer pushes"),
            "{message}"
        );
    }
}
