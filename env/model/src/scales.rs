//! Units adapted to a recording, so that priors and thresholds apply to objects of any size.

/// Units of length, force and time, expressed in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Unit of length, m.
    pub length: f64,
    /// Unit of force, N.
    pub force: f64,
    /// Unit of time, s.
    pub time: f64,
}

impl Scales {
    /// SI units.
    pub const SI: Self = Self { length: 1.0, force: 1.0, time: 1.0 };

    /// Unit of mass, kg.
    pub fn mass(&self) -> f64 {
        self.force * self.time * self.time / self.length
    }

    /// Unit of torque, N·m.
    pub fn torque(&self) -> f64 {
        self.force * self.length
    }

    /// Unit of acceleration, m/s².
    pub fn acceleration(&self) -> f64 {
        self.length / (self.time * self.time)
    }

    /// Size of a derived unit such as `N·s²/m²` in SI units; `None` if a factor is unknown.
    ///
    /// # Examples
    /// ```
    /// let scales = trundle_model::Scales { length: 2.0, force: 3.0, time: 5.0 };
    /// assert_eq!(scales.of("N·s²/m²"), Some(3.0 * 25.0 / 4.0));
    /// assert_eq!(scales.of("furlong"), None);
    /// ```
    pub fn of(&self, unit: &str) -> Option<f64> {
        let mut parts = unit.split('/');
        let above = self.product(parts.next()?)?;
        parts.try_fold(above, |size, below| Some(size / self.product(below)?))
    }

    fn product(&self, factors: &str) -> Option<f64> {
        factors.split('·').try_fold(1.0, |size, factor| Some(size * self.factor(factor)?))
    }

    fn factor(&self, factor: &str) -> Option<f64> {
        let power = match factor.chars().last()? {
            '²' => 2,
            '³' => 3,
            _ => 1,
        };
        let size = match factor.trim_end_matches(['²', '³']) {
            "1" | "rad" => 1.0,
            "m" => self.length,
            "s" => self.time,
            "Hz" => self.time.recip(),
            "N" => self.force,
            "kg" => self.mass(),
            _ => return None,
        };
        Some(f64::powi(size, power))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kind;

    #[test]
    fn every_unit_of_the_catalogue_has_a_size() {
        for param in Kind::ALL.iter().flat_map(|kind| kind.spec().params) {
            assert!(Scales::SI.of(param.unit) == Some(1.0), "{}: {}", param.name, param.unit);
        }
    }

    #[test]
    fn derived_units_follow_from_the_basic_ones() {
        let scales = Scales { length: 2.0, force: 8.0, time: 4.0 };
        assert_eq!(scales.mass(), 64.0);
        assert_eq!(scales.of("kg"), Some(64.0));
        assert_eq!(scales.of("m/s²"), Some(2.0 / 16.0));
        assert_eq!(scales.of("N·m·s"), Some(64.0));
        assert_eq!(scales.of("Hz"), Some(0.25));
    }
}
