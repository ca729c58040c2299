//! Whether the gripper is where it must be to push the object as stated.

use nalgebra::{DMatrix, DVector};
use trundle_model::Fixture;

use crate::metadata::{Contact, Frame, Reference};
use crate::prepare::{WrenchSample, median, quantile};

use super::gripper::frozen_in;
use super::group::grouped;
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Spread of a firm grasp in the object frame that noise and streams out of step explain: standard deviations, and
/// share of the object's size.
const SLIP: (f64, f64) = (8.0, 0.03);
/// A reading of so many standard deviations is felt; what feels nothing for so long, s, may hold elsewhere afterwards.
const FELT: f64 = 6.0;
const APART: f64 = 0.5;
/// Delays with which a compliant grasp gives way, in shares of the time held.
const DELAYS: [f64; 2] = [0.0, 0.02];
/// How far outside of the footprint a gripper reaches the object, in its sizes.
const REACH: f64 = 1.0;

/// Whether the reading's origin is the gripper, so that the frames show where it is.
fn at_gripper(subject: &Subject) -> bool {
    subject.reference() == Reference::Sensor && !subject.meta.on_rail() && subject.size > 0.0
}

/// Where the gripper is in the object frame from contact on: x, y, angle.
fn held_at(look: &Look) -> Vec<[f64; 3]> {
    look.prepared.wrench.iter().filter(|w| w.t >= look.prepared.contact).map(|w| w.frame).collect()
}

/// The same of each time that it holds and is felt, with the reading: one that has let go is free to move.
fn held_each(subject: &Subject, look: &Look) -> Vec<Vec<WrenchSample>> {
    let noise = &subject.dataset.noise;
    let felt =
        |[x, y, torque]: [f64; 3]| x.hypot(y) > FELT * noise.force || torque.abs() > FELT * noise.torque;
    let (mut holds, mut last) = (vec![], f64::NEG_INFINITY);
    for w in look.prepared.wrench.iter().filter(|w| w.t >= look.prepared.contact && felt(w.reading)) {
        if w.t - last > APART {
            holds.push(vec![]);
        }
        last = w.t;
        holds.last_mut().into_iter().for_each(|hold| hold.push(w.clone()));
    }
    holds
}

/// A gripper that is said to grasp but wanders on the object.
pub(crate) fn slip(subject: &Subject) -> Vec<Finding> {
    if !at_gripper(subject) || subject.meta.wrench.contact != Contact::Grasp {
        return vec![];
    }
    let firm = |look: &&Look| frozen_in(subject, look).is_none();
    let looks: Vec<_> =
        subject.episodes.iter().filter(firm).map(|look| (look, held_each(subject, look))).collect();
    let all: Vec<&[WrenchSample]> =
        looks.iter().flat_map(|(_, holds)| holds.iter().map(Vec::as_slice)).collect();
    let Some(wanders) = wanders(&all) else { return vec![] };
    let mut wanders = wanders.into_iter();
    let furthest = |holds: &Vec<_>| wanders.by_ref().take(holds.len()).fold(0.0, f64::max);
    let furthest: Vec<f64> = looks.iter().map(|(_, holds)| holds).map(furthest).collect();
    grouped(looks.iter().zip(furthest).filter_map(|((look, _), far)| slips(subject, look, far)).collect())
}

fn slips(subject: &Subject, look: &Look, wander: f64) -> Option<(f64, Finding)> {
    let sd = subject.dataset.noise.pose;
    let arm = sd[2] * subject.size; // the heading's noise moves the grasp too
    let explained = (SLIP.0 * (sd[0].max(sd[1]) + arm)).max(SLIP.1 * subject.size);
    (wander > explained + out_of_step(look)).then(|| {
        let sentence =
            format!("the gripper is said to grasp, but wanders by {:.0} mm on the object", 1e3 * wander);
        let remedy = "set wrench.contact = \"point\" if it only pushes; otherwise it slips, or a pose or its angle \
                      is wrong";
        (wander, Finding::new("grasp", Severity::Warning, sentence, remedy).of(look.name()))
    })
}

/// How far the gripper wanders on the object in each hold beyond what the load explains, m: a compliant grasp gives way
/// to the load, at once or with a delay, comes back, and is as compliant each time; a slip is not. Where it holds
/// is not known: each hold is compared with its own mean.
fn wanders(holds: &[&[WrenchSample]]) -> Option<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = vec![];
    let mut places: [Vec<f64>; 2] = [vec![], vec![]];
    for held in holds {
        let span = held.last()?.t - held.first()?.t;
        let loads: Vec<(f64, [f64; 3])> = held.iter().map(|w| (w.t, load(w))).collect();
        let columns = DELAYS.iter().flat_map(|share| (0..3).map(move |axis| (axis, share * span)));
        let columns: Vec<Vec<f64>> =
            columns.map(|(axis, lag)| centred(delayed(&loads, axis, lag))).collect::<Option<_>>()?;
        rows.extend((0..held.len()).map(|i| columns.iter().map(|c| c[i]).collect::<Vec<f64>>()));
        for (axis, place) in places.iter_mut().enumerate() {
            place.extend(centred(held.iter().map(|w| w.frame[axis]).collect())?);
        }
    }
    let columns = rows.first()?.len();
    let design = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
    let scale: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let design = DMatrix::from_fn(rows.len(), columns, |i, j| design[(i, j)] / scale[j]);
    let ridge = DMatrix::identity(columns, columns) * 1e-9;
    let solver = (design.transpose() * &design + ridge).cholesky()?;
    let left = places.map(|place| {
        let place = DVector::from_vec(place);
        &place - &design * solver.solve(&(design.transpose() * &place))
    });
    let mut first = 0;
    let spread = |held: &&[WrenchSample]| {
        let rest = |k: usize| left[k].rows(first, held.len()).iter().copied().collect::<Vec<f64>>();
        let (x, y) = (rest(0), rest(1));
        first += held.len();
        let wide = |rest: &[f64]| {
            Some(quantile(rest.iter().copied(), 0.95)? - quantile(rest.iter().copied(), 0.05)?)
        };
        Some(wide(&x)?.hypot(wide(&y)?))
    };
    holds.iter().map(spread).collect()
}

/// Numbers less their mean; `None` where there are none.
fn centred(mut values: Vec<f64>) -> Option<Vec<f64>> {
    let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)?;
    values.iter_mut().for_each(|value| *value -= mean);
    Some(values)
}

/// What loads a grasp: the force in object axes, in which its place is given too, and the torque about it.
fn load(w: &WrenchSample) -> [f64; 3] {
    let ([x, y, torque], (sin, cos)) = (w.reading, w.frame[2].sin_cos());
    [cos * x - sin * y, sin * x + cos * y, torque]
}

/// One axis of a load through a first-order lag, s.
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

/// How far the object goes between two poses: streams out of step are apart by that, m.
fn out_of_step(look: &Look) -> f64 {
    let steps = look
        .prepared
        .pose
        .windows(2)
        .map(|pair| (pair[1].pose[0] - pair[0].pose[0]).hypot(pair[1].pose[1] - pair[0].pose[1]));
    2.0 * quantile(steps, 0.95).unwrap_or(0.0)
}

/// A gripper that cannot reach the footprint.
pub(crate) fn place(subject: &Subject) -> Vec<Finding> {
    if !at_gripper(subject) || subject.meta.wrench.frame == Frame::Object {
        return vec![];
    }
    let distances = |look: &Look| {
        let frames = held_at(look);
        median(frames.iter().map(|f| outside(&subject.dataset.body.fixtures, [f[0], f[1]])))
    };
    let far = |look: &&Look| distances(look).is_some_and(|d| d > REACH * subject.size);
    subject
        .episodes
        .iter()
        .filter(far)
        .take(1)
        .map(|look| unreachable(subject, look, distances(look)))
        .collect()
}

fn unreachable(subject: &Subject, look: &Look, distance: Option<f64>) -> Finding {
    let sentence = format!(
        "in contact the gripper is {:.3} m away from the footprint, which measures {:.3} m",
        distance.unwrap_or(0.0),
        subject.size
    );
    let remedy = "check that footprint and poses are all in metres, and that the footprint is drawn about the \
                  tracker's frame";
    Finding::new("place", Severity::Error, sentence, remedy).of(look.name())
}

/// Distance of a point from the nearest corner or centre of the shape less that one's radius; a rough measure,
/// never more than the size of the shape too large, m.
fn outside(shape: &[Fixture], point: [f64; 2]) -> f64 {
    let from = |corner: &[f64; 2]| (corner[0] - point[0]).hypot(corner[1] - point[1]);
    let distance = |fixture: &Fixture| match fixture {
        Fixture::Polygon { vertices, .. } => vertices.iter().map(from).fold(f64::INFINITY, f64::min),
        Fixture::Disc { center, radius, .. } => from(center) - radius,
    };
    shape.iter().map(distance).fold(f64::INFINITY, f64::min).max(0.0)
}
