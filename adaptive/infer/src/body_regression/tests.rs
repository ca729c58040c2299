use super::parameters::PARAMETERS;
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
    let of = |data: &[Transition]| properties(&regression(data).model().resolved().unwrap());
    let (a, b) = (of(&clean), of(&touched));
    // With the same weight for all steps, the damping of x changes by more than a tenth.
    assert!((a[0] / b[0] - 1.0).abs() < 0.03 && (a[4] / b[4] - 1.0).abs() < 0.03, "{a:?} {b:?}");
}

#[test]
fn the_equation_of_motion_is_that_of_the_plant() {
    let mut model = truth();
    let contact = Contact::new(model.body.com, [0.6, 0.4], [1e-6; 3]);
    contact.add_to(&mut model, 35.0);
    let (rolling, plant) = (truth().resolved().unwrap(), model.resolved().unwrap());
    let [m, x, y, inertia, xx, xy, yy, xt, yt, tt] = properties(&rolling);
    let polar = inertia + m * (x * x + y * y);
    let parameters = Parameters::from([m, m * x, m * y, polar, xx, xy, yy, xt, yt, tt, 35.0]);
    // Fast and spinning, so that all terms of the rotating axes matter.
    let (before, wrench, dt) = ([0.0, 0.0, 0.7, 1.5, -1.0, 3.0], [40.0, -30.0, 20.0], 1e-4);
    let after = crate::baseline::hold(&plant, &before, &wrench, dt);
    let step = Transition { before, wrench, dt, after };
    let equation = StepEquation::of(&step, &(nalgebra::Matrix3::identity() * 0.5), &contact);
    let error = equation.regressors * parameters - equation.impulse;
    assert!(error.norm() < 1e-4 * equation.impulse.norm(), "{error} {}", equation.impulse);
}

#[test]
fn whitened_normal_equations_are_those_of_the_dense_covariance() {
    let data = observed(&pushes(5));
    let shape = nalgebra::Matrix3::identity() * 0.5;
    let contact = Contact::new([0.0; 2], [0.6, 0.4], NOISE.twist);
    let equations: Vec<_> = data.iter().map(|step| StepEquation::of(step, &shape, &contact)).collect();
    let weights = [1.0, 0.5, 0.2, 1.0, 0.7];
    let twist = nalgebra::Matrix3::new(2.0, 0.3, 0.1, 0.3, 1.5, 0.2, 0.1, 0.2, 0.9);
    let other = [0.4, 0.3, 0.2];
    let mut covariance = nalgebra::DMatrix::<f64>::zeros(15, 15);
    let mut design = nalgebra::DMatrix::<f64>::zeros(15, PARAMETERS);
    let mut impulse = nalgebra::DVector::<f64>::zeros(15);
    for k in 0..5 {
        let block = twist * 2.0 + nalgebra::Matrix3::from_diagonal(&other.map(|v| v / weights[k]).into());
        covariance.view_mut((3 * k, 3 * k), (3, 3)).copy_from(&block);
        if k > 0 {
            covariance.view_mut((3 * k, 3 * k - 3), (3, 3)).copy_from(&-twist);
            covariance.view_mut((3 * k - 3, 3 * k), (3, 3)).copy_from(&-twist.transpose());
        }
        design.view_mut((3 * k, 0), (3, PARAMETERS)).copy_from(&equations[k].regressors);
        impulse.rows_mut(3 * k, 3).copy_from(&equations[k].impulse);
    }
    let log_determinant = 0.5 * covariance.determinant().ln();
    let inverse = covariance.try_inverse().unwrap();
    let found = whiten(&equations, &weights, twist.as_slice().try_into().unwrap(), &other).unwrap();
    let precision = design.transpose() * &inverse * &design;
    assert!((found.precision - &precision).norm() < 1e-9 * precision.norm());
    let information = design.transpose() * &inverse * &impulse;
    assert!((found.information - &information).norm() < 1e-9 * information.norm());
    assert!((found.square / impulse.dot(&(&inverse * &impulse)) - 1.0).abs() < 1e-9);
    assert!((found.log_determinant - log_determinant).abs() < 1e-9);
}

#[test]
fn the_prior_of_mass_centre_and_inertia_is_relative_to_the_mass() {
    // The outline lies off the origin, so that a uniform body of another mass has other first moments.
    let shifted = BOX.map(|[x, y]| [x + 0.2, y - 0.1]);
    let prior = BodyPrior::of(&Body::from_footprint(&shifted, 22.0).unwrap());
    let (mean, precision) = prior.at(40.0, false);
    let uniform = Body::from_footprint(&shifted, 60.0).unwrap();
    let [x, y] = uniform.com;
    let about_origin = uniform.inertia() + 60.0 * (x * x + y * y);
    let body = [60.0, 60.0 * x, 60.0 * y, about_origin];
    let other = Parameters::from_fn(|k, _| body.get(k).copied().unwrap_or(0.0));
    let off = other - mean;
    let only_mass = (off[0] / (0.7 * 40.0)).powi(2);
    assert!((off.dot(&(precision * off)) / only_mass - 1.0).abs() < 1e-9);
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

/// Pushes of an object with dry friction of 40 N at its feet.
fn rubbing(n: usize) -> Vec<Transition> {
    let foot = |x: f64, y: f64| {
        let effect = Effect::free(Kind::CoulombFriction);
        effect.with("x", Some(x)).with("y", Some(y)).with("force", Some(10.0))
    };
    let feet = [foot(-0.5, -0.3), foot(0.5, -0.3), foot(0.5, 0.3), foot(-0.5, 0.3)];
    let model = Model::nominal(Body::from_footprint(&BOX, 30.0).unwrap(), Some(30.0), [true; 3]);
    let settings = Pushes { dt: 0.05, per_episode: n, ..Pushes::default() };
    observed(&transitions(&model.with_effects(feet.to_vec()), n, 1, &settings).unwrap())
}

fn friction_of(model: &Model) -> Option<f64> {
    let effect = model.effects.iter().find(|effect| effect.kind == Kind::SupportFriction)?;
    effect.values[0]
}

#[test]
fn dry_friction_is_found_where_it_acts_and_only_there() {
    let friction = friction_of(&regression(&rubbing(40)).model()).unwrap();
    assert!((friction / 40.0 - 1.0).abs() < 0.15, "{friction}");
    assert_eq!(friction_of(&regression(&observed(&pushes(40))).model()), None);
}

#[test]
fn an_object_that_does_not_yield_shows_friction() {
    let still = |wrench: [f64; 3]| Transition { before: [0.0; 6], wrench, dt: 0.05, after: [0.0; 6] };
    let of = |data: &[Transition]| friction_of(&regression(data).model());
    let friction = of(&[still([30.0, 0.0, 0.0]), still([50.0, 0.0, 0.0]), still([10.0, 0.0, 0.0])]);
    assert!(friction.is_some_and(|force| force > 49.0), "{friction:?}");
    assert_eq!(of(&[still([0.5, 0.0, 0.0])]), None, "a free object would hardly move either");
    let moved: Vec<_> = [still([50.0, 0.0, 0.0])].into_iter().chain(observed(&pushes(20))).collect();
    assert_eq!(of(&moved), None, "it has moved since");
}

#[test]
fn friction_of_unknown_direction_adds_half_its_square_to_the_variance_of_each_axis() {
    let found = BodyRegression { friction: 40.0, weights: vec![0.5], ..regression(&rubbing(20)) };
    let still = Transition { before: [0.0; 6], wrench: [10.0, 0.0, 0.0], dt: 0.05, after: [0.0; 6] };
    let shape = nalgebra::Matrix3::identity() * 0.5;
    let equations = [StepEquation::of(&still, &shape, &found.contact())];
    let other = [3.0, 3.0, 1.0];
    let variance = |is_dry| other[0] / found.weights_with(&equations, &other, is_dry)[0];
    assert!((variance(false) - 6.0).abs() < 1e-12);
    assert!((variance(true) - 6.0 - 0.5 * (40.0 * 0.05f64).powi(2)).abs() < 1e-9);
}

#[test]
fn the_mean_direction_of_a_noisy_velocity_and_its_unknown_share_are_those_of_samples() {
    use rand::{RngExt, SeedableRng};
    let contact = Contact::new([0.0; 2], [0.6, 0.4], [0.01, 0.01, 0.0]);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    for speed in [0.0, 0.01, 0.1] {
        let twist = nalgebra::Vector3::new(speed, 0.0, 0.0);
        let sliding = contact.sliding(twist, twist);
        // Between two observations the noise is a little less than that of one.
        let sd = 0.01 / 1.3f64.sqrt();
        let mut mean = 0.0;
        let n = 20_000;
        for _ in 0..n {
            let [u, v]: [f64; 2] = [0, 1].map(|_| rng.sample::<f64, _>(rand_distr::StandardNormal) * sd);
            mean += (speed + u) / (speed + u).hypot(v) / f64::from(n);
        }
        assert!((sliding.wrench[0] - mean).abs() < 0.1, "{speed}: {} {mean}", sliding.wrench[0]);
        let rest = 1.0 - sliding.wrench[0] * sliding.wrench[0];
        assert!((sliding.undirected - rest).abs() < 0.02, "{speed}");
    }
}
