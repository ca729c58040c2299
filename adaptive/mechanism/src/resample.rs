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

/// Samples that are held until the next one, as a smooth signal; the first value before the first sample.
///
/// A held sample belongs to the middle of its interval. Holding also attenuates, by sinc(f T): to second order the same
/// as adding a 24th of the second difference. Where there are several samples in an interval of the grid, their mean is
/// used. Samples that are held for longer, such as those of a stream that records changes only, are repeated.
pub(crate) fn held(t: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    if median_interval(t).is_some_and(|interval| 3.0 * interval <= grid.dt) {
        return centred(held_means(t, values, grid));
    }
    let (middle, pieces) = pieces(t, values, grid);
    let smooth = |k: usize| pieces[k] + second_difference(&pieces, k) / 24.0;
    interpolated(&middle, &(0..pieces.len()).map(smooth).collect::<Vec<f64>>(), grid)
}

/// Held samples as pieces of about the median interval: the middle times of the pieces, and their values. The last sample
/// is held to the end of the grid.
fn pieces(t: &[f64], values: &[f64], grid: &Grid) -> (Vec<f64>, Vec<f64>) {
    let (mut middle, mut found) = (vec![], vec![]);
    let usual = median_interval(t).unwrap_or(grid.dt).max(f64::MIN_POSITIVE);
    let end = grid.t(grid.len);
    for (k, value) in values.iter().enumerate() {
        let until = t.get(k + 1).copied().unwrap_or(end.max(t[k] + usual));
        let count = ((until - t[k]) / usual).round().max(1.0);
        let length = (until - t[k]) / count;
        for piece in 0..count as usize {
            middle.push(t[k] + (piece as f64 + 0.5) * length);
            found.push(*value);
        }
    }
    (middle, found)
}

/// Means over the intervals of the grid of samples that are held until the next one.
pub(crate) fn held_means(t: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let half = grid.dt / 2.0;
    (0..grid.len).map(|k| mean_held(t, values, grid.t(k) - half, grid.t(k) + half)).collect()
}

fn second_difference(values: &[f64], k: usize) -> f64 {
    let (before, after) = (k.saturating_sub(1), (k + 1).min(values.len() - 1));
    values[after] - 2.0 * values[k] + values[before]
}

/// Values in the middle of the intervals whose means are given, to third order.
fn centred(means: Vec<f64>) -> Vec<f64> {
    (0..means.len()).map(|k| means[k] - second_difference(&means, k) / 24.0).collect()
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

/// Measured samples: from their mean over the intervals of the grid where there are several, else the cubic through the
/// neighbours (Catmull-Rom), with constant continuation at the ends.
pub(crate) fn interpolated(t: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let found = (0..grid.len).map(|k| at(t, values, grid.t(k), grid.dt)).collect();
    let has_means = median_interval(t).is_some_and(|interval| 3.0 * interval <= grid.dt);
    if has_means { centred(found) } else { found }
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
    fn held_commands_are_late_by_half_an_interval() {
        let command = |t: f64| (3.0 * t).sin();
        for (interval, error) in [(0.02, 2e-5), (0.002, 2e-5)] {
            let t: Vec<f64> = (0..600).map(|k| f64::from(k) * interval).collect();
            let values: Vec<f64> = t.iter().map(|t| command(*t)).collect();
            let found = held(&t, &values, &GRID);
            for (k, found) in found.iter().enumerate().take(80).skip(20) {
                let expected = command(GRID.t(k) - interval / 2.0) * (1.0 - (3.0 * interval).powi(2) / 24.0);
                assert!((found - expected).abs() < error, "{interval} {k}: {found} {expected}");
            }
        }
    }

    #[test]
    fn repeated_commands_may_be_left_out() {
        let t: Vec<f64> = (0..101).map(|k| f64::from(k) * 0.01).collect();
        let ramp_then_rest = |t: &f64| t.min(0.4) + f64::from(u8::from(*t > 0.795));
        let values: Vec<f64> = t.iter().map(ramp_then_rest).collect();
        let is_new = |k: &usize| *k == 0 || values[*k] != values[*k - 1];
        let kept: Vec<usize> = (0..101).filter(is_new).collect();
        let [times, commands] = [&t, &values].map(|all| kept.iter().map(|k| all[*k]).collect::<Vec<f64>>());
        let (sparse, dense) = (held(&times, &commands, &GRID), held(&t, &values, &GRID));
        assert!(kept.len() < 50);
        for (k, (a, b)) in sparse.iter().zip(&dense).enumerate() {
            assert!((a - b).abs() < 1e-9, "{k}: {a} {b}");
        }
    }

    #[test]
    fn gaps_are_found() {
        let found = in_gap(&[0.0, 0.1, 0.6, 0.7, 1.0], &GRID, 0.4);
        assert!(!found[5] && found[30] && !found[65] && !found[99]);
    }
}
