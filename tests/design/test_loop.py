"""Diagnose, make the designed push, diagnose again: the tie is resolved."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import trundle
from tests.design.test_design import ALIKE, model, simulated


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return model(tmp_path_factory.mktemp("loop"), {"kind": "support_drag"}, body=False)


@pytest.fixture(scope="module")
def before(nominal: Path) -> trundle.Diagnosis:
    return trundle.diagnose(simulated(nominal.parent / "before", ALIKE), nominal)


def asked(answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return the experiment between slope and offset."""
    pair = {"floor_slope", "force_bias"}
    experiments: list[dict[str, Any]] = answer["experiments"]
    return next(found for found in experiments if set(found["models"]) == pair)


def test_a_tie_has_a_certificate(before: trundle.Diagnosis) -> None:
    tie = next(names for names in before.answer["tied"] if set(names) >= {"floor_slope", "force_bias"})
    certificates = [found for found in before.answer["certificates"] if set(found["models"]) <= set(tie)]
    about = next(found for found in certificates if set(found["models"]) == {"floor_slope", "force_bias"})
    assert about["same"] and about["sigmas"] < 1.0 and about["position"] < 0.01
    assert abs(about["log_likelihood_difference"]) < 2.0
    assert "indistinguishable within noise" in about["statement"]
    assert about["statement"].split(".")[0] in before.report


def test_the_designed_push_resolves_the_tie(before: trundle.Diagnosis, nominal: Path) -> None:
    plan = asked(before.answer)
    alternative = next(a for a in before.answer["alternatives"] if a["effect"] in plan["models"])
    assert alternative["experiment"] == plan["sentence"]
    best = plan["pushes"][0]
    made = {
        "start": best["start"],
        "grasp": [*best["grasp"], best["direction"]],
        "drive": "force",
        "knots": best["knots"],
    }
    after = trundle.diagnose(simulated(nominal.parent / "after", [*ALIKE, made]), nominal)
    assert after.missing == ["floor_slope"]
    assert not any("force_bias" in names for names in after.answer["tied"])
    assert after.answer["missing"][0]["probability"] > 0.95
