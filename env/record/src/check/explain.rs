//! The best explanation of the wrench by the motion: as stated, or with one mistake in axes or gains undone.

use crate::metadata::{Contact, Frame, Reference};

use super::dynamics::{Blocks, Convention, Fit, Linear, Moments, Readings, WINDOWS, fit, identity};
use super::lags::{self, Lag};
use super::subject::Subject;
use crate::prepare::wrapped;

/// Fewer blocks than this explain nothing.
const FEWEST: usize = 40;
/// Grid of angles, degrees; finer ones follow.
const ANGLES: usize = 18;
/// Grid of gains of torque against force: powers of ten, and steps within one.
const DECADES: i32 = 4;
const PER_DECADE: i32 = 5;
/// The largest gain that is a mistake, or its inverse: a factor of 1000 between units, and a quarter. A share that falls up to the end
/// of the grid only says that one of force and torque is explained better than the other.
const LARGEST: f64 = 1250.0;
/// How much more another frame must help than an angle.
const RARER: f64 = 1.25;
/// Unexplained share as stated from which on something is wrong, and by what factor undoing it must help. Over clean
/// recordings of `tests/record_prepare/varied.py` the best other convention helps by up to 2.3.
pub(crate) const WRONG: (f64, f64) = (0.1, 3.0);
/// The factor for a slight angle of the gripper, and the largest of these, rad.
const TURNED: f64 = 1.4;
pub(crate) const SLIGHT: f64 = std::f64::consts::FRAC_PI_4;
/// Groups of rows that are left out in turn for a standard deviation (jackknife).
const GROUPS: usize = 6;

/// What may be wrong with the axes or units of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mistake {
    /// Nothing.
    None,
    /// Force turned by `angle` (rad) after its y was reversed if `mirrored`; torque of the other sign if `reversed`.
    Turned { angle: f64, mirrored: bool, reversed: bool },
    /// Another frame or reference than stated; of the other sign if `negative`.
    Frame { frame: Frame, reference: Reference, negative: bool },
    /// Angles count clockwise; and the axes are mirrored, if `mirrored`.
    Clockwise { mirrored: bool },
    /// Torque to be multiplied by `gain`.
    Gain { gain: f64 },
}

impl Mistake {
    /// What undoes it.
    pub fn change(&self) -> Linear {
        let turned = |angle: f64, mirrored: bool, torque: f64| {
            let (sin, cos) = angle.sin_cos();
            let flip = if mirrored { -1.0 } else { 1.0 };
            [[cos, -sin * flip, 0.0], [sin, cos * flip, 0.0], [0.0, 0.0, torque]]
        };
        match *self {
            Self::None => identity(),
            Self::Turned { angle, mirrored, reversed } => {
                turned(angle, mirrored, if reversed { -1.0 } else { 1.0 })
            }
            Self::Frame { negative, .. } => identity().map(|row| row.map(|v| if negative { -v } else { v })),
            Self::Clockwise { mirrored } => turned(0.0, mirrored, if mirrored { -1.0 } else { 1.0 }),
            Self::Gain { gain } => turned(0.0, false, gain),
        }
    }

    fn convention(&self, stated: Convention) -> Convention {
        match *self {
            Self::Frame { frame, reference, .. } => Convention { frame, reference, ..stated },
            Self::Clockwise { .. } => Convention { clockwise: true, ..stated },
            _ => stated,
        }
    }
}

/// A mistake undone, the lag that suits it best, and how well a passive body then explains the wrench.
#[derive(Debug, Clone)]
pub(crate) struct Explanation {
    pub mistake: Mistake,
    pub lag: f64,
    pub fit: Fit,
}

/// All that several checks want to know of the wrench and the motion.
pub(crate) struct Explained {
    /// As the recording states it, at the lag that suits best.
    pub stated: Explanation,
    /// The best with one mistake undone; as stated, if none helps so much that it must have been made.
    pub best: Explanation,
    /// Lags under the best.
    pub lag: Lag,
    /// Rows of the best, and their sums by window.
    pub blocks: Blocks,
    pub moments: Vec<Moments>,
}

/// Rows of one convention, and their sums at one lag.
struct Rows {
    convention: Convention,
    blocks: Blocks,
    sum: Moments,
}

/// The best explanation; `None` where there is too little motion for any.
pub(crate) fn explain(subject: &Subject) -> Option<Explained> {
    let convention = Convention::stated(subject);
    let blocks = Blocks::new(subject, convention);
    if blocks.len() < FEWEST {
        return None;
    }
    let readings = Readings::new(subject, |reading| *reading);
    let stated = refined(&blocks, &readings, Mistake::None, 0.0);
    let mut all = vec![Rows { convention, sum: Moments::new(), blocks }];
    for other in others(subject, convention) {
        all.push(Rows { convention: other, blocks: Blocks::new(subject, other), sum: Moments::new() });
    }
    let mut best = stated.clone();
    for lag in if stated.lag == 0.0 { vec![0.0] } else { vec![0.0, stated.lag] } {
        all.iter_mut().for_each(|rows| rows.sum = Moments::sum(&rows.blocks.moments(&readings, lag)));
        let found = search(subject, &all, &stated.fit);
        let rows = all.iter().find(|rows| rows.convention == found.convention(convention))?;
        let found = refined(&rows.blocks, &readings, found, lag);
        if found.fit.share < best.fit.share {
            best = found;
        }
    }
    if !is_made(&stated, &best) {
        best = stated.clone();
    }
    let at = all.iter().position(|rows| rows.convention == best.mistake.convention(convention))?;
    let blocks = all.swap_remove(at).blocks;
    let lag = lags::lag(&blocks, &readings, &best.mistake.change());
    let moments = blocks.moments_at(&readings, &lag.by_window);
    Some(Explained { stated, best, lag, blocks, moments })
}

/// Whether so much is unexplained as stated, and so little once the mistake is undone, that it must have been made.
fn is_made(stated: &Explanation, best: &Explanation) -> bool {
    let gain = stated.fit.share / best.fit.share.max(f64::MIN_POSITIVE);
    match best.mistake {
        Mistake::Turned { angle, mirrored: false, reversed: false } if wrapped(angle).abs() < SLIGHT => {
            gain > TURNED
        }
        Mistake::Gain { gain } if gain.ln().abs() > LARGEST.ln() => false,
        _ => stated.fit.share > WRONG.0 && gain > WRONG.1,
    }
}

/// Conventions that the recording may have instead of the stated one.
fn others(subject: &Subject, stated: Convention) -> Vec<Convention> {
    if subject.meta.on_rail() {
        return vec![];
    }
    let mut others = vec![Convention { clockwise: true, ..stated }];
    for frame in [Frame::Sensor, Frame::Object, Frame::World] {
        for reference in [Reference::Sensor, Reference::Object] {
            let other = Convention { frame, reference, clockwise: false };
            if other != stated && subject.has_gripper() {
                others.push(other);
            }
        }
    }
    others
}

/// The mistake undone at its best lag.
fn refined(blocks: &Blocks, readings: &Readings, mistake: Mistake, lag: f64) -> Explanation {
    let change = mistake.change();
    let first = Moments::sum(&blocks.moments(readings, lag));
    let before = fit(&first, &change, &[]);
    let best = lags::constant(blocks, readings, &change);
    let moments = Moments::sum(&blocks.moments(readings, best));
    let after = fit(&moments, &change, &[]);
    if after.share < before.share {
        Explanation { mistake, lag: best, fit: after }
    } else {
        Explanation { mistake, lag, fit: before }
    }
}

/// The mistake that, undone, leaves least unexplained.
fn search(subject: &Subject, all: &[Rows], start: &Fit) -> Mistake {
    let [stated, others @ ..] = all else { return Mistake::None };
    let share = |rows: &Rows, mistake: &Mistake| fit(&rows.sum, &mistake.change(), &start.terms).share;
    let mut best = (Mistake::None, share(stated, &Mistake::None));
    let mut consider = |mistake: Mistake, share: f64| {
        if share < best.1 {
            best = (mistake, share);
        }
    };
    if subject.meta.on_rail() {
        let turned = Mistake::Turned { angle: std::f64::consts::PI, mirrored: false, reversed: true };
        consider(turned, share(stated, &turned));
        return best.0;
    }
    // A point contact bears no torque whose sign could be wrong.
    let signs: &[bool] =
        if subject.meta.wrench.contact == Contact::Point { &[false] } else { &[false, true] };
    let width = std::f64::consts::TAU / ANGLES as f64;
    for mirrored in [false, true] {
        for &reversed in signs {
            for step in 0..ANGLES {
                let mistake = Mistake::Turned { angle: step as f64 * width, mirrored, reversed };
                consider(mistake, share(stated, &mistake));
            }
        }
    }
    for step in -DECADES * PER_DECADE..=DECADES * PER_DECADE {
        let gain = 10f64.powf(f64::from(step) / f64::from(PER_DECADE));
        consider(Mistake::Gain { gain }, share(stated, &Mistake::Gain { gain }));
    }
    for other in others {
        for mistake in mistakes_of(other.convention) {
            // A free choice of frame is to help clearly more than the next grid angle.
            consider(mistake, RARER * share(other, &mistake));
        }
    }
    match best.0 {
        Mistake::Turned { angle, mirrored, reversed } => {
            let turned = |angle| Mistake::Turned { angle, mirrored, reversed };
            turned(minimum(|a| share(stated, &turned(a)), angle - width, angle + width))
        }
        Mistake::Gain { gain } => {
            let (ln, width) = (gain.ln(), 10f64.ln() / f64::from(PER_DECADE));
            let of = |ln: f64| Mistake::Gain { gain: ln.exp() };
            of(minimum(|ln| share(stated, &of(ln)), ln - width, ln + width))
        }
        other => other,
    }
}

fn mistakes_of(convention: Convention) -> Vec<Mistake> {
    let Convention { frame, reference, clockwise } = convention;
    if clockwise {
        return vec![Mistake::Clockwise { mirrored: false }, Mistake::Clockwise { mirrored: true }];
    }
    [false, true].map(|negative| Mistake::Frame { frame, reference, negative }).to_vec()
}

/// Where `of` is least between `low` and `high`, by golden sections.
pub(crate) fn minimum(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (of(a), of(b));
    for _ in 0..12 {
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = of(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = of(b);
        }
    }
    (low + high) / 2.0
}

impl Explained {
    /// `of` from all rows, and its standard deviation by leaving out each group of windows in turn.
    pub fn jackknife(&self, of: impl Fn(&Moments) -> f64) -> (f64, f64) {
        let whole = of(&Moments::sum(&self.moments));
        let per = self.moments.len().div_ceil(GROUPS.max(self.moments.len() / WINDOWS));
        let groups = self.moments.len().div_ceil(per.max(1));
        let without = |group: usize| {
            let kept = self.moments.iter().enumerate().filter(|(w, _)| w / per.max(1) != group);
            of(&Moments::sum(kept.map(|(_, m)| m)))
        };
        let values: Vec<f64> = (0..groups).map(without).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        (whole, ((n - 1.0) / n * square).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn a_gain_beyond_all_units_is_no_mistake() {
        let explanation = |mistake: Mistake, share: f64| {
            let fit = Fit { share, coefficients: DVector::zeros(0), terms: vec![] };
            Explanation { mistake, lag: 0.0, fit }
        };
        let stated = explanation(Mistake::None, 0.33);
        let made = |gain: f64| is_made(&stated, &explanation(Mistake::Gain { gain }, 0.01));
        assert!(made(1000.0) && made(0.001));
        assert!(!made(9000.0) && !made(1e-4));
    }
}
