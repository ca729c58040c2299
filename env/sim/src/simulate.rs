//! Simulation of scenarios as recordings.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Clock, Fixture, MAX_INNER_STATES, Model};
use trundle_record::{
    Contact, Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Obstacle, Precontact,
    Recording, Sign, Source, Split, WrenchMeta,
};

use crate::episode_setup::EpisodeSetup;
use crate::instruments::episode;
use crate::{DriveMode, Push, Scenario, Sensor, SimError, Tracker};

/// Simulate a scenario and record it. The same seed gives the same recording.
///
/// # Errors
/// If the model is incomplete or a shape is not a simple polygon.
pub fn simulate(scenario: &Scenario, model: &Model, seed: u64) -> Result<Recording, SimError> {
    let obstacles: Vec<_> = scenario.obstacles.iter().map(|o| o.polygon.clone()).collect();
    let setup = EpisodeSetup {
        model,
        obstacles: &obstacles,
        step: scenario.step,
        coupling: scenario.gripper,
        sensor: scenario.sensor,
        tracker: scenario.tracker,
    };
    let pushes = pushes(scenario, model, seed);
    let contact = contact_mode(&pushes)?;
    let mut episodes = vec![];
    for (index, push) in pushes.iter().enumerate() {
        let inner = draw_initial_inner(model, &mut rng_stream(seed, Purpose::Inner, index));
        let rows = setup.run_from(index, push, inner, rng_stream(seed, Purpose::Noise, index))?;
        episodes.push(episode(format!("episode_{index:02}"), &rows));
    }
    let names = episodes.iter().map(|e| e.name.clone());
    let held_out = names.skip(episodes.len() - scenario.held_out).collect();
    let sensor = with_tare_interval(&scenario.sensor, model)?;
    let mut metadata = metadata(&scenario.name, &model.body, scenario.weighed, &sensor, &scenario.tracker);
    metadata.wrench.contact = contact;
    metadata.scene.obstacles = obstacles.into_iter().map(|polygon| Obstacle { polygon }).collect();
    metadata.split = Split { held_out };
    Ok(Recording::new(metadata, episodes)?)
}

/// The sensor with its pre-contact interval as seen by its own clock.
fn with_tare_interval(sensor: &Sensor, model: &Model) -> Result<Sensor, SimError> {
    let lead = model.resolved()?.delay(Clock::since_contact(0.0)).map_or(0.0, |delay| (-delay).max(0.0));
    let precontact = sensor.precontact - lead;
    if lead > 0.0 && precontact < MIN_TARE_S {
        let remedy = "the reading leads the start of contact: lengthen `sensor.precontact`";
        return Err(SimError::value("latency.delay", -lead, remedy));
    }
    Ok(Sensor { precontact, ..*sensor })
}

/// The contact mode, which must be the same for all pushes of a recording.
fn contact_mode(pushes: &[Push]) -> Result<Contact, SimError> {
    let tips = pushes.iter().filter(|push| push.drive == DriveMode::PointContact).count();
    match tips {
        0 => Ok(Contact::Grasp),
        _ if tips == pushes.len() => Ok(Contact::Point),
        _ => Err(SimError::value("push.drive", "tip", "must apply to all pushes of a recording or to none")),
    }
}

/// Shortest interval for a tare, s.
const MIN_TARE_S: f64 = 0.1;

fn pushes(scenario: &Scenario, model: &Model, seed: u64) -> Vec<Push> {
    let mut pushes = scenario.pushes.clone();
    if let Some(excitation) = &scenario.random {
        let draw = |k| excitation.draw(&model.body, &mut rng_stream(seed, Purpose::Push, k));
        pushes.extend((0..excitation.count).map(draw));
    }
    pushes
}

/// Draw the initial internal states of the laws. A state with several possible starts, such as a caster's angle, is
/// random; a state with a single start, such as a load at rest, is not.
pub(crate) fn draw_initial_inner(model: &Model, rng: &mut ChaCha8Rng) -> [f64; MAX_INNER_STATES] {
    let mut start = [0.0; MAX_INNER_STATES];
    for (value, inner) in start.iter_mut().zip(model.inner()) {
        let choice = rng.random_range(0..inner.starts.len().max(1));
        let deviation: f64 = rng.sample(StandardNormal);
        let is_known = inner.starts.len() < 2;
        *value =
            inner.starts.get(choice).map_or(0.0, |s| if is_known { *s } else { s + inner.sd * deviation });
    }
    start
}

/// Purpose of a random-number stream. Each episode has one stream for each purpose.
#[derive(Clone, Copy)]
enum Purpose {
    Push,
    Noise,
    Inner,
}

/// First stream number of [`Purpose::Inner`], above the interleaved streams of the other two purposes.
const INNER_STREAM_OFFSET: u64 = 1 << 40;

fn rng_stream(seed: u64, purpose: Purpose, episode: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(match purpose {
        Purpose::Push | Purpose::Noise => 2 * episode as u64 + purpose as u64,
        Purpose::Inner => INNER_STREAM_OFFSET + episode as u64,
    });
    rng
}

/// Metadata of a recording: object and instruments, without hidden effects.
pub fn metadata(name: &str, body: &Body, weighed: bool, sensor: &Sensor, tracker: &Tracker) -> Metadata {
    Metadata {
        format: FORMAT.to_owned(),
        name: name.to_owned(),
        at_rest: true,
        object: object(body, weighed),
        wrench: WrenchMeta {
            frame: Frame::Sensor,
            reference: None,
            sign: Sign::OnObject,
            raw: true,
            precontact: Some(Precontact::Everywhere([0.0, sensor.precontact])),
            contact: Contact::Grasp,
            source: Source::Measured,
            gripper_mass: sensor.gripper.map(|gripper| gripper.mass),
            gripper_com: sensor.gripper.map(|gripper| gripper.com),
        },
        noise: noise(sensor, tracker),
        scene: Default::default(),
        split: Default::default(),
        notes: toml::Table::new(),
    }
}

/// Noise of the instruments, or `None` if any of it is zero: a recording cannot state zero noise.
fn noise(sensor: &Sensor, tracker: &Tracker) -> Option<NoiseMeta> {
    let all = sensor.noise().into_iter().chain(tracker.noise);
    let noise = NoiseMeta {
        pose: tracker.noise,
        force: sensor.force_noise,
        torque: Some(sensor.torque_noise),
        time: 0.0,
    };
    (all.fold(f64::INFINITY, f64::min) > 0.0).then_some(noise)
}

fn object(body: &Body, weighed: bool) -> ObjectMeta {
    let mut object = ObjectMeta {
        footprint: vec![],
        mass: weighed.then_some(body.mass),
        support: body.feet.clone().unwrap_or_default(),
        dof: Dof::all(),
        fixtures: vec![],
    };
    match body.fixtures.as_slice() {
        [Fixture::Polygon { vertices, .. }] => object.footprint = vertices.clone(),
        fixtures => object.fixtures = fixtures.iter().map(fixture).collect(),
    }
    object
}

fn fixture(fixture: &Fixture) -> FixtureMeta {
    match fixture {
        Fixture::Polygon { vertices, density } => {
            FixtureMeta { polygon: Some(vertices.clone()), disc: None, density: *density }
        }
        Fixture::Disc { center: [x, y], radius, density } => {
            FixtureMeta { polygon: None, disc: Some([*x, *y, *radius]), density: *density }
        }
    }
}
