//! An episode's readings as a curve: linear between samples, held beyond the first and the last.

use trundle_model::{Clock, Real};
use trundle_record::Prepared;

/// Before and after a moment, what the reading's trend is taken from, s: noise needs some samples.
const TREND: f64 = 0.05;

#[derive(Clone, Copy, Debug)]
struct Knot {
    t: f64,
    reading: [f64; 3],
    frame: [f64; 3],
    /// Integral of the reading from the first sample on.
    sum: [f64; 3],
}

/// The wrench samples of an episode, and where its clock stands.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    knots: Vec<Knot>,
    contact: f64,
    episode: f64,
}

impl Curve {
    /// Of an episode with at least one wrench sample.
    pub fn new(episode: &Prepared) -> Self {
        let mut knots: Vec<Knot> = Vec::with_capacity(episode.wrench.len());
        for sample in &episode.wrench {
            let sum = knots.last().map_or([0.0; 3], |last| {
                let half = (sample.t - last.t) / 2.0;
                [0, 1, 2].map(|k| last.sum[k] + half * (last.reading[k] + sample.reading[k]))
            });
            knots.push(Knot { t: sample.t, reading: sample.reading, frame: sample.frame, sum });
        }
        Self { knots, contact: episode.contact, episode: episode.ordinal as f64 }
    }

    /// The clock of the episode at a time of its table; a step's duration is left at zero.
    pub fn clock(&self, t: f64) -> Clock {
        let since_contact = Clock::since_contact(t - self.contact);
        Clock { t, episode: self.episode, ..since_contact }
    }

    /// The reading at a time, and its integral up to it, before which lie `after` samples.
    fn at(&self, t: f64, after: usize) -> ([f64; 3], [f64; 3]) {
        let held = |k: &Knot| (k.reading, [0, 1, 2].map(|i| k.sum[i] + (t - k.t) * k.reading[i]));
        let (Some(a), Some(b)) =
            (after.checked_sub(1).and_then(|k| self.knots.get(k)), self.knots.get(after))
        else {
            let end = if after == 0 { self.knots.first() } else { self.knots.last() };
            return end.map_or_else(Default::default, held);
        };
        let (past, share) = (t - a.t, (t - a.t) / (b.t - a.t));
        let reading = [0, 1, 2].map(|k| a.reading[k] + share * (b.reading[k] - a.reading[k]));
        (reading, [0, 1, 2].map(|k| a.sum[k] + past / 2.0 * (a.reading[k] + reading[k])))
    }

    fn before(&self, t: f64) -> usize {
        self.knots.partition_point(|k| k.t <= t)
    }

    /// Mean reading over an interval, the frame in its middle, and the spacing of samples, s.
    pub fn mean(&self, from: f64, to: f64) -> ([f64; 3], [f64; 3], f64) {
        let (first, end) = (self.before(from), self.before(to));
        let ((_, a), (_, b)) = (self.at(from, first), self.at(to, end));
        let middle = self.before((from + to) / 2.0).saturating_sub(1);
        let (low, high) = (first.saturating_sub(1), end.min(self.knots.len().saturating_sub(1)));
        let spacing = match (self.knots.get(low), self.knots.get(high)) {
            (Some(a), Some(b)) if high > low => (b.t - a.t) / (high - low) as f64,
            _ => to - from,
        };
        let frame = self.knots.get(middle).map_or([0.0; 3], |k| k.frame);
        ([0, 1, 2].map(|k| (b[k] - a[k]) / (to - from)), frame, spacing)
    }

    /// The same where the object is held in a frame, and the reading changes as it does there.
    pub fn held(&self, t: f64, frame: [f64; 3]) -> Clock {
        Clock { grasp: [frame[0], frame[1]], trend: self.trend(t), ..self.clock(t) }
    }

    /// How fast the reading changes about a time, 1/s.
    fn trend(&self, t: f64) -> [f64; 3] {
        let (before, after) = (self.mean(t - TREND, t).0, self.mean(t, t + TREND).0);
        [0, 1, 2].map(|k| (after[k] - before[k]) / TREND)
    }

    /// Mean reading over an interval where what happened is read `delay` seconds later.
    pub fn late<T: Real>(&self, from: f64, to: f64, delay: T) -> [T; 3] {
        let (from, to) = (from + delay.re(), to + delay.re());
        let ((start, a), (stop, b)) = (self.at(from, self.before(from)), self.at(to, self.before(to)));
        let length = to - from;
        [0, 1, 2].map(|k| T::chained((b[k] - a[k]) / length, [(delay, (stop[k] - start[k]) / length)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::Dual;
    use trundle_record::{Counts, WrenchSample};

    fn ramp() -> Curve {
        let sample =
            |k: usize| WrenchSample { t: k as f64 * 0.1, reading: [k as f64, 0.0, 0.0], frame: [0.0; 3] };
        Curve::new(&Prepared {
            name: "push".to_owned(),
            ordinal: 0,
            wrench: (0..6).map(sample).collect(),
            pose: vec![],
            contact: 0.0,
            tare_sd: [0.0; 3],
            at_rest: true,
            counts: Counts::default(),
            memo: Default::default(),
        })
    }

    #[test]
    fn the_mean_of_a_ramp_is_its_middle() {
        for (from, to) in [(0.0, 0.5), (0.03, 0.07), (0.15, 0.45), (0.2, 0.3)] {
            let (mean, _, spacing) = ramp().mean(from, to);
            assert!((mean[0] - 5.0 * (from + to)).abs() < 1e-12, "{from} {to} {mean:?}");
            assert!((spacing - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ramp_has_its_trend() {
        assert!((ramp().trend(0.25)[0] - 10.0).abs() < 1e-9);
    }

    #[test]
    fn readings_are_held_beyond_their_ends() {
        assert!((ramp().mean(-0.2, -0.1).0[0]).abs() < 1e-12);
        assert!((ramp().mean(0.6, 0.7).0[0] - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_late_reading_is_that_of_later_and_has_its_slope() {
        let late = ramp().late(0.12, 0.16, Dual::<1>::variable(0.05, 0));
        assert!((late[0].re - 1.9).abs() < 1e-12 && (late[0].eps[0] - 10.0).abs() < 1e-9, "{late:?}");
    }
}
