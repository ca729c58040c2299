//! A task with its current episode.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Effect, Model, ModelError, NotFinite, Rigid};
use trundle_record::{Contact, Metadata, Obstacle};

use super::action_mode::ActionMode;
use super::constants::MAX_ACTION_WIDTH;
use super::episode::{self, Episode};
use super::external_step::ExternalStep;
use super::hidden::HiddenEffects;
use super::options::Options;
use super::outcome::Outcome;
use super::scene_layout::{ResetOptions, SceneLayout};
use super::task_objects::{TaskObject, TaskObjects};
use super::{checksum, sensors};
use crate::{Instruments, Row, SimError, simulate};

/// A task with its current episode.
#[derive(Clone)]
pub struct PushTask {
    options: Arc<Options>,
    task_objects: Arc<TaskObjects>,
    extra_effects: Arc<Vec<Effect>>,
    recording: bool,
    /// Generator of episode seeds.
    seeds: ChaCha8Rng,
    /// Whether a seed has been given.
    seeded: bool,
    object_count: u64,
    object: Option<DrawnObject>,
    episode: Option<(EpisodeStart, Episode)>,
}

/// The current object with its hidden effects.
#[derive(Clone)]
struct DrawnObject {
    seed: u64,
    task_object: Arc<TaskObject>,
    hidden: Arc<HiddenEffects>,
}

/// Seed and options of an episode's start.
#[derive(Clone, Serialize, Deserialize)]
struct EpisodeStart {
    seed: u64,
    reset: ResetOptions,
}

/// Saved state of a task.
#[derive(Serialize, Deserialize)]
struct Saved {
    seeds: ChaCha8Rng,
    seeded: bool,
    object_count: u64,
    object: Option<u64>,
    episode: Option<(EpisodeStart, episode::Saved)>,
}

impl PushTask {
    /// Create a task.
    ///
    /// # Errors
    /// If an option is out of range. The message names it.
    pub fn new(options: Options) -> Result<Self, SimError> {
        options.check()?;
        let task_objects = TaskObjects::new(&options)?;
        let extra_effects = crate::toml_file::effects(&options.effects)?;
        Ok(Self {
            options: Arc::new(options),
            task_objects: Arc::new(task_objects),
            extra_effects: Arc::new(extra_effects),
            recording: false,
            seeds: ChaCha8Rng::seed_from_u64(0),
            seeded: false,
            object_count: 0,
            object: None,
            episode: None,
        })
    }

    /// The options of the task.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Start an episode. Missing options are drawn at random. A seed determines this and all later episodes.
    ///
    /// # Errors
    /// If start or goal are invalid, or the grasp is not on the object.
    pub fn reset(&mut self, seed: Option<u64>, reset: &ResetOptions) -> Result<(), SimError> {
        let seeded = self.seeded || seed.is_some();
        let mut seeds = seed.map_or_else(|| self.seeds.clone(), ChaCha8Rng::seed_from_u64);
        let seed = seeds.random();
        let (object, episode) = self.start_episode(seed, reset)?;
        (self.seeds, self.seeded) = (seeds, seeded);
        self.object_count += u64::from(self.object.as_ref().is_none_or(|o| o.seed != object.seed));
        self.object = Some(object);
        self.episode = Some((EpisodeStart { seed, reset: reset.clone() }, episode));
        Ok(())
    }

    fn start_episode(&self, seed: u64, reset: &ResetOptions) -> Result<(DrawnObject, Episode), SimError> {
        let object = match self.object.as_ref().filter(|_| reset.same_object) {
            Some(object) => object.clone(),
            None => self.draw_object(seed)?,
        };
        let (fixed, rng) = (
            &mut sensors::rng_stream(object.seed, OBSTACLE_STREAM),
            &mut sensors::rng_stream(seed, LAYOUT_STREAM),
        );
        let layout = SceneLayout::draw(self.options.task, &object.task_object, reset, [fixed, rng])?;
        let grasp = reset.grasp.unwrap_or_else(|| object.task_object.default_grasp());
        check_grasp(&object.task_object, grasp)?;
        let (options, task_object) = (self.options.clone(), object.task_object.clone());
        let episode =
            Episode::new(options, task_object, &object.hidden, layout, grasp, seed, self.recording)?;
        Ok((object, episode))
    }

    fn draw_object(&self, seed: u64) -> Result<DrawnObject, SimError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let task_object = self.task_objects.draw(&mut rng)?;
        let hidden = HiddenEffects::draw(&task_object, &self.options, &self.extra_effects, &mut rng)?;
        Ok(DrawnObject { seed, task_object, hidden: Arc::new(hidden) })
    }

    /// Whether a seed has been given, so that a reset without seed continues its sequence.
    pub fn seeded(&self) -> bool {
        self.seeded
    }

    /// Whether the samples of the instruments are recorded.
    pub fn recording(&self) -> bool {
        self.recording
    }

    /// A copy without recording, for a planner's rollouts.
    #[must_use]
    pub fn fork(&self) -> Self {
        let mut fork = self.clone();
        fork.recording = false;
        if let Some((_, episode)) = &mut fork.episode {
            episode.stop_recording();
        }
        fork
    }

    /// Current mass properties, without instrument effects.
    pub fn rigid(&self) -> Option<Rigid<f64>> {
        self.episode.as_ref().map(|(_, episode)| episode.rigid())
    }

    /// Whether an episode is running.
    pub fn ready(&self) -> bool {
        self.episode.as_ref().is_some_and(|(_, episode)| !episode.ended())
    }

    /// Apply an action until the next one is due. `action` has [`ActionMode::width`] entries, which are clipped to [−1, 1].
    /// Returns `None` if no episode is running.
    ///
    /// # Errors
    /// If the motion is not finite. The message names the parameter to check first. The episode has then ended.
    pub fn step(&mut self, action: &[f64]) -> Result<Option<Outcome>, SimError> {
        self.step_after(action, self.options.decision_time)
    }

    /// As [`PushTask::step`], after a decision that took `thinking` s.
    ///
    /// # Errors
    /// As [`PushTask::step`].
    pub fn step_after(&mut self, action: &[f64], thinking: f64) -> Result<Option<Outcome>, SimError> {
        let full = self.options.action.full_scale();
        let Some((_, episode)) = self.episode.as_mut().filter(|(_, episode)| !episode.ended()) else {
            return Ok(None);
        };
        let mut target = [0.0; MAX_ACTION_WIDTH];
        for (entry, (share, full)) in target.iter_mut().zip(action.iter().zip(full)) {
            *entry = share.clamp(-1.0, 1.0) * full;
        }
        let mut outcome = episode.step(target, thinking)?;
        outcome.action_clipped = action.iter().any(|share| share.abs() > 1.0);
        if episode.is_finite() && outcome.reward.is_finite() {
            return Ok(Some(outcome));
        }
        let (at, model) = (episode.seconds(), self.model());
        let error = model.map(|model| ModelError::NotFinite(NotFinite::of(&model, at)));
        error.map_or(Ok(Some(outcome)), |error| Err(error.into()))
    }

    /// Advance by one action along a motion that another simulator computed: one entry per simulation step. Returns `None`
    /// if no episode is running.
    ///
    /// # Errors
    /// If the options do not allow it, the number of steps is another one, or a value is not finite. The episode is then
    /// unchanged.
    pub fn follow(&mut self, motion: &[ExternalStep]) -> Result<Option<Outcome>, SimError> {
        let episode = self.episode.as_mut().filter(|(_, episode)| !episode.ended());
        episode.map(|(_, episode)| episode.follow(motion)).transpose()
    }

    /// Write the observation, [`Options::observation_len`] numbers, with new noise. Before the first reset nothing is
    /// written.
    pub fn observe(&mut self, observation: &mut [f64]) {
        if let Some((_, episode)) = &mut self.episode {
            episode.observe(observation);
        }
    }

    /// Record the samples of sensor and tracker from the next reset on.
    pub fn record(&mut self) {
        self.recording = true;
    }

    /// Recorded samples since the last call.
    pub fn take_rows(&mut self) -> Vec<Row> {
        let recorder = self.episode.as_mut().and_then(|(_, episode)| episode.recorder());
        recorder.map(Instruments::take_rows).unwrap_or_default()
    }

    /// Metadata of a recording. If the task has a single object, it is available before the first reset.
    ///
    /// # Errors
    /// If the object has not been drawn yet.
    pub fn metadata(&self, name: &str) -> Result<Metadata, SimError> {
        let remedy = "the object is drawn by reset(): call it first";
        let task_object = self.task_object().ok_or_else(|| SimError::value("recording", name, remedy))?;
        let (sensor, tracker) = (sensors::sensor(&self.options), sensors::tracker(&self.options));
        let mut metadata = simulate::metadata(name, &task_object.body, false, &sensor, &tracker);
        if self.options.action == ActionMode::Push {
            metadata.wrench.contact = Contact::Point;
        }
        let obstacles = self.layout().map(|layout| layout.obstacles.clone()).unwrap_or_default();
        metadata.scene.obstacles = obstacles.into_iter().map(|polygon| Obstacle { polygon }).collect();
        Ok(metadata)
    }

    /// Number of objects drawn so far. It changes whenever the hidden effects change.
    pub fn object_count(&self) -> u64 {
        self.object_count
    }

    /// The visible properties of the object.
    pub fn task_object(&self) -> Option<&Arc<TaskObject>> {
        self.object.as_ref().map(|object| &object.task_object).or_else(|| self.task_objects.only())
    }

    /// The hidden effects.
    pub fn hidden(&self) -> Option<&HiddenEffects> {
        self.object.as_ref().map(|object| &*object.hidden)
    }

    /// The model of the object with all effects.
    pub fn model(&self) -> Option<Model> {
        self.object.as_ref().map(|object| object.hidden.model(&object.task_object.body))
    }

    /// The scene layout of the episode.
    pub fn layout(&self) -> Option<&SceneLayout> {
        self.episode.as_ref().map(|(_, episode)| episode.layout())
    }

    /// True poses of object, goal and gripper in the world, the wrench at the gripper in gripper axes, and whether the
    /// gripper holds the object.
    pub fn view(&self) -> Option<([[f64; 3]; 4], bool)> {
        self.episode.as_ref().map(|(_, episode)| (episode.view(), episode.action_model().is_holding()))
    }

    /// Serialise the state, without the recording.
    ///
    /// # Errors
    /// If the serialisation fails.
    pub fn save(&self) -> Result<Vec<u8>, SimError> {
        let saved = Saved {
            seeds: self.seeds.clone(),
            seeded: self.seeded,
            object_count: self.object_count,
            object: self.object.as_ref().map(|object| object.seed),
            episode: self.episode.as_ref().map(|(start, episode)| (start.clone(), episode.save())),
        };
        let bytes = postcard::to_stdvec(&saved).map_err(|e| SimError::State(e.to_string()))?;
        Ok(checksum::append(&bytes))
    }

    /// Restore the state saved by a task with the same options, bit for bit.
    ///
    /// # Errors
    /// If the bytes are not a saved state, or are damaged.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), SimError> {
        let saved: Saved =
            postcard::from_bytes(checksum::verify(bytes)?).map_err(|e| SimError::State(e.to_string()))?;
        let Saved { seeds, seeded, object_count, object, episode } = saved;
        self.object = object.map(|seed| self.draw_object(seed)).transpose()?;
        self.recording = false;
        self.episode = match episode {
            None => None,
            Some((start, saved)) => {
                let reset = ResetOptions { same_object: true, ..start.reset.clone() };
                let (_, mut episode) = self.start_episode(start.seed, &reset)?;
                episode.load(saved)?;
                Some((start, episode))
            }
        };
        (self.seeds, self.seeded, self.object_count) = (seeds, seeded, object_count);
        Ok(())
    }
}

/// Streams of random numbers: the layout from the episode's seed, and the obstacles from the object's seed.
const LAYOUT_STREAM: u64 = 3;
const OBSTACLE_STREAM: u64 = 4;

/// Largest distance of a grasp from the object, m.
const RIM_TOLERANCE_M: f64 = 1e-6;

fn check_grasp(task_object: &TaskObject, grasp: [f64; 2]) -> Result<(), SimError> {
    if grasp.iter().all(|v| v.is_finite()) && task_object.body.outside(grasp).0 <= RIM_TOLERANCE_M {
        return Ok(());
    }
    Err(SimError::value("grasp", grasp, "must lie on the object (object frame, m)"))
}
