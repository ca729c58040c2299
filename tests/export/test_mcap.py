"""Recordings as MCAP: other libraries read ROS messages, and `trundle import` restores every bit."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.interfaces import ConnectionExtRosbag2, QosDurability
from rosbags.rosbag2 import Reader, Writer
from rosbags.typesys import Stores, get_typestore

import trundle
from trundle.cli import main
from trundle.export import write_mcap
from trundle.importers import read

DEMO = Path(__file__).parents[2] / "configs" / "experiments" / "demo.toml"
OBJECT = ["object_x", "object_y", "object_theta"]
GRIPPER = ["gripper_x", "gripper_y", "gripper_theta"]
WRENCH = ["force_x", "force_y", "torque_z"]
METADATA: dict[str, Any] = {
    "format": "trundle-recording/1",
    "name": 'a "table", ünnamed',
    "object": {"footprint": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0 / 3.0]]},
    "wrench": {"frame": "object", "sign": "on_object"},
}
N = 60


@pytest.fixture(scope="module")
def recording() -> trundle.Recording:
    """Two pushes of the demo, one held out, with lost poses and skipped readings."""
    whole = trundle.simulate(DEMO)
    episodes = {}
    for name in ("episode_00", "episode_06"):
        table = whole.frame(name)
        table.loc[100:180, OBJECT + GRIPPER] = np.nan
        table.loc[::7, WRENCH] = np.nan
        episodes[name] = table.dropna(subset=["object_x", "force_x"], how="all")
    split = {"held_out": ["episode_06"]}
    return trundle.Recording(whole.metadata | {"split": split, "notes": {"floor": 0.1}}, episodes)


def columns(names: list[str], seed: int = 0) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=N) for name in names}


def every(k: int, names: list[str]) -> dict[str, Any]:
    """Return columns with a sample in every k-th row."""
    return {
        name: np.where(np.arange(N) % k == 0, values, np.nan) for name, values in columns(names, k).items()
    }


def tilting() -> dict[str, Any]:
    parts = np.random.default_rng(1).normal(size=(4, N))
    names = [f"gripper_{part}" for part in ("qw", "qx", "qy", "qz")]
    return columns(["gripper_x", "gripper_y", "gripper_z"]) | dict(
        zip(names, parts / np.linalg.norm(parts, axis=0), strict=True)
    )


def notes() -> list[str]:
    return ["" if row % 5 else f'stück "{row}",\nnext' for row in range(N)]


PLANAR = {"t": np.arange(N) * 0.01} | columns(OBJECT + WRENCH)
TABLES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "headings of many turns": ({}, PLANAR | {"object_theta": np.linspace(-50.0, 50.0, N)}),
    "times that are no whole nanoseconds": ({}, PLANAR | {"t": (np.arange(N) - 7) / 3.0}),
    "times since 1970": ({}, PLANAR | {"t": 1.75e9 + np.arange(N) / 3.0}),
    "a gripper that tilts": ({}, PLANAR | tilting()),
    "a gripper that was never seen": ({}, PLANAR | dict.fromkeys(GRIPPER, np.full(N, np.nan))),
    "six axes": ({}, PLANAR | columns(["force_z", "torque_x", "torque_y"], 3)),
    "streams out of step": ({}, PLANAR | every(2, OBJECT) | every(3, GRIPPER)),
    "notes": ({}, PLANAR | {"note_what": notes(), "note_größe": [""] * N}),
    "a rail": (
        {"object": {"dof": ["x"]}, "wrench": {"frame": "world", "sign": "on_object"}},
        {"t": PLANAR["t"]} | columns(["object_x", "force_x"]),
    ),
}


def back(path: Path) -> trundle.Recording:
    imported = read(path, "mcap")
    return trundle.Recording(imported.metadata, imported.episodes)


@pytest.mark.parametrize("case", TABLES)
def test_the_round_trip_is_exact(case: str, tmp_path: Path) -> None:
    metadata, table = TABLES[case]
    recording = trundle.Recording(METADATA | metadata, {"push 1": table, "push 2": table})
    assert back(write_mcap(recording, tmp_path / "table.mcap")) == recording


def test_the_round_trip_on_the_command_line(
    recording: trundle.Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording.write(tmp_path / "run")
    file = tmp_path / "made" / "run.mcap"
    assert main(["export", str(tmp_path / "run"), "--mcap", str(file)]) == 0
    assert capsys.readouterr().out == f"{file}\n"
    assert list(file.parent.iterdir()) == [file]
    assert main(["import", str(file), "--out", str(tmp_path / "again")]) == 0
    again = trundle.read(tmp_path / "again")
    assert again == recording
    assert again.metadata == recording.metadata
    assert again.metadata["split"]["held_out"] == ["episode_06"]


def messages(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return log time and content of the messages by topic."""
    store = get_typestore(Stores.LATEST)
    heard: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with Reader(path) as reader:
        for connection, stamp, data in reader.messages():
            heard[connection.topic].append((stamp, store.deserialize_cdr(data, connection.msgtype)))
    return heard


def test_other_libraries_read_the_ros_messages(recording: trundle.Recording, tmp_path: Path) -> None:
    file = write_mcap(recording, tmp_path / "run.mcap")
    heard = messages(file)
    with Reader(file) as reader:
        types = {each.topic: each.msgtype for each in reader.connections}
        qos = {
            each.topic: each.ext.offered_qos_profiles
            for each in reader.connections
            if isinstance(each.ext, ConnectionExtRosbag2)
        }
    assert types == {
        "/trundle/recording": "std_msgs/msg/String",
        "/episode/name": "std_msgs/msg/String",
        "/episode/time": "std_msgs/msg/Float64",
        "/object/pose": "geometry_msgs/msg/PoseStamped",
        "/object/heading": "std_msgs/msg/Float64",
        "/gripper/pose": "geometry_msgs/msg/PoseStamped",
        "/gripper/heading": "std_msgs/msg/Float64",
        "/wrench": "geometry_msgs/msg/WrenchStamped",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/scene/object": "visualization_msgs/msg/MarkerArray",
        "/scene/wrench": "visualization_msgs/msg/MarkerArray",
    }
    assert qos["/episode/name"][0].durability == QosDurability.TRANSIENT_LOCAL
    assert qos["/wrench"] == []
    whole = {name: np.concatenate([e[name] for e in recording.episodes.values()]) for name in OBJECT + WRENCH}
    poses = [message.pose for _, message in heard["/object/pose"]]
    seen = ~np.isnan(whole["object_x"])
    assert [pose.position.x for pose in poses] == whole["object_x"][seen].tolist()
    assert [pose.position.y for pose in poses] == whole["object_y"][seen].tolist()
    theta = np.array([2.0 * np.arctan2(pose.orientation.z, pose.orientation.w) for pose in poses])
    assert np.abs(np.sin((theta - whole["object_theta"][seen]) / 2.0)).max() < 1e-15
    wrenches = [message.wrench for _, message in heard["/wrench"]]
    read_at = ~np.isnan(whole["force_x"])
    assert [wrench.force.x for wrench in wrenches] == whole["force_x"][read_at].tolist()
    assert [wrench.torque.z for wrench in wrenches] == whole["torque_z"][read_at].tolist()
    assert {message.header.frame_id for _, message in heard["/object/pose"]} == {"world"}
    assert {message.header.frame_id for _, message in heard["/wrench"]} == {"gripper"}
    for stamp, message in heard["/wrench"] + heard["/gripper/pose"]:
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    (begin, first), (later, second) = heard["/episode/name"]
    assert (first.data, second.data) == tuple(recording.episodes)
    t = recording.episodes["episode_00"]["t"]
    rows = [stamp for stamp, _ in heard["/episode/time"]]
    assert rows[: len(t)] == [begin + round((time - t[0]) * 1e9) for time in t.tolist()]
    assert rows[len(t)] == later == rows[len(t) - 1] + 10**9


def test_the_scene_is_drawn_from_frames_and_markers(recording: trundle.Recording, tmp_path: Path) -> None:
    heard = messages(write_mcap(recording, tmp_path / "run.mcap"))
    prepared = trundle.prepare(recording)
    frames: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    for stamp, message in heard["/tf"]:
        (each,) = message.transforms
        assert each.header.frame_id == "world"
        frames[each.child_frame_id].append((stamp, each.transform))
    for frame in ("object", "gripper"):
        poses = heard[f"/{frame}/pose"]
        assert [stamp for stamp, _ in frames[frame]] == [stamp for stamp, _ in poses]
        for (_, placed), (_, message) in zip(frames[frame], poses, strict=True):
            assert placed.translation.x == message.pose.position.x
            assert placed.translation.y == message.pose.position.y
            assert placed.rotation == message.pose.orientation
    assert [stamp for stamp, _ in heard["/scene/object"]] == [stamp for stamp, _ in heard["/episode/name"]]
    outline, feet = heard["/scene/object"][0][1].markers
    assert (outline.ns, outline.type, outline.header.frame_id) == ("outline", outline.LINE_STRIP, "object")
    corners = [[point.x, point.y] for point in outline.points]
    assert corners == [*(shape := recording.metadata["object"]["footprint"]), shape[0]]
    assert (feet.ns, feet.type) == ("feet", feet.SPHERE_LIST)
    assert [[point.x, point.y] for point in feet.points] == recording.metadata["object"]["support"]
    arrows = [message.markers[0] for _, message in heard["/scene/wrench"]]
    ends = np.array([[[point.x, point.y] for point in arrow.points] for arrow in arrows])
    push = np.concatenate([each["on_object"][:, :2] for each in prepared.values()])
    foot = np.concatenate([each["frame"][:, :2] for each in prepared.values()])
    assert {(arrow.type, arrow.header.frame_id) for arrow in arrows} == {(0, "object")}
    np.testing.assert_allclose(ends[:, 0], foot, atol=1e-12)
    drawn = ends[:, 1] - ends[:, 0]
    np.testing.assert_allclose(drawn * np.linalg.norm(push) / np.linalg.norm(drawn), push, atol=1e-9)
    t = recording.episodes["episode_00"]["t"]
    begin = heard["/episode/name"][0][0]
    stamps = [begin + round((time - t[0]) * 1e9) for time in prepared["episode_00"]["wrench_t"].tolist()]
    assert [stamp for stamp, _ in heard["/scene/wrench"]][: len(stamps)] == stamps


def test_schemas_are_embedded(recording: trundle.Recording, tmp_path: Path) -> None:
    content = write_mcap(recording, tmp_path / "run.mcap").read_bytes()
    for definition in (b"MSG: geometry_msgs/TransformStamped", b"MSG: visualization_msgs/Marker"):
        assert definition in content


def test_obstacles_are_drawn_and_unusable_wrenches_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: Any) -> None:
        raise trundle.TrundleError("the wrench cannot be tared")

    monkeypatch.setattr("trundle.export.markers.recorded_episodes", refuse)
    box = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0]]
    recording = trundle.Recording(METADATA | {"scene": {"obstacle": [{"polygon": box}]}}, {"a": PLANAR})
    file = write_mcap(recording, tmp_path / "run.mcap")
    heard = messages(file)
    assert "/scene/wrench" not in heard
    outline, obstacle = heard["/scene/object"][0][1].markers
    assert (outline.header.frame_id, obstacle.header.frame_id) == ("object", "world")
    assert [[point.x, point.y] for point in obstacle.points] == [*box, box[0]]
    assert back(file) == recording


def test_a_map_overrides_the_embedded_metadata(recording: trundle.Recording, tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text("".join(f'[{role}]\ntopic = "/{role}/pose"\n' for role in ("object", "gripper")))
    path.write_text(path.read_text() + '[wrench]\ntopic = "/wrench"\n[[episode]]\nname = "a"\nend = 2.0\n')
    table = read(write_mcap(recording, tmp_path / "run.mcap"), "mcap", path).episodes["a"]
    expected = recording.episodes["episode_00"]["gripper_theta"][: len(table["t"])]
    np.testing.assert_allclose(table["gripper_theta"], expected, atol=1e-12)


def test_only_an_earlier_export_is_replaced(recording: trundle.Recording, tmp_path: Path) -> None:
    file = write_mcap(trundle.Recording(METADATA, {"a": PLANAR}), tmp_path / "run.mcap")
    assert back(write_mcap(recording, file)) == recording
    once = file.read_bytes()
    assert write_mcap(recording, file).read_bytes() == once
    for broken in (b"", b"my bag", once[:-500]):
        file.write_bytes(broken)
        with pytest.raises(trundle.TrundleError, match=r"run\.mcap: exists and is not an export"):
            write_mcap(recording, file)
        assert file.read_bytes() == broken


def test_an_interrupted_export_changes_nothing(
    recording: trundle.Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write_mcap(recording, tmp_path / "run.mcap")
    before, write = file.read_bytes(), Writer.write

    def interrupted(writer: Writer, connection: Any, stamp: int, data: Any) -> None:
        if sum(writer.counts.values()) == 100:
            raise KeyboardInterrupt
        write(writer, connection, stamp, data)

    monkeypatch.setattr(Writer, "write", interrupted)
    for name in ("run.mcap", "other.mcap"):
        with pytest.raises(KeyboardInterrupt):
            write_mcap(recording, tmp_path / name)
    assert list(tmp_path.iterdir()) == [file]
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("t", "message"),
    [
        (
            np.append(np.arange(N - 1.0), N - 2.0 + 1e-10),
            r"episode a, row 60, column t: .* merge the two rows",
        ),
        (np.arange(N) * 1e8, r"episode a: lasts 5\.9e\+09 s, which exceeds the largest ROS stamp"),
    ],
)
def test_times_out_of_range_are_refused(t: Any, message: str, tmp_path: Path) -> None:
    recording = trundle.Recording(METADATA, {"a": PLANAR | {"t": t}})
    with pytest.raises(trundle.TrundleError, match=message):
        write_mcap(recording, tmp_path / "run.mcap")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["empty", "--mcap", "a.mcap"], "empty: the folder has no recording.toml"),
        (["run", "--mcap", "a.bag"], "--mcap a.bag: unknown suffix '.bag'"),
        (["run", "--mcap", "folder.mcap"], "--mcap folder.mcap: is a folder; give a file"),
        (
            ["run", "--mcap", "a.mcap", "--out", "b"],
            "--mcap a.mcap: --out and --footprint apply only to --mujoco",
        ),
        (["run"], "run: is a folder, not a model file; use --mcap FILE for a recording"),
    ],
)
def test_unsupported_input_is_refused(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    trundle.Recording(METADATA, {"a": PLANAR}).write("run")
    for folder in ("empty", "folder.mcap"):
        (tmp_path / folder).mkdir()
    before = sorted(tmp_path.iterdir())
    assert main(["export", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


def test_another_format_is_named(
    recording: trundle.Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trundle.export.mcap.FORMAT", "trundle-mcap/9")
    file = write_mcap(recording, tmp_path / "run.mcap")
    with pytest.raises(
        ValueError, match=r"run\.mcap: .*'trundle-mcap/9'; this trundle reads 'trundle-mcap/1'"
    ):
        read(file, "mcap")
