//! Parameters that enter the equations of all joints of a model: masses, loads, gravity, offsets of encoders.

use crate::dynamics::{EpisodeDynamics, InverseDynamics};
use crate::model::{Effect, Kind, Nominal, Role, Slot};
use crate::problem::Problem;

/// What a model needs at joint `j` in an episode, for given values; its own inertia only if that is wanted.
pub(crate) fn inverse_dynamics(
    problem: &Problem,
    dynamics: &EpisodeDynamics,
    j: usize,
    (effects, slots, values): (&[Effect], &[Slot], &[f64]),
    wants_inertia: bool,
) -> InverseDynamics<f64> {
    let mut sum = dynamics.effort[j].clone();
    let mut inertia = wants_inertia.then(|| dynamics.own_inertia(j).clone());
    for (slot, value) in slots.iter().zip(values) {
        match slot.role {
            Role::Nominal(Nominal::Mass(body)) => {
                let change = value - problem.bodies[body].1;
                add(&mut sum, &dynamics.by_mass[j][body], change);
                inertia.iter_mut().for_each(|sum| add(sum, &dynamics.matrix_by_mass[j][body][j], change));
            }
            Role::Nominal(Nominal::Parameter(k)) => {
                let reference = problem.simulator.as_ref().map_or(0.0, |s| s.parameters[k].reference);
                add(&mut sum, &dynamics.by_parameter[j][k], value - reference);
            }
            _ => {}
        }
    }
    let masses = mass_changes(problem, slots, values);
    for effect in with_values(effects, slots, values) {
        match effect.kind {
            Kind::Payload(body) => {
                let weights = payload(&effect.values);
                add_all(&mut sum, &dynamics.by_payload[j][body], &weights);
                inertia
                    .iter_mut()
                    .for_each(|sum| add_all(sum, &dynamics.inertia_by_payload[j][body], &weights));
            }
            Kind::BaseTilt => {
                add_all(&mut sum, &dynamics.by_gravity[j], &gravity_change(problem.gravity, &effect.values));
            }
            Kind::EncoderOffset(other) => {
                let offset = effect.values[0];
                add_all(&mut sum, &dynamics.by_offset[j][other], &[-offset, 0.5 * offset * offset]);
            }
            Kind::Joint(..) => {}
        }
        let shift = shift(problem, &effect);
        for (body, change) in &masses {
            add_with_mass(&mut sum, dynamics, (j, *body), &effect, &shift, *change);
        }
    }
    InverseDynamics { effort: sum, own_inertia: inertia }
}

/// Entry of the mass matrix for two joints, with refitted masses.
pub(crate) fn coupling(
    problem: &Problem,
    dynamics: &EpisodeDynamics,
    [j, other]: [usize; 2],
    (slots, values): (&[Slot], &[f64]),
) -> Vec<f64> {
    let mut sum = dynamics.mass_matrix[j][other].clone();
    for (body, change) in mass_changes(problem, slots, values) {
        add(&mut sum, &dynamics.matrix_by_mass[j][body][other], change);
    }
    sum
}

/// Derivative of [`inverse_dynamics`] by a slot.
pub(crate) fn slope(
    problem: &Problem,
    dynamics: &EpisodeDynamics,
    j: usize,
    slot: &Slot,
    (effects, slots, values): (&[Effect], &[Slot], &[f64]),
    wants_inertia: bool,
) -> InverseDynamics<f64> {
    let mut sum = vec![0.0; dynamics.effort[j].len()];
    let mut inertia = wants_inertia.then(|| sum.clone());
    match slot.role {
        Role::Nominal(Nominal::Mass(body)) => {
            add(&mut sum, &dynamics.by_mass[j][body], 1.0);
            for effect in with_values(effects, slots, values) {
                add_with_mass(&mut sum, dynamics, (j, body), &effect, &shift(problem, &effect), 1.0);
            }
            inertia.iter_mut().for_each(|sum| add(sum, &dynamics.matrix_by_mass[j][body][j], 1.0));
        }
        Role::Nominal(Nominal::Parameter(k)) => add(&mut sum, &dynamics.by_parameter[j][k], 1.0),
        Role::Nominal(_) => {}
        Role::Effect(index, param) => {
            let all = with_values(effects, slots, values);
            let effect = &all[index];
            let slope = shift_slope(problem, effect, param);
            for (body, change) in mass_changes(problem, slots, values) {
                add_with_mass(&mut sum, dynamics, (j, body), effect, &slope, change);
            }
            match effect.kind {
                Kind::Payload(body) => {
                    let weights = payload_slope(&effect.values, param);
                    add_all(&mut sum, &dynamics.by_payload[j][body], &weights);
                    let own = &dynamics.inertia_by_payload[j][body];
                    inertia.iter_mut().for_each(|sum| add_all(sum, own, &weights));
                }
                Kind::BaseTilt => {
                    let slope = gravity_slope(problem.gravity, &effect.values, param);
                    add_all(&mut sum, &dynamics.by_gravity[j], &slope);
                }
                Kind::EncoderOffset(other) => {
                    add_all(&mut sum, &dynamics.by_offset[j][other], &[-1.0, effect.values[0]]);
                }
                Kind::Joint(..) => {}
            }
        }
    }
    InverseDynamics { effort: sum, own_inertia: inertia }
}

/// Changes of refitted masses by body, kg.
fn mass_changes(problem: &Problem, slots: &[Slot], values: &[f64]) -> Vec<(usize, f64)> {
    let change = |(slot, value): (&Slot, &f64)| match slot.role {
        Role::Nominal(Nominal::Mass(body)) => Some((body, value - problem.bodies[body].1)),
        _ => None,
    };
    slots.iter().zip(values).filter_map(change).collect()
}

/// Change of gravity or of a position by an effect.
fn shift(problem: &Problem, effect: &Effect) -> Vec<f64> {
    match effect.kind {
        Kind::BaseTilt => gravity_change(problem.gravity, &effect.values).to_vec(),
        Kind::EncoderOffset(_) => vec![-effect.values[0]],
        _ => vec![],
    }
}

/// Its derivative by a parameter of the effect.
fn shift_slope(problem: &Problem, effect: &Effect, param: usize) -> Vec<f64> {
    match effect.kind {
        Kind::BaseTilt => gravity_slope(problem.gravity, &effect.values, param).to_vec(),
        Kind::EncoderOffset(_) => vec![-1.0],
        _ => vec![],
    }
}

/// Add what a change of gravity or of a position changes at joint `j` together with a change of the mass of a body.
fn add_with_mass(
    sum: &mut [f64],
    dynamics: &EpisodeDynamics,
    (j, body): (usize, usize),
    effect: &Effect,
    shift: &[f64],
    mass: f64,
) {
    let series: &[Vec<f64>] = match effect.kind {
        Kind::BaseTilt => &dynamics.by_mass_and_gravity[j][body],
        Kind::EncoderOffset(other) => std::slice::from_ref(&dynamics.by_mass_and_offset[j][body][other]),
        _ => &[],
    };
    series.iter().zip(shift).for_each(|(series, shift)| add(sum, series, shift * mass));
}

fn add(sum: &mut [f64], series: &[f64], factor: f64) {
    sum.iter_mut().zip(series).for_each(|(sum, x)| *sum += factor * x);
}

fn add_all(sum: &mut [f64], series: &[Vec<f64>], factors: &[f64]) {
    series.iter().zip(factors).for_each(|(series, factor)| add(sum, series, *factor));
}

/// Effects with the values of their slots.
pub(crate) fn with_values(effects: &[Effect], slots: &[Slot], values: &[f64]) -> Vec<Effect> {
    let mut found = effects.to_vec();
    for (slot, value) in slots.iter().zip(values) {
        if let Role::Effect(effect, param) = slot.role {
            found[effect].values[param] = *value;
        }
    }
    found
}

/// Weights of the ten columns of a point mass.
fn payload(values: &[f64]) -> [f64; 10] {
    let [m, x, y, z] = [values[0], values[1], values[2], values[3]];
    [m, m * x, m * y, m * z, m * x * x, m * y * y, m * z * z, m * x * y, m * x * z, m * y * z]
}

fn payload_slope(values: &[f64], param: usize) -> [f64; 10] {
    let [m, x, y, z] = [values[0], values[1], values[2], values[3]];
    match param {
        0 => payload(&[1.0, x, y, z]),
        1 => [0.0, m, 0.0, 0.0, 2.0 * m * x, 0.0, 0.0, m * y, m * z, 0.0],
        2 => [0.0, 0.0, m, 0.0, 0.0, 2.0 * m * y, 0.0, m * x, 0.0, m * z],
        _ => [0.0, 0.0, 0.0, m, 0.0, 0.0, 2.0 * m * z, 0.0, m * x, m * y],
    }
}

/// Gravity turned about the world's x axis, then about its y axis, less gravity.
fn gravity_change(gravity: [f64; 3], angles: &[f64]) -> [f64; 3] {
    let turned = about_y(about_x(gravity, angles[0].sin_cos()), angles[1].sin_cos());
    [0, 1, 2].map(|k| turned[k] - gravity[k])
}

fn gravity_slope(gravity: [f64; 3], angles: &[f64], param: usize) -> [f64; 3] {
    let (x, y) = (angles[0].sin_cos(), angles[1].sin_cos());
    // The derivative of (sin, cos) is (cos, -sin); the component along the axis does not change.
    if param == 0 {
        let [_, gy, gz] = about_x(gravity, (x.1, -x.0));
        about_y([0.0, gy, gz], y)
    } else {
        let [gx, _, gz] = about_y(about_x(gravity, x), (y.1, -y.0));
        [gx, 0.0, gz]
    }
}

fn about_x([x, y, z]: [f64; 3], (sin, cos): (f64, f64)) -> [f64; 3] {
    [x, cos * y - sin * z, sin * y + cos * z]
}

fn about_y([x, y, z]: [f64; 3], (sin, cos): (f64, f64)) -> [f64; 3] {
    [cos * x + sin * z, y, -sin * x + cos * z]
}

#[cfg(test)]
mod tests {
    use super::{gravity_change, gravity_slope, payload, payload_slope};

    #[test]
    fn slopes_agree_with_differences() {
        let h = 1e-6;
        for param in 0..4 {
            let at = |d: f64| {
                let mut values = [0.7, 0.1, -0.2, 0.3];
                values[param] += d;
                payload(&values)
            };
            let slope = payload_slope(&[0.7, 0.1, -0.2, 0.3], param);
            let (up, down) = (at(h), at(-h));
            for (k, slope) in slope.iter().enumerate() {
                assert!(((up[k] - down[k]) / (2.0 * h) - slope).abs() < 1e-8);
            }
        }
        for param in 0..2 {
            let at = |d: f64| {
                let mut angles = [0.1, -0.2];
                angles[param] += d;
                gravity_change([0.3, 0.2, -9.81], &angles)
            };
            let slope = gravity_slope([0.3, 0.2, -9.81], &[0.1, -0.2], param);
            let (up, down) = (at(h), at(-h));
            for (k, slope) in slope.iter().enumerate() {
                assert!(((up[k] - down[k]) / (2.0 * h) - slope).abs() < 1e-7);
            }
        }
    }
}
