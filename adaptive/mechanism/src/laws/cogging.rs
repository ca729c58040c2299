//! Periodic effort: magnets, teeth, screws.

use super::law::{
    Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, positive, signed, take,
};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_cogging",
    summary: "an effort that is periodic in the position",
    source: "Hwang and Lieu, IEEE Trans. Magn. 1994",
    applies: Applies::Always,
    params: &[
        ParamSpec {
            is_period: true,
            bounds: [0.0, 1.0],
            ..positive("period", Unit::Position, Scale::Position)
        },
        positive("amplitude", Unit::Effort, Scale::Effort),
        signed("phase", Unit::Angle, Scale::One),
    ],
    sentence: "An effort of {amplitude} repeats every {period} of joint {joint}",
    experiment: "move the joint slowly over several periods in both directions",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    let span = scales.span();
    // At the rms velocity the filter removes this period; at a third of it, 58 % of the amplitude remains.
    let finest = (2.0 * scales.velocity * scales.resolution).max(span / 200.0);
    let mut periods = vec![];
    let mut period = span / 1.5;
    // Neighbours differ by a quarter of a cycle over the range of positions.
    while period > finest && periods.len() < 400 {
        periods.push(period);
        period /= 1.0 + 0.25 * period / span;
    }
    let start = |period: &f64| vec![*period, 0.02 * scales.effort, 0.0];
    periods.iter().map(start).collect()
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    period: T,
    amplitude: T,
    phase: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [period, amplitude, phase] = take(values);
        Self { period, amplitude, phase }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        let (sin, _) = (self.period.recip() * (std::f64::consts::TAU * at.q) + self.phase).sin_cos();
        self.amplitude * sin
    }
}
