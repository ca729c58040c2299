//! An object on a rail: effects that are indistinguishable at a single heading.
#![allow(clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_diagnose::{Options, diagnose};
use trundle_fixtures::effect;
use trundle_infer::Quiet;
use trundle_model::{Body, Clock, Kind, Model, State};
use trundle_record::{Counts, Dataset, Noise, PoseSample, Prepared, WrenchSample};

const NOISE: Noise = Noise { pose: [1e-4, 1e-4, 1e-4], force: 1.0, torque: 1.0, time: 0.0, stated: true };
const RAIL: [bool; 3] = [true, false, false];

/// 12 s to and fro, with a force offset of 3 N.
fn episode(name: &str, seed: u64) -> Prepared {
    let effects = vec![
        effect(Kind::ViscousWheel, &[("x", 0.0), ("y", 0.0), ("angle", 0.0), ("mu_x", 200.0), ("mu_y", 0.0)]),
        effect(Kind::SupportFriction, &[("force", 20.0), ("spread", 1.0)]),
    ];
    let model = Model {
        body: Body::point(95.0).unwrap(),
        mass: Some(95.0),
        dof: RAIL,
        effects,
        priors: Default::default(),
        discrepancy: None,
    };
    let plant = model.resolved().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let (mut state, mut wrench, mut pose) = (State::at_rest([0.0; 3]), vec![], vec![]);
    for k in 0..12_000 {
        let t = k as f64 * 1e-3;
        let force = 60.0 * (1.3 * t).sin() + 30.0 * (4.1 * t + seed as f64).sin();
        if k % 5 == 0 {
            wrench.push(WrenchSample {
                t,
                reading: [force + 3.0 + normal(1.0), 0.0, 0.0],
                frame: [0.0; 3],
                ..Default::default()
            });
            pose.push(PoseSample { t, pose: [state.pose[0] + normal(1e-4), 0.0, 0.0] });
        }
        state = plant.step(&state, [force, 0.0, 0.0], Clock::since_contact(t), 1e-3);
    }
    let (contact, counts) = (0.0, Counts::default());
    Prepared {
        ordinal: 0,
        name: name.to_owned(),
        wrench,
        pose,
        contact,
        tare_sd: [0.0; 3],
        at_rest: true,
        counts,
        ..Default::default()
    }
}

#[test]
fn offset_and_slope_are_tied_on_a_rail() {
    let data = Dataset {
        name: "axis".to_owned(),
        body: Body::point(50.0).unwrap(),
        dof: RAIL,
        noise: NOISE,
        point_contact: false,
        commanded: true,
        wrench_pose: Default::default(),
        mass_given: None,
        training: vec![episode("a", 1)],
        held_out: vec![episode("b", 2)],
        obstacles: vec![],
    };
    let answer = serde_json::to_value(diagnose(&data, &Options::default(), &Quiet).unwrap().answer).unwrap();
    assert_eq!(answer["verdict"], "explained", "{answer:#}");
    let tied = answer["tied"][0].as_array().unwrap();
    assert!(tied.contains(&"force_bias".into()) && tied.contains(&"floor_slope".into()), "{answer:#}");
    let held_out = &answer["fit"]["held_out"];
    assert!(held_out["before"]["heading_rmse"].is_null());
    let rmse = |part: &str| held_out[part]["position_rmse"].as_f64().unwrap();
    assert!(rmse("before") > 5.0 * rmse("after"), "{held_out:#}");
}
