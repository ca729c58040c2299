"""Errors of the predictions of a dynamics model in episodes that it was not trained on."""

from __future__ import annotations

import numpy as np

from trundle.envs.observation import Observation
from trundle.experiments.sampling import Floats
from trundle.experiments.training.dynamics.collect import Episodes
from trundle.experiments.training.dynamics.model import DynamicsModel
from trundle.experiments.training.dynamics.motion import INPUTS, Motion, motion_of, shape_of, wrapped

__all__ = ["OPEN_LOOP_S", "errors_of_motion", "prediction_errors"]


OPEN_LOOP_S = 1.0
"""Duration of a prediction without observations, s."""


def prediction_errors(model: DynamicsModel, episodes: Episodes, after: float) -> dict[str, float]:
    """Return errors of predictions that start at the same time of all episodes.

    The prediction is the mean of those of the networks. Episodes that end or touch an obstacle before the end
    of a prediction are not counted.

    Parameters
    ----------
    model : DynamicsModel
    episodes : Episodes
    after : float
        Duration of the motion that the model has seen, s.

    Returns
    -------
    dict
        `episodes`, their number; root mean square of the `speed` (m/s) and `spin` (rad/s) error after one
        step; medians of the `distance` (m) and `turn` (rad) error after `OPEN_LOOP_S`.
    """
    start, steps = round(after / model.about.period), round(OPEN_LOOP_S / model.about.period)
    chosen = episodes.valid[: start + steps].all(axis=0)
    observations = episodes.observations[: start + steps + 1, chosen]
    seen, shape = Observation(observations), shape_of(observations[0])
    inputs, targets = motion_of(observations)
    context = model.start(int(chosen.sum()))
    for step in range(start):
        context = model.remember(context, Motion(inputs[step], targets[step]), shape)
    wrenches = np.concatenate([inputs[start : start + 1, :, 3:6], inputs[start:, :, 6:INPUTS]])
    begin = seen.pose[start], seen.twist[start]
    states = model.rollout(context, shape, begin, np.moveaxis(wrenches, 0, 1)).mean(axis=0)
    return errors_of_motion(states, Observation(observations[start:]))


def errors_of_motion(states: Floats, seen: Observation) -> dict[str, float]:
    """Return the errors of predicted motions; see `prediction_errors`.

    Parameters
    ----------
    states : ndarray, shape (n, steps, 6)
        Predicted pose and twist after each step, world axes.
    seen : Observation
        Observations at the start and after each step, shape (steps + 1, n, entries).
    """
    change = states[:, 0, 3:] - seen.twist[1]
    moved = states[:, -1, :3] - seen.pose[-1]
    return {
        "episodes": float(len(states)),
        "speed": float(np.sqrt((change[:, :2] ** 2).sum(axis=1).mean())),
        "spin": float(np.sqrt((change[:, 2] ** 2).mean())),
        "distance": float(np.median(np.hypot(moved[:, 0], moved[:, 1]))),
        "turn": float(np.median(np.abs(wrapped(moved[:, 2])))),
    }
