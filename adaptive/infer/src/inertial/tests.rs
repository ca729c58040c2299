//! Gradients against finite differences.

use super::*;
use trundle_model::{Body, Effect, Kind};
use trundle_record::{Counts, PoseSample, WrenchSample};

const NOISE: Noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

fn episode() -> Prepared {
    let wrench = |k: usize| {
        let t = k as f64 * 0.01;
        let reading = [20.0 * (3.0 * t).sin(), 9.0 * (5.0 * t).cos(), (4.0 * t).sin()];
        WrenchSample { t, reading, frame: [-0.6, 0.1, 0.2], ..Default::default() }
    };
    let pose = |k: usize| {
        let t = 0.02 * k as f64;
        PoseSample { t, pose: [0.5 * t + 0.1 * (2.0 * t).sin(), 0.1 * t * t, 0.9 * t] }
    };
    Prepared {
        ordinal: 0,
        name: "push".to_owned(),
        wrench: (0..300).map(wrench).collect(),
        pose: (0..150).map(pose).collect(),
        contact: 0.0,
        tare_sd: [0.04; 3],
        at_rest: false,
        counts: Counts::default(),
        ..Default::default()
    }
}

#[test]
fn gradient_matches_finite_differences() {
    let footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.5], [-0.5, 0.4]];
    let model = Model::nominal(Body::from_footprint(&footprint, 22.0).unwrap(), None, [true; 3])
        .with(Effect::free(Kind::CoulombFriction))
        .with(Effect::free(Kind::ForceBias));
    for loss in [Loss::Gaussian, Loss::STUDENT] {
        let likelihood = InertialLikelihood::new(&[episode()], &NOISE, [true; 3]).unwrap().with_loss(loss);
        assert!(likelihood.observations() > 20);
        let coordinates = crate::Coordinates::new(&model);
        let z: Vec<f64> = (0..coordinates.free().len()).map(|k| 0.6 * (1.7 * k as f64).sin()).collect();
        let values: Vec<f64> = coordinates.values(&z).0.into_iter().chain([0.7, 0.2]).collect();
        let free: Vec<usize> = (0..values.len()).collect();
        let at = likelihood.linearise(&model, &values, &free).unwrap();
        assert!((at.cost - likelihood.cost(&model, &values).unwrap()).abs() < 1e-9 * at.cost.abs());
        for slot in free {
            let h = 1e-6 * values[slot].abs().max(1e-2);
            let cost = |sign: f64| {
                let mut moved = values.clone();
                moved[slot] += sign * h;
                likelihood.cost(&model, &moved).unwrap()
            };
            let (exact, numeric) = (at.gradient[slot], (cost(1.0) - cost(-1.0)) / (2.0 * h));
            let error = (exact - numeric).abs();
            let scale = at.gradient.amax();
            assert!(error < 1e-4 * numeric.abs() + 1e-8 * scale, "{loss:?} {slot}: {exact} {numeric}");
        }
    }
}

#[test]
fn an_object_at_rest_is_an_error() {
    let mut still = episode();
    let rest = still.pose[0].pose;
    still.pose.iter_mut().for_each(|p| p.pose = rest);
    let message = InertialLikelihood::new(&[still], &NOISE, [true; 3]).err().unwrap().to_string();
    assert!(message.contains("only 0 samples of motion"), "{message}");
}
