//! Checks of the grasp: slip, and the distance of the gripper from the object.

use nalgebra::{DMatrix, DVector};

use crate::metadata::{Contact, Frame, Reference};
use crate::prepare::{WrenchSample, median, quantile};

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::gripper::frozen_travel;
use super::group::grouped;
use super::input::CheckInput;

/// Motion of a firm grasp in the object frame that noise explains, in standard deviations.
const MAX_GRASP_MOTION_SD: f64 = 8.0;
/// Motion of a firm grasp in the object frame that is tolerated, as a share of the object's size.
const MAX_GRASP_MOTION_SHARE: f64 = 0.03;
/// Time without load after which the gripper may grasp the object elsewhere, s.
const MAX_UNLOADED_TIME_S: f64 = 0.5;
/// Delays of a compliant grasp, as shares of its duration.
const COMPLIANCE_DELAYS: [f64; 2] = [0.0, 0.02];
/// Maximum distance of the gripper from the footprint in sizes of the object.
const MAX_REACH_SIZES: f64 = 1.0;

/// Whether the reference point of the readings is the gripper, so that their frames give its pose.
fn is_referred_to_gripper(input: &CheckInput) -> bool {
    input.data.reference() == Reference::Sensor && !input.data.meta.on_rail() && input.data.size > 0.0
}

/// Motion of a firm grasp in the object frame that is tolerated between simultaneous poses, m.
fn tolerated_motion(input: &CheckInput) -> f64 {
    let sd = input.data.dataset.noise.pose;
    let arm = sd[2] * input.data.size; // noise of the heading also moves the grasp
    (MAX_GRASP_MOTION_SD * (sd[0].max(sd[1]) + arm)).max(MAX_GRASP_MOTION_SHARE * input.data.size)
}

/// Wrench samples under load from contact on, where poses are known. In a long gap of the poses, or after the last one, the
/// position of the gripper on the object is too uncertain.
fn loaded<'a>(input: &'a CheckInput, episode: &'a EpisodeData) -> impl Iterator<Item = &'a WrenchSample> {
    let max_sd = tolerated_motion(input) / MAX_GRASP_MOTION_SD;
    let known = move |w: &&WrenchSample| w.t >= episode.prepared.contact && w.frame_sd <= max_sd;
    episode.prepared.wrench.iter().filter(known).filter(|w| input.data.is_loaded(w))
}

/// Wrench samples under load, split into separate grasps. A gripper without load may have released the object.
fn grasps(input: &CheckInput, episode: &EpisodeData) -> Vec<Vec<WrenchSample>> {
    let (mut grasps, mut last) = (vec![], f64::NEG_INFINITY);
    for w in loaded(input, episode) {
        if w.t - last > MAX_UNLOADED_TIME_S {
            grasps.push(vec![]);
        }
        last = w.t;
        grasps.last_mut().into_iter().for_each(|grasp| grasp.push(w.clone()));
    }
    grasps
}

/// Checks for a gripper that moves on the object although its contact is a grasp.
pub(crate) fn slip(input: &CheckInput) -> Vec<Finding> {
    if !is_referred_to_gripper(input) || input.data.meta.wrench.contact != Contact::Grasp {
        return vec![];
    }
    let firm = |episode: &&EpisodeData| frozen_travel(input, episode).is_none();
    let episodes: Vec<_> =
        input.data.episodes.iter().filter(firm).map(|episode| (episode, grasps(input, episode))).collect();
    let all: Vec<&[WrenchSample]> =
        episodes.iter().flat_map(|(_, grasps)| grasps.iter().map(Vec::as_slice)).collect();
    let Some(motions) = residual_motions(&all) else { return vec![] };
    let mut motions = motions.into_iter();
    let largest = |grasps: &Vec<_>| motions.by_ref().take(grasps.len()).fold(0.0, f64::max);
    let largest: Vec<f64> = episodes.iter().map(|(_, grasps)| grasps).map(largest).collect();
    let found = episodes.iter().zip(largest);
    grouped(found.filter_map(|((episode, _), motion)| slip_finding(input, episode, motion)).collect())
}

fn slip_finding(input: &CheckInput, episode: &EpisodeData, motion: f64) -> Option<(f64, Finding)> {
    (motion > tolerated_motion(input) + asynchrony(episode)).then(|| {
        let sentence =
            format!("wrench.contact is \"grasp\", but the gripper moves by {:.0} mm on the object", 1e3 * motion);
        let remedy = "set wrench.contact = \"point\" if the gripper only pushes; otherwise the grasp slips, or the \
                      poses are wrong";
        (motion, Finding::new("grasp", Severity::Warning, sentence, remedy).in_episode(episode.name()))
    })
}

/// Motion of the gripper on the object in each grasp that the load does not explain, m. A compliant grasp deflects under
/// load, immediately or with a delay, and with the same compliance in all grasps. The unloaded position is unknown, so
/// positions are relative to the mean of each grasp.
fn residual_motions(grasps: &[&[WrenchSample]]) -> Option<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = vec![];
    let mut positions: [Vec<f64>; 2] = [vec![], vec![]];
    for grasp in grasps {
        let span = grasp.last()?.t - grasp.first()?.t;
        let loads: Vec<(f64, [f64; 3])> = grasp.iter().map(|w| (w.t, load(w))).collect();
        let columns = COMPLIANCE_DELAYS.iter().flat_map(|share| (0..3).map(move |axis| (axis, share * span)));
        let columns: Vec<Vec<f64>> =
            columns.map(|(axis, lag)| centred(delayed(&loads, axis, lag))).collect::<Option<_>>()?;
        rows.extend((0..grasp.len()).map(|i| columns.iter().map(|c| c[i]).collect::<Vec<f64>>()));
        for (axis, position) in positions.iter_mut().enumerate() {
            position.extend(centred(grasp.iter().map(|w| w.frame[axis]).collect())?);
        }
    }
    let columns = rows.first()?.len();
    let design = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
    let scale: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let design = DMatrix::from_fn(rows.len(), columns, |i, j| design[(i, j)] / scale[j]);
    let ridge = DMatrix::identity(columns, columns) * 1e-9;
    let solver = (design.transpose() * &design + ridge).cholesky()?;
    let residual = positions.map(|position| {
        let position = DVector::from_vec(position);
        &position - &design * solver.solve(&(design.transpose() * &position))
    });
    let mut first = 0;
    let spread = |grasp: &&[WrenchSample]| {
        let axis = |k: usize| residual[k].rows(first, grasp.len()).iter().copied().collect::<Vec<f64>>();
        let (x, y) = (axis(0), axis(1));
        first += grasp.len();
        let range = |axis: &[f64]| {
            Some(quantile(axis.iter().copied(), 0.95)? - quantile(axis.iter().copied(), 0.05)?)
        };
        Some(range(&x)?.hypot(range(&y)?))
    };
    grasps.iter().map(spread).collect()
}

/// `values` minus their mean; `None` if there are none.
fn centred(mut values: Vec<f64>) -> Option<Vec<f64>> {
    let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)?;
    values.iter_mut().for_each(|value| *value -= mean);
    Some(values)
}

/// Load of a grasp: force in object axes, torque about the gripper.
fn load(w: &WrenchSample) -> [f64; 3] {
    let ([x, y, torque], (sin, cos)) = (w.reading, w.frame[2].sin_cos());
    [cos * x - sin * y, sin * x + cos * y, torque]
}

/// One axis of a load after a first-order lag with time constant `lag`, s.
fn delayed(loads: &[(f64, [f64; 3])], axis: usize, lag: f64) -> Vec<f64> {
    let (mut last, mut state) = loads.first().map_or((0.0, 0.0), |(t, load)| (*t, load[axis]));
    let one = |(t, load): &(f64, [f64; 3])| {
        let step = t - last;
        last = *t;
        let share = if lag > 0.0 { 1.0 - (-step / lag).exp() } else { 1.0 };
        state += share * (load[axis] - state);
        state
    };
    loads.iter().map(one).collect()
}

/// Apparent motion of the grasp because poses of object and gripper are not simultaneous, m.
fn asynchrony(episode: &EpisodeData) -> f64 {
    let steps = episode
        .prepared
        .pose
        .windows(2)
        .map(|pair| (pair[1].pose[0] - pair[0].pose[0]).hypot(pair[1].pose[1] - pair[0].pose[1]));
    2.0 * quantile(steps, 0.95).unwrap_or(0.0)
}

/// Checks for a gripper that is too far from the footprint under load.
pub(crate) fn out_of_reach(input: &CheckInput) -> Vec<Finding> {
    if !is_referred_to_gripper(input) || input.data.meta.wrench.frame == Frame::Object {
        return vec![];
    }
    let body = &input.data.dataset.body;
    let distance = |episode: &EpisodeData| {
        median(loaded(input, episode).map(|w| body.outside([w.frame[0], w.frame[1]]).0))
    };
    let far =
        |episode: &&EpisodeData| distance(episode).is_some_and(|d| d > MAX_REACH_SIZES * input.data.size);
    input
        .data
        .episodes
        .iter()
        .filter(far)
        .take(1)
        .map(|episode| reach_finding(input, episode, distance(episode)))
        .collect()
}

fn reach_finding(input: &CheckInput, episode: &EpisodeData, distance: Option<f64>) -> Finding {
    let sentence = format!(
        "under load the gripper is {:.3} m away from the footprint, whose size is {:.3} m",
        distance.unwrap_or(0.0),
        input.data.size
    );
    let remedy = "check that footprint and poses are in metres, and that the footprint is given in the frame that the \
                  tracker reports";
    Finding::new("place", Severity::Error, sentence, remedy).in_episode(episode.name())
}
