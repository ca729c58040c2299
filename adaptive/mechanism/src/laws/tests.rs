//! Tests that walk the catalogue of laws.

use super::*;
use trundle_model::Dual;

const SCALES: JointScales = JointScales {
    effort: 2.0,
    range: [-1.0, 1.5],
    velocity: 0.8,
    acceleration: 3.0,
    load: Some(4.0),
    resolution: 0.05,
};

/// Everything that a law computes at one state.
fn outputs<T: Real>(kind: JointKind, values: &[T]) -> Vec<T> {
    let law = Law::of(kind, values);
    let at = JointSample {
        q: 1.4,
        v: -0.5,
        a: 2.0,
        drive: Some(T::lift(1.9)),
        external: T::lift(-0.3),
        load: None,
    };
    let compliance = law.compliance();
    let others = [
        law.delay(),
        law.lag(),
        law.reading_gain(),
        law.response(&at, 4.0),
        compliance.map(|c| c.stiffness),
        compliance.and_then(|c| c.damping),
        law.gap(),
    ];
    let mut found = vec![law.effort(&at), law.dry_friction(&at)];
    found.push(law.drive(T::lift(1.9), 4.0));
    found.push(law.correct(T::lift(1.9)));
    found.extend(others.into_iter().flatten());
    found
}

/// Starting values with all refinements at values of their own.
fn values(kind: JointKind) -> Vec<f64> {
    let start = (kind.spec().starts)(&SCALES).swap_remove(0);
    let own = |(param, value): (&ParamSpec, f64)| {
        if value.is_nan() { 0.3 * param.scale.of(&SCALES) } else { value }
    };
    kind.spec().params.iter().zip(start).map(own).collect()
}

#[test]
fn derivatives_agree_with_differences() {
    for &kind in JointKind::ALL {
        let at = values(kind);
        let dual: Vec<Dual<4>> = at.iter().enumerate().map(|(k, x)| Dual::variable(*x, k)).collect();
        for (k, param) in kind.spec().params.iter().enumerate().filter(|(_, p)| !p.is_choice) {
            let step = 1e-6 * at[k].abs().max(1e-3);
            let moved = |sign: f64| {
                let mut values = at.clone();
                values[k] += sign * step;
                outputs::<f64>(kind, &values)
            };
            for ((up, down), exact) in moved(1.0).iter().zip(moved(-1.0)).zip(outputs(kind, &dual)) {
                let slope = (up - down) / (2.0 * step);
                let error = (slope - exact.eps[k]).abs();
                assert!(error < 1e-5 * (1.0 + slope.abs()), "{kind:?} {}: {slope} {exact:?}", param.name);
            }
        }
    }
}

#[test]
fn sentences_name_parameters_of_the_law_and_starts_are_complete() {
    for &kind in JointKind::ALL {
        let spec = kind.spec();
        for word in spec.sentence.split('{').skip(1).filter_map(|rest| rest.split('}').next()) {
            assert!(word == "joint" || spec.params.iter().any(|p| p.name == word), "{kind:?}: {word}");
        }
        for start in (spec.starts)(&SCALES) {
            assert_eq!(start.len(), spec.params.len(), "{kind:?}");
        }
    }
}

#[test]
fn laws_vanish_at_zero_strength() {
    for &kind in JointKind::ALL {
        let mut at = values(kind);
        for (value, param) in at.iter_mut().zip(kind.spec().params) {
            if matches!(param.scale, Scale::Effort | Scale::Damping | Scale::Inertia | Scale::Drag) {
                *value = 0.0;
            }
        }
        let is_force = matches!(
            kind,
            JointKind::DryFriction
                | JointKind::ViscousFriction
                | JointKind::DirectionalFriction
                | JointKind::Cogging
                | JointKind::RotorInertia
                | JointKind::AirDrag
        );
        let found = outputs::<f64>(kind, &at);
        assert!(!is_force || found[0] == 0.0 && found[1] == 0.0, "{kind:?}: {found:?}");
    }
}

#[test]
fn a_stop_is_in_its_half_of_the_range() {
    for (side, expected) in [(1.0, [0.25, 1.5]), (-1.0, [-1.0, 0.25])] {
        assert_eq!(stop_positions(&SCALES, &[0.0, 1.0, side]), expected);
    }
}
