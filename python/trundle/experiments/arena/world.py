"""gym-pusht's environment with hidden mass, floor friction and centre of mass of the block.

Lengths are pixels of the benchmark (its table is 512 by 512), times are seconds. Its block has the mass 1 and
the centre of mass (0, 45) in its own frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from trundle._native import TrundleError
from trundle._optional import require
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["NOMINAL", "PHYSICS", "Hidden", "PushTHidden", "apply", "draw", "make", "make_bare"]

PHYSICS = ("original", "sliding")
"""As published; or with inertia, dry floor friction and a pusher of finite mass."""
MASS = (0.3, 3.0)
FRICTION_PX_PER_S2 = (200.0, 2000.0)
"""Deceleration of the sliding block, friction coefficient times gravity."""
OFFSET_PX = 30.0
"""Largest offset of the centre of mass in each direction. The block is 120 by 120, its bars are 30 wide."""
PUSHER_MASS = 1.0
FRICTION_RADIUS_PX = 40.0
"""Torque of the floor friction, divided by its force: about the block's mean distance from its centre."""


@dataclass(frozen=True)
class Hidden:
    """Hidden parameters of the block.

    Attributes
    ----------
    mass : float
        Relative to the benchmark's. The inertia is proportional to it.
    friction : float
        Deceleration by floor friction, px/s². Not used by the original physics.
    offset_x, offset_y : float
        Centre of mass relative to the benchmark's, in the frame of the block, px.
    """

    mass: float = 1.0
    friction: float = 632.5
    offset_x: float = 0.0
    offset_y: float = 0.0


NOMINAL = Hidden()
"""The benchmark's block, with the median of the floor friction."""


def draw(rng: np.random.Generator) -> Hidden:
    """Return hidden parameters: mass and friction log-uniform in their ranges, offsets uniform."""
    return Hidden(
        log_uniform(rng, *MASS),
        log_uniform(rng, *FRICTION_PX_PER_S2),
        float(rng.uniform(-OFFSET_PX, OFFSET_PX)),
        float(rng.uniform(-OFFSET_PX, OFFSET_PX)),
    )


def make_bare(physics: str) -> Any:
    """Return gym-pusht's environment without its time limit, for simulations.

    Raises
    ------
    TrundleError
        If gym-pusht is not installed, or there is no such physics.
    """
    if physics not in PHYSICS:
        raise TrundleError(f"physics = {physics!r}: choose {', '.join(PHYSICS)}")
    module = require("gym_pusht.envs.pusht", "arena", "environments of the arena")
    return module.PushTEnv(damping=None if physics == "original" else 1.0)


def apply(env: Any, hidden: Hidden, physics: str) -> None:
    """Give the block of a gym-pusht environment hidden parameters right after a reset, in the same pose."""
    block, agent, space = env.block, env.agent, env.space
    pymunk = require("pymunk", "arena", "environments of the arena")
    pose = block.position, block.angle
    block.moment, block.mass = block.moment / block.mass * hidden.mass, hidden.mass
    block.center_of_gravity += (hidden.offset_x, hidden.offset_y)
    block.angle, block.position = pose[1], pose[0]
    if physics == "sliding":
        agent.body_type = pymunk.Body.DYNAMIC
        agent.mass, agent.moment = PUSHER_MASS, float("inf")
        force = hidden.mass * hidden.friction
        # Dry friction seen from above, as in pymunk's example tank.py: joints that correct no position.
        slide = pymunk.PivotJoint(space.static_body, block, (0, 0), block.center_of_gravity)
        turn = pymunk.GearJoint(space.static_body, block, 0.0, 1.0)
        slide.max_bias = turn.max_bias = 0.0
        slide.max_force, turn.max_force = force, force * FRICTION_RADIUS_PX
        space.add(slide, turn)
    space.reindex_shapes_for_body(block)


class PushTHidden(gymnasium.Wrapper[Floats, Floats, Floats, Floats]):
    """gym-pusht with hidden parameters that are drawn at each reset.

    Observation (pusher and block pose), action, reward, start and end are the benchmark's. The reset's `seed`
    determines the start and the parameters, which `hidden` holds.

    Parameters
    ----------
    env : gymnasium.Env
        gym-pusht's environment. `make` returns a wrapped one.
    physics : {"original", "sliding"}
    """

    def __init__(self, env: gymnasium.Env[Floats, Floats], physics: str = "original") -> None:
        super().__init__(env)
        self.physics, self.hidden = physics, NOMINAL

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Start an episode. `options["hidden"]` holds parameters, as a dictionary, that replace a draw."""
        options = dict(options or {})
        given = options.pop("hidden", None)
        observation, info = self.env.reset(seed=seed, options=options)
        self.hidden = draw(self.env.unwrapped.np_random) if given is None else Hidden(**given)
        apply(self.env.unwrapped, self.hidden, self.physics)
        return observation, info


def make(physics: str = "original") -> PushTHidden:
    """Return the benchmark's environment, with its limit of 300 steps, and hidden parameters."""
    bare = make_bare(physics)
    limit = gymnasium.spec("gym_pusht/PushT-v0").max_episode_steps or 0
    return PushTHidden(gymnasium.wrappers.TimeLimit(bare, limit), physics)
