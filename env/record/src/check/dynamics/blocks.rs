//! Blocks of rows, and the mean reading over each at any lag.

use crate::episode::Gripper;
use crate::metadata::Metadata;
use crate::motion::Motion;
use crate::prepare::{latest, median, median_step};

use super::super::subject::{Look, Subject};
use super::moments::Moments;
use super::regressors::{COLUMNS, Convention, Row, Scale, row};

/// Poses that a block spans: the smoothed acceleration is no finer.
const POSES: f64 = 3.0;
/// Blocks that suffice.
const MOST: f64 = 2000.0;
/// Blocks this many times as long as usual lie across a drop-out.
const ACROSS: f64 = 3.0;
/// Twist in standard deviations from which on the object moves.
const MOVES: f64 = 3.0;
/// Largest lag that is looked for, in lengths of a push.
const LAG: f64 = 1.0 / 12.0;
/// Windows of an episode, each with sums of its own.
pub(crate) const WINDOWS: usize = 6;

/// One block.
#[derive(Debug, Clone)]
struct Block {
    look: usize,
    window: usize,
    span: [f64; 2],
    row: Row,
}

/// All blocks of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    blocks: Vec<Block>,
    pub scale: Scale,
    /// Largest lag that is looked for, s.
    pub range: f64,
    /// Number of windows, [`WINDOWS`] for each episode.
    pub windows: usize,
}

/// Readings that can be averaged over any interval.
#[derive(Debug, Clone)]
pub(crate) struct Readings {
    looks: Vec<Integral>,
}

impl Blocks {
    /// Rows of each episode under a convention; none where there is too little motion.
    pub fn new(subject: &Subject, convention: Convention) -> Self {
        let scale = Scale::new(subject.dataset.body.bounds());
        let range = LAG * median(subject.episodes.iter().map(length)).unwrap_or(0.0);
        let width = width(subject);
        let mut all = Self { blocks: vec![], scale, range, windows: WINDOWS * subject.episodes.len() };
        for (index, look) in subject.episodes.iter().enumerate() {
            all.add(subject.meta, index, look, width, convention);
        }
        all
    }

    fn add(&mut self, meta: &Metadata, index: usize, look: &Look, width: f64, convention: Convention) {
        let Some([from, to]) = usable(look, self.range) else { return };
        let motion: Vec<&Motion> = look.motion.iter().filter(|m| m.t >= from && m.t <= to).collect();
        let grip = Grip::new(meta, look);
        let rows: Vec<Row> = motion.iter().map(|m| row(m, &grip.at(m), &self.scale, convention)).collect();
        let mut start = 0;
        for end in 1..motion.len() {
            let span = [motion[start].t, motion[end].t];
            if span[1] - span[0] < width * (1.0 - 1e-9) {
                continue;
            }
            let moving = (start..=end).any(|i| moves(motion[i]));
            if moving && span[1] - span[0] < ACROSS * width {
                let times: Vec<f64> = motion[start..=end].iter().map(|m| m.t).collect();
                let row = mean(&times, &rows[start..=end]);
                let share = (span[0] - from) / (to - from).max(f64::MIN_POSITIVE);
                let window = ((share * WINDOWS as f64) as usize).min(WINDOWS - 1);
                self.blocks.push(Block { look: index, window: WINDOWS * index + window, span, row });
            }
            start = end;
        }
    }

    /// Length of a window, s.
    pub fn window(&self) -> f64 {
        self.range / LAG / WINDOWS as f64
    }

    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Sums of each window, the readings taken `lag` later than the motion.
    pub fn moments(&self, readings: &Readings, lag: f64) -> Vec<Moments> {
        self.sums(readings, |_| lag, Moments::add)
    }

    /// The same with a lag for each window.
    pub fn moments_at(&self, readings: &Readings, lag: &[f64]) -> Vec<Moments> {
        self.sums(readings, |window| lag[window], Moments::add)
    }

    /// Sums of each window without those of the regressors.
    pub fn loads(&self, readings: &Readings, lag: f64) -> Vec<Moments> {
        self.sums(readings, |_| lag, Moments::add_load_of)
    }

    fn sums(
        &self,
        readings: &Readings,
        lag: impl Fn(usize) -> f64,
        add: impl Fn(&mut Moments, &Row, &[f64; 3]),
    ) -> Vec<Moments> {
        let mut sums = vec![Moments::new(); self.windows];
        for block in &self.blocks {
            let lag = lag(block.window);
            let mut load = readings.looks[block.look].mean(block.span[0] + lag, block.span[1] + lag);
            load[2] /= self.scale.arm;
            add(&mut sums[block.window], &block.row, &load);
        }
        sums
    }
}

/// Length of a block, s.
fn width(subject: &Subject) -> f64 {
    let steps = |look: &Look| {
        let t: Vec<f64> = look.motion.iter().map(|m| m.t).collect();
        let wrench: Vec<f64> = look.prepared.wrench.iter().map(|w| w.t).collect();
        Some((POSES * median_step(&t)?).max(median_step(&wrench)?))
    };
    let usual = median(subject.episodes.iter().filter_map(steps)).unwrap_or(0.0);
    usual.max(subject.episodes.iter().map(length).sum::<f64>() / MOST)
}

/// From contact to the end, s.
fn length(look: &Look) -> f64 {
    let end = look.motion.last().map_or(look.prepared.contact, |m| m.t);
    (end - look.prepared.contact).max(0.0)
}

/// Times at which motion and reading are known at any lag.
fn usable(look: &Look, range: f64) -> Option<[f64; 2]> {
    let (first, last) = (look.prepared.wrench.first()?.t, look.prepared.wrench.last()?.t);
    let from = (look.prepared.contact - range).max(first + range);
    (last - range > from).then_some([from, last - range])
}

fn moves(motion: &Motion) -> bool {
    (0..3).any(|k| motion.twist[k].abs() > MOVES * motion.cov[k][1][1].sqrt() && motion.twist[k] != 0.0)
}

/// Mean over time of rows, by the trapezoidal rule.
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

/// The gripper's poses, single spikes taken out.
struct Grip {
    t: Vec<f64>,
    pose: Vec<[f64; 3]>,
}

impl Grip {
    fn new(meta: &Metadata, look: &Look) -> Self {
        let none = Self { t: vec![], pose: vec![] };
        if meta.on_rail() {
            return none;
        }
        let (t, mut pose): (Vec<f64>, Vec<[f64; 3]>) = match look.episode.gripper() {
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
        let despiked: Vec<[f64; 3]> = (0..pose.len())
            .map(|i| if i == 0 || i + 1 == pose.len() { pose[i] } else { middle(i) })
            .collect();
        Self { t, pose: despiked }
    }

    /// The pose at the time of a motion, linear between samples; that of the object where there is none.
    fn at(&self, motion: &Motion) -> [f64; 3] {
        let Some(&last) = self.pose.last() else { return motion.pose };
        let Some(i) = latest(&self.t, motion.t) else { return self.pose[0] };
        let (Some(next), Some(t)) = (self.pose.get(i + 1), self.t.get(i + 1)) else { return last };
        let share = (motion.t - self.t[i]) / (t - self.t[i]);
        [0, 1, 2].map(|k| self.pose[i][k] + share * (next[k] - self.pose[i][k]))
    }
}

impl Readings {
    /// The tared readings, each after `change`.
    pub fn new(subject: &Subject, change: impl Fn(&[f64; 3]) -> [f64; 3]) -> Self {
        let of = |look: &Look| {
            let samples = look.prepared.wrench.iter().map(|w| (w.t, change(&w.reading)));
            Integral::new(samples.unzip())
        };
        Self { looks: subject.episodes.iter().map(of).collect() }
    }
}

/// The integral of a reading that is linear between its samples.
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
