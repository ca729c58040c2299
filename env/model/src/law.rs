//! What an effect is: its parameters, and what it does to the body or to the instruments.

use crate::{Body, Real};

/// Inner states of all laws of a model together, at most: a caster's angle and a swinging load.
pub const INNER: usize = 5;

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
    /// Whether it is identifiable only where the mass is given: one where the mass is free.
    pub of_mass: bool,
    /// Whether it is one of several, such as forces along axes, any of which defines the effect where the data hold it.
    pub any_of: bool,
    /// What it is to its law.
    pub role: Role,
    /// What it is.
    pub help: &'static str,
}

/// What a parameter is to its law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// How strong the effect is: a force, a mass, a gain, a delay.
    Amplitude,
    /// How it acts: an exponent, a damping ratio, a speed at which something gives way.
    Form,
    /// Coordinate of a point of the body, object frame; its axis.
    BodyPoint(usize),
    /// Coordinate of a point of the room; its axis.
    WorldPoint(usize),
    /// How large or how far away a part of the room is.
    Region,
    /// A moment.
    Time,
    /// A direction.
    Angle,
    /// Length after which something repeats.
    Period,
    /// A choice, such as an event's episode: always given, never searched.
    Choice,
}

impl Role {
    /// Whether it is never searched.
    pub fn is_choice(self) -> bool {
        self == Self::Choice
    }

    /// Whether it says where or in which direction an effect acts.
    pub fn is_place(self) -> bool {
        matches!(self, Self::BodyPoint(_) | Self::WorldPoint(_) | Self::Region | Self::Angle)
    }
}

/// A state of an effect's own, such as a caster's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inner {
    /// Its name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Values from which an episode may start; the one that its beginning fits best is taken.
    pub starts: &'static [f64],
    /// Standard deviation around each of them.
    pub sd: f64,
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acting {
    /// As a wrench on the object.
    Object,
    /// On what the instruments read.
    Instrument,
}

/// In place of a neutral value: what the body has itself, such as its mass centre.
pub const OWN: f64 = f64::NAN;

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
    /// Whether it changes what is moved: the mass, its centre or the inertia.
    pub loads: bool,
    /// States of its own.
    pub inner: &'static [Inner],
    /// Its parameters, in the order of a law's values.
    pub params: &'static [Param],
    /// The parameter, and its value, at which the effect vanishes; [`OWN`] where that is the body's own.
    pub neutral: &'static [(&'static str, f64)],
    /// What a diagnosis says of it; `{name}` stands for a parameter's value with its interval.
    pub sentence: &'static str,
    /// The push that shows it best.
    pub probe: &'static str,
}

/// When a law is asked, and how the object is held then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Time since contact began, s; negative before.
    pub since_contact: f64,
    /// The table's time in the middle of the step, s.
    pub t: f64,
    /// Duration of the step, s.
    pub dt: f64,
    /// Which episode of the recording, from 0; held-out ones count.
    pub episode: f64,
    /// Where it is held: the origin of the reading's frame in the object frame, m.
    pub grasp: [f64; 2],
    /// How fast the reading changes, reading axes, N/s, N/s, N·m/s; zero where nobody has read it.
    pub trend: [f64; 3],
    /// Standard deviations by noise of the mean reading over the step, and of the trend; zero where they are not known.
    pub noise: [[f64; 3]; 2],
}

impl Clock {
    /// A moment of a lone episode whose times count from contact.
    pub const fn since_contact(since_contact: f64) -> Self {
        let (grasp, trend, noise) = ([0.0; 2], [0.0; 3], [[0.0; 3]; 2]);
        Self { since_contact, t: since_contact, dt: 0.0, episode: 0.0, grasp, trend, noise }
    }

    /// Whether the gripper has touched the object yet.
    pub fn in_contact(&self) -> bool {
        self.since_contact >= 0.0
    }

    /// Share of the step that lies after an event at `time` of an episode, which lasts for good. It grows linearly
    /// within the step, so that the time has a gradient.
    pub fn after<T: Real>(&self, episode: f64, time: T) -> T {
        if self.episode != episode {
            return T::lift(f64::from(u8::from(self.episode > episode)));
        }
        let end = self.t + self.dt / 2.0;
        if time.re() >= end {
            T::zero()
        } else if self.dt == 0.0 || time.re() <= end - self.dt {
            T::lift(1.0)
        } else {
            (-time + end) / self.dt
        }
    }
}

/// What moves as one: its mass, where its centre lies, and its inertia about that.
#[derive(Clone, Copy, Debug)]
pub struct Rigid<T> {
    /// kg.
    pub mass: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// About the mass centre, kg·m².
    pub inertia: T,
}

impl<T: Real> Rigid<T> {
    /// Fasten a point mass at a place of the object frame.
    pub fn add_point(&mut self, mass: T, at: [T; 2]) {
        let [dx, dy] = [0, 1].map(|k| at[k] - self.com[k]);
        let total = self.mass + mass;
        let share = mass / total;
        self.inertia += self.mass * share * (dx.squared() + dy.squared());
        self.com = [self.com[0] + share * dx, self.com[1] + share * dy];
        self.mass = total;
    }
}

/// Time constants of first-order lags between a wrench and its reading, s; zero where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lags<T> {
    /// The reading follows the wrench: `τ ṙ + r = w`.
    pub sensor: T,
    /// The wrench follows what is recorded, which was commanded: `τ ẇ + w = r`.
    pub drive: T,
}

impl<T: Real> Lags<T> {
    /// Two of them together. Lags in series are taken as one whose time constant is their sum.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { sensor: self.sensor + other.sensor, drive: self.drive + other.drive }
    }
}

/// What a law is built from beside its values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site<'a, T> {
    /// The body that it acts on.
    pub body: &'a Body,
    /// The model's first viscous wheel, `[x, y, angle, mu_x, mu_y]`.
    pub wheel: Option<[T; 5]>,
}

/// The state that an object law sees.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a, T> {
    /// Position of the object frame in the world, m.
    pub position: [T; 2],
    /// Sine and cosine of the heading.
    pub heading: (T, T),
    /// Twist of the object frame's origin, object axes, `[m/s, m/s, rad/s]`.
    pub twist: [T; 3],
    /// Mass that moves, kg.
    pub mass: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// When.
    pub clock: Clock,
    /// The law's own states, in the order of [`Spec::inner`].
    pub inner: &'a [T],
}

impl<T: Real> Situation<'_, T> {
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
    /// Whether it does the same everywhere and in every heading: neither [`Act::act`] nor [`Act::advance`] looks at
    /// [`Situation::position`] or [`Situation::heading`]. Then a filter need not differentiate by the pose.
    const SAME_EVERYWHERE: bool = false;

    /// Whether [`Act::correct`] looks at [`Clock::trend`], which whoever simulates a reading must work out.
    const FOLLOWS_TREND: bool = false;

    /// From the values of [`Spec::params`], in that order.
    fn new(values: &[T], site: &Site<'_, T>) -> Self;

    /// What it does, where no state changes that; then [`Act::act`] is not asked.
    #[inline]
    fn steady(&self) -> Option<&Action<T>> {
        None
    }

    /// Add the wrench on the object.
    #[inline]
    fn act(&self, _at: &Situation<'_, T>, _sum: &mut Action<T>) {}

    /// Turn a reading `[N, N, N·m]`, in reading axes about the reading's reference point, into
    /// the truth.
    #[inline]
    fn correct(&self, reading: [T; 3], _clock: Clock) -> [T; 3] {
        reading
    }

    /// Change what is moved, where [`Spec::loads`]. `grasp`: where it is held, object frame, m.
    #[inline]
    fn load(&self, _clock: Clock, _grasp: [f64; 2], _rigid: &mut Rigid<T>) {}

    /// By how much the reading of what happens at a moment is late, s.
    #[inline]
    fn delay(&self, _clock: Clock) -> Option<T> {
        None
    }

    /// First-order lags between wrench and reading.
    #[inline]
    fn lags(&self) -> Option<Lags<T>> {
        None
    }

    /// Pose of the tracked frame in the object frame, m, m, rad, where they differ.
    #[inline]
    fn mount(&self) -> Option<[T; 3]> {
        None
    }

    /// Move its own states on by `dt` seconds; `at` is the middle of the step, but for `at.inner`, its start.
    #[inline]
    fn advance(&self, _at: &Situation<'_, T>, _dt: f64, _inner: &mut [T]) {}
}

/// The first `N` values of a law; the model has checked that there are that many.
pub(crate) fn take<T: Real, const N: usize>(values: &[T]) -> [T; N] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or_else(T::zero))
}
