//! Laws that no catalogue has, fitted without a search.

use super::unnamed;
use crate::common::{self, World, locked};
use crate::lack_of_fit::lack_of_fit;
use trundle_infer::{Comparison, Fit, FitOptions, Quiet, fit, score};
use trundle_model::{Input, Model, State, to_body};
use trundle_record::Dataset;

/// The simulation under test, and the same with an unnamed wrench, if one proves itself.
fn fitted(foreign: fn(&State<f64>) -> [f64; 3], seed: u64) -> (Dataset, Fit, Option<Fit>) {
    let world = World { foreign, ..World::of(locked()) };
    let mut data = world.recording(seed);
    data.training = world.pushes(8, seed);
    data.held_out = data.training.split_off(6);
    let comparison = Comparison::of(&data).unwrap();
    let nominal = Model::nominal(common::table(), None, [true; 3]);
    let before = fit(&comparison, &nominal, &[], &FitOptions::default(), &Quiet).unwrap();
    let left = lack_of_fit(&comparison, &before).unwrap();
    let after = unnamed((&data, &nominal), &comparison, &before, left, &Quiet).unwrap();
    (data, before, after)
}

/// One second ahead on the held-out episodes, m.
fn ahead(data: &Dataset, fit: &Fit) -> f64 {
    let Fit { model, values, channels, .. } = fit;
    score(model, values, channels, &data.held_out, &data.noise, false).unwrap().window_position_rmse.unwrap()
}

/// A force across the motion, as on a charge in a magnetic field.
fn across(state: &State<f64>) -> [f64; 3] {
    let [x, y, _] = to_body(state.twist, state.pose[2]);
    [-16.0 * y, 16.0 * x, 0.0]
}

#[test]
fn a_force_of_the_motion_is_learnt_and_lowers_the_held_out_error() {
    let (data, before, after) = fitted(across, 3);
    let after = after.unwrap();
    let unnamed = after.model.discrepancy.as_ref().unwrap();
    assert!(unnamed.check().is_ok() && unnamed.inputs.contains(&Input::Twist), "{:?}", unnamed.inputs);
    let (without, with) = (ahead(&data, &before), ahead(&data, &after));
    assert!(with < 0.6 * without, "{without} {with}");
}

/// Grooves a centimetre apart: nothing to be learnt from a few pushes.
fn grooves(state: &State<f64>) -> [f64; 3] {
    let [x, y, theta] = state.pose;
    to_body([20.0 * (600.0 * x).sin(), 20.0 * (620.0 * y).sin(), 0.0], theta)
}

#[test]
fn where_nothing_is_to_be_learnt_nothing_is_added() {
    for foreign in [grooves, |_: &State<f64>| [0.0; 3]] {
        let (_, _, after) = fitted(foreign, 4);
        let inputs = after.and_then(|fit| fit.model.discrepancy).map(|unnamed| unnamed.inputs.clone());
        assert_eq!(inputs, None);
    }
}

#[test]
#[ignore = "slow: learns a force twice"]
fn the_same_recording_gives_the_same_bytes() {
    let text = || fitted(across, 3).2.unwrap().model.to_toml(None).unwrap();
    assert_eq!(text(), text());
}
