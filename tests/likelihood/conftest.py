"""Recordings of a cart on isotropic casters, free or pushed into a wall."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import trundle

OBJECT = """
format = "trundle-object/1"
name = "cart"
[body]
mass = {mass}
footprint = [[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]]
"""

SCENARIO = """
format = "trundle-scenario/1"
name = "{name}"
object = "cart.toml"
[[effect]]
kind = "viscous_wheel"
x = 0.0
y = 0.0
angle = 0.0
mu_x = 10.0
mu_y = 30.0
[sensor]
force_noise = 0.1
torque_noise = 0.01
"""

WALL = """
[[obstacle]]
polygon = [[0.75, -2.0], [0.95, -2.0], [0.95, 2.0], [0.75, 2.0]]
"""

# Forward for two seconds, sideways, and back.
PUSHES = """
[[push]]
grasp = [-0.4, 0.05, 0.0]
drive = "force"
knots = [[0.0, 0.0, 0.0, 0.0], [0.2, 12.0, 3.0, 0.2], [2.0, 14.0, 2.0, 0.0], [2.5, -8.0, -6.0, -0.3],
         [4.0, -6.0, 3.0, 0.2]]
[[push]]
grasp = [-0.4, -0.05, 0.0]
drive = "force"
knots = [[0.0, 0.0, 0.0, 0.0], [0.2, 16.0, -3.0, 0.1], [1.8, 12.0, -4.0, 0.0], [2.2, -9.0, 6.0, 0.3],
         [3.5, -5.0, 2.0, -0.2]]
"""

#: Mass and friction free, the rest of the truth given.
MODEL = """
format = "trundle-model/1"
[[effect]]
kind = "viscous_wheel"
x = 0.0
y = 0.0
angle = 0.0
"""

Cart = Callable[..., trundle.Recording]


@pytest.fixture
def cart(tmp_path: Path) -> Cart:
    """Return a simulation of the cart's two pushes: `cart(seed=0, mass=15.0, wall=False, name="cart")`."""

    def simulate(
        seed: int = 0, mass: float = 15.0, wall: bool = False, name: str = "cart"
    ) -> trundle.Recording:
        (tmp_path / "cart.toml").write_text(OBJECT.format(mass=mass))
        scenario = tmp_path / "scenario.toml"
        scenario.write_text(SCENARIO.format(name=name) + (WALL if wall else "") + PUSHES)
        return trundle.simulate(scenario, seed=seed)

    return simulate


@pytest.fixture
def model() -> trundle.Model:
    """Return the cart's model, its mass and friction free."""
    return trundle.Model.from_toml(MODEL)
