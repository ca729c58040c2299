//! Two models that a recording cannot tell apart, the push that can, and what becomes of them after it.

use super::bench::{Bench, Instruments, Limits};
use super::imagine::imagine;
use super::{Experiment, Profile, Push, Rival, certificate, experiment};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_infer::{Comparison, Fit, FitOptions, Quiet, fit};
use trundle_model::{Body, Effect, Kind, Model};
use trundle_record::{Dataset, Noise, Prepared};

const NOISE: Noise = Noise { pose: [5e-4, 5e-4, 1.75e-3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

fn table(effects: Vec<Effect>) -> Model {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&corners, 22.0).unwrap();
    Model { body, mass: None, dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |e, (name, value)| e.with(name, Some(*value)))
}

/// A table with a drag under it, on a floor that slopes.
fn truth() -> Model {
    let drag = effect(Kind::SupportDrag, &[("mu", 25.0), ("spread", 1.0)]);
    let slope = effect(Kind::FloorSlope, &[("accel_x", 0.03), ("accel_y", -0.02)]);
    Model { mass: Some(22.0), ..table(vec![drag, slope]) }
}

fn rivals() -> [Model; 2] {
    [Kind::FloorSlope, Kind::ForceBias]
        .map(|kind| table(vec![Effect::free(Kind::SupportDrag), Effect::free(kind)]))
}

/// What instruments with noise see of a push.
fn recorded(push: &Push, ordinal: usize) -> Prepared {
    let instruments = Instruments::with(NOISE);
    let mut episode = imagine(&truth().resolved().unwrap(), push, &instruments, ordinal);
    let mut rng = ChaCha8Rng::seed_from_u64(ordinal as u64);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let tare = instruments.tare.map(&mut normal);
    for sample in &mut episode.wrench {
        let sd = [NOISE.force, NOISE.force, NOISE.torque];
        sample.reading = [0, 1, 2].map(|k| sample.reading[k] + tare[k] + normal(sd[k]));
    }
    for sample in &mut episode.pose {
        sample.pose = [0, 1, 2].map(|k| sample.pose[k] + normal(NOISE.pose[k]));
    }
    episode
}

/// Pushes along the table's x by the middle of its short side, always from the same pose: nothing turns.
fn alike() -> Dataset {
    let push = |profile, force| Push {
        grasp: [0.57, 0.0],
        direction: 0.0,
        start: [0.0; 3],
        profile,
        force,
        torque: 0.0,
        duration: 4.0,
    };
    let pushes = [
        push(Profile::ThereAndBack, 12.0),
        push(Profile::Shuttle, 20.0),
        push(Profile::Steady, 9.0),
        push(Profile::Pulses, 15.0),
    ];
    let training = pushes.iter().enumerate().map(|(k, push)| recorded(push, k)).collect();
    Dataset {
        name: "table".to_owned(),
        body: truth().body,
        dof: [true; 3],
        noise: NOISE,
        point_contact: false,
        commanded: false,
        wrench_pose: Default::default(),
        mass_given: None,
        training,
        held_out: vec![],
        obstacles: vec![],
    }
}

fn fitted(data: &Dataset) -> (Comparison, [Fit; 2]) {
    let comparison = Comparison::of(data).unwrap();
    let fits = rivals().map(|m| fit(&comparison, &m, &[], &FitOptions::default(), &Quiet).unwrap());
    (comparison, fits)
}

fn designed(data: &Dataset, fits: &[Fit; 2], count: usize) -> Experiment {
    let bench = Bench::after(data, &fits[0].channels, Limits::default());
    let [a, b] = [Rival::fitted("floor_slope", &fits[0]), Rival::fitted("force_bias", &fits[1])];
    experiment(&bench, &a, &b, count, &Quiet).unwrap()
}

#[test]
fn a_tie_is_certified_and_the_designed_push_breaks_it() {
    let mut data = alike();
    let (comparison, fits) = fitted(&data);
    let tie = certificate(&comparison, ["floor_slope", "force_bias"], [&fits[0], &fits[1]]).unwrap();
    assert!(tie.same && tie.sigmas < 0.5, "{tie:?}");

    let plan = designed(&data, &fits, 1);
    let push = plan.pushes[0].push;
    assert!(plan.sure > 0.95 && plan.repeats == Some(1));
    let turned = (push.start[2] - data.training[0].pose[0].pose[2]).abs() > 0.5;
    assert!(turned || push.profile.turns() || push.grasp[1].abs() > 0.3, "its heading must change: {push:?}");

    data.training.push(recorded(&push, 4));
    let (comparison, fits) = fitted(&data);
    let after = certificate(&comparison, ["floor_slope", "force_bias"], [&fits[0], &fits[1]]).unwrap();
    assert!(!after.same && after.sigmas > 5.0 && after.position > Some(0.01), "{after:?}");
    assert!(after.log_likelihood_difference > 0.3 * plan.separation[0], "{after:?}");
}

#[test]
fn more_of_the_same_is_worth_less_than_the_designed_push() {
    let data = alike();
    let (_, fits) = fitted(&data);
    let best = designed(&data, &fits, 1);
    let [a, b] = [Rival::fitted("a", &fits[0]), Rival::fitted("b", &fits[1])];
    let bench = Bench::after(&data, &fits[0].channels, Limits::default());
    let search = super::choose::Search::new(&bench, [&a, &b], &Quiet).unwrap();
    let usual = Push { force: 12.0, profile: Profile::ThereAndBack, ..best.pushes[0].push };
    let usual =
        Push { grasp: [0.57, 0.0], direction: 0.0, start: [0.0; 3], duration: 4.0, torque: 0.0, ..usual };
    let [repeated, _] = search.refitted(&[usual]).unwrap();
    assert!(repeated < 0.05 * best.separation[0], "{repeated} {:?}", best.separation);
}

#[test]
fn where_the_object_drifts_by_itself_a_shorter_push_keeps_the_room() {
    let data = alike();
    let (_, fits) = fitted(&data);
    let [a, b] = [Rival::fitted("floor_slope", &fits[0]), Rival::fitted("force_bias", &fits[1])];
    let limits = Limits { distance: 0.1, ..Limits::default() };
    let plan = experiment(&Bench::after(&data, &fits[0].channels, limits), &a, &b, 1, &Quiet).unwrap();
    assert!(plan.tells(), "{plan:?}");
    assert!(plan.pushes[0].push.duration < 4.0, "{:?}", plan.pushes[0].push);
}

#[test]
fn the_noise_of_a_tracker_is_no_spin_that_a_robot_can_make() {
    // Along a line: what turns is noise, here of three times the size, and the default holds.
    let mut data = alike();
    data.noise.pose[2] *= 3.0;
    data.training.iter_mut().flat_map(|e| &mut e.pose).for_each(|p| p.pose[2] *= 3.0);
    assert_eq!(Limits::seen(&data).spin, Limits::default().spin);
}

#[test]
fn a_model_and_itself_cannot_be_told_apart() {
    let data = alike();
    let (_, fits) = fitted(&data);
    let plan = designed(&data, &[fits[0].clone(), fits[0].clone()], 1);
    assert!(!plan.tells() && plan.repeats.is_none(), "{plan:?}");
    assert!(plan.sentence.starts_with("No push"));
}

#[test]
fn the_push_that_a_diagnosis_asks_for_breaks_the_tie() {
    let mut data = alike();
    let nominal = table(vec![Effect::free(Kind::SupportDrag)]);
    let options = crate::Options { model: Some(nominal), ..Default::default() };
    let answer = crate::diagnose(&data, &options, &Quiet).unwrap().answer;
    let tied: Vec<&str> = answer.tied.iter().flatten().map(String::as_str).collect();
    assert!(tied.contains(&"floor_slope") && tied.contains(&"force_bias"), "{:?}", answer.tied);
    assert!(answer.certificates.iter().any(|c| c.same), "{:?}", answer.certificates);
    let between = |e: &&Experiment| e.models.iter().all(|name| tied.contains(&name.as_str()));
    let plan = answer.experiments.iter().find(between).expect("an experiment for the tie");
    assert!(answer.alternatives.iter().any(|a| a.experiment == plan.sentence));

    data.training.push(recorded(&plan.pushes[0].push, 4));
    let answer = crate::diagnose(&data, &options, &Quiet).unwrap().answer;
    assert_eq!(answer.missing.iter().map(|m| m.effect.as_str()).collect::<Vec<_>>(), ["floor_slope"]);
    assert!(answer.tied.is_empty(), "{:?}", answer.tied);
}
