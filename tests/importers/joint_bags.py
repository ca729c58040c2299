"""ROS 2 bags of joints, written by the tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg

from tests.importers.bagwriter import EPOCH, STORE, Messages, header

CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
DEFINITION = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
"""
JOINT_STATE = "sensor_msgs/msg/JointState"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
NUMBERS = "std_msgs/msg/Float64MultiArray"
STATES_TOPIC = "/joint_states"
STORE.register(get_types_from_msg(DEFINITION, CONTROLLER))


def numbers(values: Sequence[float]) -> np.ndarray:
    return np.array(values, dtype=np.float64)


def joint_state(ns: int, names: list[str], q: Any, v: Any = (), effort: Any = ()) -> Any:
    return STORE.types[JOINT_STATE](header(ns), names, numbers(q), numbers(v), numbers(effort))


def point(positions: Any, after: float = 0.0) -> Any:
    duration = STORE.types["builtin_interfaces/msg/Duration"](int(after), round(after % 1 * 1e9))
    empty = numbers([])
    return STORE.types["trajectory_msgs/msg/JointTrajectoryPoint"](
        numbers(positions), empty, empty, empty, duration
    )


def trajectory(ns: int, names: list[str], points: list[Any]) -> Any:
    return STORE.types[TRAJECTORY](header(ns), names, points)


def controller_state(ns: int, names: list[str], positions: Any) -> Any:
    return STORE.types[CONTROLLER](header(ns), names, point(positions), point([0.0] * len(names)))


def array(values: Any) -> Any:
    layout = STORE.types["std_msgs/msg/MultiArrayLayout"]([], 0)
    return STORE.types[NUMBERS](layout, numbers(values))


def at(seconds: float) -> int:
    return EPOCH + round(seconds * 1e9)


def states(count: int = 50) -> Messages:
    """Return /joint_states of three joints at 100 Hz, in an order that changes with every message."""
    said: Messages = []
    for k in range(count):
        t = 0.01 * k
        values = {"gripper": (9.0, 8.0, 7.0), "elbow": (t, 1.0, 2.0 * t), "shoulder": (-t, -1.0, -3.0)}
        names = list(values) if k % 2 else list(values)[::-1]
        message = joint_state(at(t), names, *np.array([values[name] for name in names]).T)
        said.append((STATES_TOPIC, JOINT_STATE, at(t) + 2_000_000, message))
    return said


def write_joint_bag(folder: Path, messages: Messages, storage: str = "mcap") -> Path:
    """Write a rosbag2 folder."""
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = {
            (topic, kind): writer.add_connection(topic, kind, typestore=STORE)
            for topic, kind in dict.fromkeys((message[0], message[1]) for message in messages)
        }
        for topic, kind, ns, message in sorted(messages, key=lambda each: each[2]):
            writer.write(connections[topic, kind], ns, STORE.serialize_cdr(message, kind))
    return folder
