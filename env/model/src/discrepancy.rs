//! Model discrepancy (Kennedy & O'Hagan 2001): a wrench that represents the physics missing from a model.
//!
//! It is the mean of a Gaussian process of the state or of the reading. It acts inside the dynamics and improves
//! predictions, but does not identify an effect. With inputs `z` and length scales `ℓ`,
//!
//! ```text
//! wrench(z) = Σ_i weight_i · exp(−½ |(z − centre_i) / ℓ|²)
//! ```
//! The wrench vanishes far from the training data (Rasmussen & Williams 2006, ch. 8: subset of regressors).
//! `model.toml` stores it in the table `[unnamed]`.

use crate::generalised_force::GeneralisedForce;
use crate::law::{Clock, LawContext};
use crate::{ModelError, Real, to_body};
use serde::{Deserialize, Serialize};

/// Largest number of components of all inputs together.
const MAX_INPUT_COMPONENTS: usize = 8;

/// Input of a discrepancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// Twist of the object origin, object axes, m/s, m/s, rad/s.
    Twist,
    /// Twist of the object origin, world axes, m/s, m/s, rad/s.
    WorldTwist,
    /// Position of the object origin in the world, m, m.
    Position,
    /// Cosine and sine of the heading.
    Heading,
    /// Measured wrench, reading axes about its reference point, N, N, N·m.
    Reading,
    /// Time derivative of the reading, N/s, N/s, N·m/s.
    Trend,
    /// Time since contact, s.
    SinceContact,
}

impl Input {
    /// Number of components.
    pub fn width(self) -> usize {
        match self {
            Self::Twist | Self::WorldTwist | Self::Reading | Self::Trend => 3,
            Self::Position | Self::Heading => 2,
            Self::SinceContact => 1,
        }
    }

    /// Description for reports.
    pub fn description(self) -> &'static str {
        match self {
            Self::Twist => "the motion of the object",
            Self::WorldTwist => "the motion in world axes",
            Self::Position => "the position in the world",
            Self::Heading => "the heading",
            Self::Reading => "the measured wrench",
            Self::Trend => "the rate of change of the measured wrench",
            Self::SinceContact => "the time since contact",
        }
    }
}

/// Axes of the wrench of a discrepancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axes {
    /// Acts on the object; object axes about the object origin.
    Object,
    /// Acts on the object; world axes about the object origin.
    World,
    /// Corrects the reading; reading axes about its reference point.
    Reading,
}

/// A model discrepancy: a wrench that is a smooth function of its inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Discrepancy {
    /// Inputs. A correction of the reading may depend on the reading, its trend and the time since contact; a wrench on
    /// the object on all inputs other than reading and trend.
    pub inputs: Vec<Input>,
    /// Axes of the weights.
    pub axes: Axes,
    /// Length scales `ℓ`, one per input component, in its unit.
    pub scales: Vec<f64>,
    /// Centres in the input space, `n` rows with one entry per input component.
    pub centres: Vec<Vec<f64>>,
    /// Wrench that each centre adds at its location, `n` × `[N, N, N·m]`.
    pub weights: Vec<[f64; 3]>,
}

impl Discrepancy {
    /// Check that inputs, axes and lengths are consistent.
    ///
    /// # Errors
    /// Names the key that is invalid.
    pub fn check(&self) -> Result<(), ModelError> {
        let wrong = |what: String| Err(ModelError::Format(format!("unnamed.{what}")));
        let width = self.width();
        let reads = |input: &Input| matches!(input, Input::Reading | Input::Trend);
        let is_motion = |input: &Input| !reads(input) && *input != Input::SinceContact;
        if self.inputs.is_empty() || width > MAX_INPUT_COMPONENTS {
            return wrong(format!(
                "inputs: have {width} components in total; give 1 to {MAX_INPUT_COMPONENTS}"
            ));
        }
        let on_reading = self.axes == Axes::Reading;
        if self.inputs.iter().any(|i| if on_reading { is_motion(i) } else { reads(i) }) {
            let needed = "`reading` and `trend` require axes = \"reading\", which allows only these and `since_contact`";
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

    /// Number of components of all inputs.
    pub fn width(&self) -> usize {
        self.inputs.iter().map(|input| input.width()).sum()
    }

    /// Whether the discrepancy corrects the reading rather than acting on the object.
    pub(crate) fn corrects_reading(&self) -> bool {
        self.axes == Axes::Reading
    }

    /// Whether the discrepancy is independent of the pose.
    pub(crate) fn is_pose_invariant(&self) -> bool {
        let is_invariant = |input: &Input| {
            matches!(input, Input::Twist | Input::Reading | Input::Trend | Input::SinceContact)
        };
        self.axes != Axes::World && self.inputs.iter().all(is_invariant)
    }

    /// Vector of all input components, each in its unit.
    fn gather<T: Real>(&self, of: impl Fn(Input) -> [T; 3]) -> [T; MAX_INPUT_COMPONENTS] {
        let mut gathered = [T::zero(); MAX_INPUT_COMPONENTS];
        let numbers = self.inputs.iter().flat_map(|&input| of(input).into_iter().take(input.width()));
        for (component, number) in gathered.iter_mut().zip(numbers) {
            *component = number;
        }
        gathered
    }

    /// Add the wrench on the object, after contact.
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

    /// Corrected reading.
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

    /// Wrench at an input vector. Derivatives by the inputs are summed in `f64` and applied to the chain rule once.
    fn wrench<T: Real>(&self, z: &[T; MAX_INPUT_COMPONENTS]) -> [T; 3] {
        let point = z.map(Real::re);
        let mut value = [0.0; 3];
        let mut slopes = [[0.0; MAX_INPUT_COMPONENTS]; 3];
        for (centre, weight) in self.centres.iter().zip(&self.weights) {
            let (kernel, along) = self.kernel(centre, &point);
            for ((value, slopes), weight) in value.iter_mut().zip(&mut slopes).zip(weight) {
                *value += weight * kernel;
                for (slope, along) in slopes.iter_mut().zip(along) {
                    *slope -= weight * kernel * along;
                }
            }
        }
        [0, 1, 2].map(|k| {
            T::chained(value[k], std::array::from_fn::<_, MAX_INPUT_COMPONENTS, _>(|i| (z[i], slopes[k][i])))
        })
    }

    /// Kernel between a centre and an input vector, and the derivatives of its negative logarithm.
    fn kernel(&self, centre: &[f64], z: &[f64; MAX_INPUT_COMPONENTS]) -> (f64, [f64; MAX_INPUT_COMPONENTS]) {
        let mut along = [0.0; MAX_INPUT_COMPONENTS];
        let mut square = 0.0;
        for (((along, z), centre), scale) in along.iter_mut().zip(z).zip(centre).zip(&self.scales) {
            let distance = (z - centre) / scale;
            square += distance * distance;
            *along = distance / scale;
        }
        ((-0.5 * square).exp(), along)
    }

    /// Copy with other weights: `n` × `[N, N, N·m]`, flattened.
    #[must_use]
    pub fn with_weights(&self, weights: impl IntoIterator<Item = f64>) -> Self {
        let mut copy = self.clone();
        copy.weights.iter_mut().flatten().zip(weights).for_each(|(own, weight)| *own = weight);
        copy
    }

    /// Kernels of all centres at an input vector with one entry per input component.
    pub fn kernels(&self, inputs: &[f64]) -> Vec<f64> {
        let mut z = [0.0; MAX_INPUT_COMPONENTS];
        z.iter_mut().zip(inputs).for_each(|(z, input)| *z = *input);
        self.centres.iter().map(|centre| self.kernel(centre, &z).0).collect()
    }

    /// Input vector for a pose and twist (world axes) and a reading (reading axes), in the order of
    /// [`Discrepancy::inputs`].
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
