use super::*;

const PERIOD_S: f64 = 0.05;
const RISE_S: f64 = 0.02;
const FULL: [f64; 3] = [100.0, 100.0, 40.0];

/// Changing command, N, N and N·m.
fn command(k: usize) -> [f64; 3] {
    let t = k as f64;
    [60.0 * (1.1 * t).sin(), 50.0 * (0.7 * t + 1.0).cos(), 20.0 * (1.7 * t).sin()]
}

/// Wrenches of an arm every millisecond, by a simulation that shares no grid with the estimate.
fn simulated(truth: &ArmResponse, periods: usize) -> Vec<[f64; 3]> {
    let (step, mut states) = (truth.discretised(1e-3), AxisStates::default());
    let (per_period, delay) = ((PERIOD_S * 1e3).round() as usize, (truth.delay * 1e3).round() as usize);
    let at = |ms: usize| {
        let Some(since) = ms.checked_sub(delay) else { return [0.0; 3] };
        let (k, phase) = (since / per_period, ((since % per_period) as f64 + 0.5) * 1e-3);
        let before = if k > 0 { command(k - 1) } else { [0.0; 3] };
        let share = (phase / RISE_S).min(1.0);
        [0, 1, 2].map(|i| before[i] + share * (command(k)[i] - before[i]))
    };
    let exerted = |states: &AxisStates| [0, 1, 2].map(|axis| truth.axes()[axis].wrench(states[axis]));
    (0..periods * per_period)
        .map(|ms| {
            step.advance(&mut states, at(ms));
            exerted(&states)
        })
        .collect()
}

fn estimated(truth: &ArmResponse, periods: usize) -> ArmEstimate {
    let wrenches = simulated(truth, periods);
    let mut estimate = ArmEstimate::new(PERIOD_S, RISE_S, FULL).unwrap();
    for k in 0..periods {
        let end = ((k + 1) as f64 * PERIOD_S * 1e3).round() as usize;
        estimate.observe(command(k), wrenches[end - 1], true);
    }
    estimate
}

fn lag(time_constant: f64) -> AxisResponse {
    AxisResponse::Lag { time_constant }
}

#[test]
fn delay_and_lag_are_recovered() {
    for (delay, time_constant) in [(0.0, 0.08), (0.1, 0.15), (0.06, 0.05)] {
        let truth = ArmResponse { delay, force: lag(time_constant), torque: lag(time_constant), turn: 0.0 };
        let found = estimated(&truth, 20).response();
        assert!((found.delay - delay).abs() < 0.011, "{truth:?} {found:?}");
        assert_eq!((found.force, found.torque), (truth.force, truth.torque));
    }
}

#[test]
fn the_shortest_of_the_indistinguishable_delays_counts() {
    // The wrench reaches the command 20 ms after it takes effect, and is read 50 ms after.
    for (delay, expected) in [(0.05, 0.05), (0.07, 0.05), (0.1, 0.1)] {
        let found = estimated(&ArmResponse { delay, ..ArmResponse::default() }, 20).response();
        assert_eq!(found, ArmResponse { delay: expected, ..ArmResponse::default() });
    }
}

#[test]
fn a_compliance_is_recovered() {
    let turn = 0.0165;
    let force = AxisResponse::Compliant { frequency: 34.0, damping_ratio: 0.5, gain: 0.83 };
    let torque = AxisResponse::Compliant { frequency: 60.0, damping_ratio: 0.9, gain: 1.0 };
    let found = estimated(&ArmResponse { delay: 0.0, force, torque, turn }, 20).response();
    assert_eq!(found.force, AxisResponse::Compliant { frequency: 36.0, damping_ratio: 0.45, gain: 0.85 });
    assert!(matches!(found.torque, AxisResponse::Compliant { .. } | AxisResponse::Lag { .. }), "{found:?}");
}

#[test]
fn an_ideal_arm_is_recognised_and_needs_no_prediction() {
    let estimate = estimated(&ArmResponse::default(), 20);
    assert!(estimate.response().is_ideal());
    assert_eq!(estimate.wrenches(), None);
    let commanded = estimate.commanded();
    assert!(commanded.response().is_ideal() && commanded.pending.is_empty());
}

#[test]
fn wrenches_within_a_period_are_those_of_the_arm() {
    let truth = ArmResponse { delay: 0.04, force: lag(0.08), torque: lag(0.08), turn: 0.0 };
    let (estimate, exact) = (estimated(&truth, 20), simulated(&truth, 20));
    let wrenches = estimate.wrenches().unwrap();
    for (k, period) in wrenches.iter().enumerate().skip(1) {
        for (time, wrench) in estimate.knots().iter().zip(period) {
            let ms = ((k as f64 * PERIOD_S + time) * 1e3).round() as usize;
            assert!((wrench[0] - exact[ms - 1][0]).abs() < 3.0, "{k} {time}: {wrench:?}");
        }
    }
}

#[test]
fn pending_commands_are_those_that_have_not_taken_effect() {
    let truth = ArmResponse { delay: 0.1, force: lag(0.08), torque: lag(0.08), turn: 0.0 };
    let commanded = estimated(&truth, 20).commanded();
    let last = commanded.pending[commanded.pending.len() - 1];
    assert_eq!(commanded.pending.len(), 20);
    assert!((0..3).all(|axis| (last[axis] - command(19)[axis]).abs() < 1e-9), "{last:?}");
}

#[test]
fn an_arm_without_the_object_exerts_nothing_and_is_not_compared() {
    let mut estimate =
        estimated(&ArmResponse { delay: 0.0, force: lag(0.08), torque: lag(0.08), turn: 0.0 }, 20);
    let before = estimate.response();
    for _ in 0..5 {
        estimate.observe([50.0, 0.0, 0.0], [0.0; 3], false);
    }
    assert_eq!(estimate.response(), before);
    assert_eq!(estimate.wrenches().unwrap()[24], [[0.0; 3]; 4]);
}

#[test]
fn invalid_times_are_refused() {
    let error = ArmEstimate::new(0.01, 0.02, FULL).unwrap_err().to_string();
    assert!(error.contains("0 < rise <= period"), "{error}");
    assert!(ArmEstimate::new(PERIOD_S, RISE_S, [0.0, 1.0, 1.0]).is_err());
}
