"""Episodes along a motion that another simulator computes."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import Pushing, TrundleError
from trundle.envs.view import require_episode

__all__ = ["ExternalMotion", "Stepped"]

Array = NDArray[np.float64]
Stepped: TypeAlias = tuple[Array, float, bool, bool, dict[str, Any]]
"""What `gymnasium.Env.step` returns."""


class ExternalMotion:
    """Part of `trundle.envs.Push`: another simulator in place of trundle's."""

    _native: Pushing

    def follow(
        self, poses: ArrayLike, twists: ArrayLike, wrenches: ArrayLike, impulses: ArrayLike = 0.0
    ) -> Stepped:
        """Advance by one action along a motion that another simulator computed, instead of simulating it.

        Goal, observations with their noise, costs and the end of the episode are those of `step`. n is the
        number of simulation steps per action, the argument `substeps`.

        Parameters
        ----------
        poses : array_like, shape (n, 3)
            Pose of the object's frame after each step: x, y (m), heading (rad), world frame.
        twists : array_like, shape (n, 3)
            Velocity of the object's origin (m/s) and spin (rad/s) after each step, world axes.
        wrenches : array_like, shape (n, 3)
            Mean force (N) and torque (N m) of the gripper on the object during each step, object axes,
            torque about the object's origin.
        impulses : array_like, shape (n,), optional
            Impulse of obstacles on the object during each step, N s.

        Returns
        -------
        tuple
            As `step`.

        Raises
        ------
        TrundleError
            If a shape is another one, a value is not finite, or `action`, `arm` or `realtime` is not the
            default: the other simulator contains the arm. The episode is then unchanged.

        Examples
        --------
        >>> import gymnasium, numpy, trundle
        >>> push = gymnasium.make("trundle/PushPose-v1").unwrapped
        >>> pose = trundle.envs.Observation(push.reset(seed=0)[0]).pose
        >>> at_rest = numpy.zeros((25, 3))
        >>> observation, *_ = push.follow(at_rest + pose, at_rest, at_rest)
        """
        motion = stack_motion(poses, twists, wrenches, impulses)
        return self._returned(self._native.follow(motion))

    def scene(self) -> dict[str, Any]:
        """Return the true scene, for another simulator; not for the agent.

        Returns
        -------
        dict
            `object` and `goal`: poses (x, y, heading), m and rad, world frame. `obstacles`: polygons, m,
            world frame.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        view = require_episode(self._native.view())
        return {key: view[key] for key in ("object", "goal", "obstacles")}

    def _returned(self, stepped: Stepped | None) -> Stepped:
        """Return a step, or raise `ResetNeeded` if no episode is running."""
        raise NotImplementedError


def stack_motion(poses: ArrayLike, twists: ArrayLike, wrenches: ArrayLike, impulses: ArrayLike) -> Array:
    """Return a motion as the native module expects it, shape (n, 10).

    Raises
    ------
    TrundleError
        If an argument is not numbers of its shape.
    """
    try:
        parts = [np.asarray(part, dtype=np.float64) for part in (poses, twists, wrenches)]
        struck = np.asarray(impulses, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise TrundleError(f"poses, twists, wrenches, impulses: {error}") from error
    shapes = [part.shape for part in parts]
    if len(set(shapes)) != 1 or len(shapes[0]) != 2 or shapes[0][1] != 3:
        raise TrundleError(f"poses, twists, wrenches of shapes {shapes}: give (n, 3)")
    count = len(parts[0])
    if struck.shape not in ((), (count,)):
        raise TrundleError(f"impulses of shape {struck.shape}: give ({count},) or one number")
    return np.column_stack([*parts, np.broadcast_to(struck, count)])
