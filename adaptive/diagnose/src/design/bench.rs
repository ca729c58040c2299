//! The bench on which a push is designed: what the robot may do, what the instruments see, where the object stands.

use serde::Serialize;
use trundle_infer::Channels;
use trundle_model::{Body, to_body};
use trundle_record::{Dataset, Noise, Prepared};

/// What a push may take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Largest force at the grasp, N.
    pub force: f64,
    /// Largest torque at the grasp, N·m.
    pub torque: f64,
    /// Time in contact, s.
    pub duration: f64,
    /// Largest speed of the object's origin, m/s.
    pub speed: f64,
    /// Largest spin, rad/s.
    pub spin: f64,
    /// Largest distance of the object's origin from where it stood, m.
    pub distance: f64,
}

impl Default for Limits {
    /// A mobile manipulator at arm's length.
    fn default() -> Self {
        Self { force: 30.0, torque: 8.0, duration: 6.0, speed: 0.6, spin: 1.0, distance: 1.2 }
    }
}

impl Limits {
    /// What a recording shows: a robot can do again what it did. Where it did nothing of a kind, the default.
    pub fn seen(data: &Dataset) -> Self {
        let plain = Self::default();
        let readings = || data.training.iter().flat_map(|e| e.wrench.iter().map(|w| w.reading));
        let moved = data
            .training
            .iter()
            .map(motion)
            .fold([0.0; 3], |most: [f64; 3], own| [0, 1, 2].map(|k| most[k].max(own[k])));
        let lasting = data.training.iter().filter_map(|e| Some(e.pose.last()?.t - e.contact));
        let or = |value: f64, least: f64, otherwise: f64| if value > least { value } else { otherwise };
        let force = readings().map(|[x, y, _]| x.hypot(y)).fold(0.0, f64::max);
        let torque = readings().map(|r| r[2].abs()).fold(0.0, f64::max);
        let tenths = |value: f64| (10.0 * value).round() / 10.0;
        // The fastest that a tracker's noise makes an object at rest seem.
        let jitter = |k: usize| 6.0 * std::f64::consts::SQRT_2 * data.noise.pose[k] / SPAN;
        Self {
            force: or(tenths(force), 5.0 * data.noise.force, plain.force),
            // A gripper that pushed at a point, or without turning, may still turn a little.
            torque: or(tenths(torque), 10.0 * data.noise.torque, plain.torque),
            duration: or(tenths(lasting.fold(0.0, f64::max)).min(10.0), 1.0, plain.duration),
            distance: or(moved[0], 0.1, plain.distance),
            speed: or(moved[1], jitter(0).max(0.05), plain.speed),
            spin: or(moved[2], jitter(2).max(0.1), plain.spin),
        }
    }

    /// The first limit that is no positive number, and its value.
    pub fn fault(&self) -> Option<(&'static str, f64)> {
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

/// What the instruments see of a push.
#[derive(Clone, Debug)]
pub struct Instruments {
    /// Standard deviations.
    pub noise: Noise,
    /// Poses a second.
    pub pose_rate: f64,
    /// Wrench samples a second.
    pub wrench_rate: f64,
    /// Standard deviation of the tare's error, reading axes, N, N, N·m.
    pub tare: [f64; 3],
}

impl Instruments {
    /// A tracker at 60 Hz and a wrist sensor at 125 Hz with this noise, tared over a hundred samples.
    pub fn with(noise: Noise) -> Self {
        let tare = [noise.force, noise.force, noise.torque].map(|sd| 0.1 * sd);
        Self { noise, pose_rate: 60.0, wrench_rate: 125.0, tare }
    }

    /// Those of a recording, with the noise that a fit found or was told.
    fn of(data: &Dataset, channels: &Channels) -> Self {
        let [force, _, torque] = channels.reading;
        let found = Noise { pose: channels.pose, force, torque, stated: true, ..data.noise };
        // Where wrenches are compared, nothing is said of poses.
        let blind = channels.pose.iter().all(|sd| *sd == 0.0);
        let plain = Self::with(if blind { data.noise.clone() } else { found });
        let Some(episode) = data.training.first() else { return plain };
        let rate = |times: Vec<f64>, otherwise: f64| match (times.first(), times.last()) {
            (Some(a), Some(b)) if b > a => (times.len() - 1) as f64 / (b - a),
            _ => otherwise,
        };
        let pose_rate = rate(episode.pose.iter().map(|p| p.t).collect(), plain.pose_rate);
        let wrench_rate = rate(episode.wrench.iter().map(|w| w.t).collect(), plain.wrench_rate);
        Self { pose_rate, wrench_rate, tare: episode.tare_sd, ..plain }
    }

    /// Fewer poses with as much in them, for sorting pushes: at most `rate` a second.
    pub(super) fn thinned(&self, rate: f64) -> Self {
        let share = (rate / self.pose_rate).min(1.0);
        let noise = Noise { pose: self.noise.pose.map(|sd| sd * share.sqrt()), ..self.noise };
        Self { noise, pose_rate: self.pose_rate * share, ..self.clone() }
    }
}

/// What a design is made for.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The object.
    pub body: Body,
    /// Directions in which it can move: x, y, θ.
    pub dof: [bool; 3],
    /// What a push may take.
    pub limits: Limits,
    /// What is seen of it.
    pub instruments: Instruments,
    /// Where the object stands unless it is moved or turned first: pose in the world.
    pub stands: [f64; 3],
    /// Whether all recorded pushes began with this heading, give or take 15°.
    pub alike: bool,
    /// Further places to stand it at, world, m.
    pub places: Vec<[f64; 2]>,
    /// Number of episodes that were recorded before.
    pub recorded: usize,
    /// How often the neighbours of the best push so far are tried, at most.
    pub rounds: usize,
}

/// Rounds where nobody waits.
const ROUNDS: usize = 3;

impl Bench {
    /// Without a recording: the object stands at the origin.
    pub fn bare(body: Body, dof: [bool; 3], limits: Limits, noise: Noise) -> Self {
        let instruments = Instruments::with(noise);
        Self {
            body,
            dof,
            limits,
            instruments,
            stands: [0.0; 3],
            alike: false,
            places: vec![],
            recorded: 0,
            rounds: ROUNDS,
        }
    }

    /// For a push on top of a recording: where its pushes began, with its instruments.
    pub fn after(data: &Dataset, channels: &Channels, limits: Limits) -> Self {
        let starts: Vec<[f64; 3]> = data.training.iter().filter_map(first).collect();
        let (stands, concentration) = mean(&starts);
        Self {
            instruments: Instruments::of(data, channels),
            stands,
            alike: concentration > 0.966,
            places: far_from(&data.training, stands),
            recorded: data.training.len() + data.held_out.len(),
            ..Self::bare(data.body.clone(), data.dof, limits, data.noise.clone())
        }
    }

    /// The same with a shorter search.
    #[must_use]
    pub fn hurried(self) -> Self {
        Self { rounds: 1, ..self }
    }

    /// Whether the object is on a rail along x.
    pub fn on_rail(&self) -> bool {
        !self.dof[1] && !self.dof[2]
    }
}

fn first(episode: &Prepared) -> Option<[f64; 3]> {
    episode.pose.first().map(|p| p.pose)
}

/// Mean pose, and how alike the headings are: one for all the same, zero for all around the circle.
fn mean(starts: &[[f64; 3]]) -> ([f64; 3], f64) {
    let n = starts.len().max(1) as f64;
    let [x, y] = [0, 1].map(|k| starts.iter().map(|s| s[k]).sum::<f64>() / n);
    let (sin, cos) = starts.iter().fold((0.0, 0.0), |(s, c), p| (s + p[2].sin() / n, c + p[2].cos() / n));
    // To the centimetre and the degree: nobody stands an object up more exactly.
    let degree = std::f64::consts::PI / 180.0;
    let heading = (sin.atan2(cos) / degree).round() * degree;
    let [x, y] = [x, y].map(|p| (100.0 * p).round() / 100.0);
    ([x, y, heading], sin.hypot(cos))
}

/// The place that was visited farthest from where pushes begin, if it is another: what is tied to the floor shows
/// when one comes back to it.
fn far_from(episodes: &[Prepared], [x, y, _]: [f64; 3]) -> Vec<[f64; 2]> {
    let visited = episodes.iter().flat_map(|e| &e.pose).map(|p| [p.pose[0], p.pose[1]]);
    let distance = |p: &[f64; 2]| (p[0] - x).hypot(p[1] - y);
    let farthest = visited.max_by(|a, b| distance(a).total_cmp(&distance(b)));
    farthest.filter(|p| distance(p) > 0.3).into_iter().collect()
}

/// Over this time the speed of a recorded motion is taken, s.
const SPAN: f64 = 0.1;

/// Extent of a recorded motion; see [`extent`].
fn motion(episode: &Prepared) -> [f64; 3] {
    let mut poses: Vec<[f64; 3]> = Vec::new();
    let mut next = f64::NEG_INFINITY;
    for sample in episode.pose.iter().filter(|p| p.pose.iter().all(|v| v.is_finite())) {
        if sample.t >= next {
            poses.push(sample.pose);
            next = sample.t + SPAN;
        }
    }
    extent(&poses, 1.0 / SPAN)
}

/// How far a motion goes: largest distance from its start, speed, and spin.
pub(super) fn extent(poses: &[[f64; 3]], rate: f64) -> [f64; 3] {
    let Some(&start) = poses.first() else { return [0.0; 3] };
    let moved = |a: [f64; 3], b: [f64; 3]| to_body([b[0] - a[0], b[1] - a[1], b[2] - a[2]], 0.0);
    let size = |[x, y, turn]: [f64; 3]| (x.hypot(y), turn.abs());
    let distance = poses.iter().map(|p| size(moved(start, *p)).0).fold(0.0, f64::max);
    let steps = poses.windows(2).map(|w| size(moved(w[0], w[1])));
    let (speed, spin) =
        steps.fold((0.0, 0.0), |(v, s): (f64, f64), (d, t)| (v.max(d * rate), s.max(t * rate)));
    [distance, speed, spin]
}
