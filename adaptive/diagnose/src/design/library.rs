//! The pushes that are tried: a coarse net over grasps, directions, profiles and headings, and the neighbours of one.

use super::bench::Bench;
use super::push::{Profile, Push};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use trundle_model::{Body, Fixture};

/// Share of the way from the mass centre to the rim at which the gripper holds the object.
const DEPTH: f64 = 0.95;
/// At most so many grasps.
const GRASPS: usize = 12;

/// Where the object can be held: corners and middles of its edges, eight points of a disc.
pub(super) fn grasps(body: &Body) -> Vec<[f64; 2]> {
    let rim: Vec<[f64; 2]> = body.fixtures.iter().flat_map(rim).collect();
    let held = |p: &[f64; 2]| [0, 1].map(|k| round(body.com[k] + DEPTH * (p[k] - body.com[k]), 0.01));
    let every = rim.len().div_ceil(GRASPS).max(1);
    let mut found: Vec<[f64; 2]> = rim.iter().step_by(every).map(held).collect();
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
    // Rounding to whole numbers first keeps 0.3 from becoming 0.30000000000000004.
    (value / to).round() / to.recip().round()
}

/// Profiles that mean something for the object.
fn profiles(bench: &Bench) -> impl Iterator<Item = Profile> {
    let rail = bench.on_rail();
    Profile::ALL.into_iter().filter(move |p| !(rail && p.turns()))
}

/// A coarse net.
pub(super) fn net(bench: &Bench) -> Vec<Push> {
    let grasps = grasps(&bench.body);
    let every = grasps.len().div_ceil(3).max(1);
    let (turns, directions): (&[f64], &[f64]) =
        if bench.on_rail() { (&[0.0], &[0.0]) } else { (&[0.0, FRAC_PI_2], &[0.0, FRAC_PI_2]) };
    let mut pushes = Vec::new();
    for profile in profiles(bench) {
        for (k, &turn) in turns.iter().enumerate() {
            for (m, grasp) in grasps.iter().step_by(every).enumerate() {
                // A torque alone has no direction; of the rest, each grasp is tried with each direction.
                let along = if profile == Profile::Turn { &directions[..1] } else { directions };
                for (n, &direction) in along.iter().enumerate() {
                    // Half of the net, as a chessboard: the neighbours of the best fill the gaps.
                    if (k + m + n) % 2 == 0 || directions.len() == 1 || profile == Profile::Turn {
                        pushes.push(first(bench, *grasp, direction, profile, turn));
                    }
                }
            }
        }
    }
    pushes
}

fn first(bench: &Bench, grasp: [f64; 2], direction: f64, profile: Profile, turn: f64) -> Push {
    let [x, y, heading] = bench.stands;
    Push {
        grasp,
        direction,
        start: [x, y, heading + turn],
        profile,
        force: bench.limits.force,
        torque: bench.limits.torque,
        duration: bench.limits.duration,
    }
}

/// Pushes that differ from one in a single respect; `fine` once the coarse ones bring nothing more.
pub(super) fn neighbours(bench: &Bench, push: &Push, fine: bool) -> Vec<Push> {
    let step = if fine { FRAC_PI_4 / 3.0 } else { FRAC_PI_4 };
    let mut near: Vec<Push> = if fine { vec![] } else { apart(bench, push) };
    near.extend([1.5, 0.5, 0.25].map(|factor| stronger(bench, push, factor)));
    if bench.on_rail() {
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

/// Other profiles, grasps and places.
fn apart(bench: &Bench, push: &Push) -> Vec<Push> {
    let full = first(bench, push.grasp, push.direction, push.profile, 0.0);
    let mut near: Vec<Push> = profiles(bench)
        .map(|profile| Push { profile, force: full.force, torque: full.torque, ..*push })
        .collect();
    if !bench.on_rail() {
        near.extend(grasps(&bench.body).into_iter().map(|grasp| Push { grasp, ..*push }));
        let [x, y, _] = bench.stands;
        let places = bench.places.iter().copied().chain([[x, y]]);
        near.extend(places.map(|[x, y]| Push { start: [x, y, push.start[2]], ..*push }));
    }
    near.retain(|other| other != push);
    near
}

/// The same push, stronger or weaker, within the limits of wrench.
fn stronger(bench: &Bench, push: &Push, factor: f64) -> Push {
    let most = (bench.limits.force / push.force).min(bench.limits.torque / push.torque);
    push.scaled(factor.min(most))
}

fn wrapped(angle: f64) -> f64 {
    let turns = (angle / TAU).round();
    angle - turns * TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::bench::Limits;
    use trundle_record::Noise;

    const NOISE: Noise =
        Noise { pose: [5e-4, 5e-4, 1.75e-3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    fn bench(dof: [bool; 3]) -> Bench {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        Bench::bare(Body::from_footprint(&corners, 22.0).unwrap(), dof, Limits::default(), NOISE)
    }

    #[test]
    fn grasps_lie_on_the_object() {
        let bench = bench([true; 3]);
        let grasps = grasps(&bench.body);
        assert_eq!(grasps.len(), 8);
        assert!(grasps.iter().all(|p| bench.body.outside(*p).0 == 0.0), "{grasps:?}");
        assert!(grasps.contains(&[0.57, -0.38]) && grasps.contains(&[0.0, 0.38]));
    }

    #[test]
    fn every_push_keeps_the_limits_of_wrench() {
        for dof in [[true; 3], [true, false, false]] {
            let bench = bench(dof);
            let net = net(&bench);
            let all =
                net.iter().chain(&net).flat_map(|push| neighbours(&bench, push, false)).chain(net.clone());
            for push in all {
                assert!(
                    push.force <= 30.0 + 1e-9 && push.torque <= 8.0 + 1e-9 && push.force > 0.0,
                    "{push:?}"
                );
                if !dof[1] {
                    assert!(push.direction == 0.0 && push.start == [0.0; 3] && !push.profile.turns());
                }
            }
            assert!((5..60).contains(&net.len()), "{}", net.len());
        }
    }
}
