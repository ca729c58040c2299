//! Motion regime of the misfit.
//!
//! First, families of missing wrenches with a simple description are tested: different damping from a time on,
//! drag on one part of the floor, in one direction or on the object, and a force constant in the world or in the
//! sensor. The family that explains most is reported if it explains most of the misfit. Otherwise the regime is
//! the part of the motion in which the missing wrench is large: just after contact, at low speed or at high
//! speed.

use super::change_points::ChangePoint;
use super::places::Region;
use super::scan_data::ScanData;
use super::score_test::ScoreTest;
use crate::answer::RegimeKind;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use trundle_infer::Residual;
use trundle_model::{to_body, transport};

/// Minimum share of the total χ² that a reported family explains.
const MIN_EXPLAINED_SHARE: f64 = 0.5;
/// Duration of the phase just after contact, s.
const CONTACT_PHASE_S: f64 = 0.2;
/// Minimum ratio of the misfits in two parts of the motion.
const MIN_MISFIT_RATIO: f64 = 2.0;
/// Minimum number of samples.
const MIN_SAMPLES: usize = 30;
/// Maximum share of the visited floor that a reported region covers.
const MAX_REGION_SHARE: f64 = 0.6;

/// Motion regime of a misfit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Regime {
    pub kind: RegimeKind,
    pub description: String,
}

impl Regime {
    fn new(kind: RegimeKind, description: impl Into<String>) -> Self {
        Self { kind, description: description.into() }
    }
}

/// A family of missing wrenches.
struct WrenchFamily {
    chi_square: f64,
    dof: usize,
    regime: Regime,
}

/// The regime, if one stands out.
pub(crate) fn regime(
    data: &ScanData,
    changes: &[ChangePoint],
    regions: &[Region],
    names: &[String],
    contacts: &[f64],
) -> Option<Regime> {
    let mut families: Vec<WrenchFamily> =
        [constant_in_world, constant_in_sensor, direction_dependent_drag, drag_on_object]
            .into_iter()
            .filter_map(|family| family(&data.score_test))
            .collect();
    families.extend(changes.first().map(|change| after_change(change, data.total, names)));
    families.extend(regions.first().filter(|r| r.share < MAX_REGION_SHARE).map(|region| WrenchFamily {
        chi_square: region.chi_square,
        dof: 4,
        regime: Regime::new(RegimeKind::PartOfFloor, "only on one part of the floor"),
    }));
    let best = families
        .into_iter()
        .filter(|f| f.chi_square > MIN_EXPLAINED_SHARE * data.total)
        .max_by(|a, b| (a.chi_square - penalty(a.dof)).total_cmp(&(b.chi_square - penalty(b.dof))));
    best.map(|f| f.regime).or_else(|| by_motion(data, contacts))
}

/// Penalty for the parameters of a family in χ² (Schwarz 1978), for some thousand samples.
fn penalty(dof: usize) -> f64 {
    8.0 * dof as f64
}

fn after_change(change: &ChangePoint, total: f64, names: &[String]) -> WrenchFamily {
    let name = names.get(change.episode).map_or("", String::as_str);
    let description = format!("from {:.2} s of {name} to the end of the recording", change.time);
    let regime = Regime::new(RegimeKind::FromTimeOn, description);
    WrenchFamily { chi_square: change.share * total, dof: 7, regime }
}

/// A force with a constant direction in the world.
fn constant_in_world(score_test: &ScoreTest) -> Option<WrenchFamily> {
    if score_test.free_directions() < 3 {
        return None;
    }
    let column = |unit: [f64; 3]| score_test.column(&score_test.profile(|_, s| to_body(unit, s.pose[2])));
    let test = score_test.test(&[&column([1.0, 0.0, 0.0]), &column([0.0, 1.0, 0.0])]);
    let [x, y] = [test.coefficients[0], test.coefficients[1]];
    let degrees = y.atan2(x).to_degrees();
    let description = format!("in all motions, as a force constant in the world along {degrees:.0}°");
    let regime = Regime::new(RegimeKind::ConstantInWorld, description);
    Some(WrenchFamily { chi_square: test.chi_square, dof: test.dof, regime })
}

/// A wrench that is constant in the axes of the sensor.
fn constant_in_sensor(score_test: &ScoreTest) -> Option<WrenchFamily> {
    let column = |unit: [f64; 3]| {
        let of = |episode: &super::score_test::Episode| {
            episode.frames.iter().map(|f| transport(unit, *f)).collect()
        };
        score_test.column(&score_test.episodes.iter().map(of).collect())
    };
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let columns: Vec<_> = (0..3).filter(|&k| score_test.dof[k]).map(|k| column(axes[k])).collect();
    let test = score_test.test(&columns.iter().collect::<Vec<_>>());
    let description = "in all motions, as a wrench constant in the sensor's axes";
    let regime = Regime::new(RegimeKind::ConstantInSensor, description);
    Some(WrenchFamily { chi_square: test.chi_square, dof: test.dof, regime })
}

/// A drag at the origin that depends on the direction of motion in the world.
fn direction_dependent_drag(score_test: &ScoreTest) -> Option<WrenchFamily> {
    if score_test.free_directions() < 3 {
        return None;
    }
    let drag = |matrix: [f64; 3]| {
        score_test.column(&score_test.profile(|_, s| {
            let [vx, vy, _] = s.twist;
            let [xx, xy, yy] = matrix;
            to_body([-(xx * vx + xy * vy), -(xy * vx + yy * vy), 0.0], s.pose[2])
        }))
    };
    let columns = [drag([1.0, 0.0, 0.0]), drag([0.0, 1.0, 0.0]), drag([0.0, 0.0, 1.0])];
    let test = score_test.test(&columns.iter().collect::<Vec<_>>());
    let [xx, xy, yy] = [test.coefficients[0], test.coefficients[1], test.coefficients[2]];
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let degrees = angle.rem_euclid(PI).to_degrees();
    let description = format!("when moving along world direction {degrees:.0}°");
    let regime = Regime::new(RegimeKind::WorldDirection, description);
    Some(WrenchFamily { chi_square: test.chi_square, dof: test.dof + 1, regime })
}

/// A drag at one or several points of the object: one symmetric matrix in object axes. It also explains part of a
/// dry friction.
fn drag_on_object(score_test: &ScoreTest) -> Option<WrenchFamily> {
    let moving: Vec<usize> = (0..3).filter(|&k| score_test.dof[k]).collect();
    let drag = |i: usize, j: usize| {
        score_test.column(&score_test.profile(|_, s| {
            let twist = to_body(s.twist, s.pose[2]);
            let mut wrench = [0.0; 3];
            wrench[i] -= twist[j];
            if i != j {
                wrench[j] -= twist[i];
            }
            wrench
        }))
    };
    let pairs = moving.iter().flat_map(|&i| moving.iter().filter(move |&&j| j >= i).map(move |&j| (i, j)));
    let columns: Vec<_> = pairs.map(|(i, j)| drag(i, j)).collect();
    let test = score_test.test(&columns.iter().collect::<Vec<_>>());
    let regime =
        Regime::new(RegimeKind::DragOnObject, "in all motions, as a drag that moves with the object");
    Some(WrenchFamily { chi_square: test.chi_square, dof: test.dof, regime })
}

/// The part of the motion in which the missing wrench is large.
fn by_motion(data: &ScanData, contacts: &[f64]) -> Option<Regime> {
    let score_test = &data.score_test;
    let all = || {
        score_test
            .episodes
            .iter()
            .enumerate()
            .flat_map(|(e, episode)| episode.residuals.iter().map(move |r| (e, r)))
    };
    if all().count() < MIN_SAMPLES {
        return None;
    }
    let misfit = |r: &Residual| squared_mahalanobis(r, score_test.dof);
    let total: f64 = all().map(|(_, r)| misfit(r)).sum();
    let early = |(e, r): &(usize, &Residual)| {
        contacts.get(*e).is_some_and(|c| (0.0..CONTACT_PHASE_S).contains(&(r.t - c)))
    };
    let share = all().filter(early).map(|(_, r)| misfit(r)).sum::<f64>() / total.max(f64::MIN_POSITIVE);
    let time = all().filter(early).count() as f64 / all().count() as f64;
    if share > 0.7 && time < 0.2 {
        let description = format!("within {CONTACT_PHASE_S:.1} s of each contact");
        return Some(Regime::new(RegimeKind::AfterContact, description));
    }
    let mut samples: Vec<(f64, f64)> = all().map(|(_, r)| (speed(r), misfit(r))).collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    by_speed(&samples, score_test.free_directions())
}

/// Compares the slow and the fast third of samples of speed and misfit.
fn by_speed(samples: &[(f64, f64)], free_directions: usize) -> Option<Regime> {
    let third = samples.len() / 3;
    let mean = |part: &[(f64, f64)]| part.iter().map(|s| s.1).sum::<f64>() / part.len() as f64;
    let (slow, fast) = (mean(&samples[..third]), mean(&samples[2 * third..]));
    if slow.max(fast) < 3.0 * free_directions as f64 {
        return None;
    }
    Some(if slow > MIN_MISFIT_RATIO * fast {
        Regime::new(RegimeKind::LowSpeed, format!("below {:.2} m/s and at reversals", samples[third].0))
    } else if fast > MIN_MISFIT_RATIO * slow {
        Regime::new(RegimeKind::HighSpeed, format!("above {:.2} m/s", samples[2 * third].0))
    } else {
        Regime::new(RegimeKind::AllSpeeds, "at all speeds")
    })
}

fn speed(residual: &Residual) -> f64 {
    residual.twist[0].hypot(residual.twist[1])
}

/// Squared Mahalanobis distance of a residual wrench from zero, over the free directions.
fn squared_mahalanobis(residual: &Residual, dof: [bool; 3]) -> f64 {
    let mut covariance: Matrix3<f64> = residual.covariance;
    let mut wrench = Vector3::from(residual.wrench);
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}
