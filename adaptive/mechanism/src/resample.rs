//! Samples at irregular times, brought to a uniform grid.

/// Uniform times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    /// First time, s.
    pub start: f64,
    /// Interval, s.
    pub dt: f64,
    /// Number of times.
    pub len: usize,
}

impl Grid {
    /// Time of sample `k`, s.
    pub fn t(&self, k: usize) -> f64 {
        self.start + k as f64 * self.dt
    }

    /// The times.
    pub fn times(&self) -> Vec<f64> {
        (0..self.len).map(|k| self.t(k)).collect()
    }
}

/// Median interval between times, s; `None` for fewer than two.
pub(crate) fn median_interval(t: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Index of the last time that is not after `at`.
fn before(t: &[f64], at: f64) -> usize {
    t.partition_point(|time| *time <= at).saturating_sub(1)
}

/// Mean of samples that are held until the next one, over the intervals of the grid; the first value before the first
/// sample. Values at the times of the grid alone would be half an interval early.
pub(crate) fn held(t: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    (0..grid.len)
        .map(|k| mean_held(t, values, grid.t(k) - grid.dt / 2.0, grid.t(k) + grid.dt / 2.0))
        .collect()
}

fn mean_held(t: &[f64], values: &[f64], from: f64, to: f64) -> f64 {
    let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
    let (first, last) = (before(t, from), before(t, to));
    let one = |k: usize| {
        let start = if k == first { from } else { t[k] };
        let end = if k == last { to } else { t[k + 1] };
        value(k) * (end - start) / (to - from)
    };
    if first == last { value(first) } else { (first..=last).map(one).sum() }
}

/// Measured samples: their mean over the intervals of the grid where there are several, else the cubic through the
/// neighbours (Catmull-Rom), with constant continuation at the ends.
pub(crate) fn interpolated(t: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    (0..grid.len).map(|k| at(t, values, grid.t(k), grid.dt)).collect()
}

fn at(t: &[f64], values: &[f64], time: f64, dt: f64) -> f64 {
    let (Some(first), Some(last)) = (t.first(), t.last()) else { return 0.0 };
    if time <= *first || time >= *last {
        return if time <= *first { values[0] } else { values[values.len() - 1] };
    }
    let (from, to) =
        (t.partition_point(|x| *x < time - dt / 2.0), t.partition_point(|x| *x < time + dt / 2.0));
    if to - from >= 3 {
        // The mean belongs to the mean time; a linear trend brings it to the middle of the interval.
        let count = (to - from) as f64;
        let mean_t = t[from..to].iter().sum::<f64>() / count;
        let mean = values[from..to].iter().sum::<f64>() / count;
        let slope = (values[to - 1] - values[from]) / (t[to - 1] - t[from]);
        return mean + slope * (time - mean_t);
    }
    let i = before(t, time).min(t.len() - 2);
    let h = t[i + 1] - t[i];
    let x = (time - t[i]) / h;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(t.len() - 1));
        (values[b] - values[a]) / (t[b] - t[a])
    };
    let (m0, m1) = (slope(i) * h, slope(i + 1) * h);
    let (y0, y1) = (values[i], values[i + 1]);
    y0 + x * (m0 + x * (3.0 * (y1 - y0) - 2.0 * m0 - m1 + x * (2.0 * (y0 - y1) + m0 + m1)))
}

/// Whether each grid time lies in a gap of more than `largest` seconds between samples.
pub(crate) fn in_gap(t: &[f64], grid: &Grid, largest: f64) -> Vec<bool> {
    (0..grid.len)
        .map(|k| {
            let time = grid.t(k);
            let i = before(t, time);
            match (t.get(i), t.get(i + 1)) {
                (Some(a), Some(b)) => *a > time || b - a > largest,
                (Some(a), None) => time - a > largest,
                _ => true,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { start: 0.0, dt: 0.01, len: 101 };

    #[test]
    fn a_parabola_is_interpolated_exactly_inside() {
        let t: Vec<f64> = (0..60).map(|k| k as f64 * 0.0171).collect();
        let values: Vec<f64> = t.iter().map(|t| 1.0 + t - 3.0 * t * t).collect();
        for (k, found) in interpolated(&t, &values, &GRID).iter().enumerate().skip(5).take(80) {
            let time = GRID.t(k);
            assert!((found - (1.0 + time - 3.0 * time * time)).abs() < 1e-9);
        }
    }

    #[test]
    fn commands_are_held() {
        let found = held(&[0.0, 0.5], &[1.0, 2.0], &GRID);
        // The interval around the step contains both halves.
        let expected = [1.0, 1.5, 2.0];
        assert!(
            found[49..=51].iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-12),
            "{:?}",
            &found[49..=51]
        );
    }

    #[test]
    fn gaps_are_found() {
        let found = in_gap(&[0.0, 0.1, 0.6, 0.7, 1.0], &GRID, 0.4);
        assert!(!found[5] && found[30] && !found[65] && !found[99]);
    }
}
