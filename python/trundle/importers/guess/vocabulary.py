"""Words in the names of columns: bodies, quantities, and what is not part of a recording."""

from __future__ import annotations

from typing import Literal

__all__ = [
    "CLOCK_WORDS",
    "GRIPPER_WORDS",
    "NEUTRAL_WORDS",
    "OBJECT_WORDS",
    "QUANTITY_WORDS",
    "REASONS",
    "TORQUE_OR_TRANSLATION",
    "WRENCH_WORDS",
    "Quantity",
]

Quantity = Literal["position", "heading", "quaternion", "force", "torque", "time"]


def words(text: str) -> frozenset[str]:
    """Return the words of a text."""
    return frozenset(text.split())


OBJECT_WORDS = words(
    "object obj body table desk cart trolley box bed chair sofa cabinet furniture load payload block slider "
    "workpiece carriage crate"
)
GRIPPER_WORDS = words(
    "gripper hand tool tcp ee eef effector endeffector tip finger flange wrist sensor ft pusher probe "
    "manipulator robot arm"
)
WRENCH_WORDS = words("force torque wrench ft sensor loadcell load f")
NAMES: dict[Quantity, frozenset[str]] = {
    "position": words("pos position positions p translation trans loc location coord xyz"),
    "heading": words("yaw theta heading psi th"),
    "quaternion": words("q quat quaternion orientation ori rotation rot"),
    "force": words("f force forces frc"),
    "torque": words("torque torques tau moment moments trq"),
    "time": words("time timestamp stamp clock epoch elapsed t"),
}
QUANTITY_WORDS = {word: quantity for quantity, named in NAMES.items() for word in named}
NEUTRAL_WORDS = words(
    "pose field data msg value transform state measured meas actual header mocap vicon optitrack tracker "
    "wrench loadcell end"
)
"""Words that distinguish neither bodies nor quantities."""
CLOCK_WORDS = words("header field data msg value ros log rel relative abs unix")
"""Words of a time column that name no instrument."""
NOT_USED = {
    "a velocity or an acceleration": words(
        "vel velocity velocities speed twist omega rate dot acc accel acceleration jerk angular vx vy vz wx "
        "wy wz ax ay az dx dy dz xdot ydot zdot thetadot yawrate"
    ),
    "a command, not a measurement": words(
        "cmd command commanded des desired ref reference setpoint target goal planned"
    ),
    "an error or a statistic": words("err error std sigma var cov covariance variance bias offset residual"),
    "not a quantity of a recording": words(
        "joint motor current voltage temp temperature battery imu gyro mag status seq id frame quality valid "
        "count index button roll pitch"
    ),
}
REASONS = {word: reason for reason, named in NOT_USED.items() for word in named}
"""Why a column with this word is not used."""
TORQUE_OR_TRANSLATION = "t may be a torque or a translation"
