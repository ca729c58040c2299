"""Objects with much content."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import trundle
from tests.record_prepare.table import Table
from tests.record_prepare.table import recording as table_recording
from tests.report.answers import table_diagnosis

MODEL = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
{mass}
""" + "".join(
    f"""
[[effect]]
kind = "viscous_wheel"
x = {0.1 * k}
y = 0.0
angle = 0.3
mu_x = 20.0
mu_y = 180.0
"""
    for k in range(-4, 5)
)


def model(mass: str = "mass = 22.0") -> trundle.Model:
    """Return a model with nine wheels; an empty `mass` is free."""
    return trundle.Model.from_toml(MODEL.format(mass=mass))


@cache
def recording(name: str = "table", episodes: int = 3) -> trundle.Recording:
    """Return a recording, the last episode of which is held out."""
    last = f"episode_{episodes - 1:02}"
    return table_recording(Table(episodes=episodes, metadata={"name": name, "split": {"held_out": [last]}}))


def answer() -> dict[str, Any]:
    """Return the answer of a diagnosis: one missing effect."""
    return table_diagnosis()


def diagnosis(found: dict[str, Any] | None = None) -> trundle.Diagnosis:
    """Return a diagnosis with a million numbers in its series."""
    series = {"episodes": [{"t": np.zeros(100_000).tolist()} for _ in range(10)]}
    return trundle.Diagnosis(found or answer(), model(), "<html>" * 9999, series, None)  # type: ignore[arg-type]


def fit() -> trundle.Fit:
    """Return a fit with many parameters."""
    known = {"mean": 22.1, "sd": 0.1, "low": 21.9, "high": 22.3, "unit": "kg", "identifiable": True}
    unknown = {key: None for key in ("mean", "sd", "low", "high")} | {"unit": "m", "identifiable": False}
    score = {"position_rmse": 0.012, "window_position_rmse": None, "force_rmse": 1.2}
    summary: Any = {
        "recording": "table",
        "parameters": [
            {"name": "body.mass", **known},
            *({"name": f"wheel_{k}.x", **unknown} for k in range(30)),
        ],
        "converged": True,
        "lack_of_fit": {
            "found": True,
            "gain_nats": 90.0,
            "residual_force_rms": 3.2,
            "residual_torque_rms": 0.4,
        },
        "training": score,
        "held_out": None,
    }
    return trundle.Fit(model(), summary)
