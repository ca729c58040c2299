//! A minimal recording for the tests of this crate.
#![allow(clippy::unwrap_used, reason = "an invalid sample fails its test")]

use trundle_record::{Episode, JointMetadata, JointRecording, Metadata, Recording};

pub const TOML: &str = r#"
format = "trundle-recording/1"
name = "a table"

[object]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]

[wrench]
frame = "sensor"
reference = "sensor"
sign = "on_object"
raw = true
precontact = [0.0, 0.2]
contact = "grasp"
source = "measured"
"#;

pub const CSV: &str = "\
t,object_x,object_y,object_theta,gripper_x,gripper_y,gripper_theta,force_x,force_y,torque_z,note_who
0.0,0.0,0.0,0.0,-0.6,0.0,0.0,0.1,0.2,0.3,ann
0.1,,,,,,,0.1,0.2,0.3,
0.2,0.0,0.0,0.0,-0.6,0.0,0.0,0.1,0.2,0.3,\"bob, \"\"the\"\" builder\"
0.3,1e-3,0.0,0.0,-0.599,0.0,0.0,5.1,0.2,0.3,
";

/// The same table with a tilting gripper and all six wrench axes.
pub const TILTING: &str = "\
t,object_x,object_y,object_theta,gripper_x,gripper_y,gripper_z,gripper_qw,gripper_qx,gripper_qy,gripper_qz,\
force_x,force_y,force_z,torque_x,torque_y,torque_z
0.0,0.0,0.0,0.0,-0.6,0.0,0.8,1.0,0.0,0.0,0.0,0.1,0.2,9.3,0,0,0.3
0.1,0.0,0.0,0.0,-0.6,0.0,0.8,0.6,0.0,0.8,0.0,0.1,0.2,9.3,0,0,0.3
0.2,0.0,0.0,0.0,-0.6,0.0,0.8,0.9995,0.0,0.0,0.0,0.1,0.2,9.3,0,0,0.3
";

pub fn metadata(more: &str) -> Metadata {
    Metadata::from_toml(&format!("{TOML}{more}").replace("raw = true", "raw = false")).unwrap()
}

pub fn episode(name: &str) -> Episode {
    let home = tempfile::tempdir().unwrap();
    folder(home.path(), TOML, CSV);
    let mut episode = Recording::read(home.path()).unwrap().episodes.remove(0);
    episode.name = name.to_owned();
    episode
}

pub fn recording() -> Recording {
    Recording::new(metadata(""), vec![episode("episode_00")]).unwrap()
}

/// Metadata of a recording of two joints that sets every key.
pub const JOINTS_TOML: &str = r#"
format = "trundle-recording/2"
name = "elbow"

[mechanism]
model = "robot.xml"
joints = ["shoulder", "elbow"]
free = ["armature:elbow", "damping:elbow", "mass:forearm"]

[effort]
source = {shoulder = "measured", elbow = "current"}
gain = {elbow = 0.21}
signed = true

[target]
stiffness = "free"
damping = 0.5
limit = 3.0

[encoder]
side = "joint"

[noise]
position = 1e-4
position_step = {shoulder = 1.5e-3}
velocity = 1e-2
effort = 0.05

[delay]
v = 0.02

[episode.episode_00]
payload = {body = "forearm", mass = 0.5, com = [0.0, 0.0, 0.1]}
gain = {shoulder = 1.5}

[start]
at_rest = true

[notes]
who = "ann"
"#;

pub const JOINTS_CSV: &str = "\
t,q_shoulder,q_elbow,v_elbow,effort_shoulder,effort_elbow,target_elbow,known_elbow,on_elbow,load_elbow,note_who
0.0,0.1,0.2,0.0,1.0,2.0,0.3,0.0,1,1e5,ann
0.1,0.1,,0.0,1.0,2.0,,,,,
0.2,0.1,0.25,0.5,1.0,2.0,0.35,0.0,0,1e5,
";

/// A model that includes another document.
pub const MODEL: &str = "<mujoco><include file=\"arm.xml\"/></mujoco>";

pub fn joint_recording() -> JointRecording {
    let home = tempfile::tempdir().unwrap();
    joint_folder(home.path(), JOINTS_TOML, JOINTS_CSV);
    JointRecording::read(home.path()).unwrap()
}

pub fn joint_metadata() -> JointMetadata {
    JointMetadata::from_toml(JOINTS_TOML).unwrap()
}

/// Writes a recording of joints with one episode and its model to the folder `path`.
pub fn joint_folder(path: &std::path::Path, toml: &str, csv: &str) {
    folder(path, toml, csv);
    std::fs::write(path.join("robot.xml"), MODEL).unwrap();
    std::fs::write(path.join("arm.xml"), "<mujocoinclude/>").unwrap();
}

/// Writes a recording with one episode to the folder `path`.
pub fn folder(path: &std::path::Path, toml: &str, csv: &str) {
    std::fs::write(path.join("recording.toml"), toml).unwrap();
    std::fs::write(path.join("episode_00.csv"), csv).unwrap();
}
