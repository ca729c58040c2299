//! The open-loop task: a path around an obstacle is planned once on a model and executed without feedback.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use trundle_infer::{InferError, Stage, StateVector, Watch, hold, r2};
use trundle_model::{Clock, Model, Plant, Prior, to_body};
use trundle_sim::{SimError, World};

use super::curves::{Noise, data};
use super::learners::{Given, Trouble, physics};
use crate::error::refused;
use crate::toml_dict;
use crate::watch::{once, watched};

/// Many fits, each of which reports its own share.
const STAGES: [Stage; 1] = once("fit");

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_open_loop, module)?)
}

impl From<SimError> for Trouble {
    fn from(error: SimError) -> Self {
        Self::Other(error.to_string())
    }
}

/// Step of the world in which plans are carried out, s.
const STEP: f64 = 2e-3;
/// How often a plan that touches the obstacle is made anew, farther out.
const WIDER: usize = 4;
/// By how much farther out, m.
const OUT: f64 = 0.15;

/// The task: from rest at the origin to `goal`, around an obstacle.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Course {
    /// Where the way ends, m from the origin along x.
    length: f64,
    /// How far to the side it leads halfway, m; negative: to the right.
    beside: f64,
    /// Corners of the obstacle, m, world.
    obstacle: Vec<[f64; 2]>,
    /// Pushes in a plan.
    steps: usize,
    /// For how long each is held, s.
    hold: f64,
    /// Largest force along an axis, N, and torque, N·m.
    reach: [f64; 2],
    /// In what axes a push is held.
    axes: Axes,
}

/// In what axes a wrench is held while the object turns.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Axes {
    /// It turns with the object, as the pushes that a model is scored on.
    Object,
    /// It keeps its direction in the world.
    World,
}

impl Axes {
    /// The wrench in object axes at a heading.
    fn turned(self, wrench: [f64; 3], heading: f64) -> [f64; 3] {
        match self {
            Self::Object => wrench,
            Self::World => to_body(wrench, heading),
        }
    }
}

/// A plan and the poses that its model expects, the first the start.
struct Plan {
    wrenches: Vec<[f64; 3]>,
    poses: Vec<[f64; 3]>,
}

impl Course {
    /// Pushes that keep the model on the way; farther out if it would touch the obstacle. Only the model is asked.
    fn plan(&self, model: &Model) -> Result<Plan, Trouble> {
        let mut course = self.clone();
        let mut plan = course.along(model)?;
        for _ in 0..WIDER {
            if !self.carry_out(model, &plan.wrenches)?.1 {
                break;
            }
            course.beside += OUT * self.beside.signum();
            plan = course.along(model)?;
        }
        Ok(plan)
    }

    /// One push after the other: that which brings the model to the way's next pose at the way's speed.
    fn along(&self, model: &Model) -> Result<Plan, Trouble> {
        let plant = model.resolved()?;
        let mut x: StateVector = [0.0; 6];
        let (mut plan, mut wrench) = (Plan { wrenches: vec![], poses: vec![[0.0; 3]] }, [0.0; 3]);
        for k in 1..=self.steps {
            let (place, twist) = (self.pose(k as f64), self.twist(k as f64));
            // What is missing is made up for within some pushes.
            let target = [0, 1, 2].map(|i| {
                let expected = x[i] + self.hold * (x[3 + i] + twist[i]) / 2.0;
                twist[i] + (place[i] - expected) / (CATCH_UP * self.hold)
            });
            wrench = self.invert(&plant, &x, target, wrench);
            x = self.held(&plant, &x, &wrench);
            plan.wrenches.push(wrench);
            plan.poses.push([x[0], x[1], x[2]]);
        }
        Ok(plan)
    }

    /// The state after a push.
    fn held(&self, plant: &Plant<f64>, x: &StateVector, wrench: &[f64; 3]) -> StateVector {
        let steps = (self.hold / FINE).round().max(1.0);
        let after = |x, _| hold(plant, &x, &self.axes.turned(*wrench, x[2]), self.hold / steps);
        (0..steps as usize).fold(*x, after)
    }

    /// Pose on the way after `k` pushes: along a curve `y = b sin²(πx/L)` with the least jerk, facing ahead.
    fn pose(&self, k: f64) -> [f64; 3] {
        let t = (k / self.steps as f64).clamp(0.0, 1.0);
        let x = self.length * t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        let phase = std::f64::consts::PI * x / self.length;
        let slope = self.beside * (2.0 * phase).sin() * std::f64::consts::PI / self.length;
        [x, self.beside * phase.sin().powi(2), slope.atan()]
    }

    fn twist(&self, k: f64) -> [f64; 3] {
        const H: f64 = 1e-4;
        let (before, after) = (self.pose(k - H), self.pose(k + H));
        let span = self.hold * (f64::min(k + H, self.steps as f64) - (k - H));
        [0, 1, 2].map(|i| (after[i] - before[i]) / span)
    }

    /// The push, within reach, after which the model moves as wanted: Newton's method from the push before.
    fn invert(&self, plant: &Plant<f64>, x: &StateVector, wanted: [f64; 3], start: [f64; 3]) -> [f64; 3] {
        let [force, torque] = self.reach;
        let reach = [force, force, torque];
        let mut wrench = start;
        for _ in 0..ROUNDS {
            let at = self.held(plant, x, &wrench);
            let miss = [0, 1, 2].map(|i| wanted[i] - at[3 + i]);
            let columns = [0, 1, 2].map(|k| {
                let mut other = wrench;
                other[k] += PROBE;
                let moved = self.held(plant, x, &other);
                [0, 1, 2].map(|i| (moved[3 + i] - at[3 + i]) / PROBE)
            });
            let Some(change) = solve(columns, miss) else { break };
            wrench = [0, 1, 2].map(|i| (wrench[i] + change[i]).clamp(-reach[i], reach[i]));
        }
        wrench
    }

    /// The poses to which pushes bring an object among obstacles, and whether it touched one.
    fn carry_out(&self, truth: &Model, wrenches: &[[f64; 3]]) -> Result<(Vec<[f64; 3]>, bool), Trouble> {
        let mut world = World::new(truth, std::slice::from_ref(&self.obstacle), STEP)?;
        world.place([0.0; 3]);
        let (mut poses, mut touched, mut t) = (vec![[0.0; 3]], false, 0.0);
        for &wrench in wrenches {
            for _ in 0..(self.hold / STEP).round() as usize {
                let wrench = self.axes.turned(wrench, world.state().pose[2]);
                world.step(wrench, Clock::since_contact(t));
                t += STEP;
                touched |= world.is_touching();
            }
            poses.push(world.state().pose);
        }
        Ok((poses, touched))
    }

    fn miss(&self, poses: &[[f64; 3]]) -> f64 {
        poses.last().map_or(f64::NAN, |p| (p[0] - self.length).hypot(p[1]))
    }
}

/// Within how many pushes a plan makes up for being off its way.
const CATCH_UP: f64 = 2.0;
/// Step with which a plan is simulated, s; as that of the pushes that a model is scored on.
const FINE: f64 = 5e-3;
/// Newton steps for each push.
const ROUNDS: usize = 4;
/// Change of the wrench by which its effect is found, N and N·m.
const PROBE: f64 = 1e-2;

/// Solve three equations by Cramer's rule; `None` if they are not independent.
fn solve([a, b, c]: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
    };
    let whole = determinant(a, b, c);
    let found =
        [determinant(right, b, c), determinant(a, right, c), determinant(a, b, right)].map(|d| d / whole);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

/// How a model came to be less than right.
#[derive(Clone, Copy)]
enum Flaw {
    /// Its values are off by so much: of positive ones the logarithm, of places a share of the body's size, of
    /// angles rad.
    Off(f64),
    /// It was learnt from so many noisy pushes.
    Learnt(usize, Noise),
}

struct Outcome {
    r2: f64,
    error: f64,
    planned: f64,
    touched: bool,
    expected: Vec<[f64; 3]>,
    poses: Vec<[f64; 3]>,
}

/// The task with models that are wrong to known degrees: a list of dicts, for `sizes` first, then for `counts`.
#[pyfunction]
#[pyo3(signature = (truth, form, course, sizes, counts, noise, seed, *, tested=200, starts=8, progress=None))]
#[expect(clippy::too_many_arguments, reason = "called from one place, by name")]
fn _open_loop<'py>(
    py: Python<'py>,
    truth: &str,
    form: &str,
    course: &Bound<'py, PyDict>,
    sizes: Vec<f64>,
    counts: Vec<usize>,
    noise: (String, f64),
    seed: u64,
    tested: usize,
    starts: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let truth = Model::from_toml(truth).map_err(refused)?.0;
    let form = Model::from_toml(form).map_err(refused)?.0;
    let course: Course = toml_dict::from_dict(course, "course")?
        .try_into()
        .map_err(|error: toml::de::Error| refused(format!("course: {}", error.message())))?;
    let found: Vec<Outcome> = watched(py, progress, &STAGES, |watch| {
        let noise = Noise::of(&noise.0, noise.1)?;
        let flaws: Vec<_> = sizes.iter().map(|&s| Flaw::Off(s)).collect();
        let learnt = counts.iter().map(|&n| Flaw::Learnt(n, noise));
        let flaws: Vec<_> = flaws.into_iter().chain(learnt).collect();
        let trial = Trial { truth: &truth, form: &form, course: &course, tested, starts, seed };
        flaws.iter().map(|&flaw| trial.run(flaw, watch)).collect()
    })?;
    found.iter().map(|outcome| outcome.to_dict(py)).collect()
}

struct Trial<'a> {
    truth: &'a Model,
    form: &'a Model,
    course: &'a Course,
    tested: usize,
    starts: usize,
    seed: u64,
}

impl Trial<'_> {
    fn run(&self, flaw: Flaw, watch: &dyn Watch) -> Result<Outcome, InferError> {
        if watch.cancelled() {
            return Err(InferError::Interrupted);
        }
        Ok(self.outcome(&self.model(flaw, watch)?)?)
    }

    fn model(&self, flaw: Flaw, watch: &dyn Watch) -> Result<Model, Trouble> {
        match flaw {
            Flaw::Off(size) => off(self.truth, size, self.seed),
            Flaw::Learnt(count, noise) => {
                let (training, _) = data(self.truth, noise, count, self.tested, self.seed, self.course.hold)?;
                let given = Given { form: self.form, starts: self.starts, seed: self.seed };
                physics(&training, &given, watch)
            }
        }
    }

    fn outcome(&self, model: &Model) -> Result<Outcome, Trouble> {
        let plant = model.resolved()?;
        let noise = Noise::Wrench(0.0);
        let (_, test) = data(self.truth, noise, 0, self.tested, self.seed, self.course.hold)?;
        let plan = self.course.plan(model)?;
        let (poses, touched) = self.course.carry_out(self.truth, &plan.wrenches)?;
        Ok(Outcome {
            r2: r2(&plant, &test),
            error: self.course.miss(&poses),
            planned: self.course.miss(&plan.poses),
            touched,
            expected: plan.poses,
            poses,
        })
    }
}

/// A model whose values are off by `size`, drawn by `seed`: the same draw, scaled, for every size.
fn off(truth: &Model, size: f64, seed: u64) -> Result<Model, Trouble> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(3);
    let [low, high] = truth.body.bounds();
    let value = |slot: trundle_model::Slot| {
        let z: f64 = StandardNormal.sample(&mut rng);
        let value = slot.value.unwrap_or(0.0);
        match slot.prior {
            Prior::LogNormal { .. } => value * (size * z).exp(),
            Prior::OnBody(axis) => value + size * z * (high[axis] - low[axis]),
            Prior::Angle(_) => value + size * z,
            Prior::Normal { sd, .. } => value + size * z * sd,
            _ => value,
        }
    };
    let values: Vec<f64> = truth.slots().into_iter().map(value).collect();
    Ok(truth.with_values(&values)?)
}

impl Outcome {
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("r2", self.r2)?;
        dict.set_item("error", self.error)?;
        dict.set_item("planned", self.planned)?;
        dict.set_item("touched", self.touched)?;
        dict.set_item("expected", self.expected.clone())?;
        dict.set_item("poses", self.poses.clone())?;
        Ok(dict)
    }
}
