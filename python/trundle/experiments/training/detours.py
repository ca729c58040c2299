"""Detours around obstacles during a training; needs `trundle[rl]`."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

from trundle._native import ObstacleMap
from trundle.envs.ids import task_of
from trundle.envs.observation import Observation
from trundle.envs.seen_outline import bounding_rectangle
from trundle.experiments.sampling import Floats

__all__ = ["DetourWrapper"]


class DetourWrapper(VecEnvWrapper):  # type: ignore[misc]
    """Adds `detour` to the infos: by how much obstacles lengthen the shortest path to the goal, m.

    The path is that of the object's bounding box, from its measured pose at the end of the step.

    Parameters
    ----------
    venv : VecEnv
        A batch of environments of version 1 with obstacles.
    env_id : str
    hidden : int
        Number of entries that an oracle appends to the observations.
    turn_cost : float
        Cost of a turn on a path, m/rad.
    """

    def __init__(self, venv: VecEnv, env_id: str, hidden: int, turn_cost: float) -> None:
        super().__init__(venv)
        self._task, self._hidden, self._turn_cost = task_of(env_id), hidden, turn_cost
        self.first: Floats = np.zeros((venv.num_envs, 0))
        """The first observations of the episodes."""
        self._maps: list[ObstacleMap] = []

    def reset(self) -> Any:
        """Start episodes."""
        observations = self.venv.reset()
        self.begin(observations)
        return observations

    def begin(self, observations: Floats) -> None:
        """Set `first`, and compute the maps of obstacles from it."""
        self.first = observations.copy()
        self._maps = [self._map(row) for row in observations]

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Step, and add the detours."""
        observations, rewards, dones, infos = self.venv.step_wait()
        ends = observations.copy()
        for last in np.flatnonzero(dones):
            ends[last] = infos[last]["terminal_observation"]
        for info, one, pose in zip(infos, self._maps, Observation(ends).pose, strict=True):
            info["detour"] = one.detour(pose)
        for last in np.flatnonzero(dones):
            self.first[last], self._maps[last] = observations[last], self._map(observations[last])
        return observations, rewards, dones, infos

    def _map(self, observation: Floats) -> ObstacleMap:
        """Return the map of an episode that begins with an observation."""
        assert self._task is not None
        row = observation[: len(observation) - self._hidden]
        seen, obstacles = Observation(row), self._task.seen_obstacles(row)
        outline = bounding_rectangle(seen, has_middle=True)
        return ObstacleMap(outline, obstacles, seen.goal_pose, seen.pose, self._turn_cost)
