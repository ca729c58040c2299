"""Scenes of furniture: rectangles, L-shaped desks and round tables, held by a rigid grasp."""

from __future__ import annotations

import numpy as np

from trundle.experiments.blind.instrument import Instrument
from trundle.experiments.blind.outline import Outline, circle, inset_corners
from trundle.experiments.blind.push import draw_grasp, draw_push, low_excitation
from trundle.experiments.blind.scene import Scene, draw_wheel
from trundle.experiments.sampling import Floats

__all__ = ["EPISODE_DURATION_S", "draw_scene"]

EPISODE_DURATION_S = 6.0
"""Duration of an episode."""
POSE_RATE_HZ = 60.0
"""Sample rate of the tracker."""
SENSOR_RATES_HZ = (125.0, 200.0, 250.0)
"""Sample rates of the force-torque sensor."""
POSE_NOISE = (5e-4, 5e-4, float(np.radians(0.1)))
WRENCH_NOISE = (0.4, 0.4, 0.05)
FOOT_INSET_M = 0.05
"""Distance of the feet from the edge."""


def draw_scene(seed: int, attempt: int = 0, episodes: int = 8, *, alike: bool = False) -> Scene:
    """Return the scene of a seed; each attempt gives another one.

    With `alike`, all pushes have the initial pose and grasp of the first and do not rotate.
    """
    rng = np.random.default_rng([seed, attempt, 1])
    shape = draw_shape(rng)
    mass = round(float(rng.uniform(8.0, 40.0)), 1)
    grasps = [draw_grasp(rng, shape) for _ in range(int(rng.integers(3, 5)))]
    gain = float(rng.uniform(60.0, 200.0))
    wheel = draw_wheel(rng, shape)
    pushes = tuple(draw_push(rng, grasps[k % len(grasps)]) for k in range(episodes))
    offset = tuple(rng.uniform(-1, 1, 3) * (3.0, 3.0, 0.3))
    rate = float(rng.choice(SENSOR_RATES_HZ))
    return Scene(
        seed=seed,
        shape=shape,
        mass=mass,
        wheel=wheel,
        pushes=tuple(low_excitation(push, pushes[0]) for push in pushes) if alike else pushes,
        seconds=(EPISODE_DURATION_S,) * episodes,
        gain=(gain, (4.0 if alike else 0.2) * gain),
        limit=(80.0, 120.0 if alike else 25.0),
        offset=offset,
        instrument=Instrument(
            POSE_RATE_HZ, rate, POSE_NOISE[0], POSE_NOISE[2], WRENCH_NOISE[0], WRENCH_NOISE[2]
        ),
        pose_noise=POSE_NOISE,
        wrench_noise=WRENCH_NOISE,
        feet_given=bool(rng.random() < 0.7) or shape.disc is not None,
        mass_given=bool(rng.random() < 0.3),
        held_out=min(2, episodes - 1),
    )


def draw_shape(rng: np.random.Generator) -> Outline:
    """Return a shape of random kind and size with its frame near its middle."""
    kind = str(rng.choice(("rectangle", "ell", "round"), p=(0.5, 0.25, 0.25)))
    at = np.round(rng.uniform(-0.1, 0.1, 2), 3)
    if kind == "rectangle":
        half = np.round((rng.uniform(0.35, 0.75), rng.uniform(0.25, 0.45)), 3)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        return shape_from_boxes(kind, corners, at, [(0.0, 0.0, *half)])
    if kind == "ell":
        return ell(rng, at)
    radius = round(float(rng.uniform(0.35, 0.6)), 3)
    feet = at + (radius - FOOT_INSET_M) * circle(int(rng.integers(3, 6)))
    return Outline(kind, (float(at[0]), float(at[1]), radius), at + radius * circle(32), feet)


def ell(rng: np.random.Generator, at: Floats) -> Outline:
    """Return an L-shaped desk: two boxes that share an edge."""
    width, depth = np.round(rng.uniform((1.0, 0.8), (1.6, 1.3)), 3)
    thick = round(float(rng.uniform(0.35, 0.5)), 3)
    w, d = width / 2, depth / 2
    corners = [[-w, -d], [w, -d], [w, thick - d], [thick - w, thick - d], [thick - w, d], [-w, d]]
    along = (0.0, thick / 2 - d, w, thick / 2)
    across = (thick / 2 - w, thick / 2, thick / 2, d - thick / 2)
    return shape_from_boxes("ell", np.array(corners), at, [along, across])


def shape_from_boxes(
    kind: str, outline: Floats, at: Floats, boxes: list[tuple[float, float, float, float]]
) -> Outline:
    """Return a shape of boxes, moved to `at`, with feet inside its corners."""
    moved = tuple((float(x + at[0]), float(y + at[1]), float(w), float(d)) for x, y, w, d in boxes)
    return Outline(kind, None, outline + at, inset_corners(outline, FOOT_INSET_M, 3) + at, boxes=moved)
