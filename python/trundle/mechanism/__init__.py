"""Mechanisms of hinge and slide joints: MJCF and URDF models evaluated by MuJoCo.

Needs the extra `[mujoco]`. `Mechanism.load` reads a model, `Mechanism.inverse_dynamics` and
`Mechanism.regressors` evaluate it along a measured motion, and `simulate` simulates it. `MechanismModel` is a
model file.
"""

from __future__ import annotations

from trundle.mechanism.contacts import touching_bodies
from trundle.mechanism.drives import EffortDrive, PositionDrive, SwitchedDrive
from trundle.mechanism.files import JointEffect, MechanismModel, MechanismTable, Posterior
from trundle.mechanism.loading import Payload
from trundle.mechanism.model import Mechanism
from trundle.mechanism.regressors import Regressors
from trundle.mechanism.simulation import simulate
from trundle.mechanism.transmissions import SplitModel, Transmission, split_model

__all__ = [
    "EffortDrive",
    "JointEffect",
    "Mechanism",
    "MechanismModel",
    "MechanismTable",
    "Payload",
    "PositionDrive",
    "Posterior",
    "Regressors",
    "SplitModel",
    "SwitchedDrive",
    "Transmission",
    "simulate",
    "split_model",
    "touching_bodies",
]


def __dir__() -> list[str]:
    return __all__
