//! Simulation of an episode from its first pose.

use crate::curve::Curve;
use crate::filter::advance;
use crate::track::{Step, cut_into_steps};
use trundle_model::{MAX_INNER_STATES, Plant, State};
use trundle_record::Prepared;

/// The same up to time `until`, s, with the laws' own states starting from `inner`.
pub(crate) fn simulate(
    plant: &Plant<f64>,
    episode: &Prepared,
    inner: [f64; MAX_INNER_STATES],
    until: f64,
) -> Vec<[f64; 3]> {
    let Some(first) = episode.pose.first() else { return vec![] };
    let mut state = State::moving(first.pose, episode.first_twist).with_inner(inner);
    let mut poses = vec![first.pose];
    if episode.wrench.is_empty() {
        return vec![first.pose; episode.pose.len()];
    }
    let curve = Curve::new(episode);
    let mut steps: Vec<Step> = Vec::new();
    for pair in episode.pose.windows(2).take_while(|pair| pair[1].t <= until) {
        steps.clear();
        cut_into_steps(pair[0].t, &pair[1], &curve, curve.max_step(), &mut steps);
        for step in &steps {
            advance(plant, &mut state, &[0.0; 3], step, &curve);
        }
        poses.push(state.pose);
    }
    poses
}
