//! Intervals have their nominal coverage, and the test detects intervals that are too narrow.
#![allow(clippy::unwrap_used)]

use trundle_infer::Quiet;
use trundle_posterior::{Calibration, ParameterCalibration, calibrations, replicates};

/// A table with a wheel at a known place: the mass and two coefficients are inferred.
const SMALL: &str = r#"
format = "trundle-calibration/1"
name = "mass and two coefficients"
method = "laplace"
starts = 2

[model]
format = "trundle-model/1"
[model.body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
[[model.effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.2

[prior]
body.mass = { distribution = "log_normal", median = 22, sd = 0.3 }
viscous_wheel.mu_x = { distribution = "log_normal", median = 15, sd = 0.5 }
viscous_wheel.mu_y = { distribution = "log_normal", median = 100, sd = 0.5 }

[push]
episodes = 1
duration = 3.0
force = 12.0
grasp = [-0.6, 0.0]
scatter = 0.1

[noise]
position = 0.0005
angle = 0.00175
force = 0.4
torque = 0.05
tare_force = 0.04
tare_torque = 0.005
"#;

fn calibrated(shrink: f64) -> Vec<ParameterCalibration> {
    let calibration = Calibration::from_toml(SMALL).unwrap().shrunk(shrink);
    let rounds = replicates(&calibration, &(0..60).collect::<Vec<_>>(), 7, &Quiet).unwrap();
    calibrations(&calibration.parameters, &rounds)
}

#[test]
fn ninety_percent_intervals_cover_and_halved_ones_do_not() {
    for line in calibrated(1.0) {
        let [share, low, high] = line.cover_90;
        assert!(low <= 0.9 && 0.9 <= high, "{}: {share} in {low}..{high}", line.name);
        assert!(line.uniform_p > 0.001, "{line:?}");
    }
    for line in calibrated(0.5) {
        assert!(line.cover_90[2] < 0.9, "{line:?}");
    }
}

#[test]
fn rounds_do_not_depend_on_one_another() {
    let calibration = Calibration::from_toml(SMALL).unwrap();
    let all = replicates(&calibration, &[0, 1, 2], 7, &Quiet).unwrap();
    let last = replicates(&calibration, &[2], 7, &Quiet).unwrap();
    assert_eq!(all[2..], last);
}

#[test]
fn an_invalid_file_is_an_error_that_names_the_field() {
    let refused =
        |from: &str, to: &str| Calibration::from_toml(&SMALL.replace(from, to)).err().unwrap().to_string();
    assert!(refused("trundle-calibration/1", "trundle-calibration/9").contains("trundle-calibration/9"));
    assert!(refused("force = 0.4", "force = 0.0").contains("noise.force = 0"));
    assert!(refused("viscous_wheel.mu_y =", "viscous_wheel.mu_z =").contains("mu_z"));
    assert!(refused("duration = 3.0", "duration = 0.1").contains("push.duration"));
    assert!(refused("footprint", "# footprint").contains("footprint"));
}
