"""The error of an invalid action."""

from __future__ import annotations

from gymnasium.error import InvalidAction

from trundle._native import TrundleError

__all__ = ["ActionError"]


class ActionError(TrundleError, InvalidAction):
    """An action outside the action space; both an `InvalidAction` of Gymnasium and a `TrundleError`.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/PushPose-v0", disable_env_checker=True)
    >>> observation, info = env.reset(seed=0)
    >>> env.step([2.0, 0.0, 0.0])
    Traceback (most recent call last):
        ...
    trundle.envs.action_error.ActionError: ...
    """
