"""Effects that mask each other: two of them gain little alone and much together."""

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


@pytest.mark.slow
def test_a_triple_whose_second_effect_gains_little_is_named(tmp_path: Path) -> None:
    """Added to the caster, the offset gains 709 nats, and 1760 with the inertia of the gripper."""
    settings = read(CONFIG, "tune")
    (case,) = (case for part in settings.parts() for case in plan_cases(part) if case.case == "case_0015")
    draw = GENERATORS[settings.generator]
    draw(planned=asdict(case), options=settings.drawing(), folder=tmp_path / "case")
    answer = trundle.diagnose(tmp_path / "case").answer
    named = {missing["effect"] for missing in answer["missing"]}
    assert answer["verdict"] == "explained"
    assert named == {"caster_swivel", "gripper_inertia", "tracker_offset"} == set(case.names)
