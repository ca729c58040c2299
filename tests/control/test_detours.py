"""Detours around obstacles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from trundle import TrundleError
from trundle._native import ObstacleMap

SQUARE = np.array([(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)])
WALL = [(0.9, -0.5), (1.1, -0.5), (1.1, 0.5), (0.9, 0.5)]
GOAL, START = (2.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def test_an_obstacle_lengthens_the_path() -> None:
    """With a clearance of 3 cm the centre passes at 0.83 m from the line from start to goal.

    Steps in eight directions reach (0.57, 0.83) by 0.57 along a diagonal and 0.26 along an axis.
    """
    found = ObstacleMap(SQUARE, [WALL], GOAL, START, 0.3)
    expected = 2 * (0.57 * np.sqrt(2) + 0.26) + 0.86 - 2.0
    assert found.detour(START) == pytest.approx(expected, abs=0.1)
    assert found.detour((1.5, 0.0, 0.0)) == pytest.approx(0.0, abs=0.02)
    assert found.detour(GOAL) == 0.0


def test_without_obstacles_there_is_no_detour() -> None:
    assert ObstacleMap(SQUARE, [], GOAL, START, 0.3).detour(START) == 0.0


@pytest.mark.parametrize(
    ("outline", "obstacles", "words"),
    [
        (SQUARE, [WALL[:2]], "obstacle = .* must have at least three corners"),
        (SQUARE[:2], [WALL], "footprint"),
    ],
)
def test_invalid_polygons_are_refused(
    outline: NDArray[np.float64], obstacles: list[list[tuple[float, float]]], words: str
) -> None:
    with pytest.raises(TrundleError, match=words):
        ObstacleMap(outline, obstacles, GOAL, START, 0.3)
