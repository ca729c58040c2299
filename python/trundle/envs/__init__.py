"""Gymnasium environments, registered when `trundle` is imported.

=============================== ====================================================================
id                              task
=============================== ====================================================================
``trundle/PushPose-v0``         push an object with hidden effects to a pose
``trundle/PushPath-v0``         along a path
``trundle/PushAround-v0``       to a pose behind an obstacle
``trundle/PushDoor-v0``         through a doorway
``trundle/PushPoseGoal-v0``, …  the same four, goal-conditioned (Gymnasium-Robotics' convention)
``trundle/LockedWheel-v0``      the paper's: a table, one wheel of which is locked, to a pose
=============================== ====================================================================

Each exists as ``-v1`` too, and the first four with a level, such as ``trundle/PushAroundHard-v1``.

`gymnasium.make` makes one environment, `gymnasium.make_vec` a batch that is stepped on all cores.
"""

from trundle._native import Pushing
from trundle.envs.action_error import ActionError
from trundle.envs.goal import PushAroundGoal, PushDoorGoal, PushGoal, PushPathGoal, PushPoseGoal
from trundle.envs.ids import FLAT
from trundle.envs.observation import Observation
from trundle.envs.oracle import Oracle, VectorOracle
from trundle.envs.push import Push
from trundle.envs.tasks import LockedWheel, PushAround, PushDoor, PushPath, PushPose
from trundle.envs.vector import PushGoalVec, PushVec

HOUSEHOLD = Pushing.HOUSEHOLD
"""Names of the ten household objects in Fig. 7 of the paper."""

__all__ = [
    "FLAT",
    "HOUSEHOLD",
    "ActionError",
    "LockedWheel",
    "Observation",
    "Oracle",
    "Push",
    "PushAround",
    "PushAroundGoal",
    "PushDoor",
    "PushDoorGoal",
    "PushGoal",
    "PushGoalVec",
    "PushPath",
    "PushPathGoal",
    "PushPose",
    "PushPoseGoal",
    "PushVec",
    "VectorOracle",
]


def __dir__() -> list[str]:
    return __all__
