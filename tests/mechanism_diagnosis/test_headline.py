"""The sentence at the top of a page."""

from __future__ import annotations

from typing import Any, cast

from trundle.joint_diagnosis.report import headline


def answer(*probabilities: float) -> Any:
    missing = [
        {"effect": "joint_dry_friction", "where": {"joint": f"joint_{k}"}, "probability": probability}
        for k, probability in enumerate(probabilities)
    ]
    return cast("Any", {"verdict": "explained", "missing": missing})


def test_an_effect_with_a_low_probability_may_be_missing() -> None:
    assert headline(answer(0.9)) == "The simulation misses dry friction at joint joint_0."
    assert headline(answer(0.9, 0.4)).startswith("The simulation may miss dry friction at joint joint_0 and")
