//! The task "push a table with a hidden locked wheel to a pose".

mod episode;
mod hidden;
pub mod rules;

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trundle_record::Metadata;

use crate::gripper::wrap;
use crate::{Instruments, Row, Sensor, SimError, Tracker, simulate};
use episode::{Beginning, Episode};
use rules::{GRASP, HALF, NOISIEST, OBSERVATION, PLACES, SENSOR_RATE};

pub use episode::Saved;
pub use hidden::Hidden;

/// What [`LockedWheel::reset`] may be told; the rest is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reset {
    /// Pose at which the object stands, m and rad.
    pub start: Option<[f64; 3]>,
    /// Pose at which it should be.
    pub goal: Option<[f64; 3]>,
    /// Where the gripper holds it, object frame, m.
    pub grasp: Option<[f64; 2]>,
    /// Keep the hidden wheel as it is.
    pub same_object: bool,
}

/// What a step has led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Minus the time integral of the pose error, less a penalty if the object was lost.
    pub reward: f64,
    /// The goal was reached, or the object was lost.
    pub terminated: bool,
    /// The goal was reached.
    pub success: bool,
    /// Distance to the goal, m.
    pub distance: f64,
    /// Heading less goal heading, rad, in (−π, π].
    pub heading_error: f64,
}

/// A table of which one wheel is locked, nobody says which, and a goal pose.
pub struct LockedWheel {
    noise: f64,
    recording: bool,
    objects: u64,
    hidden: Option<Hidden>,
    episode: Option<Episode>,
}

impl LockedWheel {
    /// The task; `noise` scales what the instruments add (1: as documented, 0: perfect).
    ///
    /// # Errors
    /// When `noise` is negative or too large.
    pub fn new(noise: f64) -> Result<Self, SimError> {
        if !(0.0..=NOISIEST).contains(&noise) {
            return Err(SimError::value("noise", noise, "must lie in [0, 10]; 1 is as documented"));
        }
        Ok(Self { noise, recording: false, objects: 0, hidden: None, episode: None })
    }

    /// Begin an episode; everything that is not told is drawn by `seed`.
    ///
    /// # Errors
    /// When the start or goal lies outside the arena, or the grasp beside the table.
    pub fn reset(&mut self, seed: u64, told: &Reset) -> Result<[f64; OBSERVATION], SimError> {
        check(told)?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (drawn, start) = (Hidden::draw(&mut random), draw_start(&mut random));
        let start = told.start.unwrap_or(start);
        let goal = told.goal.unwrap_or_else(|| draw_goal(start, &mut random));
        let hidden = self.hidden.filter(|_| told.same_object).unwrap_or(drawn);
        let beginning = self.beginning(start, goal, told.grasp.unwrap_or(GRASP), seed);
        let mut episode = Episode::new(&hidden, beginning, self.recording)?;
        let observation = episode.observe();
        self.objects += u64::from(self.hidden != Some(hidden));
        (self.hidden, self.episode) = (Some(hidden), Some(episode));
        Ok(observation)
    }

    /// Whether an episode is under way.
    pub fn ready(&self) -> bool {
        self.episode.as_ref().is_some_and(|episode| !episode.ended())
    }

    /// Apply a wrench at the grasp, gripper axes, for [`rules::CONTROL`] seconds; `None` without an
    /// episode under way.
    pub fn step(&mut self, wrench: [f64; 3]) -> Option<([f64; OBSERVATION], Outcome)> {
        let episode = self.episode.as_mut().filter(|episode| !episode.ended())?;
        let outcome = episode.push(wrench);
        Some((episode.observe(), outcome))
    }

    /// From the next reset on, keep what sensor and tracker see, each at its own rate.
    pub fn record(&mut self) {
        self.recording = true;
    }

    /// What they saw since the last time.
    pub fn take_rows(&mut self) -> Vec<Row> {
        let recorder = self.episode.as_mut().and_then(Episode::recorder);
        recorder.map(Instruments::take).unwrap_or_default()
    }

    /// What a recording says of the object and the instruments.
    ///
    /// # Errors
    /// Never: the table is a sound body.
    pub fn metadata(&self, name: &str) -> Result<Metadata, SimError> {
        Ok(simulate::metadata(name, &hidden::table()?, false, &self.sensor(), &self.tracker()))
    }

    /// How many different objects there have been; it changes when the hidden wheel does.
    pub fn objects(&self) -> u64 {
        self.objects
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the grasp in gripper axes,
    /// for drawing; `None` before the first reset.
    pub fn view(&self) -> Option<[[f64; 3]; 4]> {
        self.episode.as_ref().map(Episode::view)
    }

    /// What is needed to go on elsewhere; a copy does not record.
    pub fn save(&self) -> (u64, Option<Hidden>, Option<Saved>) {
        (self.objects, self.hidden, self.episode.as_ref().map(Episode::save))
    }

    /// Go on from what another has saved; exact to the last bit.
    ///
    /// # Errors
    /// When it is no saved state.
    pub fn restore(
        &mut self,
        objects: u64,
        hidden: Option<Hidden>,
        saved: Option<&Saved>,
    ) -> Result<(), SimError> {
        self.episode = match (hidden, saved) {
            (Some(hidden), Some(saved)) => {
                let beginning = self.beginning([0.0; 3], saved.goal, saved.grasp, saved.seed);
                let mut episode = Episode::new(&hidden, beginning, false)?;
                episode.restore(saved);
                Some(episode)
            }
            _ => None,
        };
        (self.objects, self.hidden) = (objects, hidden);
        Ok(())
    }

    fn beginning(&self, start: [f64; 3], goal: [f64; 3], grasp: [f64; 2], seed: u64) -> Beginning {
        let (sensor, tracker) = (self.sensor(), self.tracker());
        Beginning { start, goal, grasp, seed, sensor, tracker, noise: self.noise }
    }

    fn sensor(&self) -> Sensor {
        let plain = Sensor::default();
        Sensor {
            rate: SENSOR_RATE,
            force_noise: plain.force_noise * self.noise,
            torque_noise: plain.torque_noise * self.noise,
            ..plain
        }
    }

    fn tracker(&self) -> Tracker {
        let plain = Tracker::default();
        Tracker { noise: plain.noise.map(|sd| sd * self.noise), ..plain }
    }
}

fn draw_start(random: &mut ChaCha8Rng) -> [f64; 3] {
    [random.random_range(-0.5..=0.5), random.random_range(-0.5..=0.5), random.random_range(-PI..=PI)]
}

/// 0.4 to 1.0 m away in any direction that stays in the arena, turned by up to 0.8 rad.
fn draw_goal([x, y, theta]: [f64; 3], random: &mut ChaCha8Rng) -> [f64; 3] {
    let far = random.random_range(0.4..=1.0);
    let (sin, cos) = random.random_range(-PI..=PI).sin_cos();
    let inside = |value: f64| value.clamp(-PLACES, PLACES);
    [inside(x + far * cos), inside(y + far * sin), wrap(theta + random.random_range(-0.8..=0.8))]
}

fn check(told: &Reset) -> Result<(), SimError> {
    for (key, pose) in [("start", told.start), ("goal", told.goal)] {
        let Some([x, y, theta]) = pose else { continue };
        if !(theta.is_finite() && x.abs() <= PLACES && y.abs() <= PLACES) {
            let remedy = "x and y must lie in [-2, 2] m and the heading be finite";
            return Err(SimError::value(key, [x, y, theta], remedy));
        }
    }
    match told.grasp {
        Some([x, y]) if !(x.abs() <= HALF[0] && y.abs() <= HALF[1]) => {
            Err(SimError::value("grasp", [x, y], "must lie on the table: |x| <= 0.6 m, |y| <= 0.4 m"))
        }
        _ => Ok(()),
    }
}
