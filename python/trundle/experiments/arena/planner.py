"""A planner for gym-pusht: the cross-entropy method (Rubinstein 1999) over positions of the pusher."""

from __future__ import annotations

import numpy as np

from trundle.experiments.arena.simulator import Simulator
from trundle.experiments.sampling import Floats

__all__ = ["ACTIONS_PER_KNOT", "Planner"]

KNOTS, ACTIONS_PER_KNOT = 4, 3
SAMPLES, ELITES, ITERATIONS = 40, 6, 3
SPREAD_PX, LEAST_SPREAD_PX = 80.0, 4.0
TABLE_PX = (15.0, 497.0)
NEARNESS_WEIGHT = 0.02
"""Cost of the distance between pusher and block, px of the goal's cost for each px."""
PATH_WEIGHT = 0.5
"""Cost of the mean over the plan, relative to that of its end."""
OUTLINE = np.array(
    [(-60, 0), (60, 0), (60, 30), (-60, 30), (-15, 30), (15, 30), (15, 120), (-15, 120)], float
)
GOAL = np.array([256.0, 256.0, np.pi / 4])
MIDDLE = np.array([0.0, 45.0])


def corners(poses: Floats, points: Floats = OUTLINE) -> Floats:
    """Return points of the block (..., n, 2) on the table for its poses (..., 3)."""
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    turned = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    placed: Floats = points @ np.swapaxes(turned, -1, -2) + poses[..., None, :2]
    return placed


def costs(states: Floats) -> Floats:
    """Return the cost (n,) of predicted states (n, steps, 10), in px."""
    away = np.linalg.norm(corners(states[..., 2:5]) - corners(GOAL), axis=-1).mean(-1)
    middle = corners(states[..., 2:5], MIDDLE[None])[..., 0, :]
    near = np.linalg.norm(states[..., :2] - middle, axis=-1)
    total: Floats = away[:, -1] + PATH_WEIGHT * away.mean(-1) + NEARNESS_WEIGHT * near.mean(-1)
    return total


class Planner:
    """Plans positions of the pusher, each held for `ACTIONS_PER_KNOT` actions.

    Parameters
    ----------
    seed : int
        Of the samples.
    """

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.plan: Floats | None = None

    def act(self, simulator: Simulator) -> Floats:
        """Return the position to command (2,) in the simulator's state, and keep the rest of the plan."""
        middle = corners(simulator.state[2:5], MIDDLE[None])[0]
        if self.plan is None:
            self.plan = np.tile(middle, (KNOTS, 1))
        best, least = np.vstack([self.plan[1:], middle]), np.inf
        mean, spread = best, np.full_like(best, SPREAD_PX)
        for _ in range(ITERATIONS):
            plans = np.clip(self.rng.normal(mean, spread, (SAMPLES, KNOTS, 2)), *TABLE_PX)
            plans[0] = best
            actions = np.repeat(plans, ACTIONS_PER_KNOT, axis=1)
            cost = costs(np.stack([simulator.rollout(simulator.state, one) for one in actions]))
            order = np.argsort(cost)[:ELITES]
            if cost[order[0]] < least:
                best, least = plans[order[0]], cost[order[0]]
            mean = plans[order].mean(0)
            spread = np.maximum(plans[order].std(0), LEAST_SPREAD_PX)
        self.plan = best
        position: Floats = best[0]
        return position
