"""A small simulated recording for the examples in docstrings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.report.answers import table_sample

ROOT = Path(__file__).resolve().parents[2]

SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "configs/objects/office_table.toml"
held_out = 1

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

[sensor]
rate = 100.0
[tracker]
rate = 60.0
[random]
count = 3
duration = 2.0
speed = 0.3
spin = 0.5
"""

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
"""

FRICTION = """
[[effect]]
kind = "coulomb_friction"
x = 0.5
y = -0.3
"""


LOG = "t,x_mm,y_mm,theta_deg,fx,fy,tz\n0.0,1,2,0,0.1,0.2,0\n0.1,1,3,2,1.5,0.2,0.1\n0.2,2,5,4,1.6,0.3,0.1\n"


@pytest.fixture(scope="session")
def examples(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Return the folder in which the examples run, and their global names.

    Examples use ``trundle``, ``np``, ``recording`` (three episodes of 2 s, the last one held out), its
    ``episode``, its ``prediction``, the ``posterior`` of one parameter, and a ``diagnosis``; and the files
    ``scenario.toml``, ``model.toml`` (all values given), ``free.toml`` (the friction force is free),
    ``wheel.toml`` (no friction), ``log.csv`` (poses and wrenches) and ``configs/``.
    """
    folder = tmp_path_factory.mktemp("examples")
    (folder / "configs").symlink_to(ROOT / "configs")
    (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    (folder / "wheel.toml").write_text(MODEL, encoding="utf-8")
    (folder / "free.toml").write_text(MODEL + FRICTION, encoding="utf-8")
    (folder / "model.toml").write_text(f"{MODEL}{FRICTION}force = 14.0\n", encoding="utf-8")
    (folder / "log.csv").write_text(LOG, encoding="utf-8")
    recording = trundle.simulate(folder / "scenario.toml", seed=1)
    names = {
        "trundle": trundle,
        "np": np,
        "recording": recording,
        "episode": recording["episode_00"],
        "prediction": trundle.predict(recording, folder / "model.toml"),
        "diagnosis": diagnosis(),
        "posterior": trundle.sample(recording, folder / "free.toml", draws=50, starts=2),
    }
    return folder, names


def diagnosis() -> trundle.Diagnosis:
    """Return a diagnosis that names dry friction."""
    answer, series = table_sample()
    model = trundle.Model.from_toml(f"{MODEL}{FRICTION}force = 6.0\n")
    return trundle.Diagnosis(answer, model, "<html></html>", series, None)  # type: ignore[arg-type]
