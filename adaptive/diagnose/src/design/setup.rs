//! Setup of an experiment: limits of the robot, instruments, and the start pose of the object.

use serde::Serialize;
use trundle_infer::Channels;
use trundle_model::{Body, to_body};
use trundle_record::{Dataset, Noise, Prepared};

/// Limits of a push.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Maximum force at the grasp, N.
    pub force: f64,
    /// Maximum torque at the grasp, N·m.
    pub torque: f64,
    /// Time in contact, s.
    pub duration: f64,
    /// Maximum speed of the object's origin, m/s.
    pub speed: f64,
    /// Maximum angular speed, rad/s.
    pub spin: f64,
    /// Maximum distance of the object's origin from its start, m.
    pub distance: f64,
}

impl Default for Limits {
    /// Limits of a mobile manipulator.
    fn default() -> Self {
        Self { force: 30.0, torque: 8.0, duration: 6.0, speed: 0.6, spin: 1.0, distance: 1.2 }
    }
}

impl Limits {
    /// The largest values in a recording, which the robot can repeat. A quantity that the recording does not exercise
    /// has its default limit.
    pub fn from_recording(data: &Dataset) -> Self {
        let default = Self::default();
        let readings = || data.training.iter().flat_map(|e| e.wrench.iter().map(|w| w.reading));
        let extents = data
            .training
            .iter()
            .map(motion)
            .fold([0.0; 3], |max: [f64; 3], extent| [0, 1, 2].map(|k| max[k].max(extent[k])));
        let durations = data.training.iter().filter_map(|e| Some(e.pose.last()?.t - e.contact));
        let or =
            |value: f64, threshold: f64, otherwise: f64| if value > threshold { value } else { otherwise };
        let force = readings().map(|[x, y, _]| x.hypot(y)).fold(0.0, f64::max);
        let torque = readings().map(|r| r[2].abs()).fold(0.0, f64::max);
        let tenths = |value: f64| (10.0 * value).round() / 10.0;
        // Largest apparent speed of an object at rest due to the tracker's noise.
        let jitter = |k: usize| 6.0 * std::f64::consts::SQRT_2 * data.noise.pose[k] / SPEED_INTERVAL_S;
        Self {
            force: or(tenths(force), 5.0 * data.noise.force, default.force),
            // A gripper that pushed at a point, or without a torque, may still apply a small torque.
            torque: or(tenths(torque), 10.0 * data.noise.torque, default.torque),
            duration: or(tenths(durations.fold(0.0, f64::max)).min(10.0), 1.0, default.duration),
            distance: or(extents[0], 0.1, default.distance),
            speed: or(extents[1], jitter(0).max(0.05), default.speed),
            spin: or(extents[2], jitter(2).max(0.1), default.spin),
        }
    }

    /// The first limit that is not a positive number, and its value.
    pub fn first_invalid(&self) -> Option<(&'static str, f64)> {
        let all = [
            ("force", self.force),
            ("torque", self.torque),
            ("duration", self.duration),
            ("speed", self.speed),
            ("spin", self.spin),
            ("distance", self.distance),
        ];
        all.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0))
    }
}

/// Sensors that record a push.
#[derive(Clone, Debug)]
pub struct Instruments {
    /// Standard deviations.
    pub noise: Noise,
    /// Pose samples per second.
    pub pose_rate: f64,
    /// Wrench samples per second.
    pub wrench_rate: f64,
    /// Standard deviation of the tare error, reading axes, N, N, N·m.
    pub tare: [f64; 3],
}

impl Instruments {
    /// A tracker at 60 Hz and a wrist sensor at 125 Hz with the given noise, tared over a hundred samples.
    pub fn with(noise: Noise) -> Self {
        let tare = [noise.force, noise.force, noise.torque].map(|sd| 0.1 * sd);
        Self { noise, pose_rate: 60.0, wrench_rate: 125.0, tare }
    }

    /// The instruments of a recording, with the noise of a fit.
    fn of_recording(data: &Dataset, channels: &Channels) -> Self {
        let [force, _, torque] = channels.reading;
        let found = Noise { pose: channels.pose, force, torque, stated: true, ..data.noise };
        // A comparison of wrenches estimates no noise of the poses.
        let has_no_pose_noise = channels.pose.iter().all(|sd| *sd == 0.0);
        let default = Self::with(if has_no_pose_noise { data.noise.clone() } else { found });
        let Some(episode) = data.training.first() else { return default };
        let rate = |times: Vec<f64>, otherwise: f64| match (times.first(), times.last()) {
            (Some(a), Some(b)) if b > a => (times.len() - 1) as f64 / (b - a),
            _ => otherwise,
        };
        let pose_rate = rate(episode.pose.iter().map(|p| p.t).collect(), default.pose_rate);
        let wrench_rate = rate(episode.wrench.iter().map(|w| w.t).collect(), default.wrench_rate);
        Self { pose_rate, wrench_rate, tare: episode.tare_sd, ..default }
    }

    /// Instruments with at most `rate` poses per second and equal information, for ranking pushes.
    pub(super) fn thinned(&self, rate: f64) -> Self {
        let share = (rate / self.pose_rate).min(1.0);
        let noise = Noise { pose: self.noise.pose.map(|sd| sd * share.sqrt()), ..self.noise };
        Self { noise, pose_rate: self.pose_rate * share, ..self.clone() }
    }
}

/// Conditions for which an experiment is designed.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The object.
    pub body: Body,
    /// Free directions: x, y, θ.
    pub dof: [bool; 3],
    /// Limits of a push.
    pub limits: Limits,
    /// Sensors.
    pub instruments: Instruments,
    /// Default start pose of the object in the world.
    pub start_pose: [f64; 3],
    /// Whether the recorded pushes started with the same heading, within about 15°.
    pub has_common_heading: bool,
    /// Alternative start positions, world, m.
    pub places: Vec<[f64; 2]>,
    /// Number of recorded episodes.
    pub recorded_episodes: usize,
    /// Maximum number of neighbourhood searches around the best push.
    pub max_search_rounds: usize,
}

/// Default number of neighbourhood searches.
const MAX_SEARCH_ROUNDS: usize = 3;

impl Setup {
    /// Setup without a recording; the object starts at the origin.
    pub fn without_recording(body: Body, dof: [bool; 3], limits: Limits, noise: Noise) -> Self {
        let instruments = Instruments::with(noise);
        Self {
            body,
            dof,
            limits,
            instruments,
            start_pose: [0.0; 3],
            has_common_heading: false,
            places: vec![],
            recorded_episodes: 0,
            max_search_rounds: MAX_SEARCH_ROUNDS,
        }
    }

    /// Setup that continues a recording: its instruments and its mean start pose.
    pub fn from_recording(data: &Dataset, channels: &Channels, limits: Limits) -> Self {
        let starts: Vec<[f64; 3]> = data.training.iter().filter_map(first_pose).collect();
        let (start_pose, concentration) = mean_pose(&starts);
        Self {
            instruments: Instruments::of_recording(data, channels),
            start_pose,
            has_common_heading: concentration > 0.966,
            places: far_from(&data.training, start_pose),
            recorded_episodes: data.training.len() + data.held_out.len(),
            ..Self::without_recording(data.body.clone(), data.dof, limits, data.noise.clone())
        }
    }

    /// The same setup with a shorter search.
    #[must_use]
    pub fn with_short_search(self) -> Self {
        Self { max_search_rounds: 1, ..self }
    }

    /// Whether the object moves on a rail along x.
    pub fn on_rail(&self) -> bool {
        !self.dof[1] && !self.dof[2]
    }
}

fn first_pose(episode: &Prepared) -> Option<[f64; 3]> {
    episode.pose.first().map(|p| p.pose)
}

/// Mean pose, and the concentration of the headings: one if they are equal, zero if they are uniform on the
/// circle.
fn mean_pose(starts: &[[f64; 3]]) -> ([f64; 3], f64) {
    let n = starts.len().max(1) as f64;
    let [x, y] = [0, 1].map(|k| starts.iter().map(|s| s[k]).sum::<f64>() / n);
    let (sin, cos) = starts.iter().fold((0.0, 0.0), |(s, c), p| (s + p[2].sin() / n, c + p[2].cos() / n));
    // Round to centimetres and degrees, the accuracy of placing an object by hand.
    let degree = std::f64::consts::PI / 180.0;
    let heading = (sin.atan2(cos) / degree).round() * degree;
    let [x, y] = [x, y].map(|p| (100.0 * p).round() / 100.0);
    ([x, y, heading], sin.hypot(cos))
}

/// The visited position farthest from the start, if it is more than 0.3 m away. Effects that are fixed to the
/// floor show when the object returns to it.
fn far_from(episodes: &[Prepared], [x, y, _]: [f64; 3]) -> Vec<[f64; 2]> {
    let visited = episodes.iter().flat_map(|e| &e.pose).map(|p| [p.pose[0], p.pose[1]]);
    let distance = |p: &[f64; 2]| (p[0] - x).hypot(p[1] - y);
    let farthest = visited.max_by(|a, b| distance(a).total_cmp(&distance(b)));
    farthest.filter(|p| distance(p) > 0.3).into_iter().collect()
}

/// Interval over which speeds of a recorded motion are computed, s.
const SPEED_INTERVAL_S: f64 = 0.1;

/// Extent of a recorded motion; see [`extent`].
fn motion(episode: &Prepared) -> [f64; 3] {
    let mut poses: Vec<[f64; 3]> = Vec::new();
    let mut next = f64::NEG_INFINITY;
    for sample in episode.pose.iter().filter(|p| p.pose.iter().all(|v| v.is_finite())) {
        if sample.t >= next {
            poses.push(sample.pose);
            next = sample.t + SPEED_INTERVAL_S;
        }
    }
    extent(&poses, 1.0 / SPEED_INTERVAL_S)
}

/// Extent of a motion: maximum distance from its start, speed, and angular speed.
pub(super) fn extent(poses: &[[f64; 3]], rate: f64) -> [f64; 3] {
    let Some(&start) = poses.first() else { return [0.0; 3] };
    let displacement = |a: [f64; 3], b: [f64; 3]| to_body([b[0] - a[0], b[1] - a[1], b[2] - a[2]], 0.0);
    let size = |[x, y, turn]: [f64; 3]| (x.hypot(y), turn.abs());
    let distance = poses.iter().map(|p| size(displacement(start, *p)).0).fold(0.0, f64::max);
    let steps = poses.windows(2).map(|w| size(displacement(w[0], w[1])));
    let (speed, spin) =
        steps.fold((0.0, 0.0), |(v, s): (f64, f64), (d, t)| (v.max(d * rate), s.max(t * rate)));
    [distance, speed, spin]
}
