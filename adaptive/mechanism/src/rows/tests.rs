//! Residuals and their derivatives, of a carriage on a rail.

use super::{JointRows, Scope, evaluate};
use crate::laws::JointKind;
use crate::model::{Effect, Kind};
use crate::slots::slots;
use crate::{Dynamics, EpisodeDynamics, Problem, motion};
use std::collections::BTreeMap;
use trundle_record::{Episode, JointMetadata, JointRecording};

const MASS: f64 = 2.0;

/// A carriage whose encoder is on either side of a transmission, with the effort of its drive over time, if it has one.
pub(crate) fn carriage(side: &str, effort: Option<fn(f64) -> f64>) -> Problem {
    let text = format!(
        "format = \"trundle-recording/2\"\nname = \"axis\"\n[mechanism]\nmodel = \"robot.xml\"\n\
         joints = [\"x\"]\n[encoder]\nside = \"{side}\"\n"
    );
    let t: Vec<f64> = (0..1200).map(|k| k as f64 * 0.005).collect();
    let mut episode = Episode { name: "episode".to_owned(), ..Episode::default() };
    let positions = t.iter().map(|t| 0.2 * (3.0 * t).sin() + 0.05 * (8.0 * t).cos()).collect();
    let efforts = effort.map(|effort| t.iter().map(|t| effort(*t)).collect());
    for (title, values) in [("t", t), ("q_x", positions)] {
        episode.insert(title.to_owned(), values);
    }
    if let Some(efforts) = efforts {
        episode.insert("effort_x".to_owned(), efforts);
    }
    let metadata = JointMetadata::from_toml(&text).unwrap();
    let files = BTreeMap::from([("robot.xml".to_owned(), vec![])]);
    let recording = JointRecording::new(metadata, vec![episode], files).unwrap();
    let motion = motion(&recording).unwrap();
    let a = &motion.episodes[0].a[0];
    let zeros = || vec![0.0; a.len()];
    // Any series will do.
    let some = |size: f64| -> Vec<f64> { a.iter().map(|a| size * (1.0 + 0.1 * a)).collect() };
    let episode = EpisodeDynamics {
        effort: vec![a.iter().map(|a| MASS * a).collect()],
        mass_matrix: vec![vec![vec![MASS; a.len()]]],
        by_mass: vec![vec![a.clone()]],
        matrix_by_mass: vec![vec![vec![vec![1.0; a.len()]]]],
        by_gravity: vec![[some(-MASS), zeros(), some(0.3 * MASS)]],
        by_payload: vec![vec![std::array::from_fn(|_| zeros())]],
        inertia_by_payload: vec![vec![std::array::from_fn(|_| zeros())]],
        by_offset: vec![vec![[some(2.0), some(-1.0)]]],
        by_velocity: vec![vec![zeros()]],
        by_mass_and_gravity: vec![vec![[some(-1.0), zeros(), some(0.3)]]],
        by_mass_and_offset: vec![vec![vec![some(2.0 / MASS)]]],
        by_parameter: vec![],
    };
    let dynamics = Dynamics {
        bodies: vec!["link".to_owned()],
        masses: vec![MASS],
        armature: vec![0.4],
        damping: vec![1.0],
        frictionloss: vec![0.0],
        gravity: [0.0, 0.0, -9.81],
        is_hinge: vec![false],
        episodes: vec![episode],
        ..Dynamics::default()
    };
    Problem::new(&recording, &motion, Some(&dynamics)).unwrap()
}

#[test]
fn the_mass_of_a_body_has_a_log_normal_prior() {
    let slots = slots(&carriage("joint", None), &[]);
    let mass = slots.iter().find(|slot| slot.name == "mass:link").unwrap();
    assert!(mass.bounds[0] > 0.0);
    assert!((mass.prior.cost(MASS * 0.3_f64.exp()) - 0.5).abs() < 1e-12);
    assert!((mass.prior.cost(MASS * (-0.3_f64).exp()) - 0.5).abs() < 1e-12);
}

#[test]
fn derivatives_are_those_of_the_residual() {
    let effort: fn(f64) -> f64 = |t| -4.0 * (3.0 * t).sin() - 7.0 * (8.0 * t + 0.1).cos();
    let law = |kind| Kind::Joint(kind, 0);
    let cases = [
        (law(JointKind::LoadFriction), "joint", Some(effort), vec![0.3]),
        (law(JointKind::Elasticity), "joint", Some(effort), vec![900.0, 3.0]),
        (law(JointKind::Elasticity), "drive", Some(effort), vec![900.0, 3.0]),
        (law(JointKind::EffortGain), "joint", Some(effort), vec![0.7]),
        (law(JointKind::EffortSaturation), "joint", Some(effort), vec![6.0]),
        (law(JointKind::Backlash), "joint", Some(effort), vec![0.004]),
        (law(JointKind::ViscousFriction), "joint", Some(effort), vec![0.7]),
        (law(JointKind::ViscousFriction), "joint", None, vec![0.7]),
        (Kind::BaseTilt, "joint", Some(effort), vec![0.2, -0.3]),
        (Kind::EncoderOffset(0), "joint", Some(effort), vec![0.2]),
    ];
    for (kind, side, effort, values) in cases {
        let problem = carriage(side, effort);
        let mut effects = vec![Effect { kind, values }];
        let beside = match kind {
            Kind::Joint(JointKind::EffortSaturation, _) => Some((JointKind::EffortGain, vec![0.7])),
            Kind::Joint(JointKind::Backlash, _) => {
                Some((JointKind::DryFriction, vec![0.5, f64::NAN, f64::NAN]))
            }
            _ => None,
        };
        effects.extend(beside.map(|(kind, values)| Effect { kind: law(kind), values }));
        let slots = slots(&problem, &effects);
        // Another mass than the model's: its own inertia is not the given one. Delays of whole samples have no derivative
        // at the ends of an episode.
        let value = |slot: &crate::model::Slot| match slot.name.split(':').next() {
            Some("mass") => 1.3 * MASS,
            Some("timing") => 3e-4,
            _ => slot.start,
        };
        let start: Vec<f64> = slots.iter().map(value).collect();
        let rows = |values: &[f64]| -> JointRows {
            evaluate(&problem, &effects, &slots, values, Scope::Training, true).swap_remove(0)
        };
        let exact = rows(&start);
        for (column, &slot) in exact.columns.iter().enumerate() {
            let step = 1e-6 * start[slot].abs().max(1e-3);
            let moved = |sign: f64| {
                let mut values = start.clone();
                values[slot] += sign * step;
                rows(&values).residual
            };
            let slope = (moved(1.0) - moved(-1.0)) / (2.0 * step);
            let error = (&slope - exact.jacobian.column(column)).amax();
            assert!(error < 1e-4 * (1e-6 + slope.amax()), "{kind:?} {}: {error}", slots[slot].name);
        }
    }
}

#[test]
fn small_inertias_do_not_make_the_residual_of_a_passive_joint_small() {
    let problem = carriage("joint", None);
    let effects = [Effect { kind: Kind::Joint(JointKind::Spring, 0), values: vec![5.0, 0.1] }];
    let slots = slots(&problem, &effects);
    let residual = |factor: f64| {
        let value = |slot: &crate::model::Slot| match slot.name.split(':').next() {
            Some("mass") => factor * MASS,
            Some("armature") => factor * 0.4,
            Some("damping") => factor,
            _ if slot.name.ends_with("stiffness") => factor * 5.0,
            _ => slot.start,
        };
        let values: Vec<f64> = slots.iter().map(value).collect();
        evaluate(&problem, &effects, &slots, &values, Scope::Training, false).swap_remove(0).residual
    };
    let (full, small) = (residual(1.0), residual(0.01));
    assert!((&full - &small).amax() < 1e-9 * full.amax(), "{} {}", full.amax(), small.amax());
}

/// Residuals of a carriage with laws of its drive.
fn residual_with(laws: &[(JointKind, f64)]) -> nalgebra::DVector<f64> {
    let problem = carriage("joint", Some(|t| -4.0 * (3.0 * t).sin() - 7.0 * (8.0 * t + 0.1).cos()));
    let effect =
        |(kind, value): &(JointKind, f64)| Effect { kind: Kind::Joint(*kind, 0), values: vec![*value] };
    let effects: Vec<Effect> = laws.iter().map(effect).collect();
    let slots = slots(&problem, &effects);
    let values: Vec<f64> = slots.iter().map(|slot| slot.start).collect();
    evaluate(&problem, &effects, &slots, &values, Scope::Training, false).swap_remove(0).residual
}

#[test]
fn residuals_are_errors_of_the_reading_for_every_gain() {
    // The reading less the gain times the needed effort.
    let [half, one, two] = [0.5, 1.0, 2.0].map(|gain| residual_with(&[(JointKind::EffortGain, gain)]));
    let needed = &one - &two;
    assert!((&one - residual_with(&[])).amax() < 1e-9 * needed.amax());
    assert!((half - &one - &needed * 0.5).amax() < 1e-9 * needed.amax());
}

#[test]
fn a_small_gain_does_not_hide_what_a_limit_removes() {
    let nominal = residual_with(&[]).norm();
    let laws = [(JointKind::EffortGain, 0.05), (JointKind::EffortSaturation, 4.0)];
    assert!(residual_with(&laws).norm() > nominal, "{} {nominal}", residual_with(&laws).norm());
}

#[test]
fn a_small_gain_does_not_hide_what_a_soft_transmission_removes() {
    // The drive moves against its own damping, and hardly any effort arrives.
    let problem = carriage("joint", Some(|t| -4.0 * (3.0 * t).sin() - 7.0 * (8.0 * t).sin()));
    let size = |laws: &[(JointKind, Vec<f64>)], changed: &[(&str, f64)]| {
        let effect = |(kind, values): &(JointKind, Vec<f64>)| Effect {
            kind: Kind::Joint(*kind, 0),
            values: values.clone(),
        };
        let effects: Vec<Effect> = laws.iter().map(effect).collect();
        let slots = slots(&problem, &effects);
        let own = |name: &str| changed.iter().find(|(key, _)| name == *key).map(|(_, value)| *value);
        let values: Vec<f64> = slots.iter().map(|slot| own(&slot.name).unwrap_or(slot.start)).collect();
        let rows = evaluate(&problem, &effects, &slots, &values, Scope::Training, false);
        rows[0].residual.norm()
    };
    let laws = [(JointKind::EffortGain, vec![0.05]), (JointKind::Elasticity, vec![2.0, f64::NAN])];
    let (found, nominal) = (size(&laws, &[("armature:x", 0.0), ("damping:x", 20.0)]), size(&[], &[]));
    assert!(found > nominal, "{found} {nominal}");
}

#[test]
fn residuals_below_the_noise_determine_values() {
    // The damping is 2 % more than the model's: its effort is below the least noise of a drive.
    let problem = carriage("joint", Some(|t| (MASS + 0.4) * acceleration(t) + 1.02 * velocity(t)));
    let found = crate::fit::fit(&problem, &[], None, Scope::Training, crate::fit::MAX_STEPS);
    assert!(found.sd[0] <= super::noise_floor(&problem, 0), "{}", found.sd[0]);
    let damping = found.slots.iter().position(|slot| slot.name == "damping:x").unwrap();
    assert!((found.values[damping] - 1.02).abs() < 2e-3, "{}", found.values[damping]);
}

fn velocity(t: f64) -> f64 {
    0.6 * (3.0 * t).cos() - 0.4 * (8.0 * t).sin()
}

fn acceleration(t: f64) -> f64 {
    -1.8 * (3.0 * t).sin() - 3.2 * (8.0 * t).cos()
}
