//! The likelihood along the seen motion.

use super::{VALUES, pushed, under_test, wheeled};
use crate::common::{World, effect, locked};
use crate::foreign::likelihood::Along;
use crate::foreign::own_states::beginning;
use crate::foreign::path::Path;
use trundle_infer::{Channels, Likelihood, Quiet};
use trundle_model::{Effect, Kind, Model, Plant};
use trundle_record::Dataset;

/// The right simulator along the first episodes of a recording.
fn along(data: &Dataset, episodes: usize) -> Along {
    along_at(data, episodes, VALUES)
}

/// The same with other values.
fn along_at(data: &Dataset, episodes: usize, values: [f64; 3]) -> Along {
    let simulator = wheeled();
    let foreign = under_test(&simulator, false);
    let one = |e| Path::new(e, &data.noise).unwrap();
    let paths: Vec<Path> = data.training.iter().take(episodes).map(one).collect();
    Along::new(&foreign, &values, &paths, Channels::of(&data.noise), data.dof, &Quiet).unwrap()
}

/// Laws on the table, without its wheel.
fn laws(effects: Vec<Effect>) -> Model {
    Model { effects, ..locked() }
}

fn plant(effects: Vec<Effect>) -> Plant<f64> {
    laws(effects).resolved().unwrap()
}

/// Mean square of the whitened innovations.
fn square(along: &Along, plant: &Plant<f64>) -> f64 {
    let innovations = along.innovations(plant, &VALUES);
    innovations.iter().map(|e| e * e).sum::<f64>() / innovations.len() as f64
}

#[test]
fn innovations_of_the_right_simulator_are_white() {
    let data = pushed(locked());
    let along = along(&data, 3);
    let innovations = along.innovations(&plant(vec![]), &VALUES);
    let n = innovations.len() as f64;
    let square: f64 = innovations.iter().map(|e| e * e).sum::<f64>() / n;
    let next: f64 = innovations.windows(4).map(|w| w[0] * w[3]).sum::<f64>() / n / square;
    assert!((square - 1.0).abs() < 0.08 && next.abs() < 0.05, "{square} {next}");
    let felt = along.felt_mass().unwrap();
    assert!((felt / 22.0 - 1.0).abs() < 0.15, "{felt}");
}

fn caster() -> Effect {
    effect(Kind::CasterSwivel, &[("x", 0.5), ("y", 0.25), ("trail", 0.06), ("mu_side", 60.0)])
}

#[test]
fn a_caster_is_followed_from_where_it_stood() {
    let hidden = caster();
    let mut world = World::of(locked().with(hidden.clone()));
    world.inner[0] = 1.2;
    let data = world.recording(3);
    let along = along(&data, 3);
    let with = plant(vec![hidden]);
    let starts = along.starts(&with, &VALUES);
    let found: Vec<(f64, f64)> = starts.iter().map(|start| (start.inner[0], start.price)).collect();
    assert!(found.iter().all(|(angle, price)| (angle - 1.2).abs() < 0.2 && *price > 0.0), "{found:?}");
    // An episode that is only simulated: its first second tells.
    let simulator = wheeled();
    let (foreign, seen) = (under_test(&simulator, false), (&data.noise, data.dof));
    let angle = beginning(&foreign, (&with, &VALUES), &data.held_out[0], seen, &Quiet).unwrap()[0];
    assert!((angle - 1.2).abs() < 0.2, "{angle}");
    let (without, with) = (square(&along, &plant(vec![])), square(&along, &with));
    assert!(without > 2.0 && (with - 1.0).abs() < 0.15, "{without} {with}");
}

#[test]
fn a_swinging_load_is_followed() {
    let values = [("x", 0.3), ("y", -0.2), ("mass", 5.0), ("frequency", 1.2), ("damping_ratio", 0.02)];
    let hidden = effect(Kind::SwingingLoad, &values);
    let along = along(&World::of(locked().with(hidden.clone())).recording(3), 3);
    let (without, with) = (square(&along, &plant(vec![])), square(&along, &plant(vec![hidden])));
    assert!(without > 2.0 && (with - 1.0).abs() < 0.15, "{without} {with}");
}

/// Otherwise a body that is too heavy with a law that lightens it would copy the motion that it is to predict.
#[test]
fn what_is_missing_is_not_explained_by_the_acceleration_that_was_seen() {
    let friction = effect(Kind::CoulombFriction, &[("x", 0.4), ("y", 0.3), ("force", 12.0)]);
    let data = pushed(locked().with(friction));
    let lighter = effect(Kind::MassChange, &[("episode", 0.0), ("time", 0.0), ("mass", -15.0)]);
    let heavy = Model { mass: Some(37.0), ..laws(vec![lighter]) };
    let right = square(&along(&data, 3), &plant(vec![]));
    let values = [37.0, VALUES[1], VALUES[2]];
    let innovations = along_at(&data, 3, values).innovations(&heavy.resolved().unwrap(), &values);
    let same = innovations.iter().map(|e| e * e).sum::<f64>() / innovations.len() as f64;
    assert!(right > 5.0 && same > 0.9 * right, "{right} {same}");
}

#[test]
fn a_reading_that_lags_is_brought_forward() {
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
    let along = along(&data, 3);
    let lagging = effect(Kind::SensorLag, &[("time_constant", lag)]);
    let (without, with) = (square(&along, &plant(vec![])), square(&along, &plant(vec![lagging])));
    assert!(without > 1.5 && (with - 1.0).abs() < 0.2, "{without} {with}");
}

/// Differences of the cost by some parameters, each beside what the likelihood says.
fn slopes(along: &Along, hidden: Effect, parameters: &[usize]) -> Vec<(f64, f64)> {
    let model = laws(vec![hidden]);
    let laws: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap_or(22.0)).collect();
    let values: Vec<f64> = laws.iter().copied().chain([23.0, 16.0, 170.0]).collect();
    let free: Vec<usize> = parameters.iter().copied().chain(laws.len()..laws.len() + 3).collect();
    let at = along.linearise(&model, &values, &free).unwrap();
    let one = |(k, &slot): (usize, &usize)| {
        let h = 1e-4 * values[slot].abs().max(0.1);
        let side = |h: f64| {
            let mut moved = values.clone();
            moved[slot] += h;
            along.cost(&model, &moved).unwrap()
        };
        (at.gradient[k], (side(h) - side(-h)) / (2.0 * h))
    };
    free.iter().enumerate().map(one).collect()
}

#[test]
fn derivatives_are_those_of_the_cost() {
    let along = along(&pushed(locked()), 1);
    let friction = effect(Kind::CoulombFriction, &[("x", 0.3), ("y", 0.2), ("force", 6.0)]);
    for (exact, numeric) in slopes(&along, friction, &[1, 2, 3]) {
        assert!((exact - numeric).abs() < 1e-3 * numeric.abs() + 1e-2, "{exact} {numeric}");
    }
    // But for how the price of a start changes.
    for (exact, numeric) in slopes(&along, caster(), &[1, 2, 3, 4]) {
        assert!((exact - numeric).abs() < 0.02 * numeric.abs() + 10.0, "{exact} {numeric}");
    }
}
