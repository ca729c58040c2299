"""Scores of invented right and wrong answers."""

from __future__ import annotations

import math
from typing import Any

import pytest

from trundle.experiments.blind import figures, tables
from trundle.experiments.blind.errors import parameter_errors, place_errors
from trundle.experiments.blind.outline import region_overlap
from trundle.experiments.blind.score import has_wrong_name, is_right, named_probabilities, relative_gain
from trundle.experiments.statistics import calibration, share

Row = dict[str, Any]


def named(
    *effects: str, p: float = 0.99, verdict: str = "explained", tied: list[list[str]] | None = None
) -> Row:
    missing: list[Row] = [{"effect": e, "probability": p, "parameters": {}, "where": None} for e in effects]
    return {"verdict": verdict, "missing": missing, "tied": tied or [], "held_out": None}


def hidden(*names: str, outside: bool = False, **more: Any) -> Row:
    truth: list[Row] = [{"effect": n, "parameters": {"delay": 0.05}, "where": None} for n in names]
    oracle = {"before": 0.03, "after": 0.003}
    return {
        "names": list(names),
        "outside": outside,
        "truth": truth,
        "oracle": oracle,
        "gyration": 0.5,
        "attempts": [{"reason": None}],
        "max_tie": None,
        **more,
    }


def row(answer: Row, truth: Row, case: str = "case_0000") -> Row:
    return {"case": case, "answer": answer, "truth": truth, "cost": {"seconds": 1.0}}


TIE = [["com_offset", "tracker_offset"]]


@pytest.mark.parametrize(
    ("answer", "truth", "right"),
    [
        (named("latency"), hidden("latency"), True),
        (named("force_bias"), hidden("latency"), False),
        (named("latency", "force_bias"), hidden("latency"), False),
        (named(verdict="unexplained"), hidden("latency"), False),
        (named(verdict="consistent"), hidden("latency"), False),
        (named("latency", verdict="unexplained"), hidden("latency"), False),
        (named("com_offset", tied=TIE), hidden("tracker_offset"), True),
        (named("com_offset"), hidden("tracker_offset"), False),
        (named("com_offset", tied=TIE), hidden("latency"), False),
        (named("force_bias", "latency"), hidden("latency", "force_bias"), True),
        (named("latency", "latency"), hidden("latency", "force_bias"), False),
        (named("latency"), hidden("latency", "force_bias"), False),
        (named("latency", "tether", "force_bias"), hidden("latency", "force_bias"), False),
        (named("com_offset", "latency", tied=TIE), hidden("latency", "tracker_offset"), True),
        (named(verdict="consistent"), hidden(), True),
        (named(verdict="unexplained"), hidden(), False),
        (named("latency"), hidden(), False),
        (named(verdict="unexplained"), hidden("magnet", outside=True), True),
        (named("tether"), hidden("magnet", outside=True), False),
        (named(verdict="consistent"), hidden("magnet", outside=True), False),
    ],
)
def test_right_answers(answer: Row, truth: Row, right: bool) -> None:
    assert is_right(answer, truth) == right


def test_false_alarms_and_confident_wrong_names() -> None:
    answers = [named("latency"), named(verdict="unexplained"), named(verdict="consistent")]
    assert tables.figure(tables.FALSE_ALARMS, [row(answer, hidden()) for answer in answers]).hits == 2
    magnet = hidden("magnet", outside=True)
    assert has_wrong_name(named("tether", p=0.95), magnet)
    assert not has_wrong_name(named("tether", p=0.85), magnet)
    assert not has_wrong_name(named(verdict="unexplained"), magnet)
    assert has_wrong_name(named("latency", "tether"), hidden("latency"))
    assert not has_wrong_name(named("latency"), hidden("latency"))


def test_calibration_compares_probabilities_with_the_truth() -> None:
    assert named_probabilities(named("latency", "tether", p=0.7), hidden("latency")) == [
        (0.7, True),
        (0.7, False),
    ]
    found = calibration([(0.95, True)] * 9 + [(0.96, False)] + [(0.6, True), (0.6, False), (1.0, True)])
    assert [(p, right.hits, right.total) for p, right in found] == [
        (pytest.approx(0.6), 1, 2),
        (pytest.approx(0.951), 9, 10),
        (1.0, 1, 1),
    ]


def test_columns_of_the_confusion_matrix() -> None:
    assert (
        figures.confusion_label(named("com_offset", tied=TIE), hidden("tracker_offset")) == "tracker_offset"
    )
    assert figures.confusion_label(named("tether"), hidden("latency")) == "tether"
    assert figures.confusion_label(named("tether", "latency"), hidden("latency")) == "several"
    assert figures.confusion_label(named(verdict="consistent"), hidden("latency")) == "consistent"


def test_the_gain_is_logarithmic_and_relative_to_the_oracle() -> None:
    answer = named("latency")
    figures = {"window_position_rmse": 0.03, "window_heading_rmse": 0.08}
    answer["held_out"] = {
        "before": figures,
        "after": {name: value / math.sqrt(10) for name, value in figures.items()},
    }
    assert relative_gain(answer, hidden("latency")) == pytest.approx(0.5)
    assert relative_gain(answer, hidden()) is None
    assert relative_gain(answer, hidden("magnet", outside=True)) is None
    assert relative_gain(named("latency"), hidden("latency")) is None


def placed(effect: str, true: Row, given: Row | None, parameters: Row | None = None, **more: Any) -> Row:
    truth = hidden(effect, **more)
    truth["truth"] = [{"effect": effect, "where": true, "parameters": {"delay": 0.05, "force": 10.0}}]
    answer = named(effect)
    answer["missing"][0] |= {"where": given, "parameters": parameters or {}}
    return row(answer, truth)


def test_errors_of_places_and_times() -> None:
    point = {"body_point": [0.1, 0.2]}
    event = {"event": {"episode": "episode_02", "time": 2.0}}
    at = {"event": {"episode": "episode_02", "time": {"mean": 2.1}}}
    elsewhere = {"event": {"episode": "episode_03", "time": {"mean": 2.0}}}
    found = place_errors(
        [
            placed("coulomb_friction", point, {"body_point": {"mean": [0.1, 0.23]}}),
            placed("coulomb_friction", point, None),
            placed("wheel_event", event, at),
            placed("wheel_event", event, elsewhere),
            placed(
                "obstacle_contact",
                {"world_point": [0, 0], "radius": 0.1},
                {"world_point": {"mean": [0.12, 0]}},
            ),
            placed("latency", {}, None, {"delay": {"mean": 0.04, "sd": 0.001}}),
            row(named("tether"), hidden("latency")),
        ]
    )
    assert [e for _, e in found["body point, m"]] == pytest.approx([0.03, math.inf])
    assert [e for _, e in found["event time, s"]] == pytest.approx([0.1, math.inf])
    assert [e for _, e in found["world point, m"]] == pytest.approx([0.02])
    assert [e for _, e in found["delay, s"]] == pytest.approx([0.01])


def test_regions_are_compared_where_the_object_was() -> None:
    cells = [[x, y] for x in range(20) for y in range(10)]
    square = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]
    half = [[0.0, 0.0], [0.25, 0.0], [0.25, 0.5], [0.0, 0.5]]
    assert region_overlap(square, square, cells) == 1.0
    assert region_overlap(half, square, cells) == pytest.approx(0.5)
    beyond = [[0.0, 0.0], [0.5, 0.0], [0.5, 5.0], [0.0, 5.0]]
    assert region_overlap(beyond, square, cells) == 1.0
    assert region_overlap([[2, 2], [3, 2], [3, 3]], square, cells) == 0.0


def test_errors_of_values() -> None:
    found = parameter_errors([placed("latency", {}, None, {"delay": {"mean": 0.04, "sd": 0.005}})])
    assert found["latency.delay"][0] == pytest.approx((0.2, 2.0))


def test_shares_have_wilson_s_interval() -> None:
    one = share([True] * 24 + [False])
    assert one.value == 0.96
    assert one.interval == pytest.approx((0.8046, 0.9929), abs=2e-4)
    assert share([False] * 300).interval == pytest.approx((0.0, 0.01264), abs=1e-5)
    assert share([]).text() == "no case"


def test_missed_targets_are_reported() -> None:
    rows = [row(named("latency"), hidden("latency"))] * 10 + [row(named("tether"), hidden("latency"))]
    rows += [row(named(verdict="consistent"), hidden())] * 300
    text = tables.accuracy("furniture", rows)
    lines = {line.split("|")[1].strip(): line for line in text.splitlines()}
    assert "**missed**" in lines["one effect"]
    assert "10 of 11" in lines["one effect"]
    assert lines["false alarms"].rstrip(" |").endswith("met")
    assert "no case" in lines["two effects"]


def test_figures_are_drawn_for_any_rows(tmp_path: Any) -> None:
    rows = [
        row(named("latency", p=0.8), hidden("latency")),
        row(named("tether"), hidden("magnet", outside=True)),
        row(named(verdict="consistent"), hidden()),
    ]
    for paint in (figures.confusion, figures.reliability_diagram, figures.gains):
        paint(tmp_path / "figure.png", rows)
        assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
