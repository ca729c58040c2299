//! What the checks look at: the prepared recording, its motion, and the load at each time of the motion.

use crate::episode::{Episode, Gripper};
use crate::metadata::{Metadata, Reference};
use crate::motion::Motion;
use crate::prepare::{Dataset, Noise, Prepared, WrenchSample, latest, seen_noise};
use crate::recording::Recording;

use super::explain::{Explained, explain};

/// A recording with everything that several checks need.
pub(crate) struct Subject<'a> {
    pub meta: &'a Metadata,
    pub dataset: &'a Dataset,
    pub episodes: Vec<Look<'a>>,
    /// Diameter of the object's bounding box, m; 0 without a shape.
    pub size: f64,
    /// Noise as the data show it, whatever is stated.
    pub seen_noise: Noise,
    /// What the motion explains of the wrench; `None` where there is too little motion.
    pub explained: Option<Explained>,
}

/// One episode.
pub(crate) struct Look<'a> {
    pub episode: &'a Episode,
    pub prepared: &'a Prepared,
    pub motion: Vec<Motion>,
}

/// Load and motion at one time in contact.
pub(crate) struct Moment {
    /// Reading: force in reading axes and torque about the reference point.
    pub reading: [f64; 3],
    /// Angle of the reading axes in the world, rad.
    pub angle: f64,
    /// Velocity of the reference point, world axes, m/s.
    pub velocity: [f64; 2],
    /// Turn rate, rad/s.
    pub rate: f64,
}

impl<'a> Subject<'a> {
    pub fn new(recording: &'a Recording, dataset: &'a Dataset) -> Self {
        let look = |episode: &'a Episode| {
            let prepared = dataset.episodes().find(|prepared| prepared.name == episode.name)?;
            Some(Look { episode, prepared, motion: prepared.motion(&dataset.noise) })
        };
        let [low, high] = dataset.body.bounds();
        let mut subject = Self {
            meta: &recording.metadata,
            dataset,
            episodes: recording.episodes.iter().filter_map(look).collect(),
            size: (high[0] - low[0]).hypot(high[1] - low[1]),
            seen_noise: seen_noise(recording),
            explained: None,
        };
        subject.explained = explain(&subject);
        subject
    }

    /// Whether every episode has a gripper.
    pub fn has_gripper(&self) -> bool {
        self.episodes.iter().all(|look| look.episode.gripper().is_some())
    }

    /// The point that the torque is about, in the first episode that has a wrench.
    pub fn reference(&self) -> Reference {
        let present =
            self.episodes.iter().find_map(|look| look.episode.wrench()).map(|wrench| wrench.present);
        let wrench = &self.meta.wrench;
        present.map_or_else(|| wrench.reference(), |present| wrench.reference_for(present))
    }

    /// Largest force in the recording, N.
    pub fn peak_force(&self) -> f64 {
        let readings = self.dataset.episodes().flat_map(|e| &e.wrench);
        readings.map(|w| w.reading[0].hypot(w.reading[1])).fold(0.0, f64::max)
    }
}

impl Look<'_> {
    pub fn name(&self) -> &str {
        &self.prepared.name
    }

    /// When the object first surely moves, s; `None` if it never does.
    pub fn moves_from(&self) -> Option<f64> {
        Some(self.motion.iter().find(|m| moves(m))?.t)
    }

    /// Angle of the sensor on the object at the first pose, rad; 0 without a gripper.
    pub fn sensor_angle(&self) -> f64 {
        let heading = match self.episode.gripper() {
            Some(Gripper::Level(s)) => s.value.first().map(|v| v[2]),
            Some(Gripper::Tilting(s)) => s.value.first().map(|v| 2.0 * v[6].atan2(v[3])),
            None => None,
        };
        let object = self.prepared.pose.first().map_or(0.0, |p| p.pose[2]);
        heading.map_or(0.0, |heading| heading - object)
    }

    /// Times in contact at which the object surely moves; one for the whole push where only its ends are known.
    pub fn moments(&self) -> Vec<Moment> {
        if self.motion.is_empty() {
            return self.mean_moment().into_iter().collect();
        }
        let times: Vec<f64> = self.prepared.wrench.iter().map(|w| w.t).collect();
        let in_contact = self.motion.iter().filter(|m| m.t >= self.prepared.contact && moves(m));
        let moment =
            |m: &Motion| Some(moment(&self.prepared.wrench[latest(&times, m.t)?], m.pose[2], m.twist));
        in_contact.filter_map(moment).collect()
    }

    /// The reading half way through the push, against the mean twist from the first to the last pose.
    fn mean_moment(&self) -> Option<Moment> {
        let (first, last) = (self.prepared.pose.first()?, self.prepared.pose.last()?);
        let loaded: Vec<&WrenchSample> =
            self.prepared.wrench.iter().filter(|w| w.t >= self.prepared.contact).collect();
        let half_way = loaded.get(loaded.len() / 2)?;
        let duration = last.t - first.t;
        let twist = [0, 1, 2].map(|k| (last.pose[k] - first.pose[k]) / duration);
        (duration > 0.0).then(|| moment(half_way, first.pose[2], twist))
    }
}

fn moment(wrench: &WrenchSample, theta: f64, [vx, vy, rate]: [f64; 3]) -> Moment {
    let (sin, cos) = theta.sin_cos();
    let [x, y, angle] = wrench.frame;
    let arm = [cos * x - sin * y, sin * x + cos * y];
    Moment {
        reading: wrench.reading,
        angle: theta + angle,
        velocity: [vx - rate * arm[1], vy + rate * arm[0]],
        rate,
    }
}

/// Whether the twist stands out of its uncertainty.
fn moves(motion: &Motion) -> bool {
    (0..3).any(|k| motion.twist[k].abs() > 5.0 * motion.cov[k][1][1].sqrt() && motion.twist[k] != 0.0)
}
