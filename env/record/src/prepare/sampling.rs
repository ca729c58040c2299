//! Sampling utilities: latest samples, quantiles and intervals.

/// Index of the last of `times` (increasing) that is not later than `t`; `None` before the first.
pub(crate) fn latest(times: &[f64], t: f64) -> Option<usize> {
    times.partition_point(|&time| time <= t).checked_sub(1)
}

/// Median of `values`, which must not contain NaN; `None` if there are none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// Quantile `share` (0 to 1) of `values`, rounded to the nearest order statistic; `None` if there are none.
pub(crate) fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    if values.is_empty() {
        return None;
    }
    let at = ((values.len() - 1) as f64 * share).round() as usize;
    Some(*values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// Median interval of increasing `times`, s; `None` for fewer than two.
pub(crate) fn median_step(times: &[f64]) -> Option<f64> {
    median(times.windows(2).map(|pair| pair[1] - pair[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latest_is_not_later() {
        let times = [1.0, 2.0, 3.0];
        assert_eq!(latest(&times, 0.5), None);
        assert_eq!(latest(&times, 2.0), Some(1));
        assert_eq!(latest(&times, 2.9), Some(1));
        assert_eq!(latest(&times, 9.0), Some(2));
        assert_eq!(latest(&[], 1.0), None);
    }

    #[test]
    fn quantiles_of_few() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(quantile([1.0], 0.95), Some(1.0));
        assert_eq!(median([]), None);
    }
}
