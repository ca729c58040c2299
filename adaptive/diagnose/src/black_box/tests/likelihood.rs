//! The likelihood along the measured motion.

use super::{VALUES, pushed, under_test, wheeled};
use crate::black_box::initial_states::estimate_initial_state;
use crate::black_box::likelihood::PathLikelihood;
use crate::black_box::path::Path;
use trundle_fixtures::{World, disturb_time_stamps, effect, locked};
use trundle_infer::{Channels, Likelihood, Quiet};
use trundle_model::{Effect, Kind, Model, Plant};
use trundle_record::Dataset;

/// Likelihood of the true simulator on the first episodes of a recording.
fn likelihood(data: &Dataset, episodes: usize) -> PathLikelihood {
    likelihood_at(data, episodes, VALUES)
}

/// The same at other parameter values.
fn likelihood_at(data: &Dataset, episodes: usize, values: [f64; 3]) -> PathLikelihood {
    let simulator = wheeled();
    let black_box = under_test(&simulator, false);
    let one = |e| Path::new(e, &data.noise).unwrap();
    let paths: Vec<Path> = data.training.iter().take(episodes).map(one).collect();
    PathLikelihood::new(&black_box, &values, &paths, Channels::of(&data.noise), data.dof, &Quiet).unwrap()
}

/// Laws on the table, without its wheel.
fn laws(effects: Vec<Effect>) -> Model {
    Model { effects, ..locked() }
}

fn plant(effects: Vec<Effect>) -> Plant<f64> {
    laws(effects).resolved().unwrap()
}

/// Mean square of the whitened innovations.
fn square(likelihood: &PathLikelihood, plant: &Plant<f64>) -> f64 {
    let innovations = likelihood.innovations(plant, &VALUES);
    innovations.iter().map(|e| e * e).sum::<f64>() / innovations.len() as f64
}

#[test]
fn innovations_of_the_right_simulator_are_white() {
    let data = pushed(locked());
    let likelihood = likelihood(&data, 3);
    let innovations = likelihood.innovations(&plant(vec![]), &VALUES);
    let n = innovations.len() as f64;
    let square: f64 = innovations.iter().map(|e| e * e).sum::<f64>() / n;
    let next: f64 = innovations.windows(4).map(|w| w[0] * w[3]).sum::<f64>() / n / square;
    assert!((square - 1.0).abs() < 0.08 && next.abs() < 0.05, "{square} {next}");
    let mass = likelihood.apparent_mass().unwrap();
    assert!((mass / 22.0 - 1.0).abs() < 0.15, "{mass}");
}

#[test]
fn innovations_are_white_with_errors_of_the_time_stamps() {
    let mut data = pushed(locked());
    let error = disturb_time_stamps(&mut data.training, 6e-3);
    let ignored = square(&likelihood(&data, 3), &plant(vec![]));
    data.noise.time = error;
    let stated = square(&likelihood(&data, 3), &plant(vec![]));
    assert!((stated - 1.0).abs() < 0.25 && ignored > 1.4, "{stated} {ignored}");
}

fn caster() -> Effect {
    effect(Kind::CasterSwivel, &[("x", 0.5), ("y", 0.25), ("trail", 0.06), ("mu_side", 60.0)])
}

#[test]
fn the_initial_angle_of_a_caster_is_estimated() {
    let hidden = caster();
    let mut world = World::of(locked().with(hidden.clone()));
    world.inner[0] = 1.2;
    let data = world.recording(3);
    let likelihood = likelihood(&data, 3);
    let with = plant(vec![hidden]);
    let starts = likelihood.initial_states(&with, &VALUES);
    let found: Vec<(f64, f64)> = starts.iter().map(|start| (start.inner[0], start.laplace_cost)).collect();
    assert!(
        found.iter().all(|(angle, laplace_cost)| (angle - 1.2).abs() < 0.2 && *laplace_cost > 0.0),
        "{found:?}"
    );
    // In an episode that is simulated, the first second determines the angle.
    let simulator = wheeled();
    let (black_box, instruments) = (under_test(&simulator, false), (&data.noise, data.dof));
    let angle = estimate_initial_state(&black_box, (&with, &VALUES), &data.held_out[0], instruments, &Quiet)
        .unwrap()[0];
    assert!((angle - 1.2).abs() < 0.2, "{angle}");
    let (without, with) = (square(&likelihood, &plant(vec![])), square(&likelihood, &with));
    assert!(without > 2.0 && (with - 1.0).abs() < 0.15, "{without} {with}");
}

#[test]
fn innovations_with_a_swinging_load_are_white() {
    let values = [("x", 0.3), ("y", -0.2), ("mass", 5.0), ("frequency", 1.2), ("damping_ratio", 0.02)];
    let hidden = effect(Kind::SwingingLoad, &values);
    let likelihood = likelihood(&World::of(locked().with(hidden.clone())).recording(3), 3);
    let (without, with) = (square(&likelihood, &plant(vec![])), square(&likelihood, &plant(vec![hidden])));
    assert!(without > 2.0 && (with - 1.0).abs() < 0.15, "{without} {with}");
}

/// Otherwise a body that is too heavy, with a law that reduces its mass, would reproduce the measured motion.
#[test]
fn added_inertia_uses_the_predicted_acceleration() {
    let friction = effect(Kind::CoulombFriction, &[("x", 0.4), ("y", 0.3), ("force", 12.0)]);
    let data = pushed(locked().with(friction));
    let lighter = effect(Kind::MassChange, &[("episode", 0.0), ("time", 0.0), ("mass", -15.0)]);
    let heavy = Model { mass: Some(37.0), ..laws(vec![lighter]) };
    let right = square(&likelihood(&data, 3), &plant(vec![]));
    let values = [37.0, VALUES[1], VALUES[2]];
    let innovations = likelihood_at(&data, 3, values).innovations(&heavy.resolved().unwrap(), &values);
    let same = innovations.iter().map(|e| e * e).sum::<f64>() / innovations.len() as f64;
    assert!(right > 5.0 && same > 0.9 * right, "{right} {same}");
}

#[test]
fn a_sensor_lag_is_corrected() {
    let (lag, mut data) = (0.05, pushed(locked()));
    for episode in &mut data.training {
        let mut read = episode.wrench[0].reading;
        let mut last = episode.wrench[0].t;
        for sample in &mut episode.wrench {
            let share = 1.0 - (-(sample.t - last) / lag).exp();
            read = [0, 1, 2].map(|k| read[k] + share * (sample.reading[k] - read[k]));
            (sample.reading, last) = (read, sample.t);
        }
    }
    let likelihood = likelihood(&data, 3);
    let lagging = effect(Kind::SensorLag, &[("time_constant", lag)]);
    let (without, with) = (square(&likelihood, &plant(vec![])), square(&likelihood, &plant(vec![lagging])));
    assert!(without > 1.5 && (with - 1.0).abs() < 0.2, "{without} {with}");
}

/// Gradient of the cost and its central differences with respect to some parameters.
fn slopes(likelihood: &PathLikelihood, hidden: Effect, parameters: &[usize]) -> Vec<(f64, f64)> {
    let model = laws(vec![hidden]);
    let laws: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap_or(22.0)).collect();
    let values: Vec<f64> = laws.iter().copied().chain([23.0, 16.0, 170.0]).collect();
    let free: Vec<usize> = parameters.iter().copied().chain(laws.len()..laws.len() + 3).collect();
    let at = likelihood.linearise(&model, &values, &free).unwrap();
    let one = |(k, &slot): (usize, &usize)| {
        let h = 1e-4 * values[slot].abs().max(0.1);
        let side = |h: f64| {
            let mut moved = values.clone();
            moved[slot] += h;
            likelihood.cost(&model, &moved).unwrap()
        };
        (at.gradient[k], (side(h) - side(-h)) / (2.0 * h))
    };
    free.iter().enumerate().map(one).collect()
}

#[test]
fn the_gradient_matches_central_differences() {
    let likelihood = likelihood(&pushed(locked()), 1);
    let friction = effect(Kind::CoulombFriction, &[("x", 0.3), ("y", 0.2), ("force", 6.0)]);
    for (exact, numeric) in slopes(&likelihood, friction, &[1, 2, 3]) {
        assert!((exact - numeric).abs() < 1e-3 * numeric.abs() + 1e-2, "{exact} {numeric}");
    }
    // The gradient neglects the change of the Laplace cost of the initial states.
    for (exact, numeric) in slopes(&likelihood, caster(), &[1, 2, 3, 4]) {
        assert!((exact - numeric).abs() < 0.02 * numeric.abs() + 10.0, "{exact} {numeric}");
    }
}
