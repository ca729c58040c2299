"""JointState messages and commands in ROS 2 bags."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.importers.conftest import Import
from tests.importers.joint_bags import (
    CONTROLLER,
    JOINT_STATE,
    NUMBERS,
    STATES_TOPIC,
    TRAJECTORY,
    array,
    at,
    controller_state,
    joint_state,
    point,
    states,
    trajectory,
    write_joint_bag,
)
from tests.importers.mechanisms import check_joints

T = np.arange(50) * 0.01
HINGE = {"mechanism": {"axis": "hinge", "gravity": True}}
ELBOW: dict[str, Any] = {"joints": ["elbow"], "recording": HINGE}
BOTH: dict[str, Any] = {
    "joints": ["shoulder", "elbow"],
    "recording": {"mechanism": {"model": "robot.xml"}, "effort": {"source": "current", "gain": 0.1}},
}


@pytest.fixture(autouse=True)
def model(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text("<mujoco/>")


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_joints_are_found_by_name_in_any_order(imported: Import, tmp_path: Path, storage: str) -> None:
    got = imported(write_joint_bag(tmp_path / "run", states(), storage), "rosbag2", BOTH)
    check_joints(got)
    table = got.episodes["episode_00"]
    np.testing.assert_allclose(table["t"], T, atol=1e-9)
    np.testing.assert_allclose(table["q_elbow"], T, atol=1e-9)
    np.testing.assert_allclose(table["q_shoulder"], -T, atol=1e-9)
    np.testing.assert_array_equal(table["v_shoulder"], -1.0)
    np.testing.assert_allclose(table["effort_elbow"], 2.0 * T, atol=1e-9)
    assert got.metadata["name"] == "run" and got.remarks == []


def test_names_of_the_model_may_differ_from_those_of_the_bag(imported: Import, tmp_path: Path) -> None:
    bag = write_joint_bag(tmp_path / "run", states())
    got = imported(bag, "mcap", ELBOW | {"joints": {"joint_2": "elbow"}})
    check_joints(got)
    np.testing.assert_allclose(got.episodes["episode_00"]["q_joint_2"], T, atol=1e-9)


def test_partial_messages_and_missing_values(imported: Import, tmp_path: Path) -> None:
    """Two drivers publish one joint each; one has no velocity, and the other never measures effort."""
    said = []
    for k in range(20):
        one = joint_state(at(k * 0.01), ["elbow"], [k], [np.nan], [k - 5])
        other = joint_state(at(k * 0.01 + 0.003), ["shoulder"], [2 * k], [k], [0.0])
        said += [
            (STATES_TOPIC, JOINT_STATE, at(k * 0.01), one),
            (STATES_TOPIC, JOINT_STATE, at(k * 0.01 + 0.004), other),
        ]
    got = imported(write_joint_bag(tmp_path / "run", said), "mcap", BOTH | {"angle": "radians"})
    check_joints(got)
    table = got.episodes["episode_00"]
    assert set(table) == {"t", "q_shoulder", "q_elbow", "v_shoulder", "effort_elbow"}
    assert "effort_shoulder: omitted, 0 in all messages, so that it was not measured" in got.remarks
    assert "v_elbow: omitted, no sample while the positions were recorded" in got.remarks
    assert "q_elbow: 1 samples outside the interval of all positions omitted" in got.remarks
    np.testing.assert_array_equal(np.isfinite(table["q_elbow"]), ~np.isfinite(table["q_shoulder"]))


def targets(tmp_path: Path, imported: Import, said: Any, **more: Any) -> Any:
    """Import states with commands; return times and values of the elbow's target."""
    bag = write_joint_bag(tmp_path / "run", states() + said)
    got = imported(bag, "mcap", ELBOW | more)
    check_joints(got)
    table = got.episodes["episode_00"]
    there = np.isfinite(table["target_elbow"])
    return table["t"][there], table["target_elbow"][there]


def test_a_new_trajectory_replaces_the_rest_of_the_old_one(imported: Import, tmp_path: Path) -> None:
    names = ["wrist", "elbow"]
    points = [point([0.0, value], after) for value, after in ((1.0, 0.05), (2.0, 0.1), (3.0, 0.3))]
    said = [
        ("/go", TRAJECTORY, at(-0.02), trajectory(at(-0.02), names, [point([0.0, 0.5])])),
        # A stamp of zero means "now": the time of the log.
        ("/go", TRAJECTORY, at(0.0), trajectory(0, names, points)),
        ("/go", TRAJECTORY, at(0.2), trajectory(at(0.2), names[::-1], [point([4.0, 0.0], 0.02)])),
    ]
    t, target = targets(tmp_path, imported, said, target={"topic": "/go"})
    np.testing.assert_allclose(t, [0.0, 0.05, 0.1, 0.22], atol=1e-9)
    np.testing.assert_array_equal(target, [0.5, 1.0, 2.0, 4.0])


def test_targets_of_a_controller_and_of_joint_states(imported: Import, tmp_path: Path) -> None:
    said = [
        ("/state", CONTROLLER, at(0.1) + 5, controller_state(at(0.1), ["elbow", "wrist"], [0.7, 0.0])),
        ("/cmd", JOINT_STATE, at(0.1), joint_state(at(0.1), ["elbow"], [0.9])),
        ("/all", NUMBERS, at(0.1), array([0.0, 0.3])),
    ]
    order = {"topic": "/all", "order": ["wrist", "elbow"]}
    for number, (topic, expected) in enumerate(
        [({"topic": "/state"}, 0.7), ({"topic": "/cmd"}, 0.9), (order, 0.3)]
    ):
        t, target = targets(tmp_path / str(number), imported, said, target=topic)
        np.testing.assert_allclose(t, [0.1], atol=1e-9)
        np.testing.assert_array_equal(target, [expected])


def test_a_bag_without_definitions_is_refused(imported: Import, tmp_path: Path) -> None:
    said = [("/state", CONTROLLER, at(0.1), controller_state(at(0.1), ["elbow"], [0.7]))]
    bag = write_joint_bag(tmp_path / "run", states() + said, "sqlite3")
    with closing(sqlite3.connect(next(bag.glob("*.db3")))) as base:
        base.execute("DELETE FROM message_definitions WHERE topic_type LIKE 'control_msgs%'")
        base.commit()
    with pytest.raises(
        ValueError, match=f"run: does not define the type {CONTROLLER} of /state; record with"
    ):
        imported(bag, "rosbag2", ELBOW | {"target": {"topic": "/state"}})


def test_commanded_efforts_replace_those_of_the_state(imported: Import, tmp_path: Path) -> None:
    said = [("/effort", NUMBERS, at(0.01 * k), array([k, 0.0])) for k in range(0, 50, 10)]
    bag = write_joint_bag(tmp_path / "run", states() + said)
    settings = ELBOW | {"effort": {"topic": "/effort", "order": ["elbow", "wrist"]}}
    table = imported(bag, "mcap", settings).episodes["episode_00"]
    there = np.isfinite(table["effort_elbow"])
    np.testing.assert_array_equal(table["effort_elbow"][there], [0.0, 10.0, 20.0, 30.0, 40.0])


def test_the_time_of_the_log(imported: Import, tmp_path: Path) -> None:
    said = [(STATES_TOPIC, JOINT_STATE, at(k), joint_state(0, ["elbow"], [0.1 * k])) for k in range(3)]
    bag = write_joint_bag(tmp_path / "run", said)
    for settings in (ELBOW, ELBOW | {"stamp": "log"}):
        np.testing.assert_allclose(
            imported(bag, "mcap", settings).episodes["episode_00"]["t"], [0.0, 1.0, 2.0]
        )


def test_states_without_positions_are_refused(imported: Import, tmp_path: Path) -> None:
    said = [(STATES_TOPIC, JOINT_STATE, at(k), joint_state(at(k), ["elbow"], [])) for k in range(3)]
    bag = write_joint_bag(tmp_path / "run", said)
    with pytest.raises(ValueError, match="run: no position of joint 'elbow'"):
        imported(bag, "mcap", ELBOW)


def test_several_bags_are_named_episodes(imported: Import, tmp_path: Path) -> None:
    for name in ("light", "heavy"):
        write_joint_bag(tmp_path / "runs" / name, states())
    got = imported(tmp_path / "runs", "rosbag2", ELBOW)
    check_joints(got)
    assert list(got.episodes) == ["heavy", "light"]
    cut = [{"name": "end", "source": "heavy", "start": 0.195, "end": 0.305}]
    table = imported(tmp_path / "runs", "rosbag2", ELBOW | {"episode": cut}).episodes["end"]
    np.testing.assert_allclose(table["q_elbow"], T[20:31], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"joints": ["knee"]},
            r"no joint 'knee' on /joint_states for state; the joints are elbow, gripper, shoulder",
        ),
        ({"state": {"topic": "/states"}}, r"no topic '/states' for state; the topics are: /cmd"),
        (
            {"target": {"topic": "/cmd"}},
            r"map\.toml: `target\.order` is missing: the messages on /cmd have no names",
        ),
        (
            {"target": {"topic": "/cmd", "order": ["elbow"]}},
            r"message 1 on /cmd: position has 2 values for 1 joints \(elbow\)",
        ),
        (
            {"target": {"topic": "/cmd", "order": ["wrist", "hip"]}},
            r"no joint 'elbow' on /cmd for target; the joints are hip",
        ),
        (
            {"target": {"topic": "/wrong"}},
            r"message 3 on /wrong: position has 1 values for 2 joints \(elbow, wrist\); omit",
        ),
        ({"target": {"topic": "/none"}}, r"/none for target has no messages|no topic '/none'"),
        (
            {"effort": {"topic": "/imu"}},
            r"topic /imu for effort has the type std_msgs/msg/Header; it must be one of sensor",
        ),
        ({"stat": {}}, r"unknown key `stat`; did you mean `state`"),
    ],
)
def test_mismatches_are_named(imported: Import, tmp_path: Path, change: dict[str, Any], message: str) -> None:
    from tests.importers.bagwriter import header

    good = trajectory(at(0.0), ["elbow", "wrist"], [point([0.0, 0.0])])
    bad = trajectory(at(0.1), ["elbow", "wrist"], [point([0.0])])
    said = [
        ("/cmd", NUMBERS, at(0.0), array([0.0, 0.3])),
        ("/imu", "std_msgs/msg/Header", at(0.0), header(at(0.0))),
        *(("/wrong", TRAJECTORY, at(0.1 * k), each) for k, each in enumerate((good, good, bad))),
    ]
    bag = write_joint_bag(tmp_path / "run", states() + said)
    with pytest.raises(ValueError, match=message):
        imported(bag, "mcap", ELBOW | change)
