"""The outline that an adaptive agent derives from an observation."""

from __future__ import annotations

from itertools import product
from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.envs import Observation
from trundle.envs.seen_outline import bounding_rectangle, outline_hull
from trundle.picture import outlines

LEVELS = ("Easy", "Medium", "Hard")


def depth_outside(points: Any, hull: Any) -> float:
    """Return the largest distance of points from the inside of a convex polygon."""
    edges = np.roll(hull, -1, axis=0) - hull
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    return float(((points[:, None] - hull) * normals).sum(axis=2).max())


@pytest.mark.parametrize(("level", "split"), [*product(LEVELS, ("train", "test"))])
def test_the_hull_contains_the_object_and_lies_within_its_bounding_box(level: str, split: str) -> None:
    env = gymnasium.make(f"trundle/PushAround{level}-v1", split=split, outline=True)
    source: Any = env.unwrapped
    for seed in range(12):
        seen = Observation(env.reset(seed=seed)[0])
        hull, box = outline_hull(seen), bounding_rectangle(seen, has_middle=True)
        body = np.concatenate(outlines(source.hidden_model()["body"]))
        assert depth_outside(hull, box) < 1e-5
        # The ends of an edge that only one direction meets are not seen. The planner's margin is 0.06 m.
        assert depth_outside(body, hull) < 0.03, seed
        assert depth_outside(body, box) < 1e-5


def test_a_tapered_object_has_its_own_corners() -> None:
    vector = np.zeros(48)
    seen = Observation(vector)
    vector[16:20] = (0.6, 0.4, 0.1, -0.05)
    corners = np.array([[-0.6, -0.4], [0.6, -0.2], [0.6, 0.2], [-0.6, 0.4]])
    edges = np.roll(corners, -1, axis=0) - corners
    for k, angle in enumerate(np.linspace(0.0, 2 * np.pi, 24, endpoint=False)):
        way = np.array([np.cos(angle), np.sin(angle)])
        crossed = [
            np.linalg.solve(np.column_stack([way, -e]), c) for c, e in zip(corners, edges, strict=True)
        ]
        vector[20 + k] = min(r for r, share in crossed if r > 0 and -1e-9 <= share <= 1 + 1e-9)
    hull = outline_hull(seen)
    expected = (corners + np.array([0.1, -0.05])).round(3)
    assert {tuple(row) for row in hull.round(3)} == {tuple(row) for row in expected}


@pytest.mark.parametrize("outline", [False, True])
def test_the_agent_uses_the_observed_shape(outline: bool) -> None:
    # The middle of a rectangle with a round front is not its origin.
    env = gymnasium.make("trundle/PushAroundHard-v1", outline=outline)
    agent = trundle.AdaptiveAgent(env)
    for seed in range(40):
        observation, _ = env.reset(seed=seed)
        seen = Observation(observation)
        if abs(seen.middle[0]) > 0.1:
            break
    _, (belief,) = agent.predict(observation, episode_start=True)
    footprint = np.array(belief.metadata["object"]["footprint"])
    assert footprint.max(axis=0) == pytest.approx(seen.middle + seen.half_size, abs=1e-5)
    assert footprint.min(axis=0) == pytest.approx(seen.middle - seen.half_size, abs=1e-5)
    assert (len(footprint) > 4) == outline
