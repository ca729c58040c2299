//! Tasks: push an object, of which something is hidden, to a pose, along a path, around an obstacle, through a door.

mod arm;
mod batch;
mod episode;
mod hidden;
mod memory;
mod options;
mod outcome;
mod room;
pub mod rules;
mod sealed;
mod senses;
mod things;

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Effect, Model, ModelError, NotFinite, Rigid};
use trundle_record::{Contact, Metadata, Obstacle};

use crate::{Instruments, Row, SimError, simulate};
use episode::Episode;
use rules::WIDEST;

pub use batch::{Autoreset, Batch, Rows};
pub use hidden::Hidden;
pub use options::{Goal, Mode, Options, Secret};
pub use outcome::Outcome;
pub use room::{Reset, Room};
pub use things::{Thing, Things, household};

/// A task with its episode under way.
#[derive(Clone)]
pub struct Pushing {
    options: Arc<Options>,
    things: Arc<Things>,
    more: Arc<Vec<Effect>>,
    recording: bool,
    /// Draws the seeds of episodes.
    seeds: ChaCha8Rng,
    /// Whether anybody has given a seed yet.
    seeded: bool,
    objects: u64,
    object: Option<Object>,
    episode: Option<(Began, Episode)>,
}

/// What is pushed, and what is hidden of it.
#[derive(Clone)]
struct Object {
    seed: u64,
    thing: Arc<Thing>,
    hidden: Arc<Hidden>,
}

/// What an episode began with.
#[derive(Clone, Serialize, Deserialize)]
struct Began {
    seed: u64,
    told: Reset,
}

/// What of a task changes.
#[derive(Serialize, Deserialize)]
struct Saved {
    seeds: ChaCha8Rng,
    seeded: bool,
    objects: u64,
    object: Option<u64>,
    episode: Option<(Began, episode::Saved)>,
}

impl Pushing {
    /// A task.
    ///
    /// # Errors
    /// When an option makes no sense; the message names it.
    pub fn new(options: Options) -> Result<Self, SimError> {
        options.check()?;
        let things = Things::named(&options.object)?;
        let more = crate::scenario::effects(&options.effects)?;
        Ok(Self {
            options: Arc::new(options),
            things: Arc::new(things),
            more: Arc::new(more),
            recording: false,
            seeds: ChaCha8Rng::seed_from_u64(0),
            seeded: false,
            objects: 0,
            object: None,
            episode: None,
        })
    }

    /// What it was told once and for all.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Begin an episode; what is not told is drawn. A seed decides of this and all later ones.
    ///
    /// # Errors
    /// When start or goal are impossible, or the grasp lies beside the object.
    pub fn reset(&mut self, seed: Option<u64>, told: &Reset) -> Result<(), SimError> {
        let seeded = self.seeded || seed.is_some();
        let mut seeds = seed.map_or_else(|| self.seeds.clone(), ChaCha8Rng::seed_from_u64);
        let seed = seeds.random();
        let (object, episode) = self.begin(seed, told)?;
        (self.seeds, self.seeded) = (seeds, seeded);
        self.objects += u64::from(self.object.as_ref().is_none_or(|o| o.seed != object.seed));
        self.object = Some(object);
        self.episode = Some((Began { seed, told: told.clone() }, episode));
        Ok(())
    }

    fn begin(&self, seed: u64, told: &Reset) -> Result<(Object, Episode), SimError> {
        let object = match self.object.as_ref().filter(|_| told.same_object) {
            Some(object) => object.clone(),
            None => self.draw(seed)?,
        };
        let (fixed, random) = (&mut senses::stream(object.seed, OBSTACLES), &mut senses::stream(seed, ROOMS));
        let room = Room::draw(self.options.task, &object.thing, told, [fixed, random])?;
        let grasp = told.grasp.unwrap_or_else(|| object.thing.rear());
        on_object(&object.thing, grasp)?;
        let (options, thing) = (self.options.clone(), object.thing.clone());
        let episode = Episode::new(options, thing, &object.hidden, room, grasp, seed, self.recording)?;
        Ok((object, episode))
    }

    fn draw(&self, seed: u64) -> Result<Object, SimError> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let thing = self.things.draw(&mut random)?;
        let hidden = Hidden::draw(&thing, self.options.hidden, &self.more, &mut random)?;
        Ok(Object { seed, thing, hidden: Arc::new(hidden) })
    }

    /// Whether a seed has been given, so that a reset without one goes on from there.
    pub fn seeded(&self) -> bool {
        self.seeded
    }

    /// Whether what the instruments see is kept.
    pub fn recording(&self) -> bool {
        self.recording
    }

    /// The same, but for the recording: what a planner branches on.
    #[must_use]
    pub fn fork(&self) -> Self {
        let mut fork = self.clone();
        fork.recording = false;
        if let Some((_, episode)) = &mut fork.episode {
            episode.forget();
        }
        fork
    }

    /// What moves as one now, instruments apart.
    pub fn rigid(&self) -> Option<Rigid<f64>> {
        self.episode.as_ref().map(|(_, episode)| episode.rigid())
    }

    /// Whether an episode is under way.
    pub fn ready(&self) -> bool {
        self.episode.as_ref().is_some_and(|(_, episode)| !episode.ended())
    }

    /// Act until the next action is due; each entry of `action` lies in [−1, 1], and there are [`Mode::width`] of them.
    /// `None` without an episode under way.
    ///
    /// # Errors
    /// When the motion is not finite; the message names the parameter to look at first. The episode is then over.
    pub fn step(&mut self, action: &[f64]) -> Result<Option<Outcome>, SimError> {
        let full = self.options.action.full();
        let Some((_, episode)) = self.episode.as_mut().filter(|(_, episode)| !episode.ended()) else {
            return Ok(None);
        };
        let mut target = [0.0; WIDEST];
        for (entry, (share, full)) in target.iter_mut().zip(action.iter().zip(full)) {
            *entry = share * full;
        }
        let outcome = episode.step(target)?;
        if episode.is_finite() && outcome.reward.is_finite() {
            return Ok(Some(outcome));
        }
        let (at, model) = (episode.seconds(), self.model());
        let error = model.map(|model| ModelError::NotFinite(NotFinite::of(&model, at)));
        error.map_or(Ok(Some(outcome)), |error| Err(error.into()))
    }

    /// Tell what the agent sees, [`Options::entries`] numbers; nothing before the first reset. Noise is drawn anew.
    pub fn observe(&mut self, told: &mut [f64]) {
        if let Some((_, episode)) = &mut self.episode {
            episode.observe(told);
        }
    }

    /// From the next reset on, keep what sensor and tracker see, each at its own rate.
    pub fn record(&mut self) {
        self.recording = true;
    }

    /// What they saw since the last time.
    pub fn take_rows(&mut self) -> Vec<Row> {
        let recorder = self.episode.as_mut().and_then(|(_, episode)| episode.recorder());
        recorder.map(Instruments::take).unwrap_or_default()
    }

    /// What a recording says of the object and the instruments; of the object that is always the same, before the
    /// first reset.
    ///
    /// # Errors
    /// When the object is drawn and has not been yet.
    pub fn metadata(&self, name: &str) -> Result<Metadata, SimError> {
        let remedy = "the object is drawn by reset(): call it first";
        let thing = self.thing().ok_or_else(|| SimError::value("recording", name, remedy))?;
        let (sensor, tracker) = (senses::sensor(&self.options), senses::tracker(&self.options));
        let mut metadata = simulate::metadata(name, &thing.body, false, &sensor, &tracker);
        if self.options.action == Mode::Push {
            metadata.wrench.contact = Contact::Point;
        }
        let obstacles = self.room().map(|room| room.obstacles.clone()).unwrap_or_default();
        metadata.scene.obstacles = obstacles.into_iter().map(|polygon| Obstacle { polygon }).collect();
        Ok(metadata)
    }

    /// How many different objects there have been; it changes when what is hidden does.
    pub fn objects(&self) -> u64 {
        self.objects
    }

    /// The object as anybody can see it.
    pub fn thing(&self) -> Option<&Arc<Thing>> {
        self.object.as_ref().map(|object| &object.thing).or_else(|| self.things.only())
    }

    /// What is hidden.
    pub fn hidden(&self) -> Option<&Hidden> {
        self.object.as_ref().map(|object| &*object.hidden)
    }

    /// The object with all that acts on it.
    pub fn model(&self) -> Option<Model> {
        self.object.as_ref().map(|object| object.hidden.model(&object.thing.body))
    }

    /// Where the episode takes place.
    pub fn room(&self) -> Option<&Room> {
        self.episode.as_ref().map(|(_, episode)| episode.room())
    }

    /// True poses of object, goal and gripper in the world, and the wrench at the gripper in gripper axes, for
    /// drawing; and whether it holds the object.
    pub fn view(&self) -> Option<([[f64; 3]; 4], bool)> {
        self.episode.as_ref().map(|(_, episode)| (episode.view(), episode.arm().holds()))
    }

    /// What is needed to go on elsewhere, as bytes; a copy does not record.
    ///
    /// # Errors
    /// Never, as far as is known.
    pub fn save(&self) -> Result<Vec<u8>, SimError> {
        let saved = Saved {
            seeds: self.seeds.clone(),
            seeded: self.seeded,
            objects: self.objects,
            object: self.object.as_ref().map(|object| object.seed),
            episode: self.episode.as_ref().map(|(began, episode)| (began.clone(), episode.save())),
        };
        let bytes = postcard::to_stdvec(&saved).map_err(|e| SimError::State(e.to_string()))?;
        Ok(sealed::seal(&bytes))
    }

    /// Go on from what another of the same options has saved; exact to the last bit.
    ///
    /// # Errors
    /// When it is no saved state, or a damaged one.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), SimError> {
        let saved: Saved =
            postcard::from_bytes(sealed::open(bytes)?).map_err(|e| SimError::State(e.to_string()))?;
        let Saved { seeds, seeded, objects, object, episode } = saved;
        self.object = object.map(|seed| self.draw(seed)).transpose()?;
        self.recording = false;
        self.episode = match episode {
            None => None,
            Some((began, saved)) => {
                let told = Reset { same_object: true, ..began.told.clone() };
                let (_, mut episode) = self.begin(began.seed, &told)?;
                episode.load(saved)?;
                Some((began, episode))
            }
        };
        (self.seeds, self.seeded, self.objects) = (seeds, seeded, objects);
        Ok(())
    }
}

/// Streams of random numbers from an episode's seed that draw where it takes place, and from the object's what is in
/// its way.
const ROOMS: u64 = 3;
const OBSTACLES: u64 = 4;

/// How far beside the rim a grasp may lie, m.
const RIM: f64 = 1e-6;

fn on_object(thing: &Thing, grasp: [f64; 2]) -> Result<(), SimError> {
    if grasp.iter().all(|v| v.is_finite()) && thing.body.outside(grasp).0 <= RIM {
        return Ok(());
    }
    Err(SimError::value("grasp", grasp, "must lie on the object (object frame, m)"))
}
