"""The sentence at the top of a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

from trundle.cli.commands.diagnose import format_joint_answer
from trundle.joint_diagnosis.symptoms import headline, residual_sentence, symptoms


def answer(*probabilities: float) -> Any:
    missing = [
        {"effect": "joint_dry_friction", "where": {"joint": f"joint_{k}"}, "probability": probability}
        for k, probability in enumerate(probabilities)
    ]
    return cast("Any", {"verdict": "explained", "missing": missing})


def test_an_effect_with_a_low_probability_may_be_missing() -> None:
    assert headline(answer(0.9)) == "The simulation misses dry friction at joint joint_0."
    assert headline(answer(0.9, 0.4)).startswith("The simulation may miss dry friction at joint joint_0 and")


def unexplained(regime: str | None, kind: str | None = None) -> Any:
    window = {"episode": "e1", "joint": "elbow", "start": 1.0, "end": 1.5, "strength": 3.2}
    return {
        "recording": "arm",
        "verdict": "unexplained",
        "missing": [],
        "immaterial": [],
        "tied": [],
        "alternatives": [],
        "mismatch": {"joints": {"shoulder": 0.02, "elbow": 0.98}, "windows": [window], "regime": regime},
        "residual": {
            "effort_rms": {"shoulder": 0.01, "elbow": 0.4},
            "effort_unit": {"shoulder": "N·m", "elbow": "N·m"},
            "regime": regime,
            "regime_kind": kind,
            "share": 1.0,
        },
        "fit": {"held_out": None},
    }


def test_an_unexplained_answer_says_where_when_how_large_and_what_next() -> None:
    rows = dict(symptoms(unexplained("above 0.50 rad/s, joint elbow", "high_speed")))
    assert list(rows) == ["where", "when", "how large", "tried", "record next"]
    assert "joint elbow (98 % of the misfit)" in rows["where"]
    assert "shoulder" not in rows["where"]
    assert "above 0.50 rad/s" in rows["when"]
    assert "largest in e1" in rows["when"]
    assert "0.400 N·m at joint elbow" in rows["how large"]
    assert "double the speed" in rows["record next"]


def test_a_residual_that_decays_during_a_recording_may_be_warm_up() -> None:
    rows = dict(symptoms(unexplained("in the first half of the recording, joint elbow", "first_half")))
    assert rows["when"].startswith("It is larger in the first half of the recording")
    assert "recovers in the pause" in rows["record next"]


def test_the_terminal_says_what_a_verdict_without_names_means() -> None:
    lines = format_joint_answer(unexplained(None), Path("out"))
    assert lines[:2] == ["arm: unexplained", f"  {headline(unexplained(None))}"]
    assert [line.split(":")[0].strip() for line in lines[2:]][:2] == ["where", "when"]
    assert any(line.startswith("  record next: Repeat one motion of joint elbow") for line in lines)
    assert "shoulder" not in "".join(lines)


@pytest.mark.parametrize("verdict", ["consistent", "reparameterised"])
def test_a_residual_without_a_name_is_within_the_noise(verdict: str) -> None:
    clean = {**unexplained(None), "verdict": verdict}
    assert residual_sentence(cast("Any", clean)) == "The residual is within the noise."
    assert symptoms(cast("Any", clean)) == []


def test_the_terminal_says_that_no_episode_is_held_out() -> None:
    answer = unexplained(None)
    assert answer["fit"]["held_out"] is None
    assert any("no episode is held out" in line for line in format_joint_answer(answer, Path("out")))
