//! Discrepancies outside the catalogue, fitted without a search.

use super::fit_discrepancy;
use crate::lack_of_fit::lack_of_fit;
use trundle_fixtures::{World, locked};
use trundle_infer::{Comparison, Fit, FitOptions, Quiet, fit, score};
use trundle_model::{Input, Model, State, to_body};
use trundle_record::Dataset;

/// The nominal fit, and the fit with a discrepancy wrench if one passes the validation.
fn fitted(external: fn(&State<f64>) -> [f64; 3], seed: u64) -> (Dataset, Fit, Option<Fit>) {
    let world = World { out_of_catalogue: external, ..World::of(locked()) };
    let mut data = world.recording(seed);
    data.training = world.pushes(8, seed);
    data.held_out = data.training.split_off(6);
    let comparison = Comparison::of(&data).unwrap();
    let nominal = Model::nominal(trundle_fixtures::table(), None, [true; 3]);
    let before = fit(&comparison, &nominal, &[], &FitOptions::default(), &Quiet).unwrap();
    let left = lack_of_fit(&comparison, &before).unwrap();
    let after = fit_discrepancy((&data, &nominal), &comparison, &before, left, &Quiet).unwrap();
    (data, before, after)
}

/// Held-out position error one second ahead, m.
fn ahead(data: &Dataset, fit: &Fit) -> f64 {
    let Fit { model, values, channels, .. } = fit;
    score(model, values, channels, &data.held_out, &data.noise, false).unwrap().window_position_rmse.unwrap()
}

/// A force normal to the motion, as on a charge in a magnetic field.
fn across(state: &State<f64>) -> [f64; 3] {
    let [x, y, _] = to_body(state.twist, state.pose[2]);
    [-16.0 * y, 16.0 * x, 0.0]
}

#[test]
fn a_force_that_depends_on_the_motion_lowers_the_held_out_error() {
    let (data, before, after) = fitted(across, 3);
    let after = after.unwrap();
    let unnamed = after.model.discrepancy.as_ref().unwrap();
    assert!(unnamed.check().is_ok() && unnamed.inputs.contains(&Input::Twist), "{:?}", unnamed.inputs);
    let (without, with) = (ahead(&data, &before), ahead(&data, &after));
    assert!(with < 0.6 * without, "{without} {with}");
}

/// Grooves a centimetre apart, which a few pushes cannot reveal.
fn grooves(state: &State<f64>) -> [f64; 3] {
    let [x, y, theta] = state.pose;
    to_body([20.0 * (600.0 * x).sin(), 20.0 * (620.0 * y).sin(), 0.0], theta)
}

#[test]
fn no_discrepancy_is_added_that_does_not_predict() {
    for external in [grooves, |_: &State<f64>| [0.0; 3]] {
        let (_, _, after) = fitted(external, 4);
        let inputs = after.and_then(|fit| fit.model.discrepancy).map(|unnamed| unnamed.inputs.clone());
        assert_eq!(inputs, None);
    }
}

#[test]
#[ignore = "slow: learns a force twice"]
fn the_result_is_deterministic() {
    let text = || fitted(across, 3).2.unwrap().model.to_toml(None).unwrap();
    assert_eq!(text(), text());
}
