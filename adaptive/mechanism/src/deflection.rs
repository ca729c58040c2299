//! Effort through an elastic transmission one of whose sides is not measured.

use crate::bandwidth::StageSds;
use crate::laws::{Compliance, DAMPING_RATIO};
use trundle_model::Real;

/// Numerical damping of Newmark's method: only frequencies near that of the samples are damped.
const NUMERICAL_DAMPING: f64 = 0.05;
/// Frequencies at which the noise is evaluated, and the highest of them in reciprocal standard deviations of a filter stage;
/// two stages leave 10⁻⁵ of it.
const NODES: usize = 64;
const MAX_FREQUENCY: f64 = 3.2;

/// The unmeasured side: what resists its motion besides the transmission.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unmeasured<T> {
    pub inertia: T,
    pub damping: T,
    /// Derivative by its position of the effort that it needs.
    pub stiffness: T,
}

/// State of the transmission at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deflection<T> {
    /// Position of the drive less that of the joint.
    pub position: T,
    /// Its derivatives.
    pub velocity: T,
    pub acceleration: T,
    /// Effort through the transmission.
    pub effort: T,
}

/// States of the transmission every `dt` seconds.
///
/// `rigid` is the effort that a rigid transmission would transmit. The difference z of the positions of both sides follows
/// I z″ + (D + c) z′ + (K + k) z = `rigid`, with inertia I, damping D and stiffness K of the unmeasured side, stiffness k and
/// damping c: the equation of the unmeasured side less the same equation along the measured motion (Spong 1987). It is integrated by
/// Newmark's method.
pub(crate) fn deflections<T: Real>(
    rigid: &[T],
    compliance: Compliance<T>,
    side: &dyn Fn(usize) -> Unmeasured<T>,
    dt: f64,
) -> Vec<Deflection<T>> {
    let gamma = 0.5 + NUMERICAL_DAMPING;
    let beta = (0.5 + gamma).powi(2) / 4.0;
    let stiffness = compliance.stiffness;
    let mut z = rigid.first().map_or_else(T::zero, |first| *first / (stiffness + side(0).stiffness));
    let (mut v, mut a) = (T::zero(), T::zero());
    let one = |(k, effort): (usize, &T)| {
        let Unmeasured { inertia, damping, stiffness: other } = side(k);
        let own = damping_of(compliance, inertia);
        let total = damping + own;
        if k > 0 {
            let (next_z, next_v) = (z + v * dt + a * ((0.5 - beta) * dt * dt), v + a * ((1.0 - gamma) * dt));
            let resistance = inertia + total * (gamma * dt) + (stiffness + other) * (beta * dt * dt);
            a = (*effort - total * next_v - (stiffness + other) * next_z) / resistance;
            (z, v) = (next_z + a * (beta * dt * dt), next_v + a * (gamma * dt));
        }
        Deflection { position: z, velocity: v, acceleration: a, effort: stiffness * z + own * v }
    };
    rigid.iter().enumerate().map(one).collect()
}

/// Share of the noise of the measured acceleration that is left in the residual, at most one. `measured` is the inertia of the
/// measured side.
///
/// The residual contains the acceleration times the inertia of the measured side, plus that of the other side times the
/// transmission's transfer function. A soft transmission between a light and a heavy side would filter the noise, and fit
/// better without any effect. Residuals are divided by this share. Resonances that are narrower than the distance of the nodes
/// are broadened to it, so that the share is a smooth function of the stiffness.
pub(crate) fn noise_share<T: Real>(
    compliance: Compliance<T>,
    other: Unmeasured<T>,
    measured: T,
    stages: StageSds,
) -> T {
    let (mut power, mut all) = (T::zero(), 0.0);
    let unit = stages.both() / 2f64.sqrt();
    for node in 1..=NODES {
        let x = node as f64 * MAX_FREQUENCY / NODES as f64;
        let frequency = x / unit;
        let kept = |sd: f64| (-0.5 * (frequency * sd).powi(2)).exp();
        // A flat and a plain filter of the second derivative of white noise.
        let amplitude = (1.0 - (1.0 - kept(stages.first)).powi(2)) * kept(stages.second);
        let weight = x.powi(4) * amplitude * amplitude;
        let own = damping_of(compliance, other.inertia);
        let (above, below) = (own * frequency, (other.damping + own) * frequency);
        let rest = compliance.stiffness - other.inertia * (frequency * frequency);
        let broadened = other.inertia * (frequency * MAX_FREQUENCY / NODES as f64 / unit);
        let size = rest * rest + below * below + broadened * broadened;
        let real = (compliance.stiffness * rest + above * below) / size;
        let imaginary = (above * rest - compliance.stiffness * below) / size;
        let (real, imaginary) = (measured + other.inertia * real, other.inertia * imaginary);
        power += (real * real + imaginary * imaginary) * weight;
        all += weight;
    }
    let total = measured + other.inertia;
    let share = (power / all).sqrt() / total;
    if share.re() < 1.0 { share } else { T::lift(1.0) }
}

/// Damping of a transmission, at most the critical one: more would be a damper, not a spring.
fn damping_of<T: Real>(compliance: Compliance<T>, inertia: T) -> T {
    let product = compliance.stiffness * inertia;
    let critical = if product.re() > 0.0 { product.sqrt() * 2.0 } else { T::zero() };
    match compliance.damping {
        Some(damping) if damping.re() > critical.re() => critical,
        Some(damping) => damping,
        None => critical * DAMPING_RATIO,
    }
}

#[cfg(test)]
mod tests {
    use super::{Unmeasured, deflections, noise_share};
    use crate::bandwidth::StageSds;
    use crate::laws::Compliance;

    const DT: f64 = 0.002;

    fn transmitted(rigid: &[f64], compliance: Compliance<f64>) -> Vec<f64> {
        let side = |_: usize| Unmeasured { inertia: 0.02, damping: 0.1, stiffness: 0.0 };
        deflections(rigid, compliance, &side, DT).iter().map(|found| found.effort).collect()
    }

    /// Amplitude of the transmitted effort for a sine of amplitude one, after the transient.
    fn amplitude(frequency: f64, damping: Option<f64>) -> f64 {
        let rigid: Vec<f64> = (0..20_000).map(|k| (frequency * k as f64 * DT).sin()).collect();
        let compliance = Compliance { stiffness: 50.0, damping };
        let found = transmitted(&rigid, compliance);
        found[15_000..].iter().fold(0.0, |most, effort| f64::max(most, effort.abs()))
    }

    #[test]
    fn amplitudes_are_those_of_the_transfer_function() {
        for frequency in [2.0f64, 20.0, 50.0, 100.0] {
            let (k, c) = (50.0f64, 0.2f64);
            let above = (k * k + (c * frequency).powi(2)).sqrt();
            let below = (k - 0.02 * frequency * frequency).hypot((c + 0.1) * frequency);
            let found = amplitude(frequency, Some(c));
            assert!((found * below / above - 1.0).abs() < 0.03, "{frequency}: {found} {}", above / below);
        }
    }

    #[test]
    fn a_transmission_without_fitted_damping_is_damped() {
        let resonance = amplitude(50.0, None);
        assert!(resonance > 2.0 && resonance < 5.0, "{resonance}");
    }

    #[test]
    fn a_stiff_transmission_is_rigid() {
        let rigid: Vec<f64> = (0..1000).map(|k| (8.0 * k as f64 * DT).sin()).collect();
        let compliance = Compliance { stiffness: 1e9, damping: None };
        let found = transmitted(&rigid, compliance);
        assert!(rigid.iter().zip(&found).all(|(rigid, found)| (rigid - found).abs() < 1e-3));
    }

    #[test]
    fn a_soft_transmission_leaves_the_noise_of_the_measured_side() {
        let share = |stiffness: f64, measured: f64| {
            let compliance = Compliance { stiffness, damping: Some(0.1) };
            noise_share(
                compliance,
                Unmeasured { inertia: 0.5, damping: 0.1, stiffness: 0.0 },
                measured,
                StageSds { first: 0.02, second: 0.02 },
            )
        };
        assert!((share(1e-3, 0.1) - 0.1 / 0.6).abs() < 1e-3, "{}", share(1e-3, 0.1));
        assert!((share(1e9, 0.1) - 1.0).abs() < 1e-6);
        assert!(share(50.0, 0.01) < 0.2 && share(50.0, 50.0) > 0.98);
    }
}
