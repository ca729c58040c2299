use super::*;
use trundle_record::{Counts, Noise, PoseSample, Prepared, WrenchSample};

/// A disc of 20 kg with one isotropic wheel at its centre: linear in world axes but for the turn of the wrench.
const DISC: &str = r#"
format = "trundle-model/1"
[body]
mass = 20.0
fixture = [{ disc = [0.0, 0.0, 0.5] }]
[[effect]]
kind = "viscous_wheel"
x = 0.0
y = 0.0
angle = 0.0
mu_x = 40.0
mu_y = 40.0
"#;

fn model(text: &str) -> trundle_model::Model {
    trundle_model::Model::from_toml(text).unwrap().0
}

fn table() -> trundle_model::Model {
    let wheel = DISC.replace("x = 0.0\ny = 0.0", "x = -0.4\ny = 0.2").replace("mu_y = 40.0", "mu_y = 300.0");
    model(&wheel)
}

fn simulated(model: &trundle_model::Model, n: usize, seed: u64) -> Vec<Transition> {
    transitions(model, n, seed, &Pushes::default()).unwrap()
}

/// Pushes without a torque: the wrench keeps its direction while it is held.
fn straight(n: usize, seed: u64) -> Vec<Transition> {
    transitions(&model(DISC), n, seed, &Pushes { spin: 0.0, ..Pushes::default() }).unwrap()
}

#[test]
fn r2_is_the_mean_over_channels() {
    struct Fixed;
    impl Predictor for Fixed {
        fn predict(&self, x: &StateVector, _: &[f64; 3], _: f64) -> StateVector {
            [x[0], 2.0, 0.0, 0.0, 0.0, 5.0]
        }
    }
    // x is hit: 1. y is 1 and 3 and predicted 2, its mean: 0. Heading is 0 and 2 and predicted 0: 1 − 4/2 = −1.
    // The twist does not vary and does not count, right (v_x, v_y) or wrong (ω).
    let test = [[7.0, 1.0, 0.0], [9.0, 3.0, 2.0]].map(|[x, y, heading]| Transition {
        before: [x, 0.0, 0.0, 0.0, 0.0, 0.0],
        wrench: [0.0; 3],
        dt: 0.5,
        after: [x, y, heading, 0.0, 0.0, 0.0],
    });
    assert!(r2(&Fixed, &test).abs() < 1e-12, "{}", r2(&Fixed, &test));
    let pooled = {
        // The same, pooled after each channel is divided by its standard deviation over the test.
        let (errors, spread) = (0.0 + 2.0 / 1.0 + 4.0 / 1.0, 2.0 + 2.0 + 2.0);
        1.0 - errors / spread
    };
    assert!((r2(&Fixed, &test) - pooled).abs() < 1e-12);
    assert!(r2(&Fixed, &test[..1]).is_nan());
}

#[test]
fn linear_regression_is_exact_on_a_linear_object() {
    let test = straight(200, 1);
    for (n, exact) in [(11, true), (3, false)] {
        let score = r2(&Linear::fit(&straight(n, 0), Features::World).unwrap(), &test);
        assert_eq!(score > 1.0 - 1e-9, exact, "{n}: {score}");
    }
    // In object axes the direction of the force is not in the linear terms.
    assert!(r2(&Linear::fit(&straight(50, 0), Features::Recorded).unwrap(), &test) < 0.995);
    // With spin the held wrench turns by up to some 20° while it is held.
    let turning = r2(
        &Linear::fit(&simulated(&model(DISC), 50, 0), Features::World).unwrap(),
        &simulated(&model(DISC), 200, 1),
    );
    assert!((0.999..1.0 - 1e-9).contains(&turning), "{turning}");
}

#[test]
fn a_wheel_is_not_linear_in_world_axes() {
    let (training, test) = (simulated(&table(), 200, 0), simulated(&table(), 200, 1));
    let score = |features| r2(&Linear::fit(&training, features).unwrap(), &test);
    let [world, recorded, body] = Features::ALL.map(score);
    assert!(world < 0.97 && recorded < 0.97, "{world} {recorded}");
    assert!(body > world, "{body}");
}

#[test]
fn locally_weighted_regression_learns_with_data() {
    let test = simulated(&table(), 200, 1);
    let errors = [20, 60, 200]
        .map(|n| 1.0 - r2(&Local::fit(&simulated(&table(), n, 0), Features::World).unwrap(), &test));
    assert!(errors[0] > 1.3 * errors[1] && errors[1] > 1.3 * errors[2], "{errors:?}");
    let linear = r2(&Linear::fit(&simulated(&table(), 200, 0), Features::World).unwrap(), &test);
    assert!(1.0 - linear > 2.0 * errors[2], "{linear} {errors:?}");
}

#[test]
fn a_local_fit_of_a_line_is_the_line() {
    let test = straight(100, 3);
    let score = r2(&Local::fit(&straight(40, 0), Features::World).unwrap(), &test);
    assert!(score > 1.0 - 1e-6, "{score}");
}

#[test]
fn few_observations_are_enough() {
    for n in 1..5 {
        for features in Features::ALL {
            let training = simulated(&table(), n, 0);
            assert!(r2(&Linear::fit(&training, features).unwrap(), &training).is_finite() || n == 1);
            assert!(r2(&Local::fit(&training, features).unwrap(), &training).is_finite() || n == 1);
        }
    }
    assert!(matches!(Linear::fit(&[], Features::World), Err(BaselineError::Empty)));
    let mut bad = simulated(&table(), 3, 0);
    bad[1].after[4] = f64::NAN;
    let message = Local::fit(&bad, Features::World).unwrap_err().to_string();
    assert!(message.contains("transition 1") && message.contains("state after"), "{message}");
}

#[test]
fn the_true_plant_predicts_exactly() {
    let plant = table().resolved().unwrap();
    let data = simulated(&table(), 100, 2);
    assert!(r2(&plant, &data) > 1.0 - 1e-12);
    // Chained: within an episode, a transition begins where the last one ended.
    assert_eq!(data[3].after, data[4].before);
    assert_ne!(data[9].after, data[10].before);
    assert!(r2(&ConstantVelocity, &data) < 0.9);
}

#[test]
fn the_same_seed_gives_the_same_transitions_and_more_extend_them() {
    let data = simulated(&table(), 30, 5);
    assert_eq!(data, simulated(&table(), 50, 5)[..30]);
    assert_ne!(data, simulated(&table(), 30, 6));
    let (a, b) = (noisy(&data, &[0.1; 6], 7), noisy(&data, &[0.1; 6], 7));
    assert_eq!(a, b);
    assert_eq!(a[..10], noisy(&data[..10], &[0.1; 6], 7));
}

#[test]
fn noise_is_of_the_size_and_the_units_stated() {
    let data = simulated(&table(), 2000, 5);
    for reading in [SigmaReading::Si, SigmaReading::CentimetreDegree, SigmaReading::OfMotion] {
        let sd = reading.sd(0.5, &data);
        let seen = noisy(&data, &sd, 0);
        for (k, sd) in sd.iter().enumerate() {
            let square = data.iter().zip(&seen).map(|(t, s)| (s.after[k] - t.after[k]).powi(2)).sum::<f64>();
            assert!(((square / 2000.0).sqrt() / sd - 1.0).abs() < 0.06);
        }
        assert!(data.iter().zip(&seen).all(|(t, s)| t.before == s.before && t.wrench == s.wrench));
    }
    assert!((SigmaReading::CentimetreDegree.sd(0.5, &data)[2] - 0.5_f64.to_radians()).abs() < 1e-15);
}

#[test]
fn pushes_have_realistic_sizes() {
    let data = simulated(&table(), 500, 0);
    let speeds = data.iter().map(|t| t.after[3].hypot(t.after[4]));
    assert!(speeds.clone().fold(0.0, f64::max) < 2.0);
    let mean = speeds.sum::<f64>() / 500.0;
    assert!((0.1..0.7).contains(&mean), "{mean}");
    assert!(data.iter().all(|t| t.wrench[0].hypot(t.wrench[1]) <= 150.0 + 1e-9));
    let refused = transitions(&table(), 5, 0, &Pushes { dt: 0.0, ..Pushes::default() });
    assert!(refused.unwrap_err().to_string().contains("dt = 0"));
}

#[test]
fn a_recording_is_cut_into_its_transitions() {
    // 2 kg under 1 N along its x axis, which points along the world's y: y = t²/4 from contact on.
    let position = |t: f64| (t - 1.0).max(0.0).powi(2) / 4.0;
    let poses = (0..240).map(|k| f64::from(k) / 60.0);
    let readings = (0..400).map(|k| f64::from(k) / 100.0);
    let load = |t: f64| if t >= 1.0 { 1.0 } else { 0.0 };
    let episode = Prepared {
        ordinal: 0,
        name: "push".to_owned(),
        wrench: readings
            // The reading's frame is turned by 90° at the object's origin.
            .map(|t| WrenchSample {
                t,
                reading: [0.0, -load(t), 0.0],
                frame: [0.0, 0.0, 0.5 * std::f64::consts::PI],
                ..Default::default()
            })
            .collect(),
        pose: poses.map(|t| PoseSample { t, pose: [0.0, position(t), 0.5 * std::f64::consts::PI] }).collect(),
        contact: 1.0,
        tare_sd: [0.0; 3],
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    };
    let noise = Noise { pose: [1e-5; 3], force: 0.1, torque: 0.1, time: 0.0, stated: true };
    let cut = transitions_of(&episode, &noise, 0.5);
    assert_eq!(cut.len(), 5);
    for (k, t) in cut.iter().enumerate() {
        let begin = 0.5 * k as f64;
        assert!((t.dt - 0.5).abs() < 0.01, "{}", t.dt);
        assert!((t.before[1] - begin * begin / 4.0).abs() < 5e-3, "{t:?}");
        assert!((t.after[4] - (begin + 0.5) / 2.0).abs() < 0.02, "{t:?}");
        assert!((t.wrench[0] - 1.0).abs() < 1e-9 && t.wrench[1].abs() < 1e-9, "{:?}", t.wrench);
    }
    // A drop-out of the tracker removes only its own transitions.
    let mut gappy = episode.clone();
    gappy.pose.retain(|p| !(1.7..2.4).contains(&p.t));
    let left = transitions_of(&gappy, &noise, 0.5);
    assert!((3..=4).contains(&left.len()) && left.iter().all(|t| t.dt < 0.6), "{}", left.len());
}

#[test]
fn one_thread_learns_the_same_as_many() {
    let (training, test) = (noisy(&simulated(&table(), 60, 0), &[0.01; 6], 0), simulated(&table(), 20, 1));
    let predicted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let local = pool.install(|| Local::fit(&training, Features::World).unwrap());
        test.iter().map(|t| local.predict(&t.before, &t.wrench, t.dt)).collect::<Vec<_>>()
    };
    assert_eq!(predicted(1), predicted(4));
}
