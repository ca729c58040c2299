//! Tests of every effect in the catalogue. New effects are covered automatically.

#![allow(clippy::unwrap_used)]

mod cases;

use cases::*;
use nalgebra::{Matrix3, SymmetricEigen};
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use trundle_model::{
    Clock, Dual, EffectTarget, GeneralisedForce, Kind, Param, Prior, Rigid, catalogue, to_body,
};

#[test]
fn every_entry_is_complete() {
    let names: BTreeSet<_> = catalogue().map(|spec| spec.kind).collect();
    assert_eq!(names.len(), Kind::ALL.len(), "two kinds share a name");
    for spec in catalogue() {
        let kind = spec.kind;
        assert_eq!(Kind::from_name(kind).map(|k| k.spec().kind), Some(kind));
        for (what, text) in [
            ("effect", spec.effect),
            ("summary", spec.summary),
            ("source", spec.source),
            ("sentence", spec.sentence),
        ] {
            assert!(!text.trim().is_empty(), "{kind}: no {what}");
        }
        assert!(spec.sentence.ends_with('.'), "{kind}: the sentence must end with a full stop");
        let names: BTreeSet<_> = spec.params.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), spec.params.len(), "{kind}: two parameters share a name");
        assert!(spec.params.len() <= DRAWS, "{kind}: widen this test");
        for placeholder in placeholders(spec.sentence) {
            assert!(names.contains(placeholder), "{kind}: `{{{placeholder}}}` is not a parameter");
        }
    }
}

/// Names in braces.
fn placeholders(sentence: &str) -> impl Iterator<Item = &str> {
    sentence.split('{').skip(1).filter_map(|rest| rest.split('}').next())
}

#[test]
fn every_parameter_has_a_unit_bounds_and_a_prior_inside_them() {
    for spec in catalogue() {
        for p in spec.params {
            let name = format!("{}.{}", spec.kind, p.name);
            assert!(!p.unit.is_empty() && !p.help.is_empty(), "{name}: no unit or no help");
            assert!(p.lower.is_finite() && p.upper.is_finite() && p.lower < p.upper, "{name}: bounds");
            let inside = |value: f64| (p.lower..=p.upper).contains(&value);
            match p.prior {
                Prior::Normal { mean, sd } => assert!(inside(mean) && sd > 0.0, "{name}: prior"),
                Prior::LogNormal { median, sd } => {
                    assert!(p.lower >= 0.0 && median > 0.0 && inside(median) && sd > 0.0, "{name}: prior");
                }
                Prior::Uniform => {}
                Prior::OnBody(axis) => assert!(axis < 2 && p.unit == "m", "{name}: prior"),
                Prior::Angle(period) => {
                    assert!(period > 0.0 && p.upper - p.lower >= period && p.unit == "rad", "{name}: prior");
                }
            }
            assert!(p.refinement.is_none_or(inside), "{name}: refinement");
        }
    }
}

#[test]
fn every_neutral_value_belongs_to_a_parameter_and_is_legal() {
    for spec in catalogue() {
        assert!(!spec.neutral.is_empty(), "{}: no neutral values", spec.kind);
        for (name, value) in spec.neutral {
            let param = spec.params.iter().find(|p| p.name == *name);
            // The mass centre of the body lies within the bounds.
            let legal = |p: &Param| {
                (p.lower..=p.upper).contains(value) || matches!(p.prior, Prior::OnBody(_)) && value.is_nan()
            };
            assert!(param.is_some_and(legal), "{}: neutral {name} = {value}", spec.kind);
        }
    }
}

#[test]
fn at_neutral_values_nothing_changes() {
    for_every_kind(|kind, case| {
        let with = model(kind).plant(&neutral(kind, case)).unwrap();
        let without = bare(kind).resolved().unwrap();
        let [with, without] = [with, without].map(|plant| shown(outcome(&plant, &case.state, case)));
        for (a, b) in with.iter().zip(without) {
            prop_assert!((a - b).abs() <= 1e-14 * (1.0 + b.abs()), "{a} is not {b}");
        }
        Ok(())
    });
}

#[test]
fn away_from_neutral_values_something_changes() {
    let silent = RefCell::new(BTreeMap::new());
    for_every_kind(|kind, case| {
        let with = model(kind).plant(&values(kind, case)).unwrap();
        let without = bare(kind).resolved().unwrap();
        let [with, without] = [with, without].map(|plant| shown(outcome(&plant, &case.state, case)));
        let same = with == without;
        prop_assert!(!same || is_local(kind));
        *silent.borrow_mut().entry(kind).or_insert(0) += usize::from(same);
        Ok(())
    });
    // Four cases in five may lie elsewhere.
    assert!(silent.borrow().values().all(|&count| 5 * count < 4 * CASES), "{silent:?}");
}

#[test]
fn gradients_of_a_step_agree_with_finite_differences() {
    for_every_kind(|kind, case| {
        let point: Vec<f64> = case.state.into_iter().chain(values(kind, case)).collect();
        prop_assert!(point.len() <= COLUMNS, "widen this test");
        let seeded: Vec<_> =
            point.iter().enumerate().map(|(k, &v)| Dual::<COLUMNS>::variable(v, k)).collect();
        let exact = outcome(&model(kind).plant(&seeded[STATE..]).unwrap(), &seeded[..STATE], case);
        let first = point.len() - kind.spec().params.len();
        let own = |k: usize| kind.spec().params.get(k.wrapping_sub(first));
        for k in (0..point.len()).filter(|&k| own(k).is_none_or(|p| !p.role.is_choice())) {
            // Laws with an onset within a millimetre are strongly curved, and stiff laws amplify rounding.
            let (step, least, rounding) = match kind {
                _ if is_local(kind) => (2e-6, 0.5, 2e-12),
                _ if is_sharply_curved(kind) => (2e-6, 0.01, 1e-14),
                _ => (1e-5, 0.01, 1e-14),
            };
            let event = own(k).is_some_and(|p| p.name == "time");
            let h = if event { 1e-3 * DT } else { step * point[k].abs().max(least) };
            let at = |shift: f64| {
                let mut moved = point.clone();
                moved[k] += shift;
                outcome(&model(kind).plant(&moved[STATE..]).unwrap(), &moved[..STATE], case)
            };
            let (plus, minus) = (at(h), at(-h));
            for row in 0..STATE + 3 {
                let difference = (plus[row] - minus[row]) / (2.0 * h);
                let slope = exact[row].eps[k];
                // Rounding and the curvature of the law.
                let tolerance = rounding / h + 1e-5 * (slope.abs() + 1e-4);
                prop_assert!(
                    (slope - difference).abs() <= tolerance,
                    "row {row} by variable {k}: {slope} is not {difference}"
                );
            }
        }
        Ok(())
    });
}

#[test]
fn dissipative_effects_never_add_energy() {
    for_every_kind(|kind, case| {
        let twist = to_body([case.state[3], case.state[4], case.state[5]], case.state[2]);
        let power: f64 = force(kind, case).wrench(twist).iter().zip(twist).map(|(f, v)| f * v).sum();
        prop_assert!(!kind.spec().is_dissipative || power <= 1e-12, "power {power} W");
        Ok(())
    });
}

#[test]
fn damping_is_positive_semidefinite() {
    for_every_kind(|kind, case| {
        let [xx, xy, yy, tx, ty, tt] = force(kind, case).damping;
        let drag = Matrix3::new(xx, xy, tx, xy, yy, ty, tx, ty, tt);
        let least = SymmetricEigen::new(drag).eigenvalues.min();
        prop_assert!(least >= -1e-12 * drag.trace().max(1.0), "eigenvalue {least}");
        Ok(())
    });
}

#[test]
fn every_law_acts_on_its_target_only() {
    for_every_kind(|kind, case| {
        let (plant, bare) = (model(kind).plant(&values(kind, case)).unwrap(), bare(kind).resolved().unwrap());
        let corrects = plant.correct(case.applied, case.clock) != case.applied;
        let reads_otherwise = corrects
            || plant.delay(case.clock).is_some()
            || plant.lags().is_some()
            || plant.mount().is_some();
        let (GeneralisedForce { force, damping }, without) =
            (force(kind, case), bare.generalised_force(&state(&case.state), case.clock));
        let pushes = (force, damping) != (without.force, without.damping);
        let [own, whole, plain] =
            [plant.object(case.clock), plant.rigid(case.clock), bare.rigid(case.clock)].map(parts);
        let (weighs, loads) = (own != plain, whole != own && plant.mount().is_none());
        prop_assert!(kind.spec().changes_mass == (weighs || loads), "{own:?} {whole:?} {plain:?}");
        match kind.spec().target {
            EffectTarget::Object => {
                prop_assert!((pushes || weighs || is_local(kind)) && !reads_otherwise && !loads)
            }
            EffectTarget::Instrument => {
                prop_assert!(!pushes && !weighs && (reads_otherwise || loads || is_local(kind)));
            }
        }
        Ok(())
    });
}

fn parts(rigid: Rigid<f64>) -> [f64; 4] {
    let Rigid { mass, com: [x, y], inertia } = rigid;
    [mass, x, y, inertia]
}

#[test]
fn mass_and_inertia_are_positive() {
    for_every_kind(|kind, case| {
        let rigid = model(kind).plant(&values(kind, case)).unwrap().rigid(case.clock);
        prop_assert!(rigid.mass > 0.0 && rigid.inertia > 0.0, "{rigid:?}");
        Ok(())
    });
}

/// A state rotated by `angle` and translated by `shift`.
fn elsewhere(flat: &[f64; STATE], angle: f64, shift: [f64; 2]) -> [f64; STATE] {
    let (sin, cos) = angle.sin_cos();
    let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
    let ([x, y], [vx, vy]) = (turned(flat[0], flat[1]), turned(flat[3], flat[4]));
    let mut moved = *flat;
    moved[..5].copy_from_slice(&[x + shift[0], y + shift[1], flat[2] + angle, vx, vy]);
    moved
}

#[test]
fn exactly_the_pose_invariant_laws_are_independent_of_the_pose() {
    let differing = RefCell::new(BTreeSet::new());
    for_every_kind(|kind, case| {
        let plant = model(kind).plant(&values(kind, case)).unwrap();
        let after = |state: &[f64; STATE]| -> [f64; STATE] {
            let outcome = outcome(&plant, state, case);
            std::array::from_fn(|k| outcome[k])
        };
        let there = after(&elsewhere(&case.state, 0.7, [0.3, -0.2]));
        let expected = elsewhere(&after(&case.state), 0.7, [0.3, -0.2]);
        let same = there.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-11 * (1.0 + b.abs()));
        prop_assert!(same || !plant.is_pose_invariant(), "{there:?} is not {expected:?}");
        if !same {
            differing.borrow_mut().insert(kind);
        }
        Ok(())
    });
    for &kind in Kind::ALL {
        let claims = model(kind).plant(&draws_of(kind)).unwrap().is_pose_invariant();
        assert_eq!(claims, !differing.borrow().contains(&kind), "{}", kind.spec().kind);
    }
}

/// Deterministic values of a model with this kind.
fn draws_of(kind: Kind) -> Vec<f64> {
    let clock = Clock::since_contact(0.0);
    let case = Case { draws: vec![0.5; DRAWS], state: [0.0; STATE], applied: [0.0; 3], clock };
    values(kind, &case)
}
