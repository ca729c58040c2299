//! Whether there is enough motion to ask what is missing.
//!
//! From a second or so of pushing, a wheel, a mass and an effect more can be bent to one another: what comes out is
//! likely, and no finding. Better no answer.

use trundle_infer::InferError;
use trundle_record::{Dataset, Prepared};

/// Least time of pushing in all training episodes together, s.
const MIN_PUSHING_TIME_S: f64 = 3.0;

/// Refuse recordings of too little pushing.
///
/// # Errors
/// When the training episodes hold too little time between contact and their last poses.
pub(crate) fn require_pushing_time(data: &Dataset) -> Result<(), InferError> {
    let pushing_time: f64 = data.training.iter().map(pushing_time).sum();
    if pushing_time >= MIN_PUSHING_TIME_S {
        return Ok(());
    }
    Err(InferError::NoData {
        recording: data.name.clone(),
        reason: format!(
            "its training episodes hold {pushing_time:.1} s of pushing in all, and {MIN_PUSHING_TIME_S:.0} s is the least that tells \
             a missing effect from a parameter"
        ),
        remedy: "record longer pushes, or more of them".to_owned(),
    })
}

/// From contact to the last pose, s.
fn pushing_time(episode: &Prepared) -> f64 {
    episode.pose.last().map_or(0.0, |last| (last.t - episode.contact).max(0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::require_pushing_time;
    use crate::common::{World, locked};

    #[test]
    fn a_second_of_pushing_is_too_little() {
        let mut data = World::of(locked()).recording(1);
        assert!(require_pushing_time(&data).is_ok());
        for episode in &mut data.training {
            episode.pose.retain(|p| p.t < 0.9);
            episode.wrench.retain(|w| w.t < 0.9);
            episode.memo = Default::default();
        }
        let message = require_pushing_time(&data).unwrap_err().to_string();
        assert!(
            message.contains("1.9 s of pushing in all") && message.contains("record longer pushes"),
            "{message}"
        );
    }
}
