"""`trundle simulate` with laws of the floor, of the scene, and with internal states."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

OBJECT = Path(__file__).parents[2] / "configs" / "objects" / "office_table.toml"

SCENARIO = """
format = "trundle-scenario/1"
name = "a table and something else"
object = "{object}"
step = 1e-3

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 30.0
mu_y = 80.0
{effect}

[tracker]
noise = [0.0, 0.0, 0.0]

[sensor]
force_noise = 0.0
torque_noise = 0.0

[[push]]
grasp = [-0.6, 0.1, 0.0]
drive = "force"
knots = [[0, 0, 0, 0], [0.2, 40, 5, 2], [1.5, 40, -5, -2], [1.7, -30, 5, 2], [3.0, -30, -5, 1]]

[[push]]
grasp = [-0.6, 0.1, 0.0]
drive = "force"
knots = [[0, 0, 0, 0], [0.2, 40, 5, 2], [1.5, 40, -5, -2], [1.7, -30, 5, 2], [3.0, -30, -5, 1]]
"""

EFFECTS = {
    "floor_patch": "x = 1.0\ny = 0.1\nhalf_length = 0.4\nhalf_width = 0.5\nangle = 0.2\nmu = 80.0",
    "floor_grain": "mu = 40.0\nangle = 0.7",
    "tether": "x = -0.5\ny = 0.3\nanchor_x = -1.0\nanchor_y = 0.4\nstiffness = 80.0\nrest_length = 0.6",
    "obstacle_contact": "x = 1.1\ny = 0.2",
    "caster_swivel": "x = 0.5\ny = -0.3\ntrail = 0.05\nmu_side = 60.0",
    "swinging_load": "x = 0.3\ny = 0.2\nmass = 5.0\nfrequency = 1.2",
    "doorsill": "angle = 0.1\noffset = 0.8\nheight = 0.006",
}


def ends(tmp_path: Path, effect: str) -> list[NDArray[np.float64]]:
    """Return the last pose of each episode."""
    path = tmp_path / "scenario.toml"
    path.write_text(SCENARIO.format(object=OBJECT, effect=effect))
    poses = []
    for columns in trundle.simulate(path, seed=1).episodes.values():
        table = np.column_stack([columns[f"object_{axis}"] for axis in ("x", "y", "theta")])
        poses.append(table[np.isfinite(table[:, 0])][-1])
    return poses


@pytest.mark.parametrize("kind", EFFECTS)
def test_an_effect_changes_the_motion(tmp_path: Path, kind: str) -> None:
    without = ends(tmp_path, "")
    with_effect = ends(tmp_path, f'[[effect]]\nkind = "{kind}"\n{EFFECTS[kind]}')
    assert np.hypot(*(with_effect[0] - without[0])[:2]) > 0.02
    same = np.allclose(with_effect[0], with_effect[1], atol=1e-9)
    # The pushes are equal; only the initial angle of a caster varies.
    assert same == (kind != "caster_swivel")
