//! Blocks of rows, and the mean reading of each block at any lag.

use crate::episode::Gripper;
use crate::metadata::Metadata;
use crate::motion::Motion;
use crate::prepare::{latest, median, median_step};

use super::super::data::{EpisodeData, RecordingData};
use super::normal_equations::NormalEquations;
use super::regressors::{COLUMNS, Convention, Row, Scale, row};

/// Poses per block. The smoothed acceleration has no finer resolution.
const POSES_PER_BLOCK: f64 = 3.0;
/// Approximate maximum number of blocks.
const MAX_BLOCKS: f64 = 2000.0;
/// Relative length above which a block spans a drop-out.
const MAX_RELATIVE_LENGTH: f64 = 3.0;
/// Minimum twist of a moving object in standard deviations.
const MIN_TWIST_SD: f64 = 3.0;
/// Largest lag of the search as a share of the length of a push.
const MAX_LAG_SHARE: f64 = 1.0 / 12.0;
/// Number of windows per episode. Each window has its own normal equations.
pub(crate) const WINDOWS_PER_EPISODE: usize = 6;

/// A block of consecutive samples.
#[derive(Debug, Clone)]
struct Block {
    episode: usize,
    window: usize,
    span: [f64; 2],
    row: Row,
}

/// All blocks of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    blocks: Vec<Block>,
    pub scale: Scale,
    /// Largest lag of the search, s.
    pub range: f64,
    /// Total number of windows, [`WINDOWS_PER_EPISODE`] per episode.
    pub windows: usize,
}

/// Readings of all episodes, for averages over any interval.
#[derive(Debug, Clone)]
pub(crate) struct Readings {
    integrals: Vec<Integral>,
}

impl Blocks {
    /// Blocks of all episodes under a convention. Empty if there is too little motion.
    pub fn new(data: &RecordingData, convention: Convention) -> Self {
        let scale = Scale::new(data.dataset.body.bounds());
        let range = MAX_LAG_SHARE * median(data.episodes.iter().map(length)).unwrap_or(0.0);
        let width = width(data);
        let mut all =
            Self { blocks: vec![], scale, range, windows: WINDOWS_PER_EPISODE * data.episodes.len() };
        for (index, episode) in data.episodes.iter().enumerate() {
            all.add(data.meta, index, episode, width, convention);
        }
        all
    }

    fn add(
        &mut self,
        meta: &Metadata,
        index: usize,
        episode: &EpisodeData,
        width: f64,
        convention: Convention,
    ) {
        let Some([from, to]) = usable(episode, self.range) else { return };
        let motion: Vec<&Motion> = episode.motion.iter().filter(|m| m.t >= from && m.t <= to).collect();
        let gripper = GripperPath::new(meta, episode);
        let rows: Vec<Row> = motion.iter().map(|m| row(m, &gripper.at(m), &self.scale, convention)).collect();
        let mut start = 0;
        for end in 1..motion.len() {
            let span = [motion[start].t, motion[end].t];
            if span[1] - span[0] < width * (1.0 - 1e-9) {
                continue;
            }
            let moving = (start..=end).any(|i| moves(motion[i]));
            if moving && span[1] - span[0] < MAX_RELATIVE_LENGTH * width {
                let times: Vec<f64> = motion[start..=end].iter().map(|m| m.t).collect();
                let row = mean(&times, &rows[start..=end]);
                let share = (span[0] - from) / (to - from).max(f64::MIN_POSITIVE);
                let window = ((share * WINDOWS_PER_EPISODE as f64) as usize).min(WINDOWS_PER_EPISODE - 1);
                self.blocks.push(Block {
                    episode: index,
                    window: WINDOWS_PER_EPISODE * index + window,
                    span,
                    row,
                });
            }
            start = end;
        }
    }

    /// Typical length of a window, s.
    pub fn window(&self) -> f64 {
        self.range / MAX_LAG_SHARE / WINDOWS_PER_EPISODE as f64
    }

    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Normal equations of each window, with readings `lag` later than the motion.
    pub fn normal_equations(&self, readings: &Readings, lag: f64) -> Vec<NormalEquations> {
        self.sums(readings, |_| lag, NormalEquations::add)
    }

    /// Normal equations of each window, with a lag per window.
    pub fn normal_equations_at(&self, readings: &Readings, lag: &[f64]) -> Vec<NormalEquations> {
        self.sums(readings, |window| lag[window], NormalEquations::add)
    }

    /// Right-hand sides of each window, without the normal matrices.
    pub fn right_hand_sides(&self, readings: &Readings, lag: f64) -> Vec<NormalEquations> {
        self.sums(readings, |_| lag, NormalEquations::add_load_of)
    }

    fn sums(
        &self,
        readings: &Readings,
        lag: impl Fn(usize) -> f64,
        add: impl Fn(&mut NormalEquations, &Row, &[f64; 3]),
    ) -> Vec<NormalEquations> {
        let mut sums = vec![NormalEquations::new(); self.windows];
        for block in &self.blocks {
            let lag = lag(block.window);
            let mut load = readings.integrals[block.episode].mean(block.span[0] + lag, block.span[1] + lag);
            load[2] /= self.scale.arm;
            add(&mut sums[block.window], &block.row, &load);
        }
        sums
    }
}

/// Length of a block, s.
fn width(data: &RecordingData) -> f64 {
    let steps = |episode: &EpisodeData| {
        let t: Vec<f64> = episode.motion.iter().map(|m| m.t).collect();
        let wrench: Vec<f64> = episode.prepared.wrench.iter().map(|w| w.t).collect();
        Some((POSES_PER_BLOCK * median_step(&t)?).max(median_step(&wrench)?))
    };
    let usual = median(data.episodes.iter().filter_map(steps)).unwrap_or(0.0);
    usual.max(data.episodes.iter().map(length).sum::<f64>() / MAX_BLOCKS)
}

/// Time from contact to the last motion, s.
fn length(episode: &EpisodeData) -> f64 {
    let end = episode.motion.last().map_or(episode.prepared.contact, |m| m.t);
    (end - episode.prepared.contact).max(0.0)
}

/// Interval in which motion and readings are known for all lags, s.
fn usable(episode: &EpisodeData, range: f64) -> Option<[f64; 2]> {
    let (first, last) = (episode.prepared.wrench.first()?.t, episode.prepared.wrench.last()?.t);
    let from = (episode.prepared.contact - range).max(first + range);
    (last - range > from).then_some([from, last - range])
}

fn moves(motion: &Motion) -> bool {
    (0..3)
        .any(|k| motion.twist[k].abs() > MIN_TWIST_SD * motion.cov[k][1][1].sqrt() && motion.twist[k] != 0.0)
}

/// Time average of rows, by the trapezoidal rule.
fn mean(t: &[f64], rows: &[Row]) -> Row {
    let span = t[t.len() - 1] - t[0];
    let mut sum = [[0.0; COLUMNS]; 3];
    for (i, row) in rows.iter().enumerate() {
        let before = if i > 0 { t[i] - t[i - 1] } else { 0.0 };
        let after = if i + 1 < t.len() { t[i + 1] - t[i] } else { 0.0 };
        let weight = (before + after) / 2.0 / span;
        for (sums, values) in sum.iter_mut().zip(row) {
            sums.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
        }
    }
    sum
}

/// Poses of the gripper, filtered with a median of three.
struct GripperPath {
    t: Vec<f64>,
    pose: Vec<[f64; 3]>,
}

impl GripperPath {
    fn new(meta: &Metadata, episode: &EpisodeData) -> Self {
        let none = Self { t: vec![], pose: vec![] };
        if meta.on_rail() {
            return none;
        }
        let (t, mut pose): (Vec<f64>, Vec<[f64; 3]>) = match episode.raw.gripper() {
            None => return none,
            Some(Gripper::Level(stream)) => (stream.t, stream.value),
            Some(Gripper::Tilting(stream)) => {
                let heading = |v: &[f64; 7]| [v[0], v[1], 2.0 * v[6].atan2(v[3])];
                (stream.t, stream.value.iter().map(heading).collect())
            }
        };
        for i in 1..pose.len() {
            let before = pose[i - 1][2];
            pose[i][2] = before + crate::prepare::wrapped(pose[i][2] - before);
        }
        let middle = |i: usize| {
            let near = &pose[i.saturating_sub(1)..(i + 2).min(pose.len())];
            [0, 1, 2].map(|k| median(near.iter().map(|p| p[k])).unwrap_or(0.0))
        };
        let filtered: Vec<[f64; 3]> = (0..pose.len())
            .map(|i| if i == 0 || i + 1 == pose.len() { pose[i] } else { middle(i) })
            .collect();
        Self { t, pose: filtered }
    }

    /// Linearly interpolated pose at the time of `motion`; the pose of the object without gripper poses.
    fn at(&self, motion: &Motion) -> [f64; 3] {
        let Some(&last) = self.pose.last() else { return motion.pose };
        let Some(i) = latest(&self.t, motion.t) else { return self.pose[0] };
        let (Some(next), Some(t)) = (self.pose.get(i + 1), self.t.get(i + 1)) else { return last };
        let share = (motion.t - self.t[i]) / (t - self.t[i]);
        [0, 1, 2].map(|k| self.pose[i][k] + share * (next[k] - self.pose[i][k]))
    }
}

impl Readings {
    /// The tared readings, transformed by `transform`.
    pub fn new(data: &RecordingData, transform: impl Fn(&[f64; 3]) -> [f64; 3]) -> Self {
        let of = |episode: &EpisodeData| {
            let samples = episode.prepared.wrench.iter().map(|w| (w.t, transform(&w.reading)));
            Integral::new(samples.unzip())
        };
        Self { integrals: data.episodes.iter().map(of).collect() }
    }
}

/// Integral of readings that are linear between their samples.
#[derive(Debug, Clone)]
struct Integral {
    t: Vec<f64>,
    value: Vec<[f64; 3]>,
    sum: Vec<[f64; 3]>,
}

impl Integral {
    fn new((t, value): (Vec<f64>, Vec<[f64; 3]>)) -> Self {
        let mut sum = vec![[0.0; 3]; t.len()];
        for i in 1..t.len() {
            let dt = t[i] - t[i - 1];
            sum[i] = [0, 1, 2].map(|k| sum[i - 1][k] + dt * (value[i][k] + value[i - 1][k]) / 2.0);
        }
        Self { t, value, sum }
    }

    fn until(&self, t: f64) -> [f64; 3] {
        let n = self.t.len();
        if n < 2 {
            return [0.0; 3];
        }
        let i = latest(&self.t, t).unwrap_or(0).min(n - 2);
        let (h, dt) = (t - self.t[i], self.t[i + 1] - self.t[i]);
        [0, 1, 2].map(|k| {
            let slope = (self.value[i + 1][k] - self.value[i][k]) / dt;
            self.sum[i][k] + h * (self.value[i][k] + slope * h / 2.0)
        })
    }

    fn mean(&self, from: f64, to: f64) -> [f64; 3] {
        let (a, b) = (self.until(from), self.until(to));
        [0, 1, 2].map(|k| (b[k] - a[k]) / (to - from))
    }
}
