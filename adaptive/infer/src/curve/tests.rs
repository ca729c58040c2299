//! Means, trends and lags of simple curves.

use super::*;
use trundle_model::Dual;
use trundle_record::WrenchSample;

const NOISE: Noise = Noise { pose: [1e-3; 3], force: 0.01, torque: 0.01, time: 0.0, stated: true };

fn episode(readings: impl Iterator<Item = f64>) -> Prepared {
    let sample = |(k, force): (usize, f64)| {
        let frame = [0.0, 0.0, 3.0 + 0.1 * k as f64];
        let frame = [frame[0], frame[1], wrapped(frame[2])];
        WrenchSample { t: k as f64 * 0.1, reading: [force, 0.0, 0.0], frame, ..Default::default() }
    };
    Prepared {
        name: "push".to_owned(),
        wrench: readings.enumerate().map(sample).collect(),
        ..Default::default()
    }
}

#[test]
fn sparse_readings_give_longer_steps() {
    let read_every = |interval: f64| {
        let at = |k: usize| WrenchSample { t: interval * k as f64, ..Default::default() };
        max_step_s(&Prepared { wrench: (0..9).map(at).collect(), ..Default::default() })
    };
    assert_eq!(read_every(0.01), MAX_STEP_S);
    assert!((read_every(10.24) - 1.28).abs() < 1e-12);
}

fn ramp() -> Curve {
    Curve::with_noise(&episode((0..6).map(f64::from)), &NOISE)
}

#[test]
fn the_mean_of_a_ramp_is_its_middle() {
    for (from, to) in [(0.0, 0.5), (0.03, 0.07), (0.15, 0.45), (0.2, 0.3)] {
        let MeanReading { reading, spacing, spread, .. } = ramp().mean(from, to);
        assert!((reading[0] - 5.0 * (from + to)).abs() < 1e-12, "{from} {to} {reading:?}");
        assert!((spacing - 0.1).abs() < 1e-12);
        assert_eq!(spread, [0.0; 3], "a ramp has no variance between its samples");
    }
}

#[test]
fn a_step_has_the_noise_of_its_mean_reading() {
    let curve = ramp(); // a reading each 0.1 s, noise 0.01
    let clock = curve.clock_of_step(0.25, 0.4, [0.0; 3], 0.1);
    assert!((clock.noise[0][0] - 0.005).abs() < 1e-12, "the mean of four readings: {clock:?}");
    // The trend is the difference of two means over 50 ms each, a sample at most.
    assert!((clock.noise[1][0] - 0.01 * 2f64.sqrt() / TREND_WINDOW_S).abs() < 1e-12, "{clock:?}");
    assert_eq!(
        Curve::new(&episode((0..6).map(f64::from))).clock_of_step(0.25, 0.4, [0.0; 3], 0.1).noise,
        [[0.0; 3]; 2]
    );
}

#[test]
fn a_command_holds_until_the_next() {
    let held = Curve::new(&Prepared { zero_order_hold: true, ..episode((0..6).map(f64::from)) });
    assert!((held.mean(0.22, 0.28).reading[0] - 2.0).abs() < 1e-12);
    assert!((held.mean(0.15, 0.25).reading[0] - 1.5).abs() < 1e-12);
    let late = held.delayed_mean(0.12, 0.16, Dual::<1>::variable(0.1, 0));
    assert!((late[0].re - 2.0).abs() < 1e-12);
}

#[test]
fn the_frame_turns_between_samples_across_half_a_turn() {
    let (frame, _) = ramp().frame(0.15);
    assert!((wrapped(frame[2] - 3.15)).abs() < 1e-12, "{frame:?}");
}

#[test]
fn an_impact_between_samples_is_uncertain() {
    let impact = Curve::with_noise(&episode([0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0].into_iter()), &NOISE);
    // The impact may have lasted for any share of the two sample intervals around its reading.
    let spread = impact.mean(0.2, 0.4).spread[0].sqrt();
    assert!((2.0..6.0).contains(&spread), "{spread} N of a mean of 4 N");
    assert_eq!(impact.mean(0.0, 0.1).spread, [0.0; 3]);
}

#[test]
fn a_ramp_has_its_trend() {
    assert!((ramp().trend(0.25)[0] - 10.0).abs() < 1e-9);
}

#[test]
fn readings_are_constant_beyond_their_ends() {
    assert!((ramp().mean(-0.2, -0.1).reading[0]).abs() < 1e-12);
    assert!((ramp().mean(0.6, 0.7).reading[0] - 5.0).abs() < 1e-12);
}

#[test]
fn a_delayed_mean_has_the_slope_by_the_delay() {
    let late = ramp().delayed_mean(0.12, 0.16, Dual::<1>::variable(0.05, 0));
    assert!((late[0].re - 1.9).abs() < 1e-12 && (late[0].eps[0] - 10.0).abs() < 1e-9, "{late:?}");
}
