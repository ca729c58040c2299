"""ROS 2 bags, written by rosbags' own writer."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.importers.bagwriter import BAG_MAP, EPOCH, Messages, Push, pose_stamped, write_bag
from trundle.importers import Imported, MapError, SourceError

Import = Callable[[Path, str, dict[str, Any]], Imported]
OBJECT = ["object_x", "object_y", "object_theta"]
GRIPPER = ["gripper_x", "gripper_y", "gripper_theta"]
WRENCH = ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"]


def samples(table: dict[str, Any], names: list[str]) -> tuple[Any, Any]:
    """Return times and values of one stream of a table."""
    values = np.column_stack([table[name] for name in names])
    there = ~np.isnan(values).any(axis=1)
    return table["t"][there], values[there]


def check_push(table: dict[str, Any], push: Push) -> None:
    for names, t, expected in (
        (OBJECT, push.t, push.object),
        (GRIPPER, push.t, push.gripper),
        (WRENCH, push.wrench_t, push.wrench),
    ):
        times, values = samples(table, names)
        np.testing.assert_allclose(times, t, atol=1e-9)
        np.testing.assert_allclose(values, expected, atol=1e-9)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("kind", ["pose", "odometry"])
def test_a_bag_gives_the_measurements(imported: Import, tmp_path: Path, storage: str, kind: Any) -> None:
    push = Push()
    bag = write_bag(tmp_path / "bag", push.messages(kind=kind), storage)
    got = imported(bag, "rosbag2", BAG_MAP)
    check_push(got.episodes["episode_00"], push)
    assert got.metadata["name"] == "bag"


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_single_file_equals_its_folder(imported: Import, tmp_path: Path, storage: str) -> None:
    folder = write_bag(tmp_path / "bag", Push().messages(), storage)
    (file,) = (path for path in folder.iterdir() if path.suffix in (".mcap", ".db3"))
    check_push(imported(file, "mcap", BAG_MAP).episodes["episode_00"], Push())


def test_header_stamps_are_the_default(imported: Import, tmp_path: Path) -> None:
    push = Push()
    messages = push.messages()
    # Messages of the sensor were logged 80 ms after the measurement.
    late = [(topic, kind, ns + 80_000_000 * (topic == "/ft"), m) for topic, kind, ns, m in messages]
    bag = write_bag(tmp_path / "bag", late)
    check_push(imported(bag, "rosbag2", BAG_MAP).episodes["episode_00"], push)
    logged = imported(bag, "rosbag2", {**BAG_MAP, "stamp": "log"}).episodes["episode_00"]
    np.testing.assert_allclose(samples(logged, WRENCH)[0], push.wrench_t + 0.08, atol=1e-9)


def test_headers_without_time_are_refused(imported: Import, tmp_path: Path) -> None:
    messages = [
        (topic, kind, ns, pose_stamped(0, (0, 0, 0), (1, 0, 0, 0)) if topic == "/table" else m)
        for topic, kind, ns, m in Push().messages()
    ]
    with pytest.raises(SourceError, match=r'headers of /table contain no time; set `stamp = "log"`'):
        imported(write_bag(tmp_path / "bag", messages), "rosbag2", BAG_MAP)


def test_a_tilted_sensor_keeps_its_quaternion(imported: Import, tmp_path: Path) -> None:
    push = Push()
    bag = write_bag(tmp_path / "bag", push.messages(leaning=0.1))
    table = imported(bag, "rosbag2", BAG_MAP).episodes["episode_00"]
    assert "gripper_theta" not in table
    _, q = samples(table, ["gripper_qw", "gripper_qx", "gripper_qy", "gripper_qz"])
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2), np.cos(0.1), atol=1e-12)
    level = {**BAG_MAP, "gripper": {**BAG_MAP["gripper"], "level_within_deg": 10.0}}
    check_push(imported(bag, "rosbag2", level).episodes["episode_00"], push)


def test_an_upside_down_sensor_is_rotated_with_its_wrench(imported: Import, tmp_path: Path) -> None:
    push = Push()
    got = imported(write_bag(tmp_path / "bag", push.messages(hanging=True)), "rosbag2", BAG_MAP)
    check_push(got.episodes["episode_00"], push)
    assert any("upside down" in remark for remark in got.remarks)


def test_the_offset_transforms_the_tracked_frame(imported: Import, tmp_path: Path) -> None:
    """The marker is 0.1 m ahead of the object's origin and rotated by 90°."""
    push = Push()
    bag = write_bag(tmp_path / "bag", push.messages())
    offset = {"translation": [0.1, 0.0, -0.7], "rpy_deg": [0.0, 0.0, 90.0]}
    got = imported(bag, "rosbag2", {**BAG_MAP, "object": {"topic": "/table", "offset": offset}})
    _, pose = samples(got.episodes["episode_00"], OBJECT)
    theta = push.object[:, 2]
    expected = push.object[:, :2] + 0.1 * np.column_stack([np.cos(theta), np.sin(theta)])
    np.testing.assert_allclose(pose[:, :2], expected, atol=1e-9)
    np.testing.assert_allclose(pose[:, 2], theta + np.pi / 2, atol=1e-9)


def test_a_bag_is_cut_into_episodes(imported: Import, tmp_path: Path) -> None:
    push = Push()
    cuts = [{"name": "a", "end": 0.5}, {"name": "b", "start": 1.0, "end": 1.5}]
    got = imported(write_bag(tmp_path / "bag", push.messages()), "rosbag2", {**BAG_MAP, "episode": cuts})
    assert list(got.episodes) == ["a", "b"]
    t, pose = samples(got.episodes["b"], OBJECT)
    inside = (push.t >= 1.0) & (push.t <= 1.5)
    np.testing.assert_allclose(t, push.t[inside] - 1.0, atol=1e-9)
    np.testing.assert_allclose(pose, push.object[inside], atol=1e-9)


def test_several_bags_are_several_episodes(imported: Import, tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    write_bag(folder / "run_2", Push().messages())
    bare = write_bag(tmp_path / "other", Push().messages())
    shutil.copy(next(bare.glob("*.mcap")), folder / "run_1.mcap")
    assert list(imported(folder, "rosbag2", BAG_MAP).episodes) == ["episode_00", "episode_01"]
    named = [{"name": "late", "source": "run_2", "start": 1.0}]
    assert list(imported(folder, "rosbag2", {**BAG_MAP, "episode": named}).episodes) == ["late"]
    with pytest.raises(MapError, match=r"'late': `source` = None; it must be one of run_1.mcap, run_2"):
        imported(folder, "rosbag2", {**BAG_MAP, "episode": [{"name": "late"}]})


def test_lost_and_repeated_poses_are_left_out_and_counted(imported: Import, tmp_path: Path) -> None:
    push = Push()
    messages: Messages = []
    for topic, kind, ns, message in push.messages():
        messages.append((topic, kind, ns, message))
        if topic == "/table":
            # A relay repeats every message after 5 ms; the tracker loses the table at 1 s.
            again = pose_stamped(ns + 5_000_000, (0, 0, 0), (0, 0, 0, 0))
            again.pose = message.pose if ns < EPOCH + 10**9 else again.pose
            messages.append((topic, kind, ns + 5_000_000, again))
    messages.sort(key=lambda each: each[2])
    bag = write_bag(tmp_path / "bag", messages)
    got = imported(bag, "rosbag2", BAG_MAP)
    check_push(got.episodes["episode_00"], push)
    assert "/table: 50 poses of a lost tracker omitted" in got.remarks
    assert "/table: 50 samples repeated omitted" in got.remarks
    kept = imported(bag, "rosbag2", {**BAG_MAP, "keep_repeats": True}).episodes["episode_00"]
    assert len(samples(kept, OBJECT)[0]) == 150


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"object": {"topic": "/chair"}},
            r"no topic '/chair' for object; the topics are: /ft \(geometry_",
        ),
        (
            {"object": {"topic": "/ft"}},
            "for object has the type geometry_msgs/msg/WrenchStamped; it must be one of",
        ),
        ({"gripper": {"topic": "/tf"}}, "`gripper.frame` is missing: give a child frame of /tf"),
        (
            {"gripper": {"topic": "/tf", "frame": "foot"}},
            "has the frame 'foot' for gripper; the frames are elbow, hand",
        ),
        (
            {"episode": [{"name": "a", "start": 5.0}]},
            "contains no sample of object_x, object_y, object_theta; the take lasts 1.995 s",
        ),
        ({"world": {"plane": ["x", "-x"]}}, "names one axis twice"),
        (
            {"world": {"plane": ["z", "x"]}},
            "z axis of the object frame is tilted by 90 degrees from up; set `world.plane`",
        ),
        ({"wrench": {"topic": "/ft", "offset": {}}}, "unknown key `wrench.offset`; known are `topic`"),
        ({"object": {"topic": "/table", "level_within_deg": 1.0}}, "unknown key `object.level_within_deg`"),
        ({"gripper": {"frame": "hand"}}, "`gripper.topic` is missing; it is a string"),
        ({"wrenches": {}}, "unknown key `wrenches`; did you mean `wrench`"),
    ],
)
def test_mismatches_are_named(imported: Import, tmp_path: Path, change: dict[str, Any], message: str) -> None:
    bag = write_bag(tmp_path / "bag", Push().messages())
    with pytest.raises(ValueError, match=message):
        imported(bag, "rosbag2", {**BAG_MAP, **change})


def test_a_truncated_bag_is_refused(imported: Import, tmp_path: Path) -> None:
    folder = write_bag(tmp_path / "bag", Push().messages())
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(next(folder.glob("*.mcap")).read_bytes()[:5000])
    with pytest.raises(SourceError, match=r"torn\.mcap: damaged bag"):
        imported(torn, "mcap", BAG_MAP)


def test_a_ros_1_bag_is_refused_with_a_remedy(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "old.bag").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(SourceError, match="rosbags-convert"):
        imported(tmp_path / "old.bag", "rosbag2", BAG_MAP)


def test_the_example_map_makes_a_recording(tmp_path: Path) -> None:
    from trundle.importers import read

    messages = [
        ({"/table": "/mocap/table/pose", "/ft": "/ft_sensor/wrench"}.get(topic, topic), kind, ns, message)
        for topic, kind, ns, message in Push().messages()
    ]
    for _, kind, _, message in messages:
        if kind.endswith("TFMessage"):
            message.transforms[0].child_frame_id = "tool0"
    example = Path(__file__).parents[2] / "configs" / "import" / "bag.toml"
    got = read(write_bag(tmp_path / "bag", messages), "rosbag2", example)
    recording = trundle.Recording(got.metadata, got.episodes)
    assert list(recording.episodes) == ["push_1", "push_2"]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("seed", range(12))
def test_damaged_bytes_are_refused_or_read(imported: Import, tmp_path: Path, storage: str, seed: int) -> None:
    folder = write_bag(tmp_path / "bag", Push().messages(), storage)
    (whole,) = (path for path in folder.iterdir() if path.suffix in (".mcap", ".db3"))
    rng = np.random.default_rng(seed)
    data = np.frombuffer(whole.read_bytes(), dtype=np.uint8).copy()
    data[rng.integers(len(data), size=20)] = rng.integers(256, size=20)
    damaged = tmp_path / f"damaged{whole.suffix}"
    damaged.write_bytes(data.tobytes())
    try:
        imported(damaged, "rosbag2", BAG_MAP)
    except ValueError as error:
        assert "damaged" in str(error) or "quaternion" in str(error)
