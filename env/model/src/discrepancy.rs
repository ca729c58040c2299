//! A wrench without a name: what a model lacks, as the mean of a Gaussian process of the state or of the reading.
//!
//! It lies inside the dynamics and predicts, but explains nothing. With inputs `z` in units of their scales `ℓ`,
//!
//! ```text
//! wrench(z) = Σ_i weight_i · exp(−½ |(z − centre_i) / ℓ|²)
//! ```
//! which vanishes far from where there were data (Rasmussen & Williams 2006, ch. 8: subset of regressors).

use crate::law::{Clock, GeneralisedForce, LawContext};
use crate::{ModelError, Real, to_body};
use serde::{Deserialize, Serialize};

/// Numbers that all inputs together have, at most.
const MAX_INPUT_NUMBERS: usize = 8;

/// What an unnamed wrench depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// Velocity of the object frame's origin and spin, object axes, m/s, m/s, rad/s.
    Twist,
    /// The same in world axes.
    WorldTwist,
    /// Place of the object frame in the world, m, m.
    Position,
    /// Cosine and sine of the heading.
    Heading,
    /// The wrench as read, reading axes about its reference point, N, N, N·m.
    Reading,
    /// How fast that changes, N/s, N/s, N·m/s.
    Trend,
    /// Time since contact, s.
    SinceContact,
}

impl Input {
    /// How many numbers it is.
    pub fn width(self) -> usize {
        match self {
            Self::Twist | Self::WorldTwist | Self::Reading | Self::Trend => 3,
            Self::Position | Self::Heading => 2,
            Self::SinceContact => 1,
        }
    }

    /// For a sentence.
    pub fn description(self) -> &'static str {
        match self {
            Self::Twist => "the motion of the object",
            Self::WorldTwist => "the motion in the room",
            Self::Position => "the place in the room",
            Self::Heading => "the heading",
            Self::Reading => "the force that is read",
            Self::Trend => "how fast that force changes",
            Self::SinceContact => "the time since contact",
        }
    }
}

/// Axes of an unnamed wrench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axes {
    /// On the object, object axes about the object origin.
    Object,
    /// On the object, world axes about the object origin.
    World,
    /// Added to what is read, reading axes about its reference point.
    Reading,
}

/// A wrench as a smooth function of some inputs, without a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// What it depends on: where it is added to the reading, on that, its trend and the time; otherwise not on those two.
    pub inputs: Vec<Input>,
    /// Axes of its weights.
    pub axes: Axes,
    /// Lengths `ℓ` over which it changes, one for each number of the inputs, in its unit.
    pub scales: Vec<f64>,
    /// Places in the space of inputs: `n` rows, one number for each of the inputs' numbers.
    pub centres: Vec<Vec<f64>>,
    /// What each centre adds where it lies, `n` × `[N, N, N·m]`.
    pub weights: Vec<[f64; 3]>,
}

impl Discrepancy {
    /// Refuse what does not fit together.
    ///
    /// # Errors
    /// Names the key that is wrong.
    pub fn check(&self) -> Result<(), ModelError> {
        let wrong = |what: String| Err(ModelError::Format(format!("unnamed.{what}")));
        let width = self.width();
        let reads = |input: &Input| matches!(input, Input::Reading | Input::Trend);
        let is_invariant = |input: &Input| !reads(input) && *input != Input::SinceContact;
        if self.inputs.is_empty() || width > MAX_INPUT_NUMBERS {
            return wrong(format!(
                "inputs: they make {width} numbers; there must be 1 to {MAX_INPUT_NUMBERS}"
            ));
        }
        let on_reading = self.axes == Axes::Reading;
        if self.inputs.iter().any(|i| if on_reading { is_invariant(i) } else { reads(i) }) {
            let needed =
                "`reading` and `trend` go with axes = \"reading\", and that with nothing else but the time";
            return wrong(format!("inputs: {needed}"));
        }
        for (what, got, expected) in [
            ("unnamed.scales", self.scales.len(), width),
            ("unnamed.weights", self.weights.len(), self.centres.len()),
        ] {
            if got != expected {
                return Err(ModelError::Length { what, got, expected });
            }
        }
        if let Some(centre) = self.centres.iter().find(|c| c.len() != width) {
            return Err(ModelError::Length { what: "unnamed.centres", got: centre.len(), expected: width });
        }
        if let Some(scale) = self.scales.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
            return wrong(format!("scales: {scale} must be positive"));
        }
        let mut numbers = self.centres.iter().flatten().chain(self.weights.iter().flatten());
        if numbers.any(|n| !n.is_finite()) {
            return wrong("centres and unnamed.weights: must be finite".to_owned());
        }
        Ok(())
    }

    /// How many numbers the inputs are.
    pub fn width(&self) -> usize {
        self.inputs.iter().map(|input| input.width()).sum()
    }

    /// Whether it changes what is read, rather than acting on the object.
    pub(crate) fn corrects_reading(&self) -> bool {
        self.axes == Axes::Reading
    }

    /// Whether it does the same everywhere and in every heading.
    pub(crate) fn is_pose_invariant(&self) -> bool {
        let is_invariant = |input: &Input| {
            matches!(input, Input::Twist | Input::Reading | Input::Trend | Input::SinceContact)
        };
        self.axes != Axes::World && self.inputs.iter().all(is_invariant)
    }

    /// Inputs at a place of their space, each in its unit.
    fn gather<T: Real>(&self, of: impl Fn(Input) -> [T; 3]) -> [T; MAX_INPUT_NUMBERS] {
        let mut gathered = [T::zero(); MAX_INPUT_NUMBERS];
        let numbers = self.inputs.iter().flat_map(|&input| of(input).into_iter().take(input.width()));
        for (place, number) in gathered.iter_mut().zip(numbers) {
            *place = number;
        }
        gathered
    }

    /// Add the wrench on the object, once in contact.
    pub(crate) fn add_force<T: Real>(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if self.corrects_reading() || !at.clock.in_contact() {
            return;
        }
        let (sin, cos) = at.heading;
        let turned = |[x, y, z]: [T; 3]| [cos * x - sin * y, sin * x + cos * y, z];
        let zero = T::zero();
        let z = self.gather(|input| match input {
            Input::Twist => at.twist,
            Input::WorldTwist => turned(at.twist),
            Input::Position => [at.position[0], at.position[1], zero],
            Input::Heading => [cos, sin, zero],
            Input::Reading | Input::Trend => [zero; 3],
            Input::SinceContact => [T::lift(at.clock.since_contact), zero, zero],
        });
        let [x, y, torque] = self.wrench(&z);
        let (fx, fy) = match self.axes {
            Axes::World => (cos * x + sin * y, cos * y - sin * x),
            Axes::Object | Axes::Reading => (x, y),
        };
        for (sum, part) in sum.force.iter_mut().zip([fx, fy, torque]) {
            *sum += part;
        }
    }

    /// A reading with what is missing from it.
    pub(crate) fn correct<T: Real>(&self, reading: [T; 3], clock: Clock) -> [T; 3] {
        if !self.corrects_reading() || !clock.in_contact() {
            return reading;
        }
        let z = self.gather(|input| match input {
            Input::SinceContact => [T::lift(clock.since_contact); 3],
            Input::Trend => clock.trend.map(T::lift),
            _ => reading,
        });
        let [x, y, torque] = self.wrench(&z);
        [reading[0] + x, reading[1] + y, reading[2] + torque]
    }

    /// The sum over all centres. Slopes are summed as plain numbers and tied to the inputs' derivatives once.
    fn wrench<T: Real>(&self, z: &[T; MAX_INPUT_NUMBERS]) -> [T; 3] {
        let place = z.map(Real::re);
        let mut value = [0.0; 3];
        let mut slopes = [[0.0; MAX_INPUT_NUMBERS]; 3];
        for (centre, weight) in self.centres.iter().zip(&self.weights) {
            let (kernel, along) = self.kernel(centre, &place);
            for ((value, slopes), weight) in value.iter_mut().zip(&mut slopes).zip(weight) {
                *value += weight * kernel;
                for (slope, along) in slopes.iter_mut().zip(along) {
                    *slope -= weight * kernel * along;
                }
            }
        }
        [0, 1, 2].map(|k| {
            T::chained(value[k], std::array::from_fn::<_, MAX_INPUT_NUMBERS, _>(|i| (z[i], slopes[k][i])))
        })
    }

    /// The kernel between a centre and a place, and the slopes of minus its logarithm.
    fn kernel(&self, centre: &[f64], z: &[f64; MAX_INPUT_NUMBERS]) -> (f64, [f64; MAX_INPUT_NUMBERS]) {
        let mut along = [0.0; MAX_INPUT_NUMBERS];
        let mut square = 0.0;
        for (((along, z), centre), scale) in along.iter_mut().zip(z).zip(centre).zip(&self.scales) {
            let distance = (z - centre) / scale;
            square += distance * distance;
            *along = distance / scale;
        }
        ((-0.5 * square).exp(), along)
    }

    /// The same with other weights: `n` × `[N, N, N·m]`, one after the other.
    #[must_use]
    pub fn with_weights(&self, weights: impl IntoIterator<Item = f64>) -> Self {
        let mut copy = self.clone();
        copy.weights.iter_mut().flatten().zip(weights).for_each(|(own, weight)| *own = weight);
        copy
    }

    /// The kernels of all centres with a place of the input space, one number for each of the inputs' numbers.
    pub fn kernels(&self, inputs: &[f64]) -> Vec<f64> {
        let mut z = [0.0; MAX_INPUT_NUMBERS];
        z.iter_mut().zip(inputs).for_each(|(z, input)| *z = *input);
        self.centres.iter().map(|centre| self.kernel(centre, &z).0).collect()
    }

    /// The inputs in a motion under a reading: pose and twist in world axes, the reading in its own. In the order of
    /// [`Discrepancy::inputs`], each number in its unit.
    pub fn inputs_at(&self, pose: [f64; 3], twist: [f64; 3], reading: [f64; 3], clock: Clock) -> Vec<f64> {
        let of = |input: &Input| {
            let numbers = match input {
                Input::Twist => to_body(twist, pose[2]),
                Input::WorldTwist => twist,
                Input::Position => pose,
                Input::Heading => [pose[2].cos(), pose[2].sin(), 0.0],
                Input::Reading => reading,
                Input::Trend => clock.trend,
                Input::SinceContact => [clock.since_contact; 3],
            };
            numbers.into_iter().take(input.width())
        };
        self.inputs.iter().flat_map(of).collect()
    }
}
