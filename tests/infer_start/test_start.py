"""Fits from a given start."""

from __future__ import annotations

import numpy as np
import pytest

import trundle

START = {
    "body.mass": 18.0,
    "viscous_wheel.x": -0.3,
    "viscous_wheel.y": -0.1,
    "viscous_wheel.angle": 0.0,
    "viscous_wheel.mu_x": 30.0,
    "viscous_wheel.mu_y": 90.0,
}


@pytest.fixture(scope="module")
def recording() -> trundle.Recording:
    """Return a push along x of 10 kg on a wheel at the origin with 30 N·s/m in all directions."""
    t = np.arange(0.0, 3.0, 0.01)
    force = np.where(t >= 0.2, 30.0, 0.0)
    since = np.maximum(t - 0.2, 0.0)
    x = since - (1.0 - np.exp(-3.0 * since)) / 3.0
    nothing = np.zeros_like(t)
    metadata = {
        "format": "trundle-recording/1",
        "name": "push",
        "object": {"footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]},
        "wrench": {"frame": "object", "reference": "object", "sign": "on_object", "raw": False},
        "noise": {"pose": [5e-4, 5e-4, 1.7e-3], "force": 0.4, "torque": 0.05},
    }
    columns = {"object_x": x, "object_y": nothing, "object_theta": nothing}
    columns |= {"force_x": force, "force_y": nothing, "torque_z": nothing}
    return trundle.Recording(metadata, {"push": {"t": t, **columns}})


def test_a_given_start_is_sufficient(recording: trundle.Recording) -> None:
    found = trundle.fit(recording, start=START, starts=0)
    mass = next(p for p in found.summary["parameters"] if p["name"] == "body.mass")
    assert mass["mean"] == pytest.approx(10.0, rel=0.03)


@pytest.mark.parametrize(
    ("start", "said"),
    [
        ({**START, "wheel.x": 0.0}, r"start: `wheel\.x` is not a free parameter; free are body\.mass, "),
        ({k: v for k, v in START.items() if k != "body.mass"}, r"start: `body\.mass` is missing"),
        ({**START, "body.mass": -1.0}, r"start: body\.mass = -1: must lie in"),
        ({**START, "viscous_wheel.mu_x": float("nan")}, r"start: viscous_wheel\.mu_x = NaN: must lie in"),
    ],
)
def test_an_unusable_start_is_named(recording: trundle.Recording, start: dict[str, float], said: str) -> None:
    with pytest.raises(trundle.TrundleError, match=said):
        trundle.fit(recording, start=start, starts=0)


def test_a_missing_start_is_refused(recording: trundle.Recording) -> None:
    with pytest.raises(trundle.TrundleError, match="at least one start"):
        trundle.fit(recording, starts=0)
