//! Model discrepancy: its file, its derivatives, its axes and its range.

#![allow(clippy::unwrap_used)]

use trundle_model::{Clock, Dual, Model, Plant, Real, State};

const TABLE: &str = r#"
format = "trundle-model/1"

[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 21.9

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
"#;

const WHIRL: &str = r#"
[unnamed]
inputs = ["position", "heading", "world_twist"]
axes = "world"
scales = [0.8, 0.9, 1.0, 1.1, 0.5, 0.6, 0.7]
centres = [[0.1, -0.2, 0.8, 0.6, 0.1, 0.0, 0.3], [-0.5, 0.4, 0.6, -0.8, 0.0, 0.2, -0.3]]
weights = [[8.0, -3.0, 1.0], [-5.0, 6.0, 2.0]]
"#;

const DRAG: &str = r#"
[unnamed]
inputs = ["twist", "since_contact"]
axes = "object"
scales = [0.4, 0.4, 0.8, 2.0]
centres = [[0.2, 0.0, 0.1, 0.5], [-0.2, 0.1, 0.0, 1.0]]
weights = [[-9.0, 1.0, 0.5], [7.0, -2.0, 0.3]]
"#;

const PLAY: &str = r#"
[unnamed]
inputs = ["reading"]
axes = "reading"
scales = [10.0, 10.0, 2.0]
centres = [[5.0, 0.0, 0.0], [-5.0, 3.0, 1.0]]
weights = [[2.0, 0.5, -0.1], [-2.0, 1.0, 0.2]]
"#;

const LAG: &str = r#"
[unnamed]
inputs = ["reading", "trend", "since_contact"]
axes = "reading"
scales = [10.0, 10.0, 2.0, 50.0, 50.0, 9.0, 3.0]
centres = [[5.0, 0.0, 0.0, 20.0, -10.0, 2.0, 1.0]]
weights = [[2.0, 0.5, -0.1]]
"#;

const CLOCK: Clock = Clock { trend: [30.0, -5.0, 1.0], ..Clock::since_contact(0.4) };

fn model(discrepancy: &str) -> Model {
    Model::from_toml(&format!("{TABLE}{discrepancy}")).unwrap().0
}

/// Pose and twist after one step from `at`: pose, twist and reading.
fn after<T: Real>(plant: &Plant<T>, at: &[T; 9]) -> [T; 6] {
    let state = State::moving([at[0], at[1], at[2]], [at[3], at[4], at[5]]);
    let applied = plant.correct([at[6], at[7], at[8]], CLOCK);
    let State { pose, twist, .. } = plant.step(&state, applied, CLOCK, 0.01);
    [pose[0], pose[1], pose[2], twist[0], twist[1], twist[2]]
}

#[test]
fn the_file_round_trips() {
    for discrepancy in [WHIRL, DRAG, PLAY, LAG] {
        let written = model(discrepancy).to_toml(None).unwrap();
        assert_eq!(Model::from_toml(&written).unwrap().0, model(discrepancy), "{written}");
    }
    let text = model("").to_toml(None).unwrap();
    assert!(!text.contains("unnamed"), "a model without a discrepancy must not write the key: {text}");
}

#[test]
fn errors_name_key_and_value() {
    for (from, to, words) in [
        ("scales = [0.4, 0.4, ", "scales = [0.4, ", vec!["unnamed.scales", "3", "4"]),
        ("scales = [0.4, ", "scales = [-0.4, ", vec!["unnamed.scales", "-0.4", "positive"]),
        ("[0.2, 0.0, 0.1, 0.5]", "[0.2, 0.0, 0.1]", vec!["unnamed.centres", "3", "4"]),
        (", [7.0, -2.0, 0.3]]", "]", vec!["unnamed.weights", "1", "2"]),
        ("inputs = [\"twist\", ", "inputs = [\"reading\", ", vec!["unnamed.inputs", "axes"]),
        ("inputs = [\"twist\", ", "inputs = [\"weather\", ", vec!["weather", "twist"]),
        ("axes =", "axis =", vec!["axis", "axes"]),
        ("[-9.0,", "[nan,", vec!["unnamed.weights", "finite"]),
    ] {
        assert!(DRAG.contains(from));
        let text = format!("{TABLE}{}", DRAG.replace(from, to));
        let message = Model::from_toml(&text).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{message} should contain {word}");
        }
    }
}

#[test]
fn derivatives_agree_with_finite_differences() {
    let at = [0.2, -0.1, 0.5, 0.15, -0.1, 0.2, 6.0, -2.0, 0.4];
    for discrepancy in [WHIRL, DRAG, PLAY, LAG] {
        let model = model(discrepancy);
        let values: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap()).collect();
        let lifted: Vec<Dual<9>> = values.iter().map(|&v| Real::lift(v)).collect();
        let duals = std::array::from_fn(|k| Dual::<9>::variable(at[k], k));
        let (exact, plant) = (after(&model.plant(&lifted).unwrap(), &duals), model.plant(&values).unwrap());
        for k in 0..9 {
            let moved = |by: f64| {
                let mut at = at;
                at[k] += by;
                after(&plant, &at)
            };
            let (more, less) = (moved(1e-5), moved(-1e-5));
            for (row, exact) in exact.iter().enumerate() {
                let numeric = (more[row] - less[row]) / 2e-5;
                let error = (numeric - exact.eps[k]).abs();
                assert!(error < 1e-7, "{discrepancy} {row} by {k}: {numeric} {}", exact.eps[k]);
            }
        }
    }
}

#[test]
fn the_wrench_acts_in_its_axes() {
    let (with, without) = (model(WHIRL).resolved().unwrap(), model("").resolved().unwrap());
    let state = State::moving([0.1, -0.2, 0.6_f64.atan2(0.8)], [0.1, 0.0, 0.3]);
    let wrench = |plant: &Plant<f64>| plant.generalised_force(&state, CLOCK).force;
    let missing = [0, 1, 2].map(|k| wrench(&with)[k] - wrench(&without)[k]);
    // At the first centre; the second is far in heading and position.
    let far: f64 =
        [0.6 / 0.8, 0.6 / 0.9, 0.2, 1.4 / 1.1, 0.1 / 0.5, 0.2 / 0.6, 0.6 / 0.7].iter().map(|z| z * z).sum();
    let kernel = (-0.5 * far).exp();
    let world = [8.0 - 5.0 * kernel, -3.0 + 6.0 * kernel, 1.0 + 2.0 * kernel];
    let expected = trundle_model::to_body(world, state.pose[2]);
    for k in 0..3 {
        assert!((missing[k] - expected[k]).abs() < 1e-12, "{missing:?} {expected:?}");
    }
    let early = with.generalised_force(&state, Clock::since_contact(-0.1)).force;
    assert_eq!(
        early,
        without.generalised_force(&state, Clock::since_contact(-0.1)).force,
        "no wrench before contact"
    );
}

#[test]
fn the_wrench_vanishes_far_from_its_centres() {
    let (with, without) = (model(DRAG).resolved().unwrap(), model("").resolved().unwrap());
    let fast = State::moving([0.0; 3], [9.0, 0.0, 0.0]);
    let gap =
        with.generalised_force(&fast, CLOCK).force[0] - without.generalised_force(&fast, CLOCK).force[0];
    assert!(gap.abs() < 1e-12, "{gap}");
    let plant = model(PLAY).resolved().unwrap();
    let far = plant.correct([200.0, 0.0, 0.0], CLOCK);
    assert!((far[0] - 200.0).abs() < 1e-12, "{far:?}");
    let apart = 10.0_f64.powi(2) / 10.0_f64.powi(2) + 0.3_f64.powi(2) + 0.5_f64.powi(2);
    let near = plant.correct([5.0, 0.0, 0.0], CLOCK)[0];
    assert!((near - 7.0 + 2.0 * (-0.5 * apart).exp()).abs() < 1e-12, "{near}");
}
