//! Search for a mistake in axes, frames or gains. The wrench is fitted by the motion of a passive body, as stated and with
//! each possible mistake corrected.

use crate::metadata::{Contact, Frame, Reference};

use super::data::RecordingData;
use super::dynamics::{
    Blocks, Convention, Fit, LoadTransform, NormalEquations, Readings, WINDOWS_PER_EPISODE, fit, identity,
};
use super::lags::{self, Lag};
use crate::prepare::wrapped;

/// Minimum number of blocks for a fit.
const MIN_BLOCKS: usize = 40;
/// Number of grid points over a full rotation; the best one is refined.
const ANGLE_STEPS: usize = 18;
/// Decades on either side of 1 in the grid of gains of the torque.
const GAIN_DECADES: i32 = 4;
/// Grid points per decade.
const GAIN_STEPS_PER_DECADE: i32 = 5;
/// Maximum gain, or inverse gain, that can be a mistake of units: a factor of 1000 with a margin. An optimum near the end of
/// the grid only shows that the fit explains one of force and torque better than the other.
const MAX_GAIN: f64 = 1250.0;
/// Factor on the unexplained share of another frame, so that a frame must help clearly more than a rotation.
const FRAME_PENALTY: f64 = 1.25;
/// Minimum unexplained share as stated for a mistake.
pub(crate) const MIN_STATED_MISFIT: f64 = 0.1;
/// Minimum factor by which the correction of a mistake reduces the unexplained share. In clean recordings of
/// `tests/record_prepare/varied.py`, the best other convention reduces it by up to 2.3.
const MIN_IMPROVEMENT: f64 = 3.0;
/// The same factor for a small rotation of the gripper.
const MIN_SMALL_ROTATION_IMPROVEMENT: f64 = 1.4;
/// Upper limit of a small rotation, rad.
pub(crate) const MAX_SMALL_ROTATION_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Minimum number of groups of the jackknife.
const JACKKNIFE_GROUPS: usize = 6;

/// A possible mistake in the axes or units of the wrench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mistake {
    /// No mistake.
    None,
    /// The correction reverses the y axis of the force if `mirrored`, rotates the force by `angle` (rad), and negates the
    /// torque if `reversed`.
    Rotation { angle: f64, mirrored: bool, reversed: bool },
    /// The wrench has another frame or reference than stated, and the opposite sign if `negative`.
    Frame { frame: Frame, reference: Reference, negative: bool },
    /// Angles count clockwise, and the axes are mirrored if `mirrored`.
    Clockwise { mirrored: bool },
    /// The torque must be multiplied by `gain`.
    Gain { gain: f64 },
}

impl Mistake {
    /// The transform of the wrench that corrects the mistake.
    pub fn correction(&self) -> LoadTransform {
        let rotation = |angle: f64, mirrored: bool, torque: f64| {
            let (sin, cos) = angle.sin_cos();
            let flip = if mirrored { -1.0 } else { 1.0 };
            [[cos, -sin * flip, 0.0], [sin, cos * flip, 0.0], [0.0, 0.0, torque]]
        };
        match *self {
            Self::None => identity(),
            Self::Rotation { angle, mirrored, reversed } => {
                rotation(angle, mirrored, if reversed { -1.0 } else { 1.0 })
            }
            Self::Frame { negative, .. } => identity().map(|row| row.map(|v| if negative { -v } else { v })),
            Self::Clockwise { mirrored } => rotation(0.0, mirrored, if mirrored { -1.0 } else { 1.0 }),
            Self::Gain { gain } => rotation(0.0, false, gain),
        }
    }

    /// Number of statements about the wrench that are wrong. Each must help as much as a single one: the data may hardly
    /// depend on one of them, such as the reference in a push without torque.
    fn changes(&self, stated: Convention) -> i32 {
        match *self {
            Self::None => 0,
            Self::Frame { frame, reference, negative } => {
                i32::from(frame != stated.frame)
                    + i32::from(reference != stated.reference)
                    + i32::from(negative)
            }
            _ => 1,
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

/// A corrected mistake with its best lag, and the fit of a passive body.
#[derive(Debug, Clone)]
pub(crate) struct CorrectedFit {
    pub mistake: Mistake,
    pub lag: f64,
    pub fit: Fit,
}

/// Fits of the wrench by the motion, shared by several checks.
pub(crate) struct WrenchFits {
    /// Fit of the wrench as stated, at its best lag.
    pub stated: CorrectedFit,
    /// Best fit with one mistake corrected; equal to `stated` if no correction helps enough.
    pub best: CorrectedFit,
    /// Lags of the best fit.
    pub lag: Lag,
    /// Blocks of the best fit.
    pub blocks: Blocks,
    /// Normal equations of the best fit by window.
    pub equations: Vec<NormalEquations>,
}

/// Blocks under one convention, and their normal equations at one lag.
struct ConventionBlocks {
    convention: Convention,
    blocks: Blocks,
    sum: NormalEquations,
}

/// Fits the wrench and searches for a mistake; `None` if there is too little motion.
pub(crate) fn fit_wrench(data: &RecordingData) -> Option<WrenchFits> {
    let convention = Convention::stated(data);
    let blocks = Blocks::new(data, convention);
    if blocks.len() < MIN_BLOCKS {
        return None;
    }
    let readings = Readings::new(data, |reading| *reading);
    let stated = refined(&blocks, &readings, Mistake::None, 0.0);
    let mut all = vec![ConventionBlocks { convention, sum: NormalEquations::new(), blocks }];
    for other in other_conventions(data, convention) {
        all.push(ConventionBlocks {
            convention: other,
            blocks: Blocks::new(data, other),
            sum: NormalEquations::new(),
        });
    }
    let mut best = stated.clone();
    for lag in if stated.lag == 0.0 { vec![0.0] } else { vec![0.0, stated.lag] } {
        all.iter_mut()
            .for_each(|rows| rows.sum = NormalEquations::sum(&rows.blocks.normal_equations(&readings, lag)));
        let found = search(data, &all, &stated.fit);
        let rows = all.iter().find(|rows| rows.convention == found.convention(convention))?;
        let found = refined(&rows.blocks, &readings, found, lag);
        if found.fit.unexplained < best.fit.unexplained {
            best = found;
        }
    }
    if !is_mistake(&stated, &best) {
        best = stated.clone();
    }
    let at = all.iter().position(|rows| rows.convention == best.mistake.convention(convention))?;
    let blocks = all.swap_remove(at).blocks;
    let lag = lags::lag(&blocks, &readings, &best.mistake.correction());
    let equations = blocks.normal_equations_at(&readings, &lag.by_window);
    Some(WrenchFits { stated, best, lag, blocks, equations })
}

/// Whether the improvement by the correction of `best` is large enough to report the mistake.
fn is_mistake(stated: &CorrectedFit, best: &CorrectedFit) -> bool {
    let gain = stated.fit.unexplained / best.fit.unexplained.max(f64::MIN_POSITIVE);
    match best.mistake {
        Mistake::Rotation { angle, mirrored: false, reversed: false }
            if wrapped(angle).abs() < MAX_SMALL_ROTATION_RAD =>
        {
            gain > MIN_SMALL_ROTATION_IMPROVEMENT
        }
        Mistake::Gain { gain } if gain.ln().abs() > MAX_GAIN.ln() => false,
        _ => stated.fit.unexplained > MIN_STATED_MISFIT && gain > MIN_IMPROVEMENT,
    }
}

/// Conventions other than the stated one.
fn other_conventions(data: &RecordingData, stated: Convention) -> Vec<Convention> {
    if data.meta.on_rail() {
        return vec![];
    }
    let mut others = vec![Convention { clockwise: true, ..stated }];
    for frame in [Frame::Sensor, Frame::Object, Frame::World] {
        for reference in [Reference::Sensor, Reference::Object] {
            let other = Convention { frame, reference, clockwise: false };
            if other != stated && data.has_gripper() {
                others.push(other);
            }
        }
    }
    others
}

/// The corrected fit at `lag` or at the best constant lag, whichever explains more.
fn refined(blocks: &Blocks, readings: &Readings, mistake: Mistake, lag: f64) -> CorrectedFit {
    let correction = mistake.correction();
    let first = NormalEquations::sum(&blocks.normal_equations(readings, lag));
    let before = fit(&first, &correction, &[]);
    let best = lags::constant(blocks, readings, &correction);
    let equations = NormalEquations::sum(&blocks.normal_equations(readings, best));
    let after = fit(&equations, &correction, &[]);
    if after.unexplained < before.unexplained {
        CorrectedFit { mistake, lag: best, fit: after }
    } else {
        CorrectedFit { mistake, lag, fit: before }
    }
}

/// The mistake whose correction minimises the unexplained share.
fn search(data: &RecordingData, all: &[ConventionBlocks], start: &Fit) -> Mistake {
    let [stated, others @ ..] = all else { return Mistake::None };
    let share = |rows: &ConventionBlocks, mistake: &Mistake| {
        fit(&rows.sum, &mistake.correction(), &start.terms).unexplained
    };
    let mut best = (Mistake::None, share(stated, &Mistake::None));
    let mut consider = |mistake: Mistake, share: f64| {
        if share < best.1 {
            best = (mistake, share);
        }
    };
    if data.meta.on_rail() {
        let reversed = Mistake::Rotation { angle: std::f64::consts::PI, mirrored: false, reversed: true };
        consider(reversed, share(stated, &reversed));
        return best.0;
    }
    // A point contact transmits no torque whose sign could be wrong.
    let signs: &[bool] = if data.meta.wrench.contact == Contact::Point { &[false] } else { &[false, true] };
    let width = std::f64::consts::TAU / ANGLE_STEPS as f64;
    for mirrored in [false, true] {
        for &reversed in signs {
            for step in 0..ANGLE_STEPS {
                let mistake = Mistake::Rotation { angle: step as f64 * width, mirrored, reversed };
                consider(mistake, share(stated, &mistake));
            }
        }
    }
    for step in -GAIN_DECADES * GAIN_STEPS_PER_DECADE..=GAIN_DECADES * GAIN_STEPS_PER_DECADE {
        let gain = 10f64.powf(f64::from(step) / f64::from(GAIN_STEPS_PER_DECADE));
        consider(Mistake::Gain { gain }, share(stated, &Mistake::Gain { gain }));
    }
    for other in others {
        for mistake in mistakes_of(other.convention) {
            let further = (mistake.changes(stated.convention) - 1).max(0);
            let penalty = FRAME_PENALTY * MIN_IMPROVEMENT.powi(further);
            consider(mistake, penalty * share(other, &mistake));
        }
    }
    match best.0 {
        Mistake::Rotation { angle, mirrored, reversed } => {
            let rotation = |angle| Mistake::Rotation { angle, mirrored, reversed };
            rotation(minimum(|a| share(stated, &rotation(a)), angle - width, angle + width))
        }
        Mistake::Gain { gain } => {
            let (ln, width) = (gain.ln(), 10f64.ln() / f64::from(GAIN_STEPS_PER_DECADE));
            let gain = |ln: f64| Mistake::Gain { gain: ln.exp() };
            gain(minimum(|ln| share(stated, &gain(ln)), ln - width, ln + width))
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

/// Minimiser of `objective` between `low` and `high`, by a golden-section search.
pub(crate) fn minimum(objective: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (objective(a), objective(b));
    for _ in 0..12 {
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = objective(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = objective(b);
        }
    }
    (low + high) / 2.0
}

impl WrenchFits {
    /// The value of `estimate` from all windows, and its standard deviation by a jackknife over groups of windows.
    pub fn jackknife(&self, estimate: impl Fn(&NormalEquations) -> f64) -> (f64, f64) {
        let value = estimate(&NormalEquations::sum(&self.equations));
        let per =
            self.equations.len().div_ceil(JACKKNIFE_GROUPS.max(self.equations.len() / WINDOWS_PER_EPISODE));
        let groups = self.equations.len().div_ceil(per.max(1));
        let without = |group: usize| {
            let kept = self.equations.iter().enumerate().filter(|(w, _)| w / per.max(1) != group);
            estimate(&NormalEquations::sum(kept.map(|(_, m)| m)))
        };
        let values: Vec<f64> = (0..groups).map(without).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        (value, ((n - 1.0) / n * square).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn a_gain_beyond_all_units_is_not_a_mistake() {
        let corrected_fit = |mistake: Mistake, share: f64| {
            let fit = Fit { unexplained: share, coefficients: DVector::zeros(0), terms: vec![] };
            CorrectedFit { mistake, lag: 0.0, fit }
        };
        let stated = corrected_fit(Mistake::None, 0.33);
        let is_reported = |gain: f64| is_mistake(&stated, &corrected_fit(Mistake::Gain { gain }, 0.01));
        assert!(is_reported(1000.0) && is_reported(0.001));
        assert!(!is_reported(9000.0) && !is_reported(1e-4));
    }
}
