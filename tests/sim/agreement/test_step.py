"""Influence of the step size of `trundle simulate`, in free motion and at a wall."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sim.agreement.effects import ON_OBJECT, PUSH, WHEEL, effect_of
from tests.sim.agreement.scene import STEP, assert_alike, poses, simulated
from tests.sim.agreement.walls import SCENES, world

SMOOTH = (5e-7, 6e-7)
"""Tolerance, m and rad; measured 0.18 µm and 0.24 µrad."""
ROUGH = {
    # Measured 11, 57, 2.5 and 0.2 µm, 5, 56, 6 and 1 µrad.
    "coulomb_friction": (5e-5, 3e-5),
    "support_friction": (2e-4, 2e-4),
    "axis_friction": (5e-5, 3e-5),
    "body_axis_friction": (2e-4, 2e-4),
    "obstacle_contact": (1e-5, 2e-5),
    "caster_swivel": (5e-7, 3e-6),
}


@pytest.mark.parametrize("kind", ON_OBJECT)
def test_half_the_step_changes_little_in_free_motion(kind: str, tmp_path: Path) -> None:
    effects = [WHEEL, effect_of(kind)]
    whole, half = (poses(simulated(tmp_path, effects, PUSH, step=step)) for step in (None, STEP / 2))
    assert_alike(whole, half, ROUGH.get(kind, SMOOTH))


@pytest.mark.parametrize(
    ("name", "end", "impulse"),
    [
        # Measured: 0.02 mm; 0.11 mm; 1.4 mm, 2.1 mrad, 1.6 %; 0.12 mm, 0.29 mrad; 0.19 mm, 0.13 mrad.
        ("head on", (1e-4, 1e-6), 1e-3),
        ("slide", (3e-4, 1e-4), 1e-3),
        # The rebound of a corner depends on its time of impact within a step.
        ("glance", (4e-3, 6e-3), 0.04),
        ("box", (4e-4, 1e-3), 1e-3),
        ("box, fast", (5e-4, 5e-4), 1e-3),
    ],
)
def test_half_the_step_changes_little_at_a_wall(
    name: str, end: tuple[float, float], impulse: float, tmp_path: Path
) -> None:
    whole, half = (world(tmp_path, SCENES[name], step=step) for step in (STEP, STEP / 2))
    assert_alike(whole.pose[-1], half.pose[-1], end)
    given, other = whole.given[-1, :2], half.given[-1, :2]
    assert np.hypot(*(given - other)) < impulse * np.hypot(*other)
