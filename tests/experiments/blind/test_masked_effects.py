"""Effects that a search finds with difficulty, in recordings of the wide benchmark's tuning range."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

import trundle
from trundle.experiments.blind.benchmark import GENERATORS
from trundle.experiments.blind.plan import plan_cases
from trundle.experiments.blind.settings import read

CONFIG = Path(__file__).parents[3] / "configs/experiments/wide.toml"


def draw(name: str, folder: Path) -> set[str]:
    """Draw a case, and return its effects."""
    settings = read(CONFIG, "tune")
    (case,) = (case for part in settings.parts() for case in plan_cases(part) if case.case == name)
    GENERATORS[settings.generator](planned=asdict(case), options=settings.drawing(), folder=folder)
    return set(case.names)


def named(folder: Path) -> set[str]:
    answer = trundle.diagnose(folder).answer
    assert answer["verdict"] == "explained"
    return {missing["effect"] for missing in answer["missing"]}


@pytest.mark.slow
def test_a_triple_whose_second_effect_gains_little_is_named(tmp_path: Path) -> None:
    """Added to the caster, the offset gains 709 nats, and 1760 with the inertia of the gripper."""
    hidden = draw("case_0015", tmp_path / "case")
    assert named(tmp_path / "case") == hidden == {"caster_swivel", "gripper_inertia", "tracker_offset"}


@pytest.mark.slow
def test_a_caster_under_precise_poses_is_named(tmp_path: Path) -> None:
    """Without a missing wrench, fits of the right effects stop some four million nats above their optimum."""
    hidden = draw("case_0024", tmp_path / "case")
    assert named(tmp_path / "case") == hidden == {"caster_swivel", "tracker_offset"}
