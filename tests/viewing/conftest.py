"""A recording of two pushes, and a diagnosis of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import trundle

DEMO = Path(__file__).parents[2] / "configs" / "experiments" / "demo.toml"
MODEL = """
format = "trundle-model/1"

[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 22.0

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 180.0
mu_y = 320.0

[[effect]]
kind = "coulomb_friction"
x = 0.5
y = -0.3
force = 14.0
static_force = 0.0
stribeck_velocity = 0.01
creep = 1e-4
"""
WINDOW = {"episode": "episode_00", "start": 0.75, "end": 1.5, "strength": 41.0}


def answer() -> dict[str, Any]:
    """Return the content of a diagnosis.json."""
    nominal = {
        "mass": {"mean": 35.0, "sd": 8.0, "unit": "kg", "identifiable": True},
        **{
            f"viscous_wheel.{key}": {"mean": mean, "sd": 0.1, "unit": unit, "identifiable": True}
            for key, mean, unit in (("x", -0.25, "m"), ("y", 0.125, "m"), ("angle", 0.5, "rad"))
        },
    }
    return {
        "format": "trundle-diagnosis/1",
        "recording": "office table",
        "verdict": "explained",
        "missing": [
            {
                "effect": "coulomb_friction",
                "probability": 0.97,
                "statement": "Dry friction of 14 N acts.",
                "parameters": {"force": {"mean": 14.0, "sd": 0.1, "unit": "N"}},
                "where": {"body_point": {"mean": [0.5, -0.3], "sd": [0.01, 0.01]}},
                "explains": 0.9,
            }
        ],
        "mismatch": {"windows": [WINDOW], "body_point": [0.5, -0.3]},
        "residual": {"windows": []},
        "nominal": {"given": {}, "before": nominal, "after": nominal},
        "fit": {"held_out": {"before": {"position_rmse": 0.36}, "after": {"position_rmse": 0.004}}},
    }


@pytest.fixture(scope="session")
def recording() -> trundle.Recording:
    """Two pushes of the demo, the second held out."""
    whole = trundle.simulate(DEMO)
    episodes = {name: whole.episodes[name] for name in ("episode_00", "episode_06")}
    return trundle.Recording(whole.metadata | {"split": {"held_out": ["episode_06"]}}, episodes)


@pytest.fixture(scope="session")
def predictions(recording: trundle.Recording) -> pd.DataFrame:
    """Poses of the held-out push, and simulations that are 0.1 m and 0.01 m off."""
    push = trundle.prepare(recording)["episode_06"]
    table = {"episode": "episode_06", "t": push["pose_t"], "scored": True}
    for group, offset in (("observed", 0.0), ("before", 0.1), ("after", 0.01)):
        for k, axis in enumerate(("x", "y", "theta")):
            table[f"{group}_{axis}"] = push["pose"][:, k] + (offset if axis == "x" else 0.0)
    return pd.DataFrame(table)


@pytest.fixture
def diagnosis(recording: trundle.Recording, predictions: pd.DataFrame, tmp_path: Path) -> Path:
    """The folder of a diagnosis, with its recording in the folder next to it."""
    recording.write(tmp_path / "recordings" / "table")
    folder = tmp_path / "diagnosis" / "table"
    folder.mkdir(parents=True)
    (folder / "diagnosis.json").write_text(json.dumps(answer()))
    (folder / "model.toml").write_text(MODEL)
    predictions.to_parquet(folder / "predictions.parquet")
    return folder


def seen(column: Any) -> Any:
    """Return the samples of a column."""
    return column[np.isfinite(column)]
