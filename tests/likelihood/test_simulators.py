"""Fits with known obstacles, and with black-box simulators."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

Cart = Callable[..., trundle.Recording]
Vector = NDArray[np.float64]


def mean(fit: trundle.Fit, name: str) -> float:
    (found,) = [p["mean"] for p in fit.summary["parameters"] if p["name"] == name]
    return float(found)


def test_a_known_wall_is_simulated(cart: Cart, model: trundle.Model) -> None:
    recording = cart(wall=True)
    with_wall = trundle.fit(recording, model, starts=3)
    assert with_wall.summary["likelihood"] == "windows"
    assert mean(with_wall, "body.mass") == pytest.approx(15.0, rel=0.1)
    assert mean(with_wall, "viscous_wheel.mu_x") == pytest.approx(10.0, rel=0.15)
    assert mean(with_wall, "viscous_wheel.mu_y") == pytest.approx(30.0, rel=0.15)
    without = trundle.fit(recording, model, likelihood="windows", obstacles=False)
    off = [
        abs(mean(without, "body.mass") / 15.0 - 1.0),
        abs(mean(without, "viscous_wheel.mu_x") / 10.0 - 1.0),
    ]
    assert max(off) > 0.5


def test_the_filter_refuses_obstacles(cart: Cart) -> None:
    with pytest.raises(trundle.TrundleError, match="supports neither obstacles"):
        trundle.fit(cart(wall=True), likelihood="filter")


def rolling(state: Vector, wrench: Vector, dt: float, values: dict[str, float]) -> Vector:
    """Step a cart on two independent viscous frictions along its axes, by the exponential of each."""
    x, y, theta, vx, vy, omega = state.tolist()
    mass = values["body.mass"]
    cos, sin = math.cos(theta), math.sin(theta)

    def rolled(speed: float, force: float, mu: float) -> float:
        decay = math.exp(-mu * dt / mass)
        return decay * speed + (1.0 - decay) * force / mu

    ahead = rolled(cos * vx + sin * vy, float(wrench[0]), values["viscous_wheel.mu_x"])
    aside = rolled(cos * vy - sin * vx, float(wrench[1]), values["viscous_wheel.mu_y"])
    after_x, after_y = cos * ahead - sin * aside, sin * ahead + cos * aside
    spin = omega + float(wrench[2]) / (mass * (0.8**2 + 0.6**2) / 12.0) * dt
    pose = [x + (vx + after_x) / 2.0 * dt, y + (vy + after_y) / 2.0 * dt, theta + (omega + spin) / 2.0 * dt]
    return np.array([*pose, after_x, after_y, spin])


def test_a_black_box_simulator_replaces_the_laws(cart: Cart, model: trundle.Model) -> None:
    fit = trundle.fit(cart(), model, step=rolling, starts=1)
    assert fit.summary["likelihood"] == "windows"
    laws = trundle.fit(cart(), model, likelihood="windows")
    for name in ("body.mass", "viscous_wheel.mu_x", "viscous_wheel.mu_y"):
        assert mean(fit, name) == pytest.approx(mean(laws, name), rel=0.02), name


@pytest.mark.parametrize(
    "returned", [[float("nan")] * 6, [0.0] * 5, "nothing", None], ids=["nan", "short", "text", "none"]
)
def test_an_invalid_state_is_refused_with_episode_time_and_value(
    cart: Cart, model: trundle.Model, returned: Any
) -> None:
    def broken(state: Vector, wrench: Vector, dt: float, values: dict[str, float]) -> Any:
        return returned

    shown = {str: "nothing", list: "nan|0.0, 0.0", type(None): "None"}[type(returned)]
    with pytest.raises(trundle.TrundleError, match=rf"episode_0\d, t = .* s: .*({shown})"):
        trundle.fit(cart(), model, step=broken)


def test_exceptions_of_a_simulator_are_passed_on(cart: Cart, model: trundle.Model) -> None:
    def broken(state: Vector, wrench: Vector, dt: float, values: dict[str, float]) -> Vector:
        raise ZeroDivisionError("of its own")

    with pytest.raises(ZeroDivisionError, match="of its own"):
        trundle.fit(cart(), model, step=broken)
