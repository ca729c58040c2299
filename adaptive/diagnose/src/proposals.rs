//! Proposals of shapes: where, when and in which form each candidate effect may act.
//!
//! An effect has amplitudes, listed in [`trundle_model::Spec::neutral`], at whose neutral values it vanishes.
//! Its other parameters are its shape. Amplitudes follow from the data by one Newton step. Shapes are
//! proposed here over the visited region.

use crate::contact_candidates::ContactCandidate;
use crate::periods::Line;
use crate::ridge_candidates::RidgeCandidate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trundle_infer::Coordinates;
use trundle_model::{Body, Effect, Kind, Model, Param, Prior, Proposal, State, to_world};
use trundle_record::Prepared;

/// Hints from the data about where effects act.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hints<'a> {
    /// Places where the object may have touched an obstacle.
    pub contacts: &'a [ContactCandidate],
    /// Parts of the floor that seem to add friction: convex polygons, world, m.
    pub regions: &'a [Vec<[f64; 2]>],
    /// Lines across the floor at which a force is missing.
    pub ridges: &'a [RidgeCandidate],
    /// Periods in position of the missing force.
    pub lines: &'a [Line],
}

/// Number of drawn shapes for an effect with up to two shape parameters, and with more.
const SHAPE_DRAWS: [usize; 2] = [16, 48];

/// Penetration depths of an obstacle at the largest force, m: contacts yield by millimetres.
const PENETRATION_DEPTHS_M: [f64; 3] = [0.001, 0.003, 0.01];

/// Radii of obstacles, m: a table leg, a post, a bin. A fit cannot change the radius, because the centre
/// would have to move with it.
const OBSTACLE_RADII_M: [f64; 3] = [0.02, 0.05, 0.15];

/// Time between the proposed times of an event, s.
const EVENT_SPACING_S: f64 = 0.4;

/// Whether the effect vanishes at the parameter's neutral value. Refinements do not count if there are other
/// amplitudes.
pub(crate) fn is_amplitude(kind: Kind, param: &Param) -> bool {
    let neutral = kind.spec().neutral;
    (param.refinement.is_none() || neutral.len() == 1) && neutral.iter().any(|(name, _)| *name == param.name)
}

/// An effect with neutral amplitudes, and with refinements at the simple law.
fn neutral(kind: Kind, body: &Body) -> Effect {
    let mut effect = Effect::free(kind);
    for (name, value) in kind.spec().neutral {
        let param = kind.spec().params.iter().find(|p| p.name == *name);
        // NaN stands for the body's own value, a coordinate of its mass centre.
        let own = param.map_or(0.0, |p| if let Prior::OnBody(axis) = p.prior { body.com[axis] } else { 0.0 });
        effect = effect.with(name, Some(if value.is_nan() { own } else { *value }));
    }
    effect
}

/// Parameters that determine where, when and in which form an effect acts.
fn shape(model: &Model, kind: Kind) -> Vec<&'static Param> {
    let rail = model.on_rail();
    let own = |p: &&Param| p.refinement.is_none() && !is_amplitude(kind, p) && (p.on_rail || !rail);
    kind.spec().params.iter().filter(own).collect()
}

/// Whether a kind of effect has more than one place, time or form.
pub(crate) fn has_shape(model: &Model, kind: Kind) -> bool {
    !shape(model, kind).is_empty()
}

/// Proposed shapes of a kind of effect, with neutral amplitudes.
pub(crate) fn proposals(
    model: &Model,
    kind: Kind,
    episodes: &[Prepared],
    hints: &Hints<'_>,
    seed: u64,
) -> Vec<Effect> {
    let (body, source) = (&model.body, kind.proposal());
    let neutral = neutral(kind, body);
    let derived: Vec<Effect> = match source {
        Proposal::ContactCandidate => {
            hints.contacts.iter().flat_map(|contact| obstacles(&neutral, contact)).collect()
        }
        Proposal::ReadingRange => vec![saturation(neutral.clone(), episodes)],
        Proposal::EventTime => event_times(episodes).map(|moment| event(&neutral, moment)).collect(),
        Proposal::Region => hints.regions.iter().filter_map(|region| patch(&neutral, region)).collect(),
        Proposal::Ridge => hints.ridges.iter().map(|ridge| line(&neutral, ridge)).collect(),
        Proposal::Period => hints.lines.iter().flat_map(|line| ripples(&neutral, line)).collect(),
        Proposal::Random => vec![],
    };
    if matches!(
        source,
        Proposal::ContactCandidate | Proposal::Ridge | Proposal::ReadingRange | Proposal::EventTime
    ) {
        return derived;
    }
    let shape = shape(model, kind);
    if shape.is_empty() {
        return vec![neutral];
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let draws = 0..SHAPE_DRAWS[usize::from(shape.len() > 2)];
    let drawn = draws.map(|_| drawn(model, kind, &shape, episodes, &mut rng));
    derived.into_iter().chain(drawn).collect()
}

/// Phases that are proposed for a force of known period.
const PHASES: usize = 8;

/// An event at a time of an episode.
fn event(neutral: &Effect, (episode, t): (usize, f64)) -> Effect {
    neutral.clone().with("episode", Some(episode as f64)).with("time", Some(t))
}

/// Forces with a period of the missing force.
fn ripples(neutral: &Effect, line: &Line) -> Vec<Effect> {
    let ripple = neutral.clone().with("period", Some(line.period)).with("angle", Some(line.angle));
    let phase = |k: usize| std::f64::consts::TAU * k as f64 / PHASES as f64;
    (0..PHASES).map(|k| ripple.clone().with("phase", Some(phase(k)))).collect()
}

/// A ridge along a line across the floor.
fn line(neutral: &Effect, ridge: &RidgeCandidate) -> Effect {
    neutral.clone().with("angle", Some(ridge.angle)).with("offset", Some(ridge.offset))
}

/// The smallest patch that covers a region of the floor and lies along one of its edges.
fn patch(neutral: &Effect, region: &[[f64; 2]]) -> Option<Effect> {
    let edges = region.iter().zip(region.iter().cycle().skip(1));
    let around = edges.map(|(a, b)| {
        let angle = (b[1] - a[1]).atan2(b[0] - a[0]);
        let (sin, cos) = angle.sin_cos();
        let along = span(region.iter().map(|[x, y]| cos * x + sin * y));
        let across = span(region.iter().map(|[x, y]| cos * y - sin * x));
        let [u, v] = [along, across].map(|[low, high]| (low + high) / 2.0);
        let [length, width] = [along, across].map(|[low, high]| (high - low) / 2.0);
        ([cos * u - sin * v, sin * u + cos * v], [length, width], angle)
    });
    let ([x, y], [length, width], angle) =
        around.min_by(|a, b| (a.1[0] * a.1[1]).total_cmp(&(b.1[0] * b.1[1])))?;
    let patch = neutral.clone().with("x", Some(x)).with("y", Some(y)).with("angle", Some(angle));
    Some(patch.with("half_length", Some(length)).with("half_width", Some(width)))
}

/// Quantile of the readings of an axis at which its limit is proposed. Noise exceeds the limit.
const LIMIT_QUANTILE: f64 = 0.99;

/// A saturation at the largest readings. A higher limit changes nothing, and a much lower one contradicts the
/// data.
fn saturation(neutral: Effect, episodes: &[Prepared]) -> Effect {
    let limit = |k: usize| {
        let mut sizes: Vec<f64> =
            episodes.iter().flat_map(|e| &e.wrench).map(|w| w.reading[k].abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get((LIMIT_QUANTILE * sizes.len() as f64) as usize).copied().unwrap_or(0.0)
    };
    let names = [("limit_x", 0), ("limit_y", 1), ("limit_torque", 2)];
    let least = |name: &str| {
        let param = neutral.kind.spec().params.iter().find(|p| p.name == name);
        param.map_or(0.0, |p| p.lower)
    };
    let limits = names.map(|(name, k)| (name, limit(k).max(least(name))));
    limits.into_iter().fold(neutral, |e, (name, limit)| e.with(name, Some(limit)))
}

fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// Obstacles of several sizes and penetration depths at a contact.
fn obstacles(neutral: &Effect, contact: &ContactCandidate) -> Vec<Effect> {
    let of = |radius: f64, depth: f64| {
        let [x, y] = [0, 1].map(|k| contact.at[k] + (radius - depth) * contact.normal[k]);
        neutral.clone().with("x", Some(x)).with("y", Some(y)).with("radius", Some(radius))
    };
    OBSTACLE_RADII_M.iter().flat_map(|&radius| PENETRATION_DEPTHS_M.map(|depth| of(radius, depth))).collect()
}

/// Proposed times of events, from each training episode's contact on.
fn event_times(episodes: &[Prepared]) -> impl Iterator<Item = (usize, f64)> {
    episodes.iter().flat_map(|e| {
        let (first, last) = match (e.pose.first(), e.pose.last()) {
            (Some(first), Some(last)) => (first.t.max(e.contact), last.t),
            _ => (0.0, -1.0),
        };
        let count = ((last - first) / EVENT_SPACING_S).max(0.0) as usize;
        // The last interval of an episode contains too little data; the start of the next episode stands for
        // it.
        (0..count).map(move |k| (e.ordinal, first + k as f64 * EVENT_SPACING_S))
    })
}

fn drawn(
    model: &Model,
    kind: Kind,
    shape: &[&'static Param],
    episodes: &[Prepared],
    rng: &mut ChaCha8Rng,
) -> Effect {
    let alone = Model { effects: vec![Effect::free(kind)], ..model.clone() };
    let coordinates = Coordinates::new(&alone);
    let values = coordinates.values(&coordinates.draw(rng)).0;
    let params = kind.spec().params;
    let mut effect = neutral(kind, &model.body);
    let mut visited = None;
    for param in shape {
        let index = params.iter().position(|p| p.name == param.name).unwrap_or(0);
        let mut value = values.get(1 + index).copied().unwrap_or(0.0);
        if is_place(param) {
            let place = *visited.get_or_insert_with(|| visited_point(&model.body, episodes, rng));
            value = place[usize::from(param.name.ends_with('y'))];
        }
        effect = effect.with(param.name, Some(value));
    }
    effect
}

/// Shapes near given ones, within `share` of a metre, of an e-fold or of a radian.
pub(crate) fn nearby(model: &Model, parents: &[Effect], share: f64, seed: u64) -> Vec<Effect> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ share.to_bits());
    let child = |parent: &Effect, rng: &mut ChaCha8Rng| {
        let neutral = neutral(parent.kind, &model.body);
        let params = parent.kind.spec().params.iter();
        let mut effect = parent.clone();
        for ((param, value), neutral) in params.zip(&mut effect.values).zip(&neutral.values) {
            let shape = param.refinement.is_none() && !is_amplitude(parent.kind, param);
            *value = match value {
                Some(at) if shape => Some(moved(param, *at, share * rng.random_range(-1.0..=1.0))),
                _ => *neutral,
            };
        }
        effect
    };
    parents
        .iter()
        .flat_map(|p| (0..CHILDREN_PER_PARENT).map(|_| child(p, &mut rng)).collect::<Vec<_>>())
        .collect()
}

/// Number of shapes that are tried around each parent.
const CHILDREN_PER_PARENT: usize = 8;

fn moved(param: &Param, value: f64, by: f64) -> f64 {
    let moved = match param.prior {
        Prior::LogNormal { .. } => value * by.exp(),
        _ => value + by,
    };
    moved.clamp(param.lower, param.upper)
}

/// Whether a shape parameter is a coordinate in the world.
fn is_place(param: &Param) -> bool {
    param.unit == "m" && matches!(param.prior, Prior::Normal { .. })
}

/// A point in the world that a part of the body covered at some time.
fn visited_point(body: &Body, episodes: &[Prepared], rng: &mut ChaCha8Rng) -> [f64; 2] {
    let Some(episode) = episodes.get(rng.random_range(0..episodes.len().max(1))) else { return [0.0; 2] };
    let Some(sample) = episode.pose.get(rng.random_range(0..episode.pose.len().max(1))) else {
        return [0.0; 2];
    };
    let [low, high] = body.bounds();
    let point = [0, 1].map(|k| low[k] + (high[k] - low[k]) * rng.random_range(0.0..=1.0));
    let pose = State::at_rest(sample.pose).pose;
    let [x, y, _]: [f64; 3] = to_world([point[0], point[1], 0.0], pose[2]);
    [pose[0] + x, pose[1] + y]
}

/// Whether any of the kinds is proposed from the missing wrench along the episodes.
pub(crate) fn needs_courses(kinds: &[Kind]) -> bool {
    let is_from_wrench = |kind: &Kind| {
        matches!(kind.proposal(), Proposal::ContactCandidate | Proposal::Ridge | Proposal::Period)
    };
    kinds.iter().any(is_from_wrench)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{Hints, event_times, nearby, proposals};
    use trundle_fixtures::{World, locked, table};
    use trundle_model::{Kind, Model};

    fn values(effect: &trundle_model::Effect) -> Vec<f64> {
        effect.values.iter().map(|v| v.unwrap()).collect()
    }

    #[test]
    fn a_patch_is_proposed_where_the_floor_drags() {
        // A rotated rectangle of 1.0 m by 0.4 m with one corner cut off.
        let (sin, cos) = 0.4f64.sin_cos();
        let turned = |[u, v]: [f64; 2]| [1.0 + cos * u - sin * v, -2.0 + sin * u + cos * v];
        let region = [[-0.5, -0.2], [0.5, -0.2], [0.5, 0.1], [0.4, 0.2], [-0.5, 0.2]].map(turned).to_vec();
        let model = Model::nominal(table(), None, [true; 3]);
        let hints = Hints { regions: std::slice::from_ref(&region), ..Hints::default() };
        let found = proposals(&model, Kind::FloorPatch, &World::of(locked()).pushes(2, 1), &hints, 0);
        let outline = Kind::FloorPatch.region(&values(&found[0])).unwrap();
        for corner in region.iter().filter(|c| **c != region[2] && **c != region[3]) {
            let near = outline.iter().map(|p| (p[0] - corner[0]).hypot(p[1] - corner[1]));
            assert!(near.fold(f64::INFINITY, f64::min) < 1e-9, "{corner:?} of {outline:?}");
        }
    }

    #[test]
    fn moments_lie_between_contact_and_the_end() {
        let episodes = World::of(locked()).pushes(3, 1);
        let all: Vec<_> = event_times(&episodes).collect();
        assert!(all.len() > 30);
        for (episode, t) in all {
            let of = &episodes[episode];
            assert!(t >= of.contact && t < of.pose.last().unwrap().t, "{episode} {t}");
        }
    }

    #[test]
    fn neighbours_are_near_and_bounded() {
        let model = Model::nominal(table(), None, [true; 3]);
        let episodes = World::of(locked()).pushes(1, 1);
        let parents = proposals(&model, Kind::Tether, &episodes, &Hints::default(), 0);
        let neighbours = nearby(&model, &parents[..1], 0.1, 1);
        assert!(!neighbours.is_empty());
        for child in &neighbours {
            for ((param, a), b) in
                Kind::Tether.spec().params.iter().zip(values(&parents[0])).zip(values(child))
            {
                assert!((param.lower..=param.upper).contains(&b), "{}: {b}", param.name);
                assert!((a - b).abs() <= 0.1 + 0.11 * a.abs(), "{}: {a} {b}", param.name);
            }
        }
    }
}
