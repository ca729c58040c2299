"""A table without a push gains no energy: while it coasts, hits a wall, or slides along it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sim.agreement.effects import CATALOGUE, effect_of
from tests.sim.agreement.scene import CONTACT, INERTIA, MASS, STEP, Floats, Push, poses, simulated
from tests.sim.agreement.walls import BEHIND, wheel

LET_GO = 0.12
PUSH = Push(
    start=(0.0, 0.0, 0.2),
    grasp=BEHIND,
    knots=[(0, 0, 0, 0), (0.02, 300, 0, 0), (0.1, 300, 0, 0), (LET_GO, 0, 0, 0), (2.5, 0, 0, 0)],
)
WALL = (0.8, -3.0, 1.3, 3.0)
BRAKING = [kind for kind, effect in CATALOGUE.items() if effect["dissipative"]] + ["com_offset"]
"""Not what stores energy or brings it: slope, cable, load, ridge, cogs, a post that gives, mass at speed."""
SETTLED = 8
"""Steps within which an impact is over: what the table moves by during one lies below what its speed says."""


def kinetic(pose: Floats, step: float, com: tuple[float, float]) -> Floats:
    """Return the energy of the motion in each step, J."""
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    centre = pose[:, :2] + np.column_stack([cos * com[0] - sin * com[1], sin * com[0] + cos * com[1]])
    velocity, spin = np.diff(centre, axis=0) / step, np.diff(pose[:, 2]) / step
    return np.asarray((MASS * np.sum(velocity**2, axis=1) + INERTIA * spin**2) / 2.0)


@pytest.mark.parametrize("kind", BRAKING)
def test_energy_never_grows_without_a_push(kind: str, tmp_path: Path) -> None:
    effects = [wheel(-0.2, 0.1, 0.3, 8.0, 16.0), effect_of(kind)]
    columns = simulated(tmp_path, effects, PUSH, boxes=[WALL], rate=1.0 / STEP)
    let_go = round((CONTACT + LET_GO) / STEP) + 1
    energy = kinetic(poses(columns)[let_go:], STEP, (0.3, -0.2) if kind == "com_offset" else (0.0, 0.0))
    assert energy[0] > 2.0 and (energy[:-20] - energy[20:]).max() > 0.2 * energy[0], "it is to hit the wall"
    highest = np.lib.stride_tricks.sliding_window_view(energy, SETTLED).max(axis=1)
    # Measured: none.
    assert np.diff(highest).max() < 1e-9
