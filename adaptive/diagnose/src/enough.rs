//! Whether there is enough motion to ask what is missing.
//!
//! From a second or so of pushing, a wheel, a mass and an effect more can be bent to one another: what comes out is
//! likely, and no finding. Better no answer.

use trundle_infer::InferError;
use trundle_record::{Dataset, Prepared};

/// Least time of pushing in all training episodes together, s.
const LEAST: f64 = 3.0;

/// Refuse recordings of too little pushing.
///
/// # Errors
/// When the training episodes hold too little time between contact and their last poses.
pub(crate) fn enough(data: &Dataset) -> Result<(), InferError> {
    let pushed: f64 = data.training.iter().map(pushed).sum();
    if pushed >= LEAST {
        return Ok(());
    }
    Err(InferError::NoData {
        recording: data.name.clone(),
        reason: format!(
            "its training episodes hold {pushed:.1} s of pushing in all, and {LEAST:.0} s is the least that tells \
             a missing effect from a parameter"
        ),
        remedy: "record longer pushes, or more of them".to_owned(),
    })
}

/// From contact to the last pose, s.
fn pushed(episode: &Prepared) -> f64 {
    episode.pose.last().map_or(0.0, |last| (last.t - episode.contact).max(0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::enough;
    use crate::common::{World, locked};

    #[test]
    fn a_second_of_pushing_is_too_little() {
        let mut data = World::of(locked()).recording(1);
        assert!(enough(&data).is_ok());
        for episode in &mut data.training {
            episode.pose.retain(|p| p.t < 0.9);
            episode.wrench.retain(|w| w.t < 0.9);
            episode.motion_cache = Default::default();
        }
        let told = enough(&data).unwrap_err().to_string();
        assert!(told.contains("1.9 s of pushing in all") && told.contains("record longer pushes"), "{told}");
    }
}
