//! A recording with its motion and dynamics: the data of all fits.

use crate::bandwidth::StageSds;
use crate::drive::Drive;
use crate::dynamics::{AxisLoad, Dynamics, EpisodeDynamics, checked, rms_of};
use crate::error::MechanismError;
use crate::kernel::Kernel;
use crate::laws::JointScales;
use crate::motion::{EpisodeMotion, Motion};
use crate::series::Series;
use crate::simulator::SimulatorSetup;
use crate::units::EffortUnit;
use trundle_record::{Axis, EncoderSide, JointRecording};

/// Standard deviations of the velocity's noise below which a joint counts as at rest.
const REST_NOISE_SDS: f64 = 3.0;
/// Least speed that counts as motion, as a share of the joint's rms velocity.
const MIN_SPEED_SHARE: f64 = 0.05;
/// Least share of a compared sample's weight at which the joint must move.
const MIN_MOVING_SHARE: f64 = 0.9;

/// A joint and its drive. Values are `None` if they are free.
#[derive(Clone, Debug)]
pub struct JointSetup {
    /// Name.
    pub name: String,
    /// Whether it is a hinge; otherwise a slide.
    pub is_hinge: bool,
    /// What drives it.
    pub drive: Drive,
    /// Whether the encoder is on the drive's side.
    pub encoder_on_drive: bool,
    /// Whether the drive is switched off at times.
    pub switches_off: bool,
    /// Whether a covariate is recorded.
    pub has_load: bool,
    /// Speed below which it counts as at rest.
    pub rest_speed: f64,
    /// Sizes of its signals.
    pub scales: JointScales,
    /// Largest command of the training episodes.
    pub largest_command: f64,
    /// Gain of the drive at which errors of its recorded effort have the size of efforts, if the gain is free.
    pub reference_gain: f64,
    /// Times by which the drive may act after its record, s: how it acts between samples is not known.
    pub timing: [f64; 2],
    /// Standard deviations that the noise of the readings and that of the accelerations can give the residual.
    pub sensor_noise: [f64; 2],
}

/// One episode.
#[derive(Clone, Debug)]
pub(crate) struct EpisodeData {
    pub name: String,
    pub held_out: bool,
    pub start: f64,
    pub dt: f64,
    /// First stage of the filter, which smoothed the motion, for drives.
    pub first_stage: Kernel,
    /// Second stage.
    pub kernel: Kernel,
    /// Number of samples of the motion from one compared sample to the next.
    pub spacing: usize,
    pub joints: Vec<Series>,
    /// Dynamics of the model; `None` for an axis without a model.
    pub dynamics: Option<EpisodeDynamics>,
    /// Load on an axis without a model.
    pub load: AxisLoad,
}

/// Parameters of an axis without a model.
#[derive(Clone, Copy, Debug)]
pub struct AxisSetup {
    /// Inertia, if it is known.
    pub inertia: Option<f64>,
    /// Whether the nominal model has a gravity torque.
    pub gravity: bool,
    /// The coefficient of sin q, if it is known; then that of cos q is zero.
    pub gravity_torque: Option<f64>,
}

/// The data of all fits.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Name of the recording.
    pub name: String,
    /// The joints.
    pub joints: Vec<JointSetup>,
    /// The axis, if there is no model.
    pub axis: Option<AxisSetup>,
    /// The user's own simulator, if it is the mechanism under test.
    pub simulator: Option<SimulatorSetup>,
    /// Bodies of the model with their masses, kg.
    pub bodies: Vec<(String, f64)>,
    /// Distance of a payload from the origin of each body that is plausible, m.
    pub farthest_payload: Vec<f64>,
    /// Armature, damping and dry friction of each joint in the model.
    pub of_model: Vec<[f64; 3]>,
    /// Gravity, world axes.
    pub gravity: [f64; 3],
    /// What may be refitted, as in `[mechanism] free`; `None` is the default.
    pub free: Option<Vec<String>>,
    /// What efforts are measured in.
    pub effort_unit: EffortUnit,
    /// Cut-off frequency, Hz.
    pub bandwidth: f64,
    /// Stages of the filter.
    pub(crate) stages: StageSds,
    /// Whether the motion is imposed.
    pub imposed: bool,
    /// Whether episodes start at rest.
    pub(crate) at_rest: bool,
    pub(crate) episodes: Vec<EpisodeData>,
}

impl Problem {
    /// Combine a recording, its motion, and the dynamics of its model, if it has one.
    ///
    /// # Errors
    /// If efforts cannot be used and nothing else drives the joints, or the dynamics do not fit.
    pub fn new(
        recording: &JointRecording,
        motion: &Motion,
        dynamics: Option<&Dynamics>,
    ) -> Result<Self, MechanismError> {
        let meta = &recording.metadata;
        if dynamics.is_none() && meta.mechanism.types.is_some() {
            return Err(MechanismError::Unsuitable {
                recording: meta.name.clone(),
                reason: "has joints without a model".to_owned(),
                remedy: "give a simulator as `step`, or an MJCF or URDF file as `mjcf`".to_owned(),
            });
        }
        let drives: Vec<Drive> =
            motion.joints.iter().map(|joint| Drive::of(recording, joint)).collect::<Result<_, _>>()?;
        let episodes = episodes(recording, motion, dynamics, &drives)?;
        let mut problem = Self::without_joints(recording, motion, dynamics, episodes);
        problem.effort_unit = problem.effort_unit_of(&drives);
        for (j, name) in motion.joints.iter().enumerate() {
            let is_hinge =
                dynamics.map_or(meta.mechanism.axis == Some(Axis::Hinge), |dynamics| dynamics.is_hinge[j]);
            let setup = problem.setup(recording, motion, j, name, is_hinge, drives[j]);
            problem.joints.push(setup);
        }
        for j in 0..problem.joints.len() {
            let rest = problem.joints[j].rest_speed;
            for episode in &mut problem.episodes {
                keep(episode, j, rest, &motion.episodes);
            }
        }
        Ok(problem)
    }

    /// The nominal mechanism, its settings and the episodes, before the joints are set up.
    fn without_joints(
        recording: &JointRecording,
        motion: &Motion,
        dynamics: Option<&Dynamics>,
        episodes: Vec<EpisodeData>,
    ) -> Self {
        let meta = &recording.metadata;
        let simulator = dynamics.and_then(|d| d.simulator.clone());
        let axis = dynamics.is_none().then_some(AxisSetup {
            inertia: meta.mechanism.inertia,
            gravity: meta.mechanism.gravity,
            gravity_torque: meta.mechanism.gravity_torque,
        });
        Self {
            name: meta.name.clone(),
            joints: vec![],
            axis,
            // Only the parameters of a simulator are refitted.
            free: simulator.as_ref().map(|_| vec![]).or_else(|| meta.mechanism.free.clone()),
            simulator,
            bodies: dynamics
                .map_or(vec![], |d| d.bodies.iter().cloned().zip(d.masses.iter().copied()).collect()),
            farthest_payload: dynamics.map_or(vec![], Dynamics::farthest_payloads),
            of_model: dynamics.map_or(vec![[0.0; 3]; motion.joints.len()], |d| {
                (0..motion.joints.len()).map(|j| [d.armature[j], d.damping[j], d.frictionloss[j]]).collect()
            }),
            gravity: dynamics.map_or([0.0; 3], |d| d.gravity),
            effort_unit: EffortUnit::Newton,
            bandwidth: motion.bandwidth,
            stages: motion.stages,
            imposed: meta.mechanism.imposed,
            at_rest: meta.start.at_rest,
            episodes,
        }
    }

    /// Number of compared samples of a joint in the training episodes.
    #[must_use]
    pub fn samples(&self, joint: usize) -> usize {
        self.episodes.iter().filter(|e| !e.held_out).map(|e| e.joints[joint].kept.len()).sum()
    }

    fn effort_unit_of(&self, drives: &[Drive]) -> EffortUnit {
        let has_value = self.episodes.iter().any(|episode| {
            episode.joints.iter().zip(drives).any(|(s, drive)| *drive != Drive::None && s.gain.is_some())
        });
        let axis = self.axis;
        let is_fixed =
            has_value || axis.is_none_or(|axis| axis.inertia.is_some() || axis.gravity_torque.is_some());
        match drives.first() {
            _ if is_fixed => EffortUnit::Newton,
            Some(Drive::Effort(_)) => EffortUnit::Recorded,
            Some(Drive::Target) => EffortUnit::TargetError,
            _ => EffortUnit::PerInertia,
        }
    }

    fn setup(
        &self,
        recording: &JointRecording,
        motion: &Motion,
        j: usize,
        name: &str,
        is_hinge: bool,
        drive: Drive,
    ) -> JointSetup {
        let training: Vec<&Series> =
            self.episodes.iter().filter(|e| !e.held_out).map(|e| &e.joints[j]).collect();
        let scales = self.scales(&training, j, drive, motion.stages.both());
        let error = |s: &Series, k: usize| s.command_error(drive, k);
        let command = training_rms(&training, &|s, k| error(s, k) * s.on[k]);
        let all = training.iter().flat_map(|s| (0..s.q.len()).map(|k| error(s, k).abs()));
        let reference_gain = if command > 0.0 { scales.effort / command } else { 1.0 };
        let interval = training.iter().map(|s| s.interval).fold(0.0, f64::max);
        let gain = training.iter().find_map(|s| s.gain).unwrap_or(reference_gain);
        let reading = gain * reading_noise(recording, motion, &training, (j, name, drive));
        let sensor_noise = [
            reading * motion.noise_gain(0, interval),
            self.inertia_of(j, &scales) * motion.position_noise[j] * motion.noise_gain(2, motion.interval[j]),
        ];
        JointSetup {
            sensor_noise,
            reference_gain,
            largest_command: all.fold(f64::MIN_POSITIVE, f64::max),
            timing: timing(drive, interval),
            name: name.to_owned(),
            is_hinge,
            drive,
            encoder_on_drive: recording.metadata.encoder_side_of(name) == EncoderSide::Drive,
            switches_off: training.iter().any(|s| s.on.contains(&0.0)),
            has_load: scales.load.is_some(),
            rest_speed: (REST_NOISE_SDS * motion.velocity_noise[j]).max(MIN_SPEED_SHARE * scales.velocity),
            scales,
        }
    }

    /// Sizes of a joint's signals in the training episodes.
    fn scales(&self, training: &[&Series], j: usize, drive: Drive, resolution: f64) -> JointScales {
        let rms = |of: &dyn Fn(&Series, usize) -> f64| training_rms(training, of);
        let acceleration = rms(&|s, k| s.a[k]);
        let gain = training.iter().find_map(|s| s.gain);
        let positions = || training.iter().flat_map(|s| &s.q);
        let low = positions().copied().fold(f64::INFINITY, f64::min);
        let high = positions().copied().fold(f64::NEG_INFINITY, f64::max);
        let needed = self.needed_effort(j, acceleration, low.abs().max(high.abs()));
        let effort = match drive {
            Drive::None => needed,
            _ if gain.is_none() && self.effort_unit == EffortUnit::Newton => needed,
            _ => rms(&|s, k| s.command_error(drive, k) * s.on[k] * gain.unwrap_or(1.0) + s.known[k]),
        };
        let load = rms(&|s, k| s.load.as_ref().map_or(0.0, |load| load[k]));
        JointScales {
            effort,
            range: [low, high],
            velocity: rms(&|s, k| s.v[k]),
            acceleration,
            load: (load > 0.0).then_some(load),
            resolution,
        }
    }

    /// Size of the inertia that a joint feels.
    fn inertia_of(&self, j: usize, scales: &JointScales) -> f64 {
        let training = self.episodes.iter().filter(|e| !e.held_out);
        let own = training.filter_map(|e| e.dynamics.as_ref()).flat_map(|d| d.own_inertia(j).iter().copied());
        match self.axis {
            Some(axis) => axis.inertia.unwrap_or_else(|| crate::laws::Scale::Inertia.of(scales)),
            None => rms_of(own) + self.of_model[j][0],
        }
    }

    /// Size of the effort that inertia, gravity and the model need at a joint.
    fn needed_effort(&self, j: usize, acceleration: f64, angle: f64) -> f64 {
        if let Some(axis) = self.axis {
            let inertial = axis.inertia.unwrap_or(1.0) * acceleration;
            return axis
                .gravity_torque
                .map_or(inertial, |torque| inertial.max(torque.abs() * angle.min(1.0)));
        }
        let training = self.episodes.iter().filter(|e| !e.held_out);
        rms_of(training.filter_map(|e| e.dynamics.as_ref()).flat_map(|d| d.effort[j].iter().copied()))
    }
}

/// Root mean square of a quantity over all samples of the training episodes.
fn training_rms(training: &[&Series], of: &dyn Fn(&Series, usize) -> f64) -> f64 {
    rms_of(training.iter().flat_map(|series| (0..series.q.len()).map(|k| of(series, k))))
}

/// Standard deviation of a reading of the drive, in its unit: that of the effort, or of the position error of a target.
fn reading_noise(
    recording: &JointRecording,
    motion: &Motion,
    training: &[&Series],
    (j, name, drive): (usize, &str, Drive),
) -> f64 {
    let stated = recording.metadata.noise.as_ref().and_then(|noise| noise.effort.as_ref()?.of(name).copied());
    let reading = stated.unwrap_or_else(|| rms_of(training.iter().map(|s| s.noise)));
    let positions = if drive == Drive::Target { motion.position_noise[j] } else { 0.0 };
    reading.hypot(positions)
}

/// Measured efforts may belong to any time between their neighbours. A held command may have changed between two samples,
/// and so act earlier than its record.
fn timing(drive: Drive, interval: f64) -> [f64; 2] {
    let half = interval / 2.0;
    match drive {
        Drive::None => [0.0, 0.0],
        _ if drive.is_held() => [-half, 0.0],
        _ => [-half, half],
    }
}

fn episodes(
    recording: &JointRecording,
    motion: &Motion,
    dynamics: Option<&Dynamics>,
    drives: &[Drive],
) -> Result<Vec<EpisodeData>, MechanismError> {
    let one = |(k, episode): (usize, &EpisodeMotion)| {
        let size = (&*episode.name, episode.grid.len);
        let own = dynamics.map(|all| checked(all, k, size, motion.joints.len())).transpose()?;
        Ok(episode_data(recording, motion, episode, drives, own))
    };
    motion.episodes.iter().enumerate().map(one).collect()
}

fn episode_data(
    recording: &JointRecording,
    motion: &Motion,
    episode: &EpisodeMotion,
    drives: &[Drive],
    dynamics: Option<EpisodeDynamics>,
) -> EpisodeData {
    let one = |j: usize| Series::new(recording, episode, j, &motion.joints[j], drives[j]);
    EpisodeData {
        name: episode.name.clone(),
        held_out: episode.held_out,
        start: episode.grid.start,
        dt: episode.grid.dt,
        first_stage: Kernel::flat(motion.stages.first, episode.grid.dt),
        kernel: Kernel::new(motion.stages.second, episode.grid.dt),
        spacing: motion.stages.spacing(episode.grid.dt),
        joints: (0..motion.joints.len()).map(one).collect(),
        dynamics,
        load: AxisLoad::default(),
    }
}

/// Select the samples that are compared: uniform in time, where every joint's motion is known and the joint moves.
fn keep(episode: &mut EpisodeData, j: usize, rest_speed: f64, motions: &[EpisodeMotion]) {
    let Some(motion) = motions.iter().find(|motion| motion.name == episode.name) else { return };
    keep_where(episode, j, rest_speed, &|k| motion.usable.iter().all(|joint| joint[k]));
}

/// [`keep`] for samples that are usable.
pub(crate) fn keep_where(
    episode: &mut EpisodeData,
    j: usize,
    rest_speed: f64,
    usable: &dyn Fn(usize) -> bool,
) {
    let kernel = &episode.kernel;
    let series = &mut episode.joints[j];
    let len = series.q.len();
    let moving: Vec<f64> = series.v.iter().map(|v| f64::from(u8::from(v.abs() >= rest_speed))).collect();
    let is_usable = |k: &usize| usable(*k - kernel.half) && usable(*k) && usable(*k + kernel.half);
    let all = (kernel.half..len.saturating_sub(kernel.half)).step_by(episode.spacing).filter(is_usable);
    (series.kept, series.resting) = all.partition(|k| kernel.at(&moving, *k) >= MIN_MOVING_SHARE);
}
