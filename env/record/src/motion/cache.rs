//! Cache of the estimated motion of an episode. An estimate takes as long as a fit and is used many times.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex};

use super::state::Motion;
use crate::prepare::{Noise, PoseSample};

/// Cache of the smoothed and the filtered motion of an episode. Other poses or noise trigger a new estimate, also in a
/// clone.
#[derive(Debug, Clone, Default)]
pub struct MotionCache {
    /// Motion from all poses.
    pub(crate) smoothed: CacheEntry,
    /// Motion from the poses up to each time.
    pub(crate) filtered: CacheEntry,
}

/// The last estimate, and the hash of its inputs.
#[derive(Debug, Default)]
pub(crate) struct CacheEntry(Mutex<Cached>);

type Cached = Option<(u64, Arc<Vec<Motion>>)>;

impl CacheEntry {
    /// The motion of the poses, taken from the cache or computed by `estimate`.
    pub fn get_or_estimate(
        &self,
        pose: &[PoseSample],
        noise: &Noise,
        rest_until: Option<f64>,
        estimate: impl FnOnce() -> Vec<Motion>,
    ) -> Vec<Motion> {
        let key = key(pose, noise, rest_until);
        if let Some((cached_key, motion)) = self.cached()
            && cached_key == key
        {
            return motion.to_vec();
        }
        // Do not estimate while the lock is held. Rayon may run work that needs the same motion on this thread while it
        // waits, and a fork would copy the locked mutex.
        let motion = estimate();
        if let Ok(mut cached) = self.0.lock() {
            *cached = Some((key, Arc::new(motion.clone())));
        }
        motion
    }

    fn cached(&self) -> Cached {
        self.0.lock().map_or(None, |cached| cached.clone())
    }
}

impl Clone for CacheEntry {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.cached()))
    }
}

/// All caches are equal, so that a cache does not affect the equality of episodes.
impl PartialEq for MotionCache {
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
    noise.time.to_bits().hash(&mut hasher);
    rest_until.map(f64::to_bits).hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_estimates_and_changed_poses_are_estimated_again() {
        let noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };
        let mut pose: Vec<PoseSample> =
            (0..9).map(|k| PoseSample { t: f64::from(k), pose: [0.1 * f64::from(k), 0.0, 0.0] }).collect();
        let estimate = |pose: &[PoseSample]| crate::motion::smooth(pose, &noise, false);
        let cache = MotionCache::default();
        let first = cache.smoothed.get_or_estimate(&pose, &noise, None, || estimate(&pose));
        let cached = cache.clone().smoothed.get_or_estimate(&pose, &noise, None, Vec::new);
        assert_eq!(first, cached);
        pose[4].pose[0] += 0.01;
        let again = cache.smoothed.get_or_estimate(&pose, &noise, None, || estimate(&pose));
        assert_ne!(first, again);
    }

    #[test]
    fn estimates_may_nest() {
        let noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };
        let pose = [PoseSample { t: 0.0, pose: [0.0; 3] }];
        let (done, ended) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let cache = MotionCache::default();
            // Simulates a thread that runs other work while it waits.
            let inner = || cache.smoothed.get_or_estimate(&pose, &noise, None, Vec::new);
            done.send(cache.smoothed.get_or_estimate(&pose, &noise, None, inner))
        });
        assert_eq!(ended.recv_timeout(std::time::Duration::from_secs(10)), Ok(vec![]));
    }
}
