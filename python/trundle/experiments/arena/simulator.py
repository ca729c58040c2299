"""Simulations of a block with given parameters: rollouts of plans, and tracking of an observed episode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle.experiments.arena.world import Hidden, apply, make_bare
from trundle.experiments.sampling import Floats

__all__ = ["ANGLE", "POSE", "Simulator"]

POSE = slice(0, 5)
"""Of a state: pusher (x, y), block (x, y, angle). The rest are velocities: pusher, centre of mass, rate."""
ANGLE = 4


class Simulator:
    """gym-pusht's physics with given parameters, and the state of an episode that it follows.

    Attributes
    ----------
    state : array of float, shape (10,)
        Poses as observed, and velocities as predicted. px, px/s, rad, rad/s.
    """

    def __init__(self, hidden: Hidden, physics: str, state: Floats) -> None:
        self.env: Any = make_bare(physics)
        self.env.reset(seed=0)
        apply(self.env, hidden, physics)
        for shape in self.env.space.shapes:
            shape.collision_type = 1  # without the benchmark's callback, which counts contacts in Python
        self.state = state

    @staticmethod
    def start(observation: Floats) -> Floats:
        """Return the state at rest in an observed pose (5,)."""
        return np.concatenate([observation, np.zeros(5)])

    def rollout(self, state: Floats, targets: Sequence[tuple[float, float]] | Floats) -> Floats:
        """Return the states (steps, 10) after each of the actions (steps, 2)."""
        env, agent, block = self.env, self.env.agent, self.env.block
        step, dt, k_p, k_v = env.space.step, env.dt, env.k_p, env.k_v
        substeps = int(1 / (dt * env.control_hz))
        values = state.tolist()
        agent.position, agent.velocity = tuple(values[0:2]), tuple(values[5:7])
        block.angle, block.position = values[ANGLE], tuple(values[2:4])
        block.velocity, block.angular_velocity = tuple(values[7:9]), values[9]
        env.space.reindex_shapes_for_body(block)
        env.space.reindex_shapes_for_body(agent)
        states = np.empty((len(targets), 10))
        for row, (to_x, to_y) in zip(states, np.asarray(targets).tolist(), strict=True):
            for _ in range(substeps):
                x, y = agent.position
                u, v = agent.velocity
                agent.velocity = (
                    u + dt * (k_p * (to_x - x) - k_v * u),
                    v + dt * (k_p * (to_y - y) - k_v * v),
                )
                step(dt)
            row[:] = *agent.position, *block.position, block.angle, *agent.velocity, *block.velocity, 0.0
            row[9] = block.angular_velocity
        return states

    def track(self, action: Floats, observation: Floats) -> Floats:
        """Follow one action of the episode, and return the error of the predicted pose (5,)."""
        predicted = self.rollout(self.state, action[None])[0]
        error: Floats = observation - predicted[POSE]
        error[ANGLE] = (error[ANGLE] + np.pi) % (2 * np.pi) - np.pi
        self.state = predicted
        self.state[POSE] += error
        return error
