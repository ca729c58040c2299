//! Likely cause of a motion that diverges.

use crate::error::NotFinite;
use crate::law::Prior;
use crate::model::{Model, Slot};

/// Smallest log ratio at which a value counts as extreme: ten prior standard deviations, or ten times the median.
const MIN_EXTREME_LOG_RATIO: f64 = std::f64::consts::LN_10;

impl NotFinite {
    /// Error for a motion of `model` that is not finite from a time `at` after its start, s.
    pub fn of(model: &Model, at: f64) -> Self {
        let named = |slot: Slot| Some((slot.name, slot.value?, slot.unit));
        Self { at, parameter: model.most_extreme().and_then(named) }
    }
}

impl Model {
    /// The parameter whose value deviates most from its prior on a logarithmic scale: the likely cause of a motion that
    /// is not finite. `None` if no value is extreme.
    pub fn most_extreme(&self) -> Option<Slot> {
        let distance = |slot: &Slot| match (slot.prior, slot.value?) {
            (Prior::Normal { mean, sd }, value) => Some(((value - mean).abs() / sd).ln()),
            (Prior::LogNormal { median, .. }, value) => Some((value / median).ln().abs()),
            _ => None,
        };
        let slots = self.slots().into_iter().filter_map(|slot| Some((distance(&slot)?, slot)));
        let (farthest, slot) = slots.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (farthest > MIN_EXTREME_LOG_RATIO).then_some(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Effect, Kind};

    fn table() -> Model {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
        Model::nominal(body, None, [true; 3])
    }

    #[test]
    fn the_most_extreme_value_is_found() {
        let usual = table().with_values(&[22.0, 0.1, 0.1, 0.3, 60.0, 60.0]).unwrap();
        assert_eq!(usual.most_extreme(), None);
        let pushing = Effect::free(Kind::DirectionalFriction);
        let pushing = pushing.with("angle", Some(0.0)).with("difference", Some(-1e5));
        let extreme = usual.with(pushing).most_extreme().unwrap();
        assert_eq!((extreme.name.as_str(), extreme.value), ("directional_friction.difference", Some(-1e5)));
    }
}
