//! The shift in time at which a stream fits the motion best.

/// A best shift.
pub(super) struct Shift {
    /// By how much the motion follows the stream, s; negative if the stream is late.
    pub delay: f64,
    /// Its standard deviation, s.
    pub sd: f64,
    /// Unexplained share without a shift, and with the best one.
    pub unexplained: [f64; 2],
}

/// The shift with the smallest unexplained share. `unexplained` is this share for a shift by a number of points, `points`
/// the largest shift, `step` the grid, and `rows` the number of independent rows.
pub(super) fn best(
    unexplained: impl Fn(isize) -> f64,
    points: isize,
    stride: isize,
    step: f64,
    rows: f64,
) -> Option<Shift> {
    let shifts: Vec<isize> = (-points / stride..=points / stride).map(|k| k * stride).collect();
    let coarse: Vec<f64> = shifts.iter().map(|&shift| unexplained(shift)).collect();
    let at = (0..coarse.len()).min_by(|&a, &b| coarse[a].total_cmp(&coarse[b]))?;
    if at == 0 || at + 1 == coarse.len() {
        return None;
    }
    let [before, here, after] = [coarse[at - 1], coarse[at], coarse[at + 1]];
    let curvature = before - 2.0 * here + after;
    if curvature <= 0.0 {
        return None;
    }
    let offset = 0.5 * (before - after) / curvature;
    let least = here - 0.25 * (before - after) * offset;
    let size = stride as f64 * step;
    Some(Shift {
        delay: size * (shifts[at] as f64 / stride as f64 + offset),
        // The share grows by curvature / 2 at one step from the minimum, and by least / rows at one standard deviation.
        sd: size * (2.0 * least.max(0.0) / (curvature * rows.max(1.0))).sqrt(),
        unexplained: [unexplained(0), least.max(0.0)],
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_minimum_between_the_points() {
        let found = best(|k| 0.1 + 0.01 * (k as f64 - 3.3).powi(2), 20, 1, 0.002, 100.0).unwrap();
        assert!((found.delay - 0.0066).abs() < 1e-9, "{}", found.delay);
        assert!((found.sd - 0.002 * (0.1_f64 / 100.0 / 0.01).sqrt()).abs() < 1e-9);
        assert!(best(|k| k as f64, 20, 1, 0.002, 100.0).is_none(), "the minimum is at the end");
    }
}
