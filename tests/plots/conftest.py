"""A small simulated recording, the model that made it, and sample diagnoses."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

import trundle

ROOT = Path(__file__).resolve().parents[2]

SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{table}"
held_out = 1
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[random]
count = 3
duration = 2.0
speed = 0.3
spin = 0.5
"""

MODEL = """
format = "trundle-model/1"
[body]
mass = 22.0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
"""

RAIL = """
format = "trundle-model/1"
[body]
mass = 95.0
[[effect]]
kind = "viscous_wheel"
mu_x = 200.0
"""


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> trundle.Recording:
    folder = tmp_path_factory.mktemp("push")
    table = ROOT / "configs" / "objects" / "office_table.toml"
    (folder / "push.toml").write_text(SCENARIO.format(table=table), encoding="utf-8")
    return trundle.simulate(folder / "push.toml", seed=2)


@pytest.fixture(scope="session")
def fitted() -> trundle.Fit:
    """The model of the simulation as the result of a fit."""
    summary = {
        "training": {"position_rmse": 0.0012},
        "held_out": {"position_rmse": 0.0034},
        "quasi_static": False,
    }
    return trundle.Fit(trundle.Model.from_toml(MODEL), cast(Any, summary))
