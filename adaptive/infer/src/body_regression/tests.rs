use super::*;
use crate::baseline::{Pushes, noisy, transitions};
use trundle_model::{Effect, Kind, Plant};

const NOISE: StepNoise = StepNoise { twist: [0.005, 0.005, 0.01], wrench: [0.4, 0.4, 0.05] };
const BOX: [[f64; 2]; 4] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];

/// A body whose mass centre and inertia differ from those of its outline, on three wheels.
fn truth() -> Model {
    let outline = Body::from_footprint(&BOX, 30.0).unwrap();
    let body = Body { com: [0.15, -0.08], gyration: 0.8 * outline.gyration, ..outline };
    let wheel = |values: [f64; 5]| Effect { kind: Kind::ViscousWheel, values: values.map(Some).to_vec() };
    let wheels = [[-0.5, 0.3, 0.4, 150.0, 70.0], [0.5, -0.3, 0.0, 8.0, 8.0], [0.5, 0.3, 1.0, 5.0, 200.0]];
    Model::nominal(body, Some(30.0), [true; 3]).with_effects(wheels.map(wheel).to_vec())
}

trait WithEffects {
    fn with_effects(self, effects: Vec<Effect>) -> Self;
}

impl WithEffects for Model {
    fn with_effects(self, effects: Vec<Effect>) -> Self {
        Self { effects, ..self }
    }
}

fn pushes(n: usize) -> Vec<Transition> {
    let settings = Pushes { dt: 0.05, per_episode: n, ..Pushes::default() };
    transitions(&truth(), n, 1, &settings).unwrap()
}

/// The same transitions with noise on the state that two of them share.
fn observed(data: &[Transition]) -> Vec<Transition> {
    let [u, v, w] = NOISE.twist;
    let mut noisy = noisy(data, &[0.0, 0.0, 0.0, u, v, w], 2);
    for k in 1..noisy.len() {
        noisy[k].before = noisy[k - 1].after;
    }
    noisy
}

fn regression(data: &[Transition]) -> BodyRegression {
    let mut found = BodyRegression::new(Body::from_footprint(&BOX, 22.0).unwrap(), NOISE);
    found.update(data).unwrap();
    found
}

/// Damping matrix and mass properties of a model.
fn properties(plant: &Plant<f64>) -> [f64; 10] {
    use trundle_model::{Clock, State};
    let clock = Clock::since_contact(0.0);
    let force = plant.generalised_force(&State::at_rest([0.0; 3]), clock);
    let rigid = plant.rigid(clock);
    let [xx, xy, yy, xt, yt, tt] = force.damping;
    [rigid.mass, rigid.com[0], rigid.com[1], rigid.inertia, xx, xy, yy, xt, yt, tt]
}

#[test]
fn all_parameters_are_recovered_from_noisy_steps() {
    let found = regression(&observed(&pushes(60)));
    let (is, should) =
        (properties(&found.model().resolved().unwrap()), properties(&truth().resolved().unwrap()));
    let tolerance = [0.6, 0.015, 0.015, 0.3, 10.0, 10.0, 10.0, 4.0, 4.0, 3.0];
    for k in 0..10 {
        assert!((is[k] - should[k]).abs() < tolerance[k], "{k}: {is:?} {should:?}");
    }
}

#[test]
fn the_first_steps_already_determine_the_mass() {
    let found = regression(&observed(&pushes(8)));
    let posterior = found.posterior().unwrap();
    let mass = posterior.names.iter().position(|name| name == "body.mass").unwrap();
    let (mean, sd) = (posterior.mean[mass], posterior.covariance[mass][mass].sqrt());
    assert!((mean - 30.0).abs() < 3.0 * sd && sd < 3.0, "{mean} ± {sd}");
}

#[test]
fn without_data_the_model_is_that_of_the_outline() {
    let outline = Body::from_footprint(&BOX, 22.0).unwrap();
    let model = BodyRegression::new(outline.clone(), NOISE).model();
    assert!((model.body.mass - 22.0).abs() < 1e-9);
    assert!((model.body.inertia() - outline.inertia()).abs() < 1e-9);
    assert!(properties(&model.resolved().unwrap())[4] < 0.01);
}

#[test]
fn contact_with_an_obstacle_hardly_changes_the_estimate() {
    let clean = observed(&pushes(60));
    let mut touched = clean.clone();
    for step in &mut touched[40..48] {
        step.wrench[0] += 60.0;
    }
    let (a, b) = (regression(&clean).model(), regression(&touched).model());
    assert!((a.body.mass / b.body.mass - 1.0).abs() < 0.05, "{} {}", a.body.mass, b.body.mass);
}

#[test]
fn a_wheel_that_locks_is_noticed_within_a_second() {
    let locked =
        Effect { kind: Kind::ViscousWheel, values: [0.5, 0.3, 0.0, 200.0, 200.0].map(Some).to_vec() };
    let settings = Pushes { dt: 0.05, per_episode: 200, ..Pushes::default() };
    let before = transitions(&truth(), 60, 1, &settings).unwrap();
    let after = transitions(&truth().with(locked.clone()), 20, 3, &settings).unwrap();
    let mut found = BodyRegression::new(Body::from_footprint(&BOX, 22.0).unwrap(), NOISE);
    let all: Vec<Transition> = before.into_iter().chain(after).collect();
    for count in 1..=all.len() {
        found.update(&all[..count]).unwrap();
    }
    let is = properties(&found.model().resolved().unwrap());
    let should = properties(&truth().with(locked).resolved().unwrap());
    assert!(found.first >= 60, "{}", found.first);
    assert!(
        (is[0] / should[0] - 1.0).abs() < 0.05 && (is[4] / should[4] - 1.0).abs() < 0.1,
        "{is:?} {should:?}"
    );
}

#[test]
fn an_axis_without_damping_does_not_move_the_wheel_along_the_other() {
    // One track that resists across only. Its lever along the other axis is not determined.
    let track = Effect { kind: Kind::ViscousWheel, values: [0.4, 0.2, 0.3, 0.0, 80.0].map(Some).to_vec() };
    let truth = truth().with_effects(vec![track]);
    let settings = Pushes { dt: 0.05, per_episode: 60, ..Pushes::default() };
    let found = regression(&observed(&transitions(&truth, 60, 5, &settings).unwrap()));
    let (is, should) =
        (properties(&found.model().resolved().unwrap()), properties(&truth.resolved().unwrap()));
    for k in 4..10 {
        assert!((is[k] - should[k]).abs() < 6.0, "{k}: {is:?} {should:?}");
    }
}

#[test]
fn the_posterior_covers_the_mass() {
    let errors: Vec<f64> = (0..40)
        .map(|seed| {
            let settings = Pushes { dt: 0.05, per_episode: 30, ..Pushes::default() };
            let found = regression(&observed(&transitions(&truth(), 30, seed, &settings).unwrap()));
            let posterior = found.posterior().unwrap();
            assert_eq!(posterior.names[0], "body.mass");
            (posterior.mean[0] - 30.0) / posterior.covariance[0][0].sqrt()
        })
        .collect();
    let inside = errors.iter().filter(|error| error.abs() < 2.0).count();
    assert!((32..=40).contains(&inside), "{inside} {errors:?}");
}

#[test]
fn data_that_are_not_finite_are_refused() {
    let mut data = pushes(3);
    data[1].wrench[2] = f64::NAN;
    let mut found = BodyRegression::new(Body::from_footprint(&BOX, 22.0).unwrap(), NOISE);
    assert!(found.update(&data).unwrap_err().to_string().contains("transition 1"));
    assert!(found.update(&[]).is_err());
}
