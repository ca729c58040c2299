//! Candidate pushes: a coarse grid over grasps, directions, profiles and headings, and the neighbours of a push.

use super::push::{Profile, Push};
use super::setup::Setup;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use trundle_model::{Body, Fixture};

/// Distance of a grasp from the centre of mass, as a share of that of the rim.
const GRASP_DEPTH: f64 = 0.95;
/// Maximum number of grasps.
const MAX_GRASPS: usize = 12;

/// Grasps on the object: corners and midpoints of its edges, or eight points of a disc.
pub(super) fn grasps(body: &Body) -> Vec<[f64; 2]> {
    let rim: Vec<[f64; 2]> = body.fixtures.iter().flat_map(rim).collect();
    let inset = |p: &[f64; 2]| [0, 1].map(|k| round(body.com[k] + GRASP_DEPTH * (p[k] - body.com[k]), 0.01));
    let every = rim.len().div_ceil(MAX_GRASPS).max(1);
    let mut found: Vec<[f64; 2]> = rim.iter().step_by(every).map(inset).collect();
    if found.is_empty() {
        found.push([0.0; 2]);
    }
    found
}

fn rim(fixture: &Fixture) -> Vec<[f64; 2]> {
    match fixture {
        Fixture::Polygon { vertices, .. } => {
            let next = vertices.iter().cycle().skip(1);
            let middle = |(a, b): (&[f64; 2], &[f64; 2])| [[0, 1].map(|k| 0.5 * (a[k] + b[k])), *b];
            vertices.iter().zip(next).flat_map(middle).collect()
        }
        Fixture::Disc { center: [x, y], radius, .. } => (0..8)
            .map(|k| (f64::from(k) * FRAC_PI_4).sin_cos())
            .map(|(sin, cos)| [x + radius * cos, y + radius * sin])
            .collect(),
    }
}

fn round(value: f64, to: f64) -> f64 {
    // Divide by the rounded reciprocal, which keeps 0.3 from becoming 0.30000000000000004.
    (value / to).round() / to.recip().round()
}

/// Profiles that the object's free directions allow.
fn profiles(setup: &Setup) -> impl Iterator<Item = Profile> {
    let rail = setup.on_rail();
    Profile::ALL.into_iter().filter(move |p| !(rail && p.turns()))
}

/// The coarse grid.
pub(super) fn coarse_grid(setup: &Setup) -> Vec<Push> {
    let grasps = grasps(&setup.body);
    let every = grasps.len().div_ceil(3).max(1);
    let (turns, directions): (&[f64], &[f64]) =
        if setup.on_rail() { (&[0.0], &[0.0]) } else { (&[0.0, FRAC_PI_2], &[0.0, FRAC_PI_2]) };
    let mut pushes = Vec::new();
    for profile in profiles(setup) {
        for (k, &turn) in turns.iter().enumerate() {
            for (m, grasp) in grasps.iter().step_by(every).enumerate() {
                // A pure torque has no direction.
                let along = if profile == Profile::Turn { &directions[..1] } else { directions };
                for (n, &direction) in along.iter().enumerate() {
                    // Use every other grid point, as on a chessboard. The neighbours of the best push fill the gaps.
                    if (k + m + n) % 2 == 0 || directions.len() == 1 || profile == Profile::Turn {
                        pushes.push(push_at(setup, *grasp, direction, profile, turn));
                    }
                }
            }
        }
    }
    pushes
}

fn push_at(setup: &Setup, grasp: [f64; 2], direction: f64, profile: Profile, turn: f64) -> Push {
    let [x, y, heading] = setup.start_pose;
    Push {
        grasp,
        direction,
        start: [x, y, heading + turn],
        profile,
        force: setup.limits.force,
        torque: setup.limits.torque,
        duration: setup.limits.duration,
    }
}

/// Pushes that differ from a push in one respect; `fine` selects smaller steps for the last searches.
pub(super) fn neighbours(setup: &Setup, push: &Push, fine: bool) -> Vec<Push> {
    let step = if fine { FRAC_PI_4 / 3.0 } else { FRAC_PI_4 };
    let mut near: Vec<Push> = if fine { vec![] } else { other_profiles_and_places(setup, push) };
    near.extend([1.5, 0.5, 0.25].map(|factor| rescaled(setup, push, factor)));
    if setup.on_rail() {
        return near;
    }
    let around: &[i32] = if fine { &[-1, 1] } else { &[-3, -2, -1, 1, 2, 3, 4] };
    for &k in around {
        let angle = f64::from(k) * step;
        near.push(Push { direction: wrapped(push.direction + angle), ..*push });
        let turned = [push.start[0], push.start[1], push.start[2] + angle];
        if fine || k % 2 == 0 {
            near.push(Push { start: turned, ..*push });
        }
    }
    near
}

/// Pushes with other profiles, grasps and start positions.
fn other_profiles_and_places(setup: &Setup, push: &Push) -> Vec<Push> {
    let full = push_at(setup, push.grasp, push.direction, push.profile, 0.0);
    let mut near: Vec<Push> = profiles(setup)
        .map(|profile| Push { profile, force: full.force, torque: full.torque, ..*push })
        .collect();
    if !setup.on_rail() {
        near.extend(grasps(&setup.body).into_iter().map(|grasp| Push { grasp, ..*push }));
        let [x, y, _] = setup.start_pose;
        let places = setup.places.iter().copied().chain([[x, y]]);
        near.extend(places.map(|[x, y]| Push { start: [x, y, push.start[2]], ..*push }));
    }
    near.retain(|other| other != push);
    near
}

/// The push scaled by a factor, within the limits of force and torque.
fn rescaled(setup: &Setup, push: &Push, factor: f64) -> Push {
    let max_factor = (setup.limits.force / push.force).min(setup.limits.torque / push.torque);
    push.scaled(factor.min(max_factor))
}

fn wrapped(angle: f64) -> f64 {
    let turns = (angle / TAU).round();
    angle - turns * TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::setup::Limits;
    use trundle_record::Noise;

    const NOISE: Noise =
        Noise { pose: [5e-4, 5e-4, 1.75e-3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    fn setup(dof: [bool; 3]) -> Setup {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        Setup::without_recording(Body::from_footprint(&corners, 22.0).unwrap(), dof, Limits::default(), NOISE)
    }

    #[test]
    fn grasps_lie_on_the_object() {
        let setup = setup([true; 3]);
        let grasps = grasps(&setup.body);
        assert_eq!(grasps.len(), 8);
        assert!(grasps.iter().all(|p| setup.body.outside(*p).0 == 0.0), "{grasps:?}");
        assert!(grasps.contains(&[0.57, -0.38]) && grasps.contains(&[0.0, 0.38]));
    }

    #[test]
    fn every_push_respects_the_limits_of_force_and_torque() {
        for dof in [[true; 3], [true, false, false]] {
            let setup = setup(dof);
            let grid = coarse_grid(&setup);
            let all =
                grid.iter().chain(&grid).flat_map(|push| neighbours(&setup, push, false)).chain(grid.clone());
            for push in all {
                assert!(
                    push.force <= 30.0 + 1e-9 && push.torque <= 8.0 + 1e-9 && push.force > 0.0,
                    "{push:?}"
                );
                if !dof[1] {
                    assert!(push.direction == 0.0 && push.start == [0.0; 3] && !push.profile.turns());
                }
            }
            assert!((5..60).contains(&grid.len()), "{}", grid.len());
        }
    }
}
