"""The user's own simulator of joints as the mechanism under test: a function that advances a state."""

from __future__ import annotations

from trundle.joint_simulator.calls import JointSimulator, JointStep, Samples
from trundle.joint_simulator.derivatives import by_parameter, by_position
from trundle.joint_simulator.forward import simulate
from trundle.joint_simulator.inverse import EffortScale, InverseDynamics, effort_scale, inverse_dynamics

__all__ = [
    "EffortScale",
    "InverseDynamics",
    "JointSimulator",
    "JointStep",
    "Samples",
    "by_parameter",
    "by_position",
    "effort_scale",
    "inverse_dynamics",
    "simulate",
]


def __dir__() -> list[str]:
    return __all__
