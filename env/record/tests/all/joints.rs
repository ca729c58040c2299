//! Reading and writing recordings of joints: round trips, models in the folder, damaged documents.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends there")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::sample::{JOINTS_CSV, JOINTS_TOML, joint_folder, joint_metadata, joint_recording};
use proptest::prelude::*;
use trundle_record::{
    AnyRecording, Axis, EffortSource, EncoderSide, Episode, FreeOr, JointMetadata, JointRecording, PerJoint,
    Recording, Table, check_joints, inspect_joints,
};

/// Any finite number, or an empty cell.
fn cell() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        2 => Just(f64::NAN),
    ]
}

/// An episode in which both joints have a position at the first time, and other cells are empty or not.
fn any_episode() -> impl Strategy<Value = Episode> {
    let row = (1e-6..1.0_f64, prop::collection::vec(cell(), 5), any::<bool>(), "[^\\x00]{0,12}");
    prop::collection::vec(row, 1..30).prop_map(|rows| {
        let mut episode = Episode { name: "episode_00".to_owned(), ..Episode::default() };
        let (mut t, mut previous) = (0.0, 1.0);
        for (step, values, on, note) in rows {
            t += step;
            episode.t.push(t);
            let mut push =
                |name: &str, cell: f64| episode.columns.entry(name.to_owned()).or_default().push(cell);
            let names = ["q_shoulder", "q_elbow", "v_elbow", "effort_elbow", "target_shoulder"];
            for (name, value) in names.into_iter().zip(values) {
                let is_needed = name == "q_shoulder" || (name == "q_elbow" && t == step);
                let value = if is_needed && value.is_nan() { previous } else { value };
                push(name, value);
                previous = if value.is_nan() { previous } else { value };
            }
            push("on_shoulder", f64::from(on));
            episode.notes.entry("note_remark".to_owned()).or_default().push(note);
        }
        episode
    })
}

fn per_joint<T: Clone + std::fmt::Debug>(
    value: impl Strategy<Value = T>,
) -> impl Strategy<Value = PerJoint<T>> {
    let table = |(values, count): (Vec<T>, usize)| {
        let joints = ["shoulder", "elbow"].into_iter().take(count).map(str::to_owned);
        PerJoint::ByJoint(joints.zip(values).collect())
    };
    (prop::collection::vec(value, 2), 0..4_usize).prop_map(move |(values, kind)| match kind {
        0 => PerJoint::All(values[0].clone()),
        count => table((values, count.min(2))),
    })
}

fn free_or() -> impl Strategy<Value = FreeOr> {
    prop_oneof![Just(FreeOr::Free), (1e-9..1e9_f64).prop_map(FreeOr::Value)]
}

/// The sample's metadata with random values.
fn any_metadata() -> impl Strategy<Value = JointMetadata> {
    let sources = [EffortSource::Measured, EffortSource::Commanded, EffortSource::Voltage];
    let drives =
        (per_joint(prop::sample::select(sources.to_vec())), per_joint(free_or()), per_joint(any::<bool>()));
    let number = || per_joint(1e-12..1e12_f64);
    let sides = per_joint(prop::sample::select(&[EncoderSide::Joint, EncoderSide::Drive][..]));
    let targets = (per_joint(free_or()), per_joint(free_or()), number());
    (drives, targets, sides, [number(), number(), number()], any::<bool>()).prop_map(
        |((source, gain, signed), (stiffness, damping, limit), side, [noise, delay, own], at_rest)| {
            let mut metadata = joint_metadata();
            metadata.effort.source = Some(source);
            // Voltages need a gain of each joint.
            metadata.effort.gain = Some(PerJoint::All(FreeOr::Free));
            metadata.effort.signed = Some(signed);
            metadata.target.stiffness = Some(stiffness);
            metadata.target.damping = Some(damping);
            metadata.encoder.side = Some(side);
            if let Some(stated) = &mut metadata.noise {
                stated.position = Some(noise);
            }
            metadata.delay.effort = Some(delay);
            metadata.start.at_rest = at_rest;
            let episode = metadata.episode.entry("episode_00".to_owned()).or_default();
            episode.effort.gain = Some(gain);
            episode.target.limit = Some(limit);
            metadata.noise.as_mut().unwrap().effort = Some(own);
            metadata
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn recordings_survive_a_round_trip(metadata in any_metadata(), first in any_episode(), mut second in any_episode()) {
        second.name = "episode_01".to_owned();
        let files = joint_recording().files;
        let recording = JointRecording::new(metadata, vec![second, first], files).unwrap();
        let home = tempfile::tempdir().unwrap();
        for table in Table::ALL {
            let path = home.path().join(table.extension());
            recording.write(&path, table).unwrap();
            prop_assert_eq!(&JointRecording::read(&path).unwrap(), &recording);
        }
        let table = recording.metadata.to_table().unwrap();
        prop_assert_eq!(&JointMetadata::from_table(table).unwrap(), &recording.metadata);
        // Values of any size do not break the checks.
        prop_assert!(check_joints(&recording).iter().all(|finding| !finding.remedy.is_empty()));
        prop_assert_eq!(inspect_joints(&recording).episodes.len(), 2);
    }
}

/// Replaces `cut` characters of `text` at `at` (modulo its length) by `patch`.
fn patched(text: &str, (at, cut, patch): &(usize, usize, String)) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    let at = at % characters.len();
    let end = (at + cut).min(characters.len());
    characters.splice(at..end, patch.chars());
    characters.into_iter().collect()
}

fn patch() -> impl Strategy<Value = (usize, usize, String)> {
    let text = prop_oneof![
        "[-+0-9.e,\\n\" {}=]{0,6}",
        "\\PC{0,3}",
        Just("nan".to_owned()),
        Just("..".to_owned()),
        Just("<include file='a'".to_owned())
    ];
    (0..2000_usize, 0..8_usize, text)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn reading_never_panics(toml in patch(), csv in patch(), model in patch()) {
        let home = tempfile::tempdir().unwrap();
        joint_folder(home.path(), &patched(JOINTS_TOML, &toml), &patched(JOINTS_CSV, &csv));
        fs::write(home.path().join("arm.xml"), patched("<mujocoinclude></mujocoinclude>", &model)).unwrap();
        if let Ok(recording) = JointRecording::read(home.path()) {
            prop_assert!(recording.validate().is_ok());
            prop_assert!(check_joints(&recording).iter().all(|finding| !finding.sentence.is_empty()));
        }
    }
}

#[test]
fn either_format_is_read() {
    let home = tempfile::tempdir().unwrap();
    let [joints, object] = ["joints", "object"].map(|name| home.path().join(name));
    joint_recording().write(&joints, Table::Csv).unwrap();
    crate::sample::recording().write(&object, Table::Csv).unwrap();
    assert_eq!(AnyRecording::read(&joints).unwrap(), AnyRecording::Joints(Box::new(joint_recording())));
    assert_eq!(
        AnyRecording::read(&object).unwrap(),
        AnyRecording::Object(Box::new(crate::sample::recording()))
    );
    assert!(Recording::read(&joints).unwrap_err().to_string().contains("JointRecording::read"));
    assert!(JointRecording::read(&object).unwrap_err().to_string().contains("Recording::read"));
    let text = JOINTS_TOML.replace("recording/2", "recording/9");
    joint_folder(&joints, &text, JOINTS_CSV);
    let error = AnyRecording::read(&joints).unwrap_err().to_string();
    assert!(error.ends_with("set format = \"trundle-recording/2\""), "{error}");
}

#[test]
fn settings_of_an_episode_override_those_of_all() {
    let metadata = joint_metadata();
    let effort = metadata.effort_of("episode_00", "shoulder");
    assert_eq!((effort.source, effort.gain), (EffortSource::Measured, FreeOr::Value(1.5)));
    let effort = metadata.effort_of("episode_00", "elbow");
    assert_eq!((effort.source, effort.gain), (EffortSource::Current, FreeOr::Value(0.21)));
    assert_eq!(metadata.effort_of("episode_01", "shoulder").gain, FreeOr::Value(1.0));
    let target = metadata.target_of("episode_00", "elbow");
    assert_eq!(
        (target.stiffness, target.damping, target.limit),
        (FreeOr::Free, FreeOr::Value(0.5), Some(3.0))
    );
    assert_eq!((metadata.delay_of("v", "elbow"), metadata.delay_of("q", "elbow")), (0.02, 0.0));
    assert_eq!(metadata.model_of("episode_00"), Some("robot.xml"));
    assert_eq!(metadata.encoder_side_of("elbow"), EncoderSide::Joint);
    assert_eq!(metadata.mechanism.axis, None::<Axis>);
}

#[test]
fn streams_leave_out_empty_cells() {
    let recording = joint_recording();
    assert_eq!(recording.stream("episode_00", "q", "elbow"), Some((vec![0.0, 0.2], vec![0.2, 0.25])));
    assert_eq!(recording.stream("episode_00", "v", "shoulder"), None);
    assert_eq!(recording.stream("episode_01", "q", "elbow"), None);
}

#[test]
fn columns_are_written_by_stream() {
    let recording = joint_recording();
    let expected = "q_elbow,q_shoulder,v_elbow,effort_elbow,effort_shoulder,target_elbow,known_elbow,on_elbow,\
         load_elbow,note_who";
    assert_eq!(recording.episodes[0].header().join(","), expected);
}

/// Relative paths of all files in `folder`.
fn listed(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => names.push(path.strip_prefix(folder).unwrap().display().to_string()),
            }
        }
    }
    names.sort();
    names
}

#[test]
fn models_are_copied_and_replaced_with_the_recording() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("run");
    let mut recording = joint_recording();
    assert_eq!(recording.files.keys().collect::<Vec<_>>(), ["arm.xml", "robot.xml"]);
    recording.metadata.mechanism.model = Some("models/robot.xml".to_owned());
    recording.metadata.episode.entry("episode_00".to_owned()).or_default().model =
        Some("heavy.urdf".to_owned());
    recording.files = [
        ("models/robot.xml", "<mujoco><include file='parts/arm.xml'/></mujoco>"),
        ("models/parts/arm.xml", "<mujoco/>"),
        ("heavy.urdf", "<robot/>"),
    ]
    .map(|(path, text)| (path.to_owned(), text.as_bytes().to_vec()))
    .into();
    recording.write(&path, Table::Csv).unwrap();
    assert_eq!(JointRecording::read(&path).unwrap(), recording);
    let expected =
        ["episode_00.csv", "heavy.urdf", "models/parts/arm.xml", "models/robot.xml", "recording.toml"];
    assert_eq!(listed(&path), expected);
    joint_recording().write(&path, Table::Parquet).unwrap();
    assert_eq!(listed(&path), ["arm.xml", "episode_00.parquet", "recording.toml", "robot.xml"]);
    // A file that the recording does not name is somebody's work.
    fs::create_dir(path.join("meshes")).unwrap();
    fs::write(path.join("meshes/link.stl"), "precious").unwrap();
    let error = recording.write(&path, Table::Csv).unwrap_err().to_string();
    assert!(error.contains("contains \"meshes/link.stl\", which is not part of a recording"), "{error}");
    assert!(path.join("meshes/link.stl").exists());
    assert_eq!(JointRecording::read(&path).unwrap(), joint_recording());
}

#[test]
fn documents_and_models_must_agree() {
    let create = |files: BTreeMap<String, Vec<u8>>| {
        let recording = joint_recording();
        JointRecording::new(recording.metadata, recording.episodes, files).unwrap_err().to_string()
    };
    let mut files = joint_recording().files;
    files.insert("link.stl".to_owned(), vec![]);
    let error = create(files.clone());
    assert!(
        error.contains("\"link.stl\" is neither a model of the recording nor included by one"),
        "{error}"
    );
    files.remove("arm.xml");
    let error = create(files.clone());
    assert!(error.contains("the model includes \"arm.xml\": the document is not among the files"), "{error}");
    files.clear();
    let error = create(files);
    assert!(
        error.contains("mechanism.model: the document is not among the files of the recording"),
        "{error}"
    );
}

#[cfg(unix)]
#[test]
fn links_out_of_the_folder_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    joint_recording().write(&run, Table::Csv).unwrap();
    fs::rename(run.join("arm.xml"), home.path().join("arm.xml")).unwrap();
    std::os::unix::fs::symlink(home.path().join("arm.xml"), run.join("arm.xml")).unwrap();
    let error = JointRecording::read(&run).unwrap_err().to_string();
    assert!(
        error.contains("the model includes \"arm.xml\": \"arm.xml\" is a link out of the folder"),
        "{error}"
    );
}
