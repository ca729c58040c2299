//! What an effect is: its parameters, and what it does to the body or to the instruments.

use crate::{Body, Real};

/// How a parameter is distributed before any data is seen, and so how it is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// Normal, for parameters of either sign.
    Normal {
        /// Mean, in the parameter's unit.
        mean: f64,
        /// Standard deviation, in the parameter's unit.
        sd: f64,
    },
    /// Log-normal, for positive parameters.
    LogNormal {
        /// Median, in the parameter's unit.
        median: f64,
        /// Standard deviation of the natural logarithm.
        sd: f64,
    },
    /// Uniform between the smallest and the largest legal value.
    Uniform,
    /// Uniform over the footprint, of which this is one coordinate (0: x, 1: y), m.
    OnBody(usize),
    /// Uniform on the circle, with this period, rad.
    Angle(f64),
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// Its name, as in `model.toml`.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Smallest legal value.
    pub lower: f64,
    /// Largest legal value.
    pub upper: f64,
    /// Belief before the data.
    pub prior: Prior,
    /// Value taken by a refinement that is left out of a file: the law then is the simple one.
    /// `None`: the parameter is essential, and free when it is left out.
    pub refinement: Option<f64>,
    /// Whether it means anything for an object on a rail.
    pub on_rail: bool,
    /// Whether it scales the unknown pressure under a flat face: one where the feet are known.
    pub of_face: bool,
    /// What it is.
    pub help: &'static str,
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acting {
    /// As a wrench on the object.
    Object,
    /// On what the instruments read.
    Instrument,
}

/// An effect's entry in the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Name in `model.toml`.
    pub kind: &'static str,
    /// Name in a diagnosis, where several building blocks are one effect to a person.
    pub effect: &'static str,
    /// One line for `trundle effects`.
    pub summary: &'static str,
    /// Where the law comes from.
    pub source: &'static str,
    /// Where it acts.
    pub acting: Acting,
    /// Whether it can only take energy out of the motion.
    pub dissipative: bool,
    /// Its parameters, in the order of a law's values.
    pub params: &'static [Param],
    /// The parameter, and its value, at which the effect vanishes.
    pub neutral: &'static [(&'static str, f64)],
    /// What a diagnosis says of it; `{name}` stands for a parameter's value with its interval.
    pub sentence: &'static str,
    /// The push that shows it best.
    pub probe: &'static str,
}

/// When a law is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Time since contact began, s; negative before.
    pub since_contact: f64,
}

impl Clock {
    /// Whether the gripper has touched the object yet.
    pub fn in_contact(&self) -> bool {
        self.since_contact >= 0.0
    }
}

/// The state that an object law sees.
#[derive(Clone, Copy, Debug)]
pub struct Situation<T> {
    /// Position of the object frame in the world, m.
    pub position: [T; 2],
    /// Sine and cosine of the heading.
    pub heading: (T, T),
    /// Twist of the object frame's origin, object axes, `[m/s, m/s, rad/s]`.
    pub twist: [T; 3],
    /// Mass of the body, kg.
    pub mass: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// When.
    pub clock: Clock,
}

impl<T: Real> Situation<T> {
    /// Velocity of a body point, object axes, m/s (the bracket of eq. 1).
    #[inline]
    pub fn velocity(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [vx, vy, spin] = self.twist;
        [vx - spin * y, vy + spin * x]
    }
}

/// A wrench on the object, split for the integrator: `push − drag · twist`, about the object
/// origin in object axes. `drag` is symmetric, `[xx, xy, yy, xθ, yθ, θθ]`, positive semidefinite.
#[derive(Clone, Copy, Debug)]
pub struct Action<T> {
    /// The part that does not brake, `[N, N, N·m]`.
    pub push: [T; 3],
    /// The damping matrix's lower triangle.
    pub drag: [T; 6],
}

impl<T: Real> Action<T> {
    /// No wrench.
    #[inline]
    pub fn none() -> Self {
        Self { push: [T::zero(); 3], drag: [T::zero(); 6] }
    }

    /// Size of the drag: its trace.
    #[inline]
    pub fn size(&self) -> f64 {
        self.drag[0].re() + self.drag[2].re() + self.drag[5].re()
    }

    /// Add a force at a body point, object axes.
    #[inline]
    pub fn push_at(&mut self, [x, y]: [T; 2], [fx, fy]: [T; 2]) {
        self.push[0] += fx;
        self.push[1] += fy;
        self.push[2] += x * fy - y * fx;
    }

    /// Add viscous drag at a body point with the symmetric matrix `[[xx, xy], [xy, yy]]`, N·s/m.
    #[inline]
    pub fn drag_at(&mut self, [x, y]: [T; 2], [xx, xy, yy]: [T; 3]) {
        let (tx, ty) = (xy * x - xx * y, yy * x - xy * y);
        for (sum, term) in self.drag.iter_mut().zip([xx, xy, yy, tx, ty, ty * x - tx * y]) {
            *sum += term;
        }
    }

    /// Add viscous drag alike in every direction at a body point, `c` in N·s/m.
    #[inline]
    pub fn brake_at(&mut self, [x, y]: [T; 2], c: T) {
        let (cx, cy) = (c * x, c * y);
        self.drag[0] += c;
        self.drag[2] += c;
        self.drag[3] -= cy;
        self.drag[4] += cx;
        self.drag[5] += cx * x + cy * y;
    }

    /// Add the other's wrench.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        for (sum, term) in self.push.iter_mut().zip(&other.push) {
            *sum += *term;
        }
        for (sum, term) in self.drag.iter_mut().zip(&other.drag) {
            *sum += *term;
        }
    }

    /// The wrench `push − drag · twist`.
    #[inline]
    pub fn wrench(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        let [xx, xy, yy, tx, ty, tt] = self.drag;
        [
            self.push[0] - (xx * vx + xy * vy + tx * spin),
            self.push[1] - (xy * vx + yy * vy + ty * spin),
            self.push[2] - (tx * vx + ty * vy + tt * spin),
        ]
    }
}

/// A law with its parameters in place. Implement what the effect does; the rest does nothing.
pub(crate) trait Act<T: Real>: Sized {
    /// From the values of [`Spec::params`], in that order.
    fn new(values: &[T], body: &Body) -> Self;

    /// Add the wrench on the object.
    #[inline]
    fn act(&self, _at: &Situation<T>, _sum: &mut Action<T>) {}

    /// Turn a reading `[N, N, N·m]`, in reading axes about the reading's reference point, into
    /// the truth.
    #[inline]
    fn correct(&self, reading: [T; 3], _clock: Clock) -> [T; 3] {
        reading
    }
}

/// The first `N` values of a law; the model has checked that there are that many.
pub(crate) fn take<T: Real, const N: usize>(values: &[T]) -> [T; N] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or_else(T::zero))
}
