//! Conversion of sensor readings to planar wrenches with the pose of their frame in the object frame.
//!
//! If the pose of the gripper is recorded, every reading is transformed to sensor axes about the sensor's origin, because
//! instrument effects are constant there.

use nalgebra::Vector3;

use crate::episode::{Episode, WrenchStream};
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Frame, Metadata, Reference, Sign};

use super::noise::Noise;
use super::options::{Options, ReadingAxes, WrenchPose};
use super::samples::{PoseSample, WrenchSample};
use super::tare::{Tare, TareMethod, UnloadedReading, Weight, sd_of_mean, weigh};
use super::track::{self, PoseNoise, Track};
use super::trajectory::{PoseAt, Trajectory, continuous, share};
use super::transform::{GripperPose, Wrench6, planar_transform, relative_pose};

/// The streams of an episode, without masked samples.
pub(crate) struct MaskedStreams<'a> {
    pub name: &'a str,
    pub object: Track<PoseSample>,
    pub gripper: Track<GripperPose>,
    pub wrench: WrenchStream,
    object_path: Trajectory,
    gripper_path: Trajectory,
    gripper_times: Vec<f64>,
}

/// Planar wrenches of an episode.
pub(crate) struct Readings {
    pub wrench: Vec<WrenchSample>,
    pub tare_sd: [f64; 3],
}

impl<'a> MaskedStreams<'a> {
    pub fn new(
        episode: &'a Episode,
        pose_noise: &PoseNoise,
        noise: &Noise,
        rule: WrenchPose,
    ) -> Result<Self, Error> {
        let name = episode.name.as_str();
        let object = track::object(episode, pose_noise);
        let gripper = track::gripper(episode, pose_noise);
        if object.samples.is_empty() {
            return Err(no_stream(name, "object pose", "record the object's pose at least once"));
        }
        let Some(wrench) = episode.wrench() else {
            return Err(no_stream(name, "wrench", "record the wrench, or remove the episode"));
        };
        let own_time = rule == WrenchPose::OwnTime;
        let planar = gripper.samples.iter().map(|p| PoseSample { t: p.t, pose: p.planar() });
        let object_path = Trajectory::new(&object.samples, noise, own_time);
        let gripper_path = Trajectory::new(&continuous(planar), noise, own_time);
        let gripper_times = gripper.samples.iter().map(|p| p.t).collect();
        Ok(Self { name, object, gripper, wrench, object_path, gripper_path, gripper_times })
    }

    fn object_at(&self, t: f64) -> PoseAt {
        let origin = PoseAt { pose: [0.0; 3], variance: [0.0; 3], correlation: 0.0 };
        self.object_path.at(t).unwrap_or(origin)
    }

    /// Pose of the gripper at `t`; `None` without a gripper stream.
    fn gripper_at(&self, t: f64) -> Option<GripperPose> {
        let (k, share) = share(&self.gripper_times, t)?;
        let samples = &self.gripper.samples;
        match (&self.gripper_path, samples.get(k + 1)) {
            (Trajectory::Smoothed(_), Some(next)) => Some(samples[k].interpolate(next, share)),
            _ => samples.get(k).cloned(),
        }
    }
}

fn no_stream(episode: &str, what: &str, remedy: &str) -> Error {
    let reason = format!("the episode has no usable {what} sample");
    Fault::Unusable { reason, remedy: remedy.into() }.at(Place::episode(episode))
}

/// Converter of readings to wrenches on the object, common to all episodes.
pub(crate) struct Reader<'a> {
    meta: &'a Metadata,
    method: TareMethod,
    axes: ReadingAxes,
    weight: Option<Weight>,
}

/// Pose of the frame of a reading in the object frame, with its uncertainty.
struct FrameAt {
    pose: [f64; 3],
    /// Variance of the position along each axis, m², and of the angle, rad².
    variance: [f64; 2],
    /// Correlation time of the error, s.
    correlation: f64,
}

/// Largest tilt relative to the attitude before contact of a level gripper, rad: two degrees.
const MAX_LEVEL_TILT_RAD: f64 = 0.035;

impl<'a> Reader<'a> {
    pub fn new(meta: &'a Metadata, options: Options, episodes: &[MaskedStreams]) -> Result<Self, Error> {
        let method = options.tare;
        let mut reader = Self { meta, method, axes: options.axes, weight: None };
        if !meta.wrench.raw || method == TareMethod::Equation12 {
            return Ok(reader);
        }
        let unloaded: Vec<Vec<UnloadedReading>> =
            episodes.iter().map(|streams| reader.unloaded(streams)).collect::<Result<_, _>>()?;
        reader.weight = match (meta.wrench.gripper_mass, meta.wrench.gripper_com) {
            (Some(mass), com) => {
                let force = mass * options.gravity;
                Some(Weight { force, moment: Vector3::from(com.unwrap_or_default()) * force })
            }
            (None, _) => weigh(&unloaded),
        };
        match episodes.iter().zip(&unloaded).find(|(streams, unloaded)| tilts(streams, unloaded)) {
            Some((streams, _)) if reader.weight.is_none() => Err(unweighed(streams.name)),
            Some((streams, _)) => check_axes(streams).map(|()| reader),
            None => Ok(Self { weight: None, ..reader }),
        }
    }

    /// The planar wrenches of an episode.
    pub fn read(&self, streams: &MaskedStreams, noise: &Noise) -> Result<Readings, Error> {
        let (tare, tare_sd) = if self.meta.wrench.raw {
            let (tare, sd) = self.tare(streams, noise)?;
            (Some(tare), sd)
        } else {
            (None, [0.0; 3])
        };
        let sample = |(&t, value): (&f64, &Wrench6)| {
            self.sample(streams, t, self.planar(streams, t, &self.signed(value), tare.as_ref()))
        };
        Ok(Readings {
            wrench: streams.wrench.t.iter().zip(&streams.wrench.value).map(sample).collect(),
            tare_sd,
        })
    }

    fn tare(&self, streams: &MaskedStreams, noise: &Noise) -> Result<(Tare, [f64; 3]), Error> {
        let unloaded = self.unloaded(streams)?;
        let Some(tare) = Tare::new(self.method, &unloaded, self.weight.as_ref()) else {
            return Err(untared(streams.name, self.meta.wrench.precontact(streams.name)));
        };
        let planar: Vec<[f64; 3]> =
            unloaded.iter().map(|r| self.planar(streams, r.pose.t, &r.wrench, Some(&tare))).collect();
        let white = [noise.force, noise.force, noise.torque].map(|sd| sd / (unloaded.len() as f64).sqrt());
        let sd = [0, 1, 2].map(|k| {
            let axis: Vec<f64> = planar.iter().map(|p| p[k]).collect();
            sd_of_mean(&axis).unwrap_or(white[k])
        });
        Ok((tare, sd))
    }

    /// The readings in the interval without contact.
    fn unloaded(&self, streams: &MaskedStreams) -> Result<Vec<UnloadedReading>, Error> {
        let interval = self.meta.wrench.precontact(streams.name);
        let inside = |t: f64| interval.is_some_and(|[start, end]| start <= t && t <= end);
        let rows = (0..streams.wrench.t.len()).filter(|&i| inside(streams.wrench.t[i]));
        let unloaded: Vec<UnloadedReading> = rows
            .map(|i| UnloadedReading {
                wrench: self.signed(&streams.wrench.value[i]),
                pose: self.pose(streams, streams.wrench.t[i]),
            })
            .collect();
        if unloaded.is_empty() { Err(untared(streams.name, interval)) } else { Ok(unloaded) }
    }

    fn signed(&self, value: &Wrench6) -> Wrench6 {
        match self.meta.wrench.sign {
            Sign::OnObject => *value,
            Sign::OnSensor => value.map(|v| -v),
        }
    }

    /// Pose of the gripper at `t`; level at the world's origin without a gripper stream.
    fn pose(&self, streams: &MaskedStreams, t: f64) -> GripperPose {
        let known = streams.gripper_at(t);
        known.map_or_else(|| GripperPose::level(t, [0.0; 3]), |pose| GripperPose { t, ..pose })
    }

    fn planar(&self, streams: &MaskedStreams, t: f64, reading: &Wrench6, tare: Option<&Tare>) -> [f64; 3] {
        let pose = self.pose(streams, t);
        let mut wrench = tare.map_or(*reading, |tare| tare.apply(reading, &pose));
        for (value, present) in wrench.iter_mut().zip(streams.wrench.present) {
            *value *= f64::from(u8::from(present)); // no weight in axes that are not measured
        }
        if self.meta.wrench.frame == Frame::Sensor && !pose.is_level() {
            return pose.planar_wrench(&wrench);
        }
        [wrench[0], wrench[1], wrench[5]]
    }

    /// The sample of the planar reading `published` in published axes, transformed to the sensor frame if this is known.
    fn sample(&self, streams: &MaskedStreams, t: f64, published: [f64; 3]) -> WrenchSample {
        let (object, gripper) = (streams.object_at(t), streams.gripper_path.at(t));
        let sensor = gripper.map(|gripper| relative(&object, &gripper));
        let from = self.frame(&object, sensor.as_ref(), streams.wrench.present);
        let in_sensor = sensor.as_ref().filter(|_| self.axes == ReadingAxes::Sensor);
        let frame = in_sensor.map_or(from.pose, |sensor| sensor.pose);
        let reading =
            if frame == from.pose { published } else { transformed(&published, &from.pose, &frame) };
        let force = published[0].hypot(published[1]);
        let [position, angle] = from.variance;
        // An error of the angle rotates the force; an error of the position changes its torque (equation 13).
        let rotated = force * force * angle;
        let variance = [rotated, rotated, force * force * position];
        let frame_sd = sensor.as_ref().map_or(0.0, |sensor| sensor.variance[0].sqrt());
        WrenchSample { t, reading, frame, frame_noise: variance.map(|v| v * from.correlation), frame_sd }
    }

    /// Pose in the object frame of the frame in which the reading is published.
    fn frame(&self, object: &PoseAt, gripper: Option<&FrameAt>, present: [bool; 6]) -> FrameAt {
        let [x, y, rotation] = gripper.map_or([0.0; 3], |at| at.pose);
        let [position, relative] = gripper.map_or([0.0; 2], |at| at.variance);
        let (angle, angle_variance) = match self.meta.wrench.frame {
            Frame::Sensor => (rotation, relative),
            Frame::Object => (0.0, 0.0),
            Frame::World => (-object.pose[2], object.variance[2]),
        };
        let correlation = gripper.map_or(object.correlation, |at| at.correlation.max(object.correlation));
        match self.meta.wrench.reference_for(present) {
            Reference::Sensor => {
                FrameAt { pose: [x, y, angle], variance: [position, angle_variance], correlation }
            }
            Reference::Object => {
                FrameAt { pose: [0.0, 0.0, angle], variance: [0.0, angle_variance], correlation }
            }
        }
    }
}

/// Pose of the gripper in the object frame.
fn relative(object: &PoseAt, gripper: &PoseAt) -> FrameAt {
    let pose = relative_pose(&object.pose, &gripper.pose);
    let [a, b] = [&object.variance, &gripper.variance];
    let lever = pose[0] * pose[0] + pose[1] * pose[1];
    let position = 0.5 * (a[0] + a[1] + b[0] + b[1] + lever * a[2]);
    let correlation = object.correlation.max(gripper.correlation);
    FrameAt { pose, variance: [position, a[2] + b[2]], correlation }
}

/// Transforms `reading` from the frame at pose `from` to the frame at pose `to`.
fn transformed(reading: &[f64; 3], from: &[f64; 3], to: &[f64; 3]) -> [f64; 3] {
    planar_transform(&relative_pose(to, from), reading)
}

/// Whether the gripper tilts away from its attitude at the tare.
fn tilts(streams: &MaskedStreams, unloaded: &[UnloadedReading]) -> bool {
    let Some(tared) = unloaded.first().map(|reading| reading.pose.down()) else { return false };
    streams.gripper.samples.iter().any(|pose| pose.down().angle(&tared) > MAX_LEVEL_TILT_RAD)
}

/// Checks that a tilting sensor has all axes that the planar projection requires.
fn check_axes(streams: &MaskedStreams) -> Result<(), Error> {
    let [_, _, force_z, torque_x, torque_y, torque_z] = streams.wrench.present;
    let torques = [torque_x, torque_y, torque_z];
    // Without any torque it is a point contact, which transmits none in any attitude.
    if force_z && (torques == [true; 3] || torques == [false; 3]) {
        return Ok(());
    }
    let fault = Fault::Unusable {
        reason: "the gripper tilts, but not all axes of the sensor are recorded".into(),
        remedy: "also record force_z, torque_x and torque_y, or keep the gripper level".into(),
    };
    Err(fault.at(Place::episode(streams.name)))
}

fn unweighed(episode: &str) -> Error {
    let fault = Fault::Unusable {
        reason: "the gripper tilts away from its attitude at the tare, and its weight is unknown".into(),
        remedy:
            "set wrench.gripper_mass and wrench.gripper_com, or give intervals without contact at several \
                 attitudes (at least 0.05 rad apart) in wrench.precontact"
                .into(),
    };
    fault.at(Place::episode(episode))
}

fn untared(episode: &str, interval: Option<[f64; 2]>) -> Error {
    let reason = match interval {
        Some([start, end]) => {
            format!("no wrench sample lies in the interval without contact, [{start}, {end}] s")
        }
        None => "the wrench is raw, but the episode has no interval without contact".into(),
    };
    let remedy =
        "set wrench.precontact to an interval of this episode in which nothing touches the gripper".into();
    Fault::Unusable { reason, remedy }.at(Place::episode(episode))
}
