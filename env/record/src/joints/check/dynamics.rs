//! Regression of the effort of one joint by the motion of all: inverse dynamics of an unknown mechanism.

use std::f64::consts::FRAC_PI_2;

use super::input::{EpisodeTracks, Input};
use super::regression::Regressors;
use crate::joints::gaussian::smooth;
use crate::joints::tracks::Track;

/// Position of the joint's own acceleration among the regressors.
pub(super) const OWN_INERTIA: usize = 0;
/// Position of the joint's own velocity.
pub(super) const VISCOUS: usize = 1;
/// Position of the sign of the joint's own velocity.
pub(super) const DRY: usize = 2;
/// Position of the constant.
const CONSTANT: usize = 3;
/// Position of sin q of the joint itself, for hinges.
pub(super) const GRAVITY_SIN: usize = 4;
/// Largest number of rows.
const MAX_ROWS: usize = 20_000;
/// Largest number of joints whose motion is part of the regression; more would need more data than an episode has.
const MAX_COUPLED_JOINTS: usize = 8;

/// Which terms a regression has.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Terms {
    /// Constant inertia, friction, and functions of the angles. Few, so that signs that are wrong stay visible.
    Constant,
    /// Also inertia that depends on the angles, and its velocity terms.
    All,
    /// All, and the position, for a drive that follows a target.
    AllAndPosition,
}

/// Rows of the regression of one joint: points of the grids at which the motion is known and the drive is on.
pub(super) struct Rows {
    /// Episode and point of each row.
    pub points: Vec<(usize, usize)>,
    pub regressors: Regressors,
    /// Columns, as given to the regression.
    pub columns: Vec<Vec<f64>>,
}

impl Rows {
    /// The rows of joint `index`. Points within `margin` of the ends of the episodes and of gaps are left out.
    pub fn new(
        input: &Input,
        index: usize,
        uses: &dyn Fn(usize) -> bool,
        margin: usize,
        terms: Terms,
    ) -> Option<Self> {
        let joint = &input.joints[index];
        let mut points = Vec::new();
        for (number, episode) in input.episodes.iter().enumerate().filter(|(number, _)| uses(*number)) {
            let track = &episode.tracks[index];
            let is_on = episode.is_on(index, joint);
            let supported = eroded(&track.valid, margin);
            points.extend((0..track.t.len()).filter(|&k| supported[k] && is_on[k]).map(|k| (number, k)));
        }
        let stride = points.len().div_ceil(MAX_ROWS).max(1);
        let points: Vec<(usize, usize)> = points.into_iter().step_by(stride).collect();
        let columns = columns(input, index, &points, terms);
        Some(Self { regressors: Regressors::new(&columns)?, points, columns })
    }

    /// Values by episode at the points of the rows, `shift` points earlier.
    pub fn pick(&self, values: &[Option<Vec<f64>>], shift: isize) -> Vec<f64> {
        let at = |&(episode, point): &(usize, usize)| {
            let point = point as isize - shift;
            values[episode].as_ref().and_then(|values| values.get(usize::try_from(point).ok()?)).copied()
        };
        self.points.iter().map(|point| at(point).unwrap_or(0.0)).collect()
    }
}

/// Whether all points within `margin` are valid.
fn eroded(valid: &[bool], margin: usize) -> Vec<bool> {
    let mut wrong_before = vec![0_usize; valid.len() + 1];
    for (k, is_valid) in valid.iter().enumerate() {
        wrong_before[k + 1] = wrong_before[k] + usize::from(!is_valid);
    }
    let range = |k: usize| (k.saturating_sub(margin), (k + margin + 1).min(valid.len()));
    let is_clear = |(from, to): (usize, usize)| wrong_before[to] == wrong_before[from];
    (0..valid.len()).map(|k| is_clear(range(k))).collect()
}

/// A function of the track of one joint or of two.
type Feature<'a> = Box<dyn Fn(&[Track], usize) -> f64 + 'a>;

/// The columns at `points`. Functions that are not linear are filtered like the effort, which contains them.
fn columns(input: &Input, index: usize, points: &[(usize, usize)], terms: Terms) -> Vec<Vec<f64>> {
    let (v_noise, v_rms) = input.speeds(index);
    let slow = (3.0 * v_noise).max(0.02 * v_rms).max(f64::MIN_POSITIVE);
    let mut linear: Vec<(usize, Feature)> = vec![
        (OWN_INERTIA, Box::new(move |tracks, k| tracks[index].a[k])),
        (VISCOUS, Box::new(move |tracks, k| tracks[index].v[k])),
        (CONSTANT, Box::new(|_, _| 1.0)),
    ];
    let mut filtered: Vec<(usize, Feature)> =
        vec![(DRY, Box::new(move |tracks, k| (tracks[index].v[k] / slow).tanh()))];
    let mut next = GRAVITY_SIN;
    let mut place = || {
        next += 1;
        next - 1
    };
    let others = (0..input.joints.len().min(MAX_COUPLED_JOINTS)).filter(|&other| other != index);
    if input.may_be_hinge() {
        filtered.push((place(), Box::new(move |tracks, k| tracks[index].q[k].sin())));
        filtered.push((place(), Box::new(move |tracks, k| tracks[index].q[k].cos())));
        for other in others.clone() {
            // Inertia depends on the angle between the links, and its changes give velocity terms.
            for phase in [0.0, FRAC_PI_2].into_iter().filter(|_| terms != Terms::Constant) {
                let turned = move |tracks: &[Track], k: usize| (tracks[other].q[k] + phase).sin();
                filtered.push((place(), Box::new(move |t, k| turned(t, k) * t[index].a[k])));
                filtered.push((place(), Box::new(move |t, k| turned(t, k) * t[other].a[k])));
                filtered.push((place(), Box::new(move |t, k| turned(t, k) * t[other].v[k] * t[other].v[k])));
                filtered.push((place(), Box::new(move |t, k| turned(t, k) * t[other].v[k] * t[index].v[k])));
            }
            // Gravity acts with sums of the angles of a chain, and forces with their differences.
            for sign in [0.0, 1.0, -1.0] {
                let angle = move |tracks: &[Track], k: usize| tracks[other].q[k] + sign * tracks[index].q[k];
                filtered.push((place(), Box::new(move |tracks, k| angle(tracks, k).sin())));
                filtered.push((place(), Box::new(move |tracks, k| angle(tracks, k).cos())));
            }
        }
    }
    if terms == Terms::AllAndPosition {
        linear.push((place(), Box::new(move |tracks, k| tracks[index].q[k])));
    }
    for other in others {
        linear.push((place(), Box::new(move |tracks, k| tracks[other].a[k])));
    }
    let mut all = vec![Vec::new(); linear.len() + filtered.len()];
    for (at, feature) in linear {
        all[at] = points.iter().map(|&(e, k)| feature(&input.episodes[e].tracks, k)).collect();
    }
    for (at, feature) in filtered {
        all[at] = pick_filtered(input, points, &feature);
    }
    all
}

fn pick_filtered(input: &Input, points: &[(usize, usize)], feature: &Feature) -> Vec<f64> {
    let values = |episode: &EpisodeTracks| {
        let tracks = &episode.tracks;
        let all: Vec<f64> = (0..tracks[0].t.len()).map(|k| feature(tracks, k)).collect();
        smooth(&all, tracks[0].width)
    };
    let episodes: Vec<Vec<f64>> = input.episodes.iter().map(values).collect();
    points.iter().map(|&(e, k)| episodes[e][k]).collect()
}
