"""Mechanisms of hinge and slide joints: MJCF and URDF models evaluated by MuJoCo.

Needs the extra `[mujoco]`. `Mechanism.load` reads a model, `Mechanism.inverse_dynamics` and
`Mechanism.regressors` evaluate it along a measured motion.
"""

from __future__ import annotations

from trundle.mechanism.loading import Payload
from trundle.mechanism.model import Mechanism
from trundle.mechanism.regressors import Regressors

__all__ = ["Mechanism", "Payload", "Regressors"]


def __dir__() -> list[str]:
    return __all__
