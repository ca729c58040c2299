//! The linear system of a filter compared with the filter itself.
#![allow(clippy::unwrap_used)]

use trundle_fixtures::{NOISE, World, disturb_time_stamps, locked};
use trundle_infer::MotionLikelihood;
use trundle_record::{Noise, Prepared};

/// Whitened innovations of one push.
fn whitened(push: &Prepared) -> Vec<f64> {
    let motion = MotionLikelihood::new(std::slice::from_ref(push), &NOISE).unwrap();
    let values: Vec<f64> = locked().slots().iter().filter_map(|s| s.value).collect();
    let innovations = motion.innovations(&locked(), &values).unwrap().unwrap();
    innovations[0].iter().flat_map(|i| (i.whitener * i.error).as_slice().to_vec()).collect()
}

#[test]
fn a_missing_wrench_adds_the_predicted_response() {
    let push = &World::of(locked()).pushes(1, 5)[0];
    let motion = MotionLikelihood::new(std::slice::from_ref(push), &NOISE).unwrap();
    let values: Vec<f64> = locked().slots().iter().filter_map(|s| s.value).collect();
    let response = motion.responses(&locked(), &values).unwrap().unwrap().remove(0);
    let seen = whitened(push);
    assert!(seen.iter().zip(&response.innovations).all(|(a, b)| (a - b).abs() < 1e-9));
    // A wrench on the object that the sensor does not measure is equivalent to a reading that is too small by
    // it.
    let (from, to) = (2.0, 3.2);
    let mut less = push.clone();
    for sample in less.wrench.iter_mut().filter(|s| (from..to).contains(&s.t)) {
        let [fx, fy, tau] = [0.02, -0.01, 0.005];
        sample.reading = [sample.reading[0] - fx, sample.reading[1] - fy, sample.reading[2] - tau];
    }
    let inside = |t: f64| if (from..to).contains(&t) { 1.0 } else { 0.0 };
    let missing: Vec<[f64; 3]> = response
        .t
        .iter()
        .zip(&motion.tracks()[0].steps)
        .map(|(t, step)| trundle_model::transport([0.02, -0.01, 0.005].map(|w| w * inside(*t)), step.frame))
        .collect();
    let predicted = response.respond(&missing);
    let changed: Vec<f64> = whitened(&less).iter().zip(&seen).map(|(a, b)| a - b).collect();
    // The wrench removed from the reading is missing, so the measured motion exceeds the predicted one.
    let size = changed.iter().map(|c| c * c).sum::<f64>().sqrt();
    let apart = changed.iter().zip(&predicted).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(size > 0.5 && apart < 0.03 * size, "{size} {apart}");
}

#[test]
fn innovations_are_white_with_errors_of_the_time_stamps() {
    let mut pushes = World::of(locked()).pushes(4, 6);
    let error = disturb_time_stamps(&mut pushes, 6e-3);
    let mean = |time: f64| {
        let noise = Noise { time, ..NOISE };
        let motion = MotionLikelihood::new(&pushes, &noise).unwrap();
        let values: Vec<f64> = locked().slots().iter().filter_map(|s| s.value).collect();
        let innovations = motion.innovations(&locked(), &values).unwrap().unwrap();
        let whitened: Vec<f64> =
            innovations.iter().flatten().map(|i| (i.whitener * i.error).norm_squared() / 3.0).collect();
        whitened.iter().sum::<f64>() / whitened.len() as f64
    };
    let (stated, ignored) = (mean(error), mean(0.0));
    assert!((0.8..1.2).contains(&stated), "{stated}");
    assert!(ignored > 1.5, "{ignored}");
}

#[test]
fn innovations_are_white_under_the_correct_model() {
    let pushes = World::of(locked()).pushes(8, 6);
    let all: Vec<f64> = pushes.iter().flat_map(whitened).collect();
    let mean = all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64;
    let next: f64 = all.windows(4).map(|w| w[0] * w[3]).sum::<f64>() / all.len() as f64;
    assert!((mean - 1.0).abs() < 0.05 && next.abs() < 0.04, "{mean} {next}");
}
