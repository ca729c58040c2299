"""The box "Use this model": its code runs, and only code that suits the model is offered."""

from __future__ import annotations

import copy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import trundle
from tests.report.answers import Sample
from trundle.report.series import Series
from trundle.report.use import use

MODEL = """
format = "trundle-model/1"

[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
support = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]
mass = 21.9

[[effect]]
kind = "coulomb_friction"
x = 0.5
y = -0.3
force = 14.0
"""


def box(sample: Sample, **more: Any) -> dict[str, Any]:
    diagnosis, series = sample
    return use(diagnosis, Series.parse(series | more))


def names(found: dict[str, Any]) -> list[str]:
    return [snippet.name for snippet in found["snippets"]]


@pytest.mark.parametrize("more", [{}, {"black_box": True}, {"quasi_static": True}])
def test_the_python_code_runs_next_to_the_model(
    samples: dict[str, Sample], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: dict[str, Any]
) -> None:
    trundle.Model.from_toml(MODEL).write(tmp_path / "model.toml")
    monkeypatch.chdir(tmp_path)
    for snippet in box(samples["table"], **more)["snippets"]:
        if snippet.name == "MuJoCo":
            script = "import sys; from trundle.cli import main; sys.exit(main(sys.argv[1:]))"
            subprocess.run([sys.executable, "-c", script, *snippet.code.split()[1:]], check=True)
            assert (tmp_path / "mujoco" / "model.toml").exists()
        else:
            exec(compile(snippet.code, snippet.name, "exec"), {})


def test_an_environment_has_exactly_the_model(tmp_path: Path) -> None:
    import gymnasium

    model = trundle.Model.from_toml(MODEL)
    options = trundle.objects.task_options(model, tmp_path / "object.toml")
    env = gymnasium.make("trundle/PushPose-v0", **options)
    env.reset(seed=3)
    hidden = env.unwrapped.hidden_model()  # type: ignore[attr-defined]
    assert hidden["body"]["mass"] == 21.9
    effect = hidden["effect"][0]
    assert [effect[key] for key in ("kind", "x", "y", "force")] == ["coulomb_friction", 0.5, -0.3, 14.0]


def test_code_that_the_model_does_not_support_is_not_offered(samples: dict[str, Sample]) -> None:
    assert names(box(samples["table"])) == ["Python", "Gymnasium environment", "MuJoCo"]
    assert names(box(samples["rail"])) == ["Python"]
    assert names(box(samples["quasi_static"])) == ["Python"]
    assert names(box(samples["discrepancy"])) == ["Python"]
    assert names(box(samples["table"], black_box=True)) == ["Python", "MuJoCo"]
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["missing"][0]["effect"] = "sensor_lag"
    assert names(box((diagnosis, series))) == ["Python", "MuJoCo"]


def test_the_box_of_an_unexplained_recording_says_what_is_not_in_the_model(
    samples: dict[str, Sample],
) -> None:
    found = box(samples["unexplained"])
    assert found["title"] == "Use the refitted model, without the missing effect"
    assert "without the missing effect" in found["content"]
    assert "learned force" in box(samples["discrepancy"])["content"]
