"""A further push of the same object: its selection, its simulation, and its score."""

from __future__ import annotations

import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from trundle.cli import main
from trundle.experiments.blind import follow_up_tables
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.follow_up import (
    DESIGNED,
    RANDOM_SIMILAR,
    RANDOM_UNRESTRICTED,
    extend_recording,
    next_push,
    push_kinds,
    requested_experiment,
    restore_object,
)
from trundle.experiments.blind.furniture.families import FAMILIES
from trundle.experiments.blind.furniture.generator import draw, simulate_case
from trundle.experiments.blind.furniture.scene import draw_scene
from trundle.experiments.blind.furniture.simulation import episode_table, make_recording, simulate
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp, Push, WrenchPush
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.score import is_unambiguous
from trundle.experiments.results import rounded

Row = dict[str, Any]


def experiment(*models: str, profile: str = "steady") -> Row:
    push = {
        "grasp": [0.2, -0.1],
        "direction": 0.5,
        "start": [0.3, 0.1, 1.2],
        "profile": profile,
        "knots": [[0.0, 0.0, 0.0, 0.0], [0.5, 12.0, 0.0, 1.0], [2.0, 12.0, 0.0, 1.0], [2.2, 0.0, 0.0, 0.0]],
    }
    return {"models": list(models), "separation": [20.0, 30.0], "sure": 0.99, "pushes": [push]}


def answered(*names: str, p: float = 0.6, tied: Any = (), experiments: Any = (), twin: float = 0.0) -> Row:
    return {
        "verdict": "explained" if names else "unexplained",
        "missing": [{"effect": name, "probability": p} for name in names],
        "tied": list(tied),
        "alternatives": [{"effect": "com_offset", "probability": twin}],
        "experiments": list(experiments),
        "effort": {"force": 12.0, "distance": 0.4, "turn": 0.1},
    }


TIE = [["floor_slope", "force_bias"]]
OF_TIE = experiment("floor_slope", "force_bias")
OF_OTHER = experiment("floor_slope", "tether + latency")


def test_pushes_for_ties_come_first_unless_uninformative() -> None:
    both, dull = [OF_OTHER, OF_TIE], {**OF_TIE, "sure": 0.1}
    assert requested_experiment(answered("floor_slope", tied=TIE, experiments=[dull, OF_OTHER])) is OF_OTHER
    assert requested_experiment(answered("floor_slope", tied=TIE, experiments=[dull])) is dull
    assert requested_experiment(answered("floor_slope", tied=TIE, experiments=[dull, OF_TIE])) is OF_TIE
    assert requested_experiment(answered("floor_slope", tied=TIE, experiments=both)) is OF_TIE
    assert requested_experiment(answered("floor_slope", experiments=both)) is OF_OTHER
    assert requested_experiment(answered("floor_slope", tied=TIE)) is None
    assert requested_experiment(answered("floor_slope", experiments=[{**OF_TIE, "pushes": []}])) is None
    assert requested_experiment(answered(experiments=both)) is None


def test_results_without_pushes_are_reported() -> None:
    old = answered("floor_slope")
    del old["experiments"]
    with pytest.raises(trundle.TrundleError, match="--fresh"):
        requested_experiment(old)


OPTIONS = {"matters": 1.5, "each_matters": 2.0, "attempts": 30, "episodes": 2, "alike": True}


@cache
def case(name: str = "force_bias") -> tuple[trundle.Recording, Row]:
    """Return a recording of two similar pushes and its sealed answer."""
    planned = {"case": "case_0000", "names": [name], "seed": 7}
    with tempfile.TemporaryDirectory() as folder:
        truth = draw(planned, OPTIONS, Path(folder) / "case_0000")
        return trundle.read(Path(folder) / "case_0000"), json.loads(json.dumps(rounded(truth)))


def test_the_extended_recording_has_one_more_training_episode() -> None:
    before, truth = case()
    scene, hidden = restore_object(truth, OPTIONS)
    made = {kind: extend_recording(before, scene, hidden, kind, OF_TIE)[0] for kind in push_kinds(alike=True)}
    for longer in made.values():
        assert longer.metadata == before.metadata
        assert longer.metadata["split"]["held_out"] == ["episode_01"]
        assert list(longer.episodes) == ["episode_00", "episode_01", "episode_02"]
        for name, columns in before.episodes.items():
            for column, values in columns.items():
                np.testing.assert_array_equal(longer.episodes[name][column], values)
    starts = {kind: longer.episodes["episode_02"]["object_theta"] for kind, longer in made.items()}
    assert np.nanmean(starts[DESIGNED][:40]) == pytest.approx(1.2, abs=0.02)
    first = before.episodes["episode_00"]["object_theta"]
    assert np.nanmean(starts[RANDOM_SIMILAR][:40]) == pytest.approx(np.nanmean(first[:40]), abs=0.02)


def test_the_further_push_has_the_same_object_and_effect() -> None:
    before, truth = case()
    scene, hidden = restore_object(truth, OPTIONS)
    again = episode_table(scene, hidden, 0, simulate(scene, hidden, 0))
    for column, values in before.episodes["episode_00"].items():
        np.testing.assert_allclose(again[column], values, atol=1e-3, err_msg=column)


def test_the_further_push_does_not_depend_on_the_hidden_effect() -> None:
    scene = draw_scene(7, 0, 2, alike=True)
    designed = next_push(scene, DESIGNED, OF_TIE)
    assert isinstance(designed, WrenchPush)
    assert (designed.start, designed.grasp) == ((0.3, 0.1, 1.2), Grasp(0.2, -0.1, 0.5))
    for kind in (RANDOM_SIMILAR, RANDOM_UNRESTRICTED):
        made = [next_push(scene, kind, asked) for asked in (OF_TIE, OF_OTHER)]
        assert repr(made[0]) == repr(made[1])


def test_control_pushes_are_drawn_similarly_and_freely() -> None:
    alike = draw_scene(7, 0, 3, alike=True)
    like, free = (next_push(alike, kind, OF_TIE) for kind in (RANDOM_SIMILAR, RANDOM_UNRESTRICTED))
    assert isinstance(like, Push)
    assert isinstance(free, Push)
    assert (like.start, like.grasp) == (alike.pushes[0].start, alike.pushes[0].grasp)
    assert not like.amplitude[2].any()
    assert free.start != like.start
    assert free.amplitude[2].any()
    assert push_kinds(alike=False) == (DESIGNED, RANDOM_SIMILAR)
    usual = next_push(draw_scene(7, 0, 3), RANDOM_SIMILAR, OF_TIE)
    assert isinstance(usual, Push)
    assert usual.amplitude[2].any()


def test_similar_pushes_do_not_rotate_the_object() -> None:
    scene = draw_scene(7, 0, 3, alike=True)
    for k in range(3):
        pose = simulate(scene, [], k).pose
        np.testing.assert_array_equal(pose[0], scene.pushes[0].start)
        assert np.ptp(pose[:, 2]) < 0.1
        assert np.ptp(pose[:, :2], axis=0).max() > 0.05


def test_each_episode_has_its_own_initial_caster_angle() -> None:
    caster = FAMILIES["caster_swivel"]
    values: Row = {"point": [0.1, 0.0], "trail": 0.05, "mu_side": 80.0, "first": [0.1, 0.2]}
    longer = HiddenEffect(caster, values).extended(np.random.default_rng(0)).values
    assert longer["first"][:2] == values["first"]
    assert len(longer["first"]) == 3
    assert len(values["first"]) == 2


def recorded(scene: Scene, hidden: list[HiddenEffect]) -> trundle.Recording:
    """Return the recording of a scene."""
    return make_recording(scene, hidden, simulate_case(scene, hidden), "case")


def test_an_event_persists_in_the_further_episode() -> None:
    """A load that was added in a training episode remains."""
    scene = draw_scene(7, 0, 2, alike=True)
    event = {"episode": 0, "time": 2.0, "mass": 5.0}
    hidden = HiddenEffect(FAMILIES["mass_change"], event)
    heavy, of_heavy = extend_recording(recorded(scene, [hidden]), scene, [hidden], DESIGNED, OF_TIE)
    light, of_light = extend_recording(recorded(scene, []), scene, [], DESIGNED, OF_TIE)
    ends = [np.nanmean(made.episodes["episode_02"]["object_x"][-40:]) for made in (heavy, light)]
    assert abs(ends[0] - ends[1]) > 0.003
    assert of_heavy["force"] == of_light["force"] == pytest.approx(12.0)
    assert of_heavy["distance"] < of_light["distance"]


def test_a_commanded_wrench_is_piecewise_linear() -> None:
    push = WrenchPush((0.0, 0.0, 0.0), Grasp(0.0, 0.0, 0.0), np.array(OF_TIE["pushes"][0]["knots"]))
    found = push.wrench(CONTACT_TIME_S + np.array([0.0, 0.25, 1.0, 2.1, 4.0]))
    np.testing.assert_allclose(found[:, 0], [0.0, 6.0, 12.0, 6.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found[:, 2], found[:, 0] / 12.0, atol=1e-9)


def rows(name: str, answers: dict[str, Row], truth: str = "floor_slope") -> tuple[Row, list[Row]]:
    known = {"names": [truth], "outside": False, "truth": []}
    made = [
        {"case": name, "push": kind, "answer": one, "truth": known, "seconds": 1.0}
        for kind, one in answers.items()
    ]
    first = [row for row in made if row["push"] == "none"]
    return first[0], [row for row in made if row["push"] != "none"]


def test_resolved_ties_are_counted_with_their_controls() -> None:
    doubt = answered("floor_slope", tied=TIE, experiments=[OF_TIE])
    alone, wrong = answered("floor_slope", p=0.999), answered("force_bias", p=0.999)
    cases = [
        rows("case_0000", {"none": doubt, DESIGNED: alone, RANDOM_SIMILAR: doubt}),
        rows("case_0001", {"none": doubt, DESIGNED: alone, RANDOM_SIMILAR: wrong}),
        rows("case_0002", {"none": doubt, DESIGNED: wrong, RANDOM_SIMILAR: alone}),
        rows("case_0003", {"none": doubt, DESIGNED: alone}),
    ]
    first, more = [one for one, _ in cases], [row for _, rest in cases for row in rest]
    found = follow_up_tables.cases_of(first, more)
    assert [case["none"]["case"] for case in found] == ["case_0000", "case_0001", "case_0002"]
    lines = follow_up_tables.rates(found).splitlines()[2:]
    assert [line.split("|")[2].split("], ")[1].strip() for line in lines] == ["0 of 3", "2 of 3", "1 of 3"]
    assert "3 of 3" in lines[0].split("|")[4]
    assert [line.split("|")[6].strip() for line in lines] == ["2.00", "1.00", "1.33"]
    compared = follow_up_tables.pairs(found).splitlines()[3]
    assert compared.split("|")[2:5] == [f" {RANDOM_SIMILAR} ", " 2 ", " 1 "]
    assert "case_0002" in follow_up_tables.all_cases(found)
    assert follow_up_tables.initially_tied(found) == found
    assert "| floor_slope | 3 | 0 | 2 | 1 |" in follow_up_tables.by_effect(found)
    said = follow_up_tables.case_counts(first, found)
    assert "4 recordings, 4 explained, 4 of these with a tie" in said
    assert "predict a decision in 99 %" in said
    assert "| designed | 12 | 0.4 | 0.1 |" in follow_up_tables.efforts(found)


def test_a_tie_with_the_true_name_is_right_but_unresolved() -> None:
    truth = {"names": ["force_bias"], "outside": False}
    assert not is_unambiguous(answered("floor_slope", tied=TIE), truth)
    assert is_unambiguous(answered("force_bias"), truth)
    assert not is_unambiguous(answered("floor_slope"), truth)
    twins = ["tracker_offset", "com_offset"]
    moved = {"names": ["com_offset"], "outside": False}
    assert is_unambiguous(answered("tracker_offset", tied=[twins]), moved)
    assert not is_unambiguous(answered("tracker_offset", tied=[[*twins, "swinging_load"]]), moved)
    assert not is_unambiguous(answered("tracker_offset"), moved)


def test_equivalent_effects_share_their_probability() -> None:
    moved: Row = {"names": ["com_offset"], "outside": False, "truth": []}
    both = answered("tracker_offset", p=0.8, tied=[["tracker_offset", "com_offset"]], twin=0.19)
    assert follow_up_tables.is_sure({"answer": both, "truth": moved})
    alone = answered("com_offset", p=0.8, twin=0.19)
    assert not follow_up_tables.is_sure({"answer": alone, "truth": moved})


def test_missing_results_are_shown_in_the_table() -> None:
    assert follow_up_tables.rates([]).count("no case") == 4
    assert "diagnosed for 0 of them" in follow_up_tables.case_counts([], [])
    follow_up_tables.pairs([])
    follow_up_tables.by_effect([])
    follow_up_tables.all_cases([])
    follow_up_tables.efforts([])


def test_detection_limits_have_no_further_pushes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prove", "--limits", "--after-design"]) == 2
    assert "remove --limits" in capsys.readouterr().err
