"""A table pushed against fixed boxes: poses and wall impulses of `trundle simulate` and MuJoCo.

An impact in which friction turns a slip round has no one law: an impulse at once, as the engine has it, and
a force that lasts a little, as the walls here have it, end apart by centimetres. Poses after such a one are
not compared.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.sim.agreement.scene import Push, assert_alike
from tests.sim.agreement.walls import RATE, SCENES, Scene, Track, struck, wheel, world


@cache
def reference(name: str) -> Track:
    """Return a scene in MuJoCo."""
    return struck(SCENES[name])


def share(one: Track, other: Track) -> float:
    """Return the difference of the impulses at the end over the impulse."""
    off = np.hypot(*(one.given - other.given)[-1, :2])
    return float(off / np.hypot(*other.given[-1, :2]))


@pytest.mark.parametrize("name", ["head on", "box", "box, fast"])
def test_walls_agree_with_mujoco_without_slip(name: str) -> None:
    ours, own = reference(name), struck(SCENES[name], own=True)
    # Measured 0.1 mm, 0.2 mrad, 0.02 %.
    assert_alike(ours.pose[-1], own.pose[-1], (5e-4, 5e-4))
    assert share(ours, own) < 5e-4


@pytest.mark.parametrize(
    ("name", "end", "ever"),
    [
        # Measured at the end, and on the way: 0.15 mm (of which the give of the wall is 0.1), 0.19 mm
        ("head on", (4e-4, 1e-6), (5e-4, 1e-6)),
        # 0.12 mm and 0.01 mrad, 0.17 mm and 0.04 mrad
        ("slide", (3e-4, 1e-4), (4e-4, 1e-4)),
        # 0.29 mm and 0.5 mrad, 0.29 mm and 1.1 mrad
        ("glance", (8e-4, 1.2e-3), (8e-4, 2.5e-3)),
        # 0.08 mm and 0.17 mrad, 0.2 and 0.4 mm
        ("box", (3e-4, 5e-4), (5e-4, 5e-4)),
        ("box, fast", (3e-4, 5e-4), (1e-3, 5e-4)),
    ],
)
def test_the_table_moves_as_in_mujoco(
    name: str, end: tuple[float, float], ever: tuple[float, float], tmp_path: Path
) -> None:
    one, other = world(tmp_path, SCENES[name]).pose, reference(name).pose
    assert_alike(one[-1], other[-1], end)
    assert_alike(one, other, ever)


@pytest.mark.parametrize(
    ("name", "most"),
    # Measured 0.02, 0.01, 0.3, 0.02 and 0.02 %.
    [("head on", 1e-3), ("slide", 1e-3), ("glance", 0.01), ("box", 1e-3), ("box, fast", 1e-3)],
)
def test_the_wall_takes_the_same_impulse(name: str, most: float, tmp_path: Path) -> None:
    one, other = world(tmp_path, SCENES[name]), reference(name)
    assert np.hypot(*other.given[-1, :2]) > 3.0
    assert share(one, other) < most


CORNER = Scene(
    Push((0.0, 0.0, 0.1), (-0.6, 0.1, 0.0), [(0, 0, 0, 0), (0.2, 40, 0, 0), (0.9, 40, 0, 0)]),
    [(1.0, -1.0, 1.5, 1.0)],
    wheel(-0.2, 0.1, 0.3, 25.0, 60.0),
)
"""A corner meets a wall at 1 m/s; friction stops its slip and turns it round."""


def rebound(track: Track) -> float:
    """Return the greatest speed of the front left corner away from the wall over that at which it came."""
    x, _, theta = track.pose.T
    speed = np.diff(1.0 - x - 0.6 * np.cos(theta) + 0.4 * np.sin(theta)) * RATE
    met = int(np.argmin(speed))
    return float(speed[met + 3 : met + 20].max() / -speed[met])


def test_no_corner_bounces_off_the_reference_walls() -> None:
    assert abs(rebound(struck(CORNER))) < 0.01


def test_no_corner_bounces(tmp_path: Path) -> None:
    assert abs(rebound(world(tmp_path, CORNER))) < 0.01
