//! Observations of an episode.

use rand::RngExt;

use super::Episode;
use crate::task::constants::*;
use crate::task::measurement_delay::Measurement;
use crate::task::scene_layout::PATH_LOOKAHEAD_M;
use crate::task::sensors::add_noise;

impl Episode {
    /// Write the observation. The environment's documentation lists its entries.
    pub fn observe(&mut self, observation: &mut [f64]) {
        let Measurement { pose: seen, twist, wrench, grasp: [px, py] } = self.observed_measurement();
        let scale = self.options.noise;
        let pose = add_noise(seen, self.tracker.noise, &mut self.state.noise);
        if self.options.drop_out == 0.0 || self.state.noise.random::<f64>() >= self.options.drop_out {
            self.state.tracked = pose;
        }
        let [x, y, theta] = self.state.tracked;
        let [vx, vy, spin] = add_noise(twist, TWIST_NOISE_SD.map(|sd| sd * scale), &mut self.state.noise);
        let [fx, fy, torque] = add_noise(wrench, self.sensor.noise(), &mut self.state.noise);
        let [bx, by, bz] = self.state.tare;
        let [gx, gy, gtheta] = self.target();
        let ((sin, cos), (gsin, gcos)) = (theta.sin_cos(), gtheta.sin_cos());
        let common =
            [x, y, cos, sin, vx, vy, spin, gx, gy, gcos, gsin, fx - bx, fy - by, torque - bz, px, py];
        let bounded = common.into_iter().zip(COMMON_BOUNDS).map(|(v, most)| v.clamp(-most, most));
        let mut entries = observation.iter_mut();
        entries.by_ref().zip(bounded).for_each(|(entry, value)| *entry = value);
        self.layout_features(|value| {
            if let Some(entry) = entries.next() {
                *entry = value.clamp(-MAX_FEATURE_M, MAX_FEATURE_M);
            }
        });
    }

    /// Pass the additional observation entries to `append`: half the object's sides if the object varies or in version 1,
    /// then in version 1 the middle of its bounds and its outline if requested, and the features of the scene.
    fn layout_features(&self, mut append: impl FnMut(f64)) {
        let has_middle = self.options.version > 0;
        if has_middle || self.options.has_varied_objects() {
            let [low, high] = self.task_object.body.bounds();
            append((high[0] - low[0]) / 2.0);
            append((high[1] - low[1]) / 2.0);
            if has_middle {
                append((high[0] + low[0]) / 2.0);
                append((high[1] + low[1]) / 2.0);
            }
        }
        if self.options.outline {
            self.task_object.outline.iter().copied().for_each(&mut append);
        }
        match &self.progress {
            Some(path) => {
                for ahead in [2.0 * PATH_LOOKAHEAD_M, 3.0 * PATH_LOOKAHEAD_M] {
                    let [x, y, _] = path.pose_at(path.arc_length + ahead);
                    append(x);
                    append(y);
                }
            }
            None => self.layout.features.iter().copied().for_each(append),
        }
    }
}
