//! Laws with inner states: conservation laws, frequencies, directions and the order of convergence.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Effect, Kind, MAX_INNER_STATES, Model, Plant, State};

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

/// A table of 20 kg with an offset mass centre.
fn table(effects: Vec<Effect>) -> Model {
    let mut body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 20.0).unwrap();
    body.com = [0.1, -0.05];
    Model { mass: Some(20.0), body, dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

fn load(frequency: f64, damping: f64) -> Effect {
    let values =
        [("x", 0.3), ("y", -0.2), ("mass", 6.0), ("frequency", frequency), ("damping_ratio", damping)];
    effect(Kind::SwingingLoad, &values)
}

fn caster(trail: f64, side: f64) -> Effect {
    effect(Kind::CasterSwivel, &[("x", 0.5), ("y", 0.3), ("trail", trail), ("mu_side", side)])
}

fn moving(twist: [f64; 3], inner: &[f64]) -> State<f64> {
    let mut own = [0.0; MAX_INNER_STATES];
    own[..inner.len()].copy_from_slice(inner);
    State::moving([0.1, 0.2, 0.3], twist).with_inner(own)
}

type Push = fn(f64) -> [f64; 3];

fn no_push(_: f64) -> [f64; 3] {
    [0.0; 3]
}

fn back_and_forth(t: f64) -> [f64; 3] {
    [30.0 * (2.2 * t).sin(), 12.0 * (3.0 * t).sin(), 4.0 * (2.0 * t).cos()]
}

fn roll(plant: &Plant<f64>, start: State<f64>, push: Push, dt: f64, duration: f64) -> Vec<State<f64>> {
    let mut motion = vec![start];
    for k in 0..(duration / dt).round() as usize {
        let t = (k as f64 + 0.5) * dt;
        let clock = Clock { dt, ..Clock::since_contact(t) };
        motion.push(plant.step(&motion[k], push(t), clock, dt));
    }
    motion
}

/// Position and velocity of a body point in the world.
fn at(state: &State<f64>, [px, py]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let (sin, cos) = state.pose[2].sin_cos();
    let (rx, ry) = (cos * px - sin * py, sin * px + cos * py);
    let [vx, vy, spin] = state.twist;
    ([state.pose[0] + rx, state.pose[1] + ry], [vx - spin * ry, vy + spin * rx])
}

/// Linear and angular momentum of body and load about the world origin, and their energy, J.
fn conserved(plant: &Plant<f64>, state: &State<f64>, frequency: f64) -> ([f64; 3], f64) {
    let rigid = plant.rigid(Clock::since_contact(1.0));
    let ([x, y], [vx, vy]) = at(state, rigid.com);
    let ([px, py], _) = at(state, [0.3, -0.2]);
    let [dx, dy, ux, uy, _] = state.inner;
    let (m, omega) = (6.0, std::f64::consts::TAU * frequency);
    let spin = rigid.mass * (x * vy - y * vx) + rigid.inertia * state.twist[2];
    let own = m * ((px + dx) * uy - (py + dy) * ux);
    let moving = rigid.mass * (vx * vx + vy * vy) + rigid.inertia * state.twist[2].powi(2);
    let energy = 0.5 * (moving + m * (ux * ux + uy * uy) + m * omega * omega * (dx * dx + dy * dy));
    ([rigid.mass * vx + m * ux, rigid.mass * vy + m * uy, spin + own], energy)
}

#[test]
fn a_load_and_its_body_conserve_momentum_and_never_gain_energy() {
    for (frequency, dt) in [(0.7, 8e-3), (1.4, 8e-3), (3.0, 4e-3)] {
        // The smallest allowed damping and the default.
        for damping in [1e-3, 0.02] {
            let plant = table(vec![load(frequency, damping)]).resolved().unwrap();
            let start = moving([0.5, -0.2, 0.8], &[0.02, 0.01, 0.3, 0.2]);
            let motion = roll(&plant, start, no_push, dt, 6.0);
            let (first, mut energy) = conserved(&plant, &motion[0], frequency);
            for state in &motion {
                let (momentum, left) = conserved(&plant, state, frequency);
                for k in 0..2 {
                    assert!((momentum[k] - first[k]).abs() < 5e-3 * first[0].abs(), "{momentum:?} {first:?}");
                }
                assert!((momentum[2] - first[2]).abs() < 0.02, "{momentum:?} {first:?} at {frequency} Hz");
                assert!(left <= energy * (1.0 + 1e-4), "{left} J after {energy} J at {frequency} Hz, {dt} s");
                energy = left;
            }
        }
    }
}

#[test]
fn a_load_oscillates_at_its_frequency_while_the_body_is_held() {
    let wheel = [("x", 0.3), ("y", -0.2), ("angle", 0.0), ("mu_x", 1e6), ("mu_y", 1e6)];
    let spin = effect(Kind::SpinDrag, &[("spin", 1e6)]);
    let held = table(vec![load(1.4, 0.02), effect(Kind::ViscousWheel, &wheel), spin]);
    let motion = roll(&held.resolved().unwrap(), moving([0.0; 3], &[0.05]), no_push, 4e-3, 5.0);
    let signs: Vec<bool> = motion.iter().map(|s| s.inner[0] > 0.0).collect();
    let crossings: Vec<usize> = (1..signs.len()).filter(|&k| signs[k] != signs[k - 1]).collect();
    let (first, last) = (crossings[0], crossings[crossings.len() - 1]);
    let frequency = (crossings.len() - 1) as f64 / 2.0 / ((last - first) as f64 * 4e-3);
    assert!((frequency - 1.4).abs() < 5e-3, "{frequency} Hz");
    // Damped by exp(−ζ ω t).
    let left = motion[motion.len() - 1].inner;
    let size = left[0].hypot((left[2]) / (std::f64::consts::TAU * 1.4));
    assert!((size / 0.05 - (-0.02 * std::f64::consts::TAU * 1.4 * 5.0f64).exp()).abs() < 0.02, "{size}");
}

#[test]
fn the_rigid_part_has_the_remaining_mass() {
    let model = table(vec![load(1.4, 0.02)]);
    let (whole, rigid) = (model.body.inertia(), model.resolved().unwrap().rigid(Clock::since_contact(0.0)));
    assert!((rigid.mass - 14.0).abs() < 1e-12 && (rigid.inertia - 0.7 * whole).abs() < 1e-12);
    assert_eq!(rigid.com, model.body.com);
}

#[test]
fn halving_the_step_quarters_the_error_with_inner_states() {
    let wheel = [("x", -0.4), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 90.0)];
    let wheel = effect(Kind::ViscousWheel, &wheel);
    let both = vec![caster(0.05, 60.0), load(1.4, 0.02), wheel];
    for (effects, inner) in [
        (vec![caster(0.05, 60.0)], &[2.0][..]),
        (vec![load(1.4, 0.02)], &[0.02, 0.0, 0.1, 0.2][..]),
        (both, &[-1.0, 0.02, 0.0, 0.1, 0.2][..]),
    ] {
        let plant = table(effects).resolved().unwrap();
        let start = moving([0.4, 0.2, 0.5], inner);
        let last = |dt: f64| *roll(&plant, start, back_and_forth, dt, 1.0).last().unwrap();
        let truth = last(5e-5);
        let error = |dt: f64| {
            let (a, b) = (last(dt), truth);
            let motion = a.pose.iter().zip(b.pose).chain(a.twist.iter().zip(b.twist));
            motion.chain(a.inner.iter().zip(b.inner)).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        for dt in [4e-3, 2e-3] {
            let ratio = error(dt) / error(dt / 2.0);
            assert!((3.4..4.7).contains(&ratio), "error falls by {ratio} from {dt} s ({:e})", error(dt));
        }
    }
}

#[test]
fn a_caster_aligns_and_then_rolls_freely() {
    // Towed in one direction, the caster aligns from any initial direction, and the side force vanishes.
    let spin = effect(Kind::SpinDrag, &[("spin", 1e6)]);
    let plant = table(vec![caster(0.06, 30.0), spin]).resolved().unwrap();
    for first in [-3.0, -1.5, 0.2, 2.0] {
        let motion = roll(&plant, moving([0.8, 0.0, 0.0], &[first]), no_push, 4e-3, 2.5);
        let last = motion[motion.len() - 1];
        let direction = last.twist[1].atan2(last.twist[0]) - last.pose[2];
        let off = (last.inner[0] - direction).sin().abs();
        assert!(off < 1e-2 && (last.inner[0] - direction).cos() > 0.0, "from {first}: off by {off}");
        let before = motion[motion.len() - 20];
        assert!((before.twist[0] - last.twist[0]).abs() < 1e-3, "the side force remains");
    }
}

#[test]
fn a_caster_keeps_its_direction_while_the_body_rotates_about_its_pivot() {
    // The pivot is fixed: the wheel does not swivel while the body rotates above it.
    let hold = [("x", 0.5), ("y", 0.3), ("angle", 0.0), ("mu_x", 1e6), ("mu_y", 1e6)];
    let plant = table(vec![caster(0.06, 30.0), effect(Kind::ViscousWheel, &hold)]).resolved().unwrap();
    let (sin, cos) = 0.3f64.sin_cos();
    let (rx, ry) = (cos * 0.5 - sin * 0.3, sin * 0.5 + cos * 0.3);
    let motion = roll(&plant, moving([0.9 * ry, -0.9 * rx, 0.9], &[1.0]), no_push, 2e-3, 1.0);
    let last = motion[motion.len() - 1];
    assert!(last.pose[2] > 1.0, "the body rotates");
    assert!((last.inner[0] + last.pose[2] - 1.3).abs() < 5e-3, "{last:?}");
}

#[test]
fn a_caster_is_stable_if_it_swivels_within_a_step() {
    // At 0.5 m/s and a trail of 5 mm it aligns within one step of 8 ms.
    let plant = table(vec![caster(5e-3, 200.0)]).resolved().unwrap();
    let motion = roll(&plant, moving([0.5, 0.1, 0.3], &[2.5]), back_and_forth, 8e-3, 5.0);
    assert!(motion.iter().all(|s| s.twist.iter().chain(&s.inner).all(|v| v.abs() < 20.0)));
}

#[test]
fn too_many_inner_states_are_rejected() {
    let error = table(vec![load(1.0, 0.02), load(2.0, 0.02)]).resolved().unwrap_err();
    assert!(error.to_string().contains('8'), "{error}");
}
