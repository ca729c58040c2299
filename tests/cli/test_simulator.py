"""`trundle diagnose --step`: the caller's own simulator from a Python file."""

import json
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from trundle.cli.simulator import Simulator

PENDULUM = """
import math

from constants import GRAVITY, LENGTH, ROTOR


def step(state, effort, dt, values):
    q, v = state
    inertia = ROTOR + values["mass"] * LENGTH**2
    weight = values["mass"] * GRAVITY * LENGTH * math.sin(q)
    v = v + dt * (effort[0] - weight - values["damping"] * v) / inertia
    return [q + dt * v, v]


number = 3.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a simulator and a recording of a pendulum that has dry friction in addition."""
    (tmp_path / "simulator.py").write_text(PENDULUM)
    (tmp_path / "constants.py").write_text("GRAVITY, LENGTH, ROTOR = 9.81, 0.2, 0.01\n")
    (tmp_path / "broken.py").write_text("import no_such_module\n")
    t = np.arange(0, 10, 0.005)
    waves = [(0.5, 1.3), (0.4, 2.9), (0.2, 5.1)]
    q = np.sum([size * np.sin(w * t + w) for size, w in waves], axis=0)
    v = np.sum([size * w * np.cos(w * t + w) for size, w in waves], axis=0)
    a = np.sum([-size * w**2 * np.sin(w * t + w) for size, w in waves], axis=0)
    effort = (0.01 + 0.7 * 0.04) * a + 0.7 * 9.81 * 0.2 * np.sin(q) + 0.05 * v + 0.2 * np.sign(v)
    effort += np.random.default_rng(0).normal(0, 0.01, len(t))
    metadata = {
        "format": "trundle-recording/2",
        "name": "pendulum",
        "mechanism": {"types": "hinge", "joints": ["arm"]},
    }
    columns = {"t": t, "q_arm": q, "effort_arm": effort}
    trundle.JointRecording(metadata, {"one": columns}).write(tmp_path / "pendulum")
    return tmp_path


def test_a_simulator_in_a_file_is_diagnosed(folder: Path) -> None:
    words = ["--step", "simulator.py:step", "--parameter", "mass=0.6", "--parameter", "damping=0.02,0,1"]
    done = command(folder, "diagnose", "pendulum", *words, "--out", "found", "--quiet")
    assert done.returncode == 0, done.stderr
    answer = json.loads((folder / "found/diagnosis.json").read_text())
    assert answer["verdict"] == "explained"
    assert [one["effect"] for one in answer["missing"]] == ["joint_dry_friction"]
    # The report shows the command that repeats the diagnosis.
    assert "--step simulator.py:step --parameter mass=0.6" in (folder / "found/report.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--step", "simulator.py"], "give FILE:NAME"),
        (["--step", "absent.py:step"], "absent.py does not exist"),
        (["--step", "simulator.py:number"], "has no function 'number'"),
        (["--step", "broken.py:step"], "ModuleNotFoundError: No module named 'no_such_module'"),
        (["--step", "simulator.py:step", "--parameter", "mass"], "give NAME=VALUE"),
        (["--step", "simulator.py:step", "--parameter", "mass=1,2"], "NAME=START,LOWER,UPPER"),
        (["--parameter", "mass=1"], "need --step"),
    ],
    ids=["name", "absent", "function", "import", "value", "bounds", "alone"],
)
def test_errors_name_the_argument_and_the_remedy(folder: Path, words: list[str], message: str) -> None:
    done = command(folder, "diagnose", "pendulum", *words, "--out", "found")
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (folder / "found").exists()


def test_parameters_are_those_of_the_python_function(folder: Path) -> None:
    found = Simulator(f"{folder}/simulator.py:step", ("mass=0.6", "damping=0.02,0,1"), True).load()
    assert found["parameters"] == {"mass": 0.6, "damping": (0.02, 0.0, 1.0)}
    assert found["vectorized"]
    assert found["step"]([0.0, 1.0], [0.0], 0.1, {"mass": 1.0, "damping": 0.0}) == [0.1, 1.0]
