"""Diagnosis of a black-box simulator: the example, and errors of the simulator."""

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
EPISODES, SECONDS = 4, 4.0


def load_example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("example", ROOT / "examples/diagnose_your_simulator.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


example = load_example()


@pytest.fixture(scope="module")
def clean() -> trundle.Recording:
    recording: trundle.Recording = example.simulate_recording(None, EPISODES, SECONDS)
    return recording


@pytest.mark.slow
def test_a_missing_effect_of_a_mujoco_model_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    line = [
        "diagnose",
        "--out",
        str(tmp_path / "found"),
        "--episodes",
        str(EPISODES),
        "--seconds",
        str(SECONDS),
    ]
    monkeypatch.setattr("sys.argv", line)
    found: trundle.Diagnosis = example.main()
    assert (found.verdict, found.missing) == ("explained", ["coulomb_friction"])
    effect = found.answer["missing"][0]
    assert effect["parameters"]["force"]["mean"] == pytest.approx(9.0, rel=0.1)
    assert effect["where"]["body_point"]["mean"] == pytest.approx([0.45, 0.3], abs=0.05)
    after = found.answer["nominal"]["after"]
    assert after["mass"]["mean"] == pytest.approx(21.0, rel=0.03)
    assert after["rolling"]["mean"] == pytest.approx(14.0, rel=0.1)
    held_out = found.answer["fit"]["held_out"]
    assert held_out["after"]["position_rmse"] < 0.3 * held_out["before"]["position_rmse"]
    names = {"diagnosis.json", "model.toml", "predictions.parquet", "report.html"}
    assert {path.name for path in (tmp_path / "found").iterdir()} == names
    # The model contains the effects to add, but not the simulator.
    assert [p["name"].split(".")[0] for p in found.model.parameters[1:]] == ["coulomb_friction"] * 6
    assert "coulomb_friction" in capsys.readouterr().out


@pytest.mark.slow
def test_a_clean_recording_is_consistent(clean: trundle.Recording) -> None:
    found = trundle.diagnose(clean, step=example.Table().step, parameters=example.PARAMETERS)
    assert (found.verdict, found.missing) == ("consistent", [])
    assert found.answer["nominal"]["after"]["mass"]["mean"] == pytest.approx(21.0, rel=0.02)
    repeated = trundle.diagnose(clean, step=example.Table().step, parameters=example.PARAMETERS)
    assert repeated.answer == found.answer


GOOD = {"mass": 21.0}


def raising(error: BaseException) -> Any:
    def step(state: Floats, wrench: Floats, dt: float, values: dict[str, float]) -> Floats:
        raise error

    return step


def test_an_exception_becomes_the_cause_of_an_error_with_the_call(clean: trundle.Recording) -> None:
    cause = RuntimeError("the engine is on fire")
    with pytest.raises(trundle.TrundleError, match="on fire") as caught:
        trundle.diagnose(clean, step=raising(cause), parameters=GOOD)
    assert caught.value.__cause__ is cause
    for words in ("push_0", "t = ", "mass = 21", "dt = 0.00", "state ["):
        assert words in str(caught.value)


@pytest.mark.parametrize(
    "answer", [np.full(6, np.nan), np.zeros(5), np.zeros((2, 3)), "nothing", None, [1.0, 2.0, None, 0, 0, 0]]
)
def test_an_invalid_state_is_refused(clean: trundle.Recording, answer: object) -> None:
    def step(state: Floats, wrench: Floats, dt: float, values: dict[str, float]) -> Any:
        return answer

    with pytest.raises(trundle.TrundleError, match="six finite numbers") as caught:
        trundle.diagnose(clean, step=step, parameters=GOOD)
    assert "push_0" in str(caught.value) and "mass = 21" in str(caught.value)


def test_ctrl_c_is_passed_on(clean: trundle.Recording) -> None:
    with pytest.raises(KeyboardInterrupt):
        trundle.diagnose(clean, step=raising(KeyboardInterrupt()), parameters=GOOD)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        (None, "give the parameters"),
        ({"mass": -1.0}, "give its uncertainty"),
        ({"mass": (20.0, 30.0, 40.0)}, r"must lie in \[30.0, 40.0\]"),
        ({"mass": {"begin": 20.0}}, "unknown key 'begin'"),
        ({"mass": {"lower": 20.0}}, "`start` is missing"),
        ({"mass": "heavy"}, "give a number"),
        ({"mass": {"start": "heavy"}}, "must be a number"),
        ({"mass": {"start": 20.0, "sd": -1.0}}, "sd = -1.0"),
    ],
)
def test_an_invalid_parameter_is_refused(clean: trundle.Recording, parameters: Any, words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.diagnose(clean, step=example.Table().step, parameters=parameters)


def test_a_model_and_a_simulator_exclude_each_other(clean: trundle.Recording, tmp_path: Path) -> None:
    with pytest.raises(trundle.TrundleError, match="remove `model`"):
        trundle.diagnose(clean, tmp_path / "model.toml", step=example.Table().step, parameters=GOOD)
    with pytest.raises(trundle.TrundleError, match="need `step`"):
        trundle.diagnose(clean, parameters=GOOD)
