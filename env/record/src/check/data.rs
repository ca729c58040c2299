//! Data of a recording that several checks share: the prepared recording, its motion and its loads.

use crate::episode::{Episode, Gripper};
use crate::metadata::{Metadata, Reference};
use crate::motion::Motion;
use crate::prepare::{Dataset, Noise, Prepared, WrenchSample, estimated_noise, latest};
use crate::recording::Recording;

/// Minimum load in standard deviations of the noise.
const MIN_LOAD_SD: f64 = 6.0;

/// A recording with the data that several checks share.
pub(crate) struct RecordingData<'a> {
    pub meta: &'a Metadata,
    pub dataset: &'a Dataset,
    pub episodes: Vec<EpisodeData<'a>>,
    /// Diagonal of the object's bounding box, m; 0 without a shape.
    pub size: f64,
    /// Noise estimated from the data, whether or not it is stated.
    pub estimated_noise: Noise,
}

/// An episode with its prepared data and motion.
pub(crate) struct EpisodeData<'a> {
    pub raw: &'a Episode,
    pub prepared: &'a Prepared,
    pub motion: Vec<Motion>,
}

/// Load and motion at one time during contact.
pub(crate) struct LoadSample {
    /// Force in reading axes, N, and torque about the reference point, N m.
    pub reading: [f64; 3],
    /// Angle of the reading axes in the world, rad.
    pub angle: f64,
    /// Velocity of the reference point in world axes, m/s.
    pub velocity: [f64; 2],
    /// Angular velocity, rad/s.
    pub rate: f64,
}

impl<'a> RecordingData<'a> {
    pub fn new(recording: &'a Recording, dataset: &'a Dataset) -> Self {
        let data = |raw: &'a Episode| {
            let prepared = dataset.episodes().find(|prepared| prepared.name == raw.name)?;
            Some(EpisodeData { raw, prepared, motion: prepared.motion(&dataset.noise) })
        };
        let [low, high] = dataset.body.bounds();
        Self {
            meta: &recording.metadata,
            dataset,
            episodes: recording.episodes.iter().filter_map(data).collect(),
            size: (high[0] - low[0]).hypot(high[1] - low[1]),
            estimated_noise: estimated_noise(recording),
        }
    }

    /// Whether every episode has a gripper.
    pub fn has_gripper(&self) -> bool {
        self.episodes.iter().all(|episode| episode.raw.gripper().is_some())
    }

    /// Reference point of the torque in the first episode with a wrench.
    pub fn reference(&self) -> Reference {
        let present =
            self.episodes.iter().find_map(|episode| episode.raw.wrench()).map(|wrench| wrench.present);
        let wrench = &self.meta.wrench;
        present.map_or_else(|| wrench.reference(), |present| wrench.reference_for(present))
    }

    /// Whether a reading shows a load. Only a load shows that the gripper touches the object: a pushed object may slide
    /// away.
    pub fn is_loaded(&self, wrench: &WrenchSample) -> bool {
        let (noise, [x, y, torque]) = (&self.dataset.noise, wrench.reading);
        x.hypot(y) > MIN_LOAD_SD * noise.force || torque.abs() > MIN_LOAD_SD * noise.torque
    }

    /// Largest force in the recording, N.
    pub fn peak_force(&self) -> f64 {
        let readings = self.dataset.episodes().flat_map(|e| &e.wrench);
        readings.map(|w| w.reading[0].hypot(w.reading[1])).fold(0.0, f64::max)
    }
}

impl EpisodeData<'_> {
    pub fn name(&self) -> &str {
        &self.prepared.name
    }

    /// Time of the first significant motion, s; `None` if there is none.
    pub fn moves_from(&self) -> Option<f64> {
        Some(self.motion.iter().find(|m| moves(m))?.t)
    }

    /// Angle of the sensor relative to the object at the first pose, rad; 0 without a gripper.
    pub fn sensor_angle(&self) -> f64 {
        let heading = match self.raw.gripper() {
            Some(Gripper::Level(s)) => s.value.first().map(|v| v[2]),
            Some(Gripper::Tilting(s)) => s.value.first().map(|v| 2.0 * v[6].atan2(v[3])),
            None => None,
        };
        let object = self.prepared.pose.first().map_or(0.0, |p| p.pose[2]);
        heading.map_or(0.0, |heading| heading - object)
    }

    /// Loads during contact at times with significant motion. One mean load if only the first and last pose are known.
    pub fn load_samples(&self) -> Vec<LoadSample> {
        if self.motion.is_empty() {
            return self.mean_load_sample().into_iter().collect();
        }
        let times: Vec<f64> = self.prepared.wrench.iter().map(|w| w.t).collect();
        let in_contact = self.motion.iter().filter(|m| m.t >= self.prepared.contact && moves(m));
        let load_sample =
            |m: &Motion| Some(load_sample(&self.prepared.wrench[latest(&times, m.t)?], m.pose[2], m.twist));
        in_contact.filter_map(load_sample).collect()
    }

    /// The reading in the middle of the push, with the mean twist from the first to the last pose.
    fn mean_load_sample(&self) -> Option<LoadSample> {
        let (first, last) = (self.prepared.pose.first()?, self.prepared.pose.last()?);
        let loaded: Vec<&WrenchSample> =
            self.prepared.wrench.iter().filter(|w| w.t >= self.prepared.contact).collect();
        let half_way = loaded.get(loaded.len() / 2)?;
        let duration = last.t - first.t;
        let twist = [0, 1, 2].map(|k| (last.pose[k] - first.pose[k]) / duration);
        (duration > 0.0).then(|| load_sample(half_way, first.pose[2], twist))
    }
}

fn load_sample(wrench: &WrenchSample, theta: f64, [vx, vy, rate]: [f64; 3]) -> LoadSample {
    let (sin, cos) = theta.sin_cos();
    let [x, y, angle] = wrench.frame;
    let arm = [cos * x - sin * y, sin * x + cos * y];
    LoadSample {
        reading: wrench.reading,
        angle: theta + angle,
        velocity: [vx - rate * arm[1], vy + rate * arm[0]],
        rate,
    }
}

/// Whether the twist is significant.
fn moves(motion: &Motion) -> bool {
    (0..3).any(|k| motion.twist[k].abs() > 5.0 * motion.cov[k][1][1].sqrt() && motion.twist[k] != 0.0)
}
