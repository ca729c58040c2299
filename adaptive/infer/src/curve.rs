//! Wrench readings of an episode as a function of time. Between samples the curve is linear, or constant
//! where the readings are commands. It is constant beyond the first and last sample.

use trundle_model::{Clock, Real};
use trundle_record::{Noise, Prepared, wrapped};

/// Length of the intervals before and after a time from which the trend of the reading is computed, s. Noise
/// requires several samples.
const TREND_WINDOW_S: f64 = 0.05;

/// Deviation of three successive readings from a straight line, in standard deviations, above which the force
/// is taken to vary between samples.
const MIN_BEND_SD: f64 = 4.0;

/// Time constants after which a first-order lag has forgotten its input, up to a factor of 10⁻⁵.
const LAG_MEMORY: f64 = 12.0;

/// A first-order lag of the reading.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lagged {
    /// Value, reading axes.
    pub value: [f64; 3],
    /// Derivative by the time constant, 1/s.
    pub by_lag: [f64; 3],
    /// Time derivative, 1/s.
    pub rate: [f64; 3],
}

impl Lagged {
    /// Advances by `dt` seconds, over which the reading changes linearly.
    fn follow(&mut self, from: [f64; 3], to: [f64; 3], dt: f64, lag: f64) {
        if lag <= 0.0 {
            (self.value, self.by_lag) = (to, [0, 1, 2].map(|k| -(to[k] - from[k]) / dt));
            return;
        }
        // y = r − lag ṙ + (y₀ − r₀ + lag ṙ) e^(−dt/lag)
        let left = (-dt / lag).exp();
        let by_lag = left * dt / (lag * lag);
        for k in 0..3 {
            let slope = (to[k] - from[k]) / dt;
            let off = self.value[k] - from[k] + lag * slope;
            self.value[k] = to[k] - lag * slope + off * left;
            self.by_lag[k] = -slope + (self.by_lag[k] + slope) * left + off * by_lag;
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Knot {
    t: f64,
    reading: [f64; 3],
    frame: [f64; 3],
    blur: [f64; 3],
    /// Integral of the reading from the first sample.
    integral: [f64; 3],
    /// Variance of this integral caused by variation between samples.
    missing_variance: [f64; 3],
}

/// Mean reading over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanReading {
    /// Mean reading, reading axes.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame at the middle of the interval.
    pub frame: [f64; 3],
    /// Spacing of the samples, s.
    pub spacing: f64,
    /// Variance of the mean reading in addition to the sensor noise, caused by the frame's uncertainty and by
    /// variation between samples.
    pub spread: [f64; 3],
}

/// The wrench samples of an episode and its clock.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    knots: Vec<Knot>,
    contact: f64,
    episode: f64,
    held: bool,
    max_step: f64,
    /// Noise of one reading, standard deviations; zero if not required.
    sd: [f64; 3],
}

/// Maximum step of a simulation under densely sampled readings, s: two steps for each pose at 60 Hz. The
/// integrator is of second order and halves its steps where dry friction stops a body.
const MAX_STEP_S: f64 = 0.008;
/// Maximum step as a share of the median interval between readings, where this is longer. It limits the
/// number of steps of slow processes.
const MAX_STEP_PER_INTERVAL: f64 = 0.125;

/// Maximum step of a simulation under the readings of an episode, s.
fn max_step_s(episode: &Prepared) -> f64 {
    let mut intervals: Vec<f64> = episode.wrench.windows(2).map(|pair| pair[1].t - pair[0].t).collect();
    intervals.sort_by(f64::total_cmp);
    intervals
        .get(intervals.len() / 2)
        .map_or(MAX_STEP_S, |median| MAX_STEP_S.max(MAX_STEP_PER_INTERVAL * median))
}

impl Curve {
    /// The curve of an episode with at least one wrench sample, for a simulation without uncertainty.
    pub fn new(episode: &Prepared) -> Self {
        Self::with_volatility(episode, &vec![[0.0; 3]; episode.wrench.len()])
    }

    /// The same with the noise of the readings and the variance between samples.
    pub fn with_noise(episode: &Prepared, noise: &Noise) -> Self {
        let sd = [noise.force, noise.force, noise.torque];
        Self { sd, ..Self::with_volatility(episode, &volatility(episode, sd)) }
    }

    fn with_volatility(episode: &Prepared, volatility: &[[f64; 3]]) -> Self {
        let held = episode.zero_order_hold;
        let mut knots: Vec<Knot> = Vec::with_capacity(episode.wrench.len());
        for (index, sample) in episode.wrench.iter().enumerate() {
            let (mut integral, mut missing_variance) = ([0.0; 3], [0.0; 3]);
            if let Some(last) = knots.last() {
                let h = sample.t - last.t;
                let mean = |k: usize| {
                    if held { last.reading[k] } else { 0.5 * (last.reading[k] + sample.reading[k]) }
                };
                integral = [0, 1, 2].map(|k| last.integral[k] + h * mean(k));
                // The integral of a Brownian bridge whose increments have variance v over h has variance v h² / 12.
                let bridge = |k: usize| volatility[index - 1][k].max(volatility[index][k]) * h * h / 12.0;
                missing_variance = [0, 1, 2].map(|k| last.missing_variance[k] + bridge(k));
            }
            let (reading, frame, blur) = (sample.reading, sample.frame, sample.frame_noise);
            knots.push(Knot { t: sample.t, reading, frame, blur, integral, missing_variance });
        }
        let max_step = max_step_s(episode);
        Self {
            knots,
            contact: episode.contact,
            episode: episode.ordinal as f64,
            held,
            max_step,
            sd: [0.0; 3],
        }
    }

    /// Maximum step of a simulation under these readings, s.
    pub fn max_step(&self) -> f64 {
        self.max_step
    }

    /// Clock of the episode at a time of its table. The step's duration is zero.
    pub fn clock(&self, t: f64) -> Clock {
        let since_contact = Clock::since_contact(t - self.contact);
        Clock { t, episode: self.episode, ..since_contact }
    }

    /// Reading at a time and its integral up to it; `after` samples lie before the time.
    fn at(&self, t: f64, after: usize) -> ([f64; 3], [f64; 3]) {
        let held = |k: &Knot| (k.reading, [0, 1, 2].map(|i| k.integral[i] + (t - k.t) * k.reading[i]));
        let (Some(a), Some(b)) = self.neighbours(after) else {
            let end = if after == 0 { self.knots.first() } else { self.knots.last() };
            return end.map_or_else(Default::default, held);
        };
        if self.held {
            return held(a);
        }
        let (past, share) = (t - a.t, (t - a.t) / (b.t - a.t));
        let reading = [0, 1, 2].map(|k| a.reading[k] + share * (b.reading[k] - a.reading[k]));
        (reading, [0, 1, 2].map(|k| a.integral[k] + past / 2.0 * (a.reading[k] + reading[k])))
    }

    fn neighbours(&self, after: usize) -> (Option<&Knot>, Option<&Knot>) {
        (after.checked_sub(1).and_then(|k| self.knots.get(k)), self.knots.get(after))
    }

    fn count_before(&self, t: f64) -> usize {
        self.knots.partition_point(|k| k.t <= t)
    }

    /// Variance of the integral up to a time caused by variation between samples.
    fn missing_variance(&self, t: f64, after: usize) -> [f64; 3] {
        match self.neighbours(after) {
            (Some(a), Some(b)) => {
                let share = (t - a.t) / (b.t - a.t);
                [0, 1, 2]
                    .map(|k| a.missing_variance[k] + share * (b.missing_variance[k] - a.missing_variance[k]))
            }
            (Some(end), None) => end.missing_variance,
            (None, _) => [0.0; 3],
        }
    }

    /// Pose of the reading frame in the object frame at a time, and the variance of its uncertainty (see
    /// [`trundle_record::WrenchSample::frame_noise`]).
    pub fn frame(&self, t: f64) -> ([f64; 3], [f64; 3]) {
        match self.neighbours(self.count_before(t)) {
            (Some(a), Some(b)) => {
                let share = (t - a.t) / (b.t - a.t);
                let [dx, dy, turn] = [0, 1, 2].map(|k| b.frame[k] - a.frame[k]);
                let [x, y, angle] = a.frame;
                let frame = [x + share * dx, y + share * dy, angle + share * wrapped(turn)];
                (frame, [0, 1, 2].map(|k| a.blur[k] + share * (b.blur[k] - a.blur[k])))
            }
            (Some(end), None) | (None, Some(end)) => (end.frame, end.blur),
            (None, None) => ([0.0; 3], [0.0; 3]),
        }
    }

    /// Mean reading over an interval.
    pub fn mean(&self, from: f64, to: f64) -> MeanReading {
        let (first, end) = (self.count_before(from), self.count_before(to));
        let ((_, a), (_, b)) = (self.at(from, first), self.at(to, end));
        let (low, high) = (first.saturating_sub(1), end.min(self.knots.len().saturating_sub(1)));
        let spacing = match (self.knots.get(low), self.knots.get(high)) {
            (Some(a), Some(b)) if high > low => (b.t - a.t) / (high - low) as f64,
            _ => to - from,
        };
        let (frame, blur) = self.frame((from + to) / 2.0);
        let (start, stop) = (self.missing_variance(from, first), self.missing_variance(to, end));
        let dt = to - from;
        let spread = [0, 1, 2].map(|k| blur[k] / dt + (stop[k] - start[k]).max(0.0) / (dt * dt));
        MeanReading { reading: [0, 1, 2].map(|k| (b[k] - a[k]) / dt), frame, spacing, spread }
    }

    /// Clock at a time for an object held at the origin of `frame`, with the trend of the reading.
    pub fn clock_at_grasp(&self, t: f64, frame: [f64; 3]) -> Clock {
        Clock { grasp: [frame[0], frame[1]], trend: self.trend(t), ..self.clock(t) }
    }

    /// Clock of a step, with the noise of its mean reading from samples `spacing` apart.
    pub fn clock_of_step(&self, t: f64, dt: f64, frame: [f64; 3], spacing: f64) -> Clock {
        let of_mean = (spacing / dt).sqrt();
        let of_trend = (2.0 * (spacing / TREND_WINDOW_S).min(1.0)).sqrt() / TREND_WINDOW_S;
        let noise = [of_mean, of_trend].map(|factor| self.sd.map(|sd| factor * sd));
        Clock { dt, noise, ..self.clock_at_grasp(t, frame) }
    }

    /// Rate of change of the reading around a time, 1/s.
    fn trend(&self, t: f64) -> [f64; 3] {
        let (before, after) =
            (self.mean(t - TREND_WINDOW_S, t).reading, self.mean(t, t + TREND_WINDOW_S).reading);
        [0, 1, 2].map(|k| (after[k] - before[k]) / TREND_WINDOW_S)
    }

    /// Reading at a time and its rate of change, 1/s.
    pub fn value(&self, t: f64) -> ([f64; 3], [f64; 3]) {
        let after = self.count_before(t);
        let rate = match self.neighbours(after) {
            (Some(a), Some(b)) if !self.held => {
                [0, 1, 2].map(|k| (b.reading[k] - a.reading[k]) / (b.t - a.t))
            }
            _ => [0.0; 3],
        };
        (self.at(t, after).0, rate)
    }

    /// The reading filtered by a first-order lag, `lag ẏ + y = r`.
    pub fn lagged(&self, t: f64, lag: f64) -> Lagged {
        let end = self.count_before(t);
        let first = self.count_before(t - LAG_MEMORY * lag).saturating_sub(1);
        let Some(oldest) = self.knots.get(first) else { return Lagged::default() };
        let mut at = oldest.t.min(t);
        let mut read = self.at(at, self.count_before(at)).0;
        let mut y = Lagged { value: read, ..Lagged::default() };
        for k in first + 1..=end {
            let knot = self.knots.get(k).filter(|_| k < end);
            let (to, next) = knot.map_or_else(|| (t, self.at(t, end).0), |knot| (knot.t, knot.reading));
            if to > at {
                y.follow(read, if self.held { read } else { next }, to - at, lag);
            }
            (at, read) = (to, next);
        }
        y.rate = [0, 1, 2].map(|k| if lag > 0.0 { (read[k] - y.value[k]) / lag } else { 0.0 });
        y
    }

    /// Mean reading over an interval for readings that are late by `delay` seconds.
    pub fn delayed_mean<T: Real>(&self, from: f64, to: f64, delay: T) -> [T; 3] {
        let (from, to) = (from + delay.re(), to + delay.re());
        let ((start, a), (stop, b)) =
            (self.at(from, self.count_before(from)), self.at(to, self.count_before(to)));
        let length = to - from;
        [0, 1, 2].map(|k| T::chained((b[k] - a[k]) / length, [(delay, (stop[k] - start[k]) / length)]))
    }
}

/// Variance of the change of the force over a sample interval, at each sample. For a random walk it is half
/// of the squared second difference. It is zero where the second difference is within the sensor noise, whose
/// second difference has six times its variance. An impact shorter than a sample interval and a step give a
/// nonzero value; a ramp does not.
fn volatility(episode: &Prepared, sd: [f64; 3]) -> Vec<[f64; 3]> {
    let mut found = vec![[0.0; 3]; episode.wrench.len()];
    if episode.zero_order_hold {
        return found; // a command is exact at all times
    }
    for (k, three) in episode.wrench.windows(3).enumerate() {
        let share = (three[1].t - three[0].t) / (three[2].t - three[0].t);
        found[k + 1] = [0, 1, 2].map(|i| {
            let [a, b, c] = [0, 1, 2].map(|j: usize| three[j].reading[i]);
            let bend = 2.0 * (b - a - share * (c - a));
            let noise = 6.0 * sd[i] * sd[i];
            if bend * bend > MIN_BEND_SD * MIN_BEND_SD * noise { 0.5 * (bend * bend - noise) } else { 0.0 }
        });
    }
    found
}

#[cfg(test)]
mod tests;
