"""ROS 2 messages that contain positions, velocities and efforts of joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["JOINT_READERS", "Part"]

NS_PER_S = 1_000_000_000


@dataclass(frozen=True)
class Part:
    """Values of some joints at one time.

    Attributes
    ----------
    stamp : int or None
        Time in the header, ns; None if the message has none, or a time of zero, which means "now".
    delay : int
        Time after `stamp`, or after the time of the log, ns.
    joints : sequence of str or None
        Names of the joints; None if the message has no names.
    values : dict of str to sequence of float
        Values in the order of `joints` by field: "position", "velocity", "effort"; empty if not measured.
    replaces : bool
        Whether later values of earlier messages are void, as at the beginning of a trajectory.
    """

    stamp: int | None
    delay: int
    joints: Sequence[str] | None
    values: dict[str, Sequence[float]]
    replaces: bool = False


def _nanoseconds(time: Any) -> int:
    return int(time.sec) * NS_PER_S + int(time.nanosec)


def _stamp(message: Any) -> int | None:
    return _nanoseconds(message.header.stamp) or None


def _joint_state(message: Any) -> Iterator[Part]:
    values = {"position": message.position, "velocity": message.velocity, "effort": message.effort}
    yield Part(_stamp(message), 0, message.name, values)


def _point(point: Any) -> dict[str, Sequence[float]]:
    return {"position": point.positions, "velocity": point.velocities, "effort": point.effort}


def _trajectory(message: Any) -> Iterator[Part]:
    for number, point in enumerate(message.points):
        after = _nanoseconds(point.time_from_start)
        yield Part(_stamp(message), after, message.joint_names, _point(point), replaces=number == 0)


def _controller_state(message: Any) -> Iterator[Part]:
    # The name of the command changed from `desired` to `reference` in ROS 2 Humble.
    command = message.reference if hasattr(message, "reference") else message.desired
    yield Part(_stamp(message), 0, message.joint_names, _point(command))


def _numbers(message: Any) -> Iterator[Part]:
    yield Part(None, 0, None, dict.fromkeys(("position", "velocity", "effort"), message.data))


JOINT_READERS: dict[str, Callable[[Any], Iterator[Part]]] = {
    "sensor_msgs/msg/JointState": _joint_state,
    "trajectory_msgs/msg/JointTrajectory": _trajectory,
    "std_msgs/msg/Float64MultiArray": _numbers,
    "control_msgs/msg/JointTrajectoryControllerState": _controller_state,
}
"""Readers of the supported message types."""
