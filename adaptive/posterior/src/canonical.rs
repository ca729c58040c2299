//! Canonical form of equivalent points.
//!
//! A wheel turned by a quarter with exchanged coefficients is the same wheel, and an angle is the same after
//! a period. Without a canonical form, chains in equivalent points would appear to disagree. As in a fit,
//! "along" is the direction of lower friction if both coefficients have the same prior. An angle is wrapped
//! to within half a period of the best mode, so that its draws are not split at the end of the circle.

use crate::modes::nearest;
use std::f64::consts::FRAC_PI_2;
use trundle_infer::Target;
use trundle_model::{Kind, Model, Prior};

/// Slots of a wheel whose angle and coefficients are all free.
struct Wheel {
    angle: usize,
    along: usize,
    across: usize,
}

/// Maps points to the canonical form nearest to a mode.
pub(crate) struct Canonical<'a> {
    target: &'a Target<'a>,
    mode: Vec<f64>,
    wheels: Vec<Wheel>,
}

impl<'a> Canonical<'a> {
    pub fn new(target: &'a Target<'a>, mode: &[f64]) -> Self {
        let wheels = if target.has_per_episode() { vec![] } else { wheels(target.model()) };
        Self { target, mode: mode.to_vec(), wheels }
    }

    /// Canonical form of a point.
    pub fn canonical_point(&self, point: &[f64]) -> Vec<f64> {
        let mut canonical = self.turned(point).unwrap_or_else(|| point.to_vec());
        for (k, z) in canonical.iter_mut().enumerate() {
            *z = nearest(&self.target.slot(k).prior, *z, self.mode[k]);
        }
        canonical
    }

    /// The point with wheels turned to the canonical order of coefficients; `None` if it already has it.
    fn turned(&self, point: &[f64]) -> Option<Vec<f64>> {
        let mut values = self.target.shared_values(point).0;
        let mut any = false;
        for wheel in &self.wheels {
            if values[wheel.along] > values[wheel.across] {
                values.swap(wheel.along, wheel.across);
                values[wheel.angle] += FRAC_PI_2;
                any = true;
            }
        }
        any.then(|| self.target.point(&values))
    }
}

/// Wheels whose prior is unchanged by a quarter turn.
fn wheels(model: &Model) -> Vec<Wheel> {
    let slots = model.slots();
    let place = |effect: &str, name: &str| {
        let name = format!("{effect}.{name}");
        slots.iter().position(|s| s.name == name && s.value.is_none())
    };
    let viscous =
        model.effects.iter().zip(model.effect_names()).filter(|(e, _)| e.kind == Kind::ViscousWheel);
    let free = viscous.filter_map(|(_, effect)| {
        let slot = |name| place(&effect, name);
        Some(Wheel { angle: slot("angle")?, along: slot("mu_x")?, across: slot("mu_y")? })
    });
    let same = |w: &Wheel| {
        matches!(slots[w.angle].prior, Prior::Angle(_)) && slots[w.along].prior == slots[w.across].prior
    };
    free.filter(same).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use trundle_infer::MotionLikelihood;
    use trundle_model::Body;

    #[test]
    fn a_wheel_turned_by_a_quarter_has_the_same_canonical_form() {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
        let model = Model::nominal(body, None, [true; 3]);
        let noise =
            trundle_record::Noise { pose: [1e-3; 3], force: 1.0, torque: 0.1, time: 0.0, stated: true };
        let likelihood = MotionLikelihood::new(&[], &noise).unwrap();
        let target = Target::new(&likelihood, &model, &BTreeSet::new()).unwrap();
        let values = [22.0, -0.5, -0.3, 0.2, 15.0, 180.0];
        let mode = target.point(&values);
        let canonical = Canonical::new(&target, &mode);
        let [mut turned, mut round] = [values; 2];
        (turned[3], turned[4], turned[5]) = (0.2 - FRAC_PI_2, 180.0, 15.0);
        round[3] = 0.2 + 3.0 * std::f64::consts::PI;
        for other in [turned, round] {
            let canonical = canonical.canonical_point(&target.point(&other));
            assert!(canonical.iter().zip(&mode).all(|(a, b)| (a - b).abs() < 1e-9), "{canonical:?} {mode:?}");
        }
    }
}
