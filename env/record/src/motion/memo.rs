//! The last motions found: they take as long as a fit, and one episode is asked for them many times.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex};

use super::Motion;
use crate::prepare::{Noise, PoseSample};

/// Keeps the motions that were found last, and what they were found from: other poses or noise are estimated anew,
/// in a copy too.
#[derive(Debug, Clone, Default)]
pub struct Memo {
    /// From all poses.
    pub(crate) smoothed: Kept,
    /// From those up to each.
    pub(crate) so_far: Kept,
}

/// One estimate, and the key of what it was made from.
#[derive(Debug, Default)]
pub(crate) struct Kept(Mutex<Known>);

type Known = Option<(u64, Arc<Vec<Motion>>)>;

impl Kept {
    /// The motion of these poses, estimated if it is not known.
    pub fn recall(
        &self,
        pose: &[PoseSample],
        noise: &Noise,
        rest_until: Option<f64>,
        estimate: impl FnOnce() -> Vec<Motion>,
    ) -> Vec<Motion> {
        let key = key(pose, noise, rest_until);
        if let Some((same, motion)) = self.known()
            && same == key
        {
            return motion.to_vec();
        }
        // Not while the lock is held: estimating uses all cores, and a thread that waits for others may be given work
        // that asks for the same motion; a fork would take the lock along.
        let motion = estimate();
        if let Ok(mut known) = self.0.lock() {
            *known = Some((key, Arc::new(motion.clone())));
        }
        motion
    }

    fn known(&self) -> Known {
        self.0.lock().map_or(None, |known| known.clone())
    }
}

impl Clone for Kept {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.known()))
    }
}

/// What is remembered is no property of an episode.
impl PartialEq for Memo {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

fn key(pose: &[PoseSample], noise: &Noise, rest_until: Option<f64>) -> u64 {
    let mut hasher = DefaultHasher::new();
    for sample in pose {
        [sample.t, sample.pose[0], sample.pose[1], sample.pose[2]].map(f64::to_bits).hash(&mut hasher);
    }
    noise.pose.map(f64::to_bits).hash(&mut hasher);
    rest_until.map(f64::to_bits).hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_remembers_and_changed_poses_are_estimated_anew() {
        let noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };
        let mut pose: Vec<PoseSample> =
            (0..9).map(|k| PoseSample { t: f64::from(k), pose: [0.1 * f64::from(k), 0.0, 0.0] }).collect();
        let found = |pose: &[PoseSample]| crate::motion::smooth(pose, &noise, false);
        let memo = Memo::default();
        let first = memo.smoothed.recall(&pose, &noise, None, || found(&pose));
        let known = memo.clone().smoothed.recall(&pose, &noise, None, Vec::new);
        assert_eq!(first, known);
        pose[4].pose[0] += 0.01;
        let anew = memo.smoothed.recall(&pose, &noise, None, || found(&pose));
        assert_ne!(first, anew);
    }

    #[test]
    fn an_estimate_may_ask_for_the_motion_that_it_estimates() {
        let noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };
        let pose = [PoseSample { t: 0.0, pose: [0.0; 3] }];
        let (done, ended) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let memo = Memo::default();
            // As a thread does that is given other work while it waits.
            let inner = || memo.smoothed.recall(&pose, &noise, None, Vec::new);
            done.send(memo.smoothed.recall(&pose, &noise, None, inner))
        });
        assert_eq!(ended.recv_timeout(std::time::Duration::from_secs(10)), Ok(vec![]));
    }
}
