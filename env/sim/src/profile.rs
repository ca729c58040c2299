//! Piecewise linear commands.

use crate::SimError;

/// Piecewise linear command through knots `[t, x, y, about z]`, with t in s since contact. Outside the knots the command
/// is constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile(Vec<[f64; 4]>);

impl Profile {
    /// A profile through these knots. Error messages refer to them by `key`.
    ///
    /// # Errors
    /// If there are no knots, a value is not finite, or the times do not increase.
    pub fn new(key: &str, knots: Vec<[f64; 4]>) -> Result<Self, SimError> {
        if knots.is_empty() {
            return Err(SimError::value(key, &knots, "give at least one knot [t, x, y, about z]"));
        }
        if let Some(knot) = knots.iter().find(|knot| knot.iter().any(|v| !v.is_finite())) {
            return Err(SimError::value(key, knot, "must be finite"));
        }
        match knots.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            Some(pair) => {
                Err(SimError::value(key, pair[1], "its time must be later than that of the previous knot"))
            }
            None => Ok(Self(knots)),
        }
    }

    /// The command at time `t`, s.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let later = self.0.partition_point(|knot| knot[0] <= t);
        let value = |knot: &[f64; 4]| [knot[1], knot[2], knot[3]];
        match (later.checked_sub(1).and_then(|k| self.0.get(k)), self.0.get(later)) {
            (Some(a), Some(b)) => {
                let share = (t - a[0]) / (b[0] - a[0]);
                [1, 2, 3].map(|k| a[k] + share * (b[k] - a[k]))
            }
            (Some(knot), None) | (None, Some(knot)) => value(knot),
            (None, None) => [0.0; 3],
        }
    }

    /// Time of the last knot, s.
    pub fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |knot| knot[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_linearly_and_extrapolates_constantly() {
        let profile = Profile::new("knots", vec![[1.0, 0.0, 2.0, 4.0], [2.0, 1.0, 0.0, 4.0]]).unwrap();
        assert_eq!(profile.at(0.0), [0.0, 2.0, 4.0]);
        assert_eq!(profile.at(1.25), [0.25, 1.5, 4.0]);
        assert_eq!(profile.at(9.0), [1.0, 0.0, 4.0]);
        assert_eq!(profile.end(), 2.0);
    }

    #[test]
    fn invalid_knots_are_errors() {
        for (knots, words) in [
            (vec![], "at least one knot"),
            (vec![[0.0, f64::NAN, 0.0, 0.0]], "finite"),
            (vec![[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]], "later"),
        ] {
            let message = Profile::new("push.knots", knots).unwrap_err().to_string();
            assert!(message.contains("push.knots") && message.contains(words), "{message}");
        }
    }
}
