//! In which motions a simulation goes wrong, in words.
//!
//! First by families of missing wrenches that are one thing said simply: another damping from a moment on, a drag on
//! one part of the floor, along one direction of it or on the object, a force constant in the world or in the sensor. The one that
//! explains most of what is missing is told if it explains most of it. Otherwise by where the missing wrench is
//! large: just after contact, in slow or in fast motion.

use super::screen::Screen;
use super::{Change, Region, Seen};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use trundle_infer::Residual;
use trundle_model::{to_body, transport};

/// Share of what any wrench would explain that a family must explain to be told.
const MOST_OF_IT: f64 = 0.5;
/// A force counts as just after contact for so long, s.
const EARLY: f64 = 0.2;
/// How much larger the misfit must be in one part of the motion than in another.
const TWICE: f64 = 2.0;
/// Fewer samples tell nothing.
const FEWEST: usize = 30;
/// A region that covers more of the floor that was visited than this is no place.
const PLACE: f64 = 0.6;

/// A family that may explain what is missing.
struct Family {
    chi_square: f64,
    dof: usize,
    words: String,
}

/// The words, if anything stands out.
pub(crate) fn regime(
    seen: &Seen,
    changes: &[Change],
    regions: &[Region],
    names: &[String],
    contacts: &[f64],
) -> Option<String> {
    let mut families: Vec<Family> = [constant_in_world, constant_in_sensor, along_grain, fixed_to_object]
        .into_iter()
        .filter_map(|family| family(&seen.screen))
        .collect();
    families.extend(changes.first().map(|change| from_then_on(change, seen.total, names)));
    families.extend(regions.first().filter(|r| r.share < PLACE).map(|region| Family {
        chi_square: region.chi_square,
        dof: 4,
        words: "only while on one part of the floor".to_owned(),
    }));
    let told = families
        .into_iter()
        .filter(|f| f.chi_square > MOST_OF_IT * seen.total)
        .max_by(|a, b| (a.chi_square - penalty(a.dof)).total_cmp(&(b.chi_square - penalty(b.dof))));
    told.map(|f| f.words).or_else(|| by_motion(seen, contacts))
}

/// What a parameter more is worth in χ² (Schwarz 1978), for some thousand samples.
fn penalty(dof: usize) -> f64 {
    8.0 * dof as f64
}

fn from_then_on(change: &Change, total: f64, names: &[String]) -> Family {
    let name = names.get(change.episode).map_or("", String::as_str);
    let words = format!("after {:.2} s of {name} to the end (from then on)", change.time);
    Family { chi_square: change.share * total, dof: 7, words }
}

/// A force that points one way in the world.
fn constant_in_world(screen: &Screen) -> Option<Family> {
    if screen.directions() < 3 {
        return None;
    }
    let along = |unit: [f64; 3]| screen.column(&screen.profile(|_, s| to_body(unit, s.pose[2])));
    let test = screen.test(&[&along([1.0, 0.0, 0.0]), &along([0.0, 1.0, 0.0])]);
    let [x, y] = [test.coefficients[0], test.coefficients[1]];
    let degrees = y.atan2(x).to_degrees();
    let words = format!("in all motions, as a force constant in the world along {degrees:.0}°");
    Some(Family { chi_square: test.chi_square, dof: test.dof, words })
}

/// A wrench that stays the same in the sensor's axes.
fn constant_in_sensor(screen: &Screen) -> Option<Family> {
    let along = |unit: [f64; 3]| {
        let of = |run: &super::screen::Run| run.frames.iter().map(|f| transport(unit, *f)).collect();
        screen.column(&screen.runs.iter().map(of).collect())
    };
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let columns: Vec<_> = (0..3).filter(|&k| screen.dof[k]).map(|k| along(axes[k])).collect();
    let test = screen.test(&columns.iter().collect::<Vec<_>>());
    let words = "in all motions, as a wrench constant in the sensor's axes".to_owned();
    Some(Family { chi_square: test.chi_square, dof: test.dof, words })
}

/// A drag at the origin that differs with the direction of motion in the world.
fn along_grain(screen: &Screen) -> Option<Family> {
    if screen.directions() < 3 {
        return None;
    }
    let drag = |matrix: [f64; 3]| {
        screen.column(&screen.profile(|_, s| {
            let [vx, vy, _] = s.twist;
            let [xx, xy, yy] = matrix;
            to_body([-(xx * vx + xy * vy), -(xy * vx + yy * vy), 0.0], s.pose[2])
        }))
    };
    let columns = [drag([1.0, 0.0, 0.0]), drag([0.0, 1.0, 0.0]), drag([0.0, 0.0, 1.0])];
    let test = screen.test(&columns.iter().collect::<Vec<_>>());
    let [xx, xy, yy] = [test.coefficients[0], test.coefficients[1], test.coefficients[2]];
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let degrees = angle.rem_euclid(PI).to_degrees();
    let words = format!("when moving along world {degrees:.0}°");
    Some(Family { chi_square: test.chi_square, dof: test.dof + 1, words })
}

/// A drag at some point of the object, or at several: one symmetric matrix in object axes. It explains dry friction
/// in part.
fn fixed_to_object(screen: &Screen) -> Option<Family> {
    let moving: Vec<usize> = (0..3).filter(|&k| screen.dof[k]).collect();
    let drag = |i: usize, j: usize| {
        screen.column(&screen.profile(|_, s| {
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
    let test = screen.test(&columns.iter().collect::<Vec<_>>());
    let words = "in all motions, as a drag that moves with the object".to_owned();
    Some(Family { chi_square: test.chi_square, dof: test.dof, words })
}

/// Where in the motion the missing wrench is large.
fn by_motion(seen: &Seen, contacts: &[f64]) -> Option<String> {
    let screen = &seen.screen;
    let all = || screen.runs.iter().enumerate().flat_map(|(e, run)| run.course.iter().map(move |r| (e, r)));
    if all().count() < FEWEST {
        return None;
    }
    let misfit = |r: &Residual| standardised(r, screen.dof);
    let whole: f64 = all().map(|(_, r)| misfit(r)).sum();
    let early =
        |(e, r): &(usize, &Residual)| contacts.get(*e).is_some_and(|c| (0.0..EARLY).contains(&(r.t - c)));
    let share = all().filter(early).map(|(_, r)| misfit(r)).sum::<f64>() / whole.max(f64::MIN_POSITIVE);
    let time = all().filter(early).count() as f64 / all().count() as f64;
    if share > 0.7 && time < 0.2 {
        return Some(format!("within {EARLY:.1} s of each contact"));
    }
    let mut samples: Vec<(f64, f64)> = all().map(|(_, r)| (speed(r), misfit(r))).collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    by_speed(&samples, screen.directions())
}

/// Slow and fast thirds of samples of speed and misfit.
fn by_speed(samples: &[(f64, f64)], directions: usize) -> Option<String> {
    let third = samples.len() / 3;
    let mean = |part: &[(f64, f64)]| part.iter().map(|s| s.1).sum::<f64>() / part.len() as f64;
    let (slow, fast) = (mean(&samples[..third]), mean(&samples[2 * third..]));
    if slow.max(fast) < 3.0 * directions as f64 {
        return None;
    }
    Some(if slow > TWICE * fast {
        format!("below {:.2} m/s and at reversals", samples[third].0)
    } else if fast > TWICE * slow {
        format!("above {:.2} m/s", samples[2 * third].0)
    } else {
        "at every speed".to_owned()
    })
}

fn speed(seen: &Residual) -> f64 {
    seen.twist[0].hypot(seen.twist[1])
}

/// Squared size of a residual wrench in units of its uncertainty, over the directions that move.
fn standardised(residual: &Residual, dof: [bool; 3]) -> f64 {
    let mut covariance: Matrix3<f64> = residual.covariance;
    let mut wrench = Vector3::from(residual.wrench);
    for k in (0..3).filter(|&k| !dof[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        (covariance[(k, k)], wrench[k]) = (1.0, 0.0);
    }
    covariance.cholesky().map_or(0.0, |c| wrench.dot(&c.solve(&wrench)))
}
