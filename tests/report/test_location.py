"""Locations as diagnosis.json gives them, complete or invalid, and the names of effects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.report.effects import EFFECTS, effect_entry
from trundle.report import wording
from trundle.report.location import locate_effects, polygon

SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]]


def entry(where: Any, effect: str = "tether", **parameters: Any) -> dict[str, Any]:
    return {"effect": effect, "where": where, "parameters": parameters}


def test_every_key_is_understood() -> None:
    (place,) = locate_effects(
        [
            entry(
                {
                    "body_point": {"mean": [0.1, 0.2], "sd": [0.01, 0.02]},
                    "world_point": {"mean": [1.0, 2.0], "sd": None},
                    "world_region": SQUARE,
                    "event": {"episode": "episode_02", "time": {"mean": 2.31, "sd": 0.02}},
                }
            )
        ]
    )
    assert place.body is not None and place.body.sd.tolist() == [0.01, 0.02]
    assert place.world is not None and place.world.sd.tolist() == [0.0, 0.0]
    assert place.event is not None and (place.event.time, place.event.sd) == (2.31, 0.02)
    assert place.on_floor and place.unknown == ()
    gap = "\xa0"
    assert place.sentences() == [
        f"On the object at (0.100 ± 0.010, 0.20 ± 0.02){gap}m.",
        f"In the world at (1, 2){gap}m.",
        f"On the floor in a region of 1.00 by 2.00{gap}m about (0.50, 1.00){gap}m.",
        f"In episode_02 at 2.31 ± 0.02{gap}s.",
    ]


@pytest.mark.parametrize(
    "where",
    [
        None,
        {},
        "nowhere",
        {"body_point": [0.1, 0.2]},
        {"body_point": {"mean": [0.1], "sd": None}},
        {"world_region": [[0.0, 0.0], [1.0, 0.0]]},
        {"world_region": [[0.0, 0.0], [1.0, None], [1.0, 1.0]]},
        {"world_region": "all of it"},
        {"event": {"episode": "episode_00"}},
        {"event": {"episode": "episode_00", "time": {"mean": float("nan")}}},
    ],
)
def test_an_invalid_location_is_ignored(where: Any) -> None:
    (place,) = locate_effects([entry(where)])
    assert place.body is None and not place.on_floor


def test_a_point_that_the_data_do_not_determine_is_reported() -> None:
    (place,) = locate_effects([entry({"body_point": None, "world_point": {"mean": None}})])
    assert place.sentences() == [
        "On the object at a point that the data do not determine.",
        "In the world at a point that the data do not determine.",
    ]


def test_floors_have_directions() -> None:
    slope = entry(None, "floor_slope", accel_x={"mean": -0.3}, accel_y={"mean": 0.4})
    grain = entry(None, "floor_grain", angle={"mean": np.pi / 2})
    level = entry(None, "floor_slope", accel_x={"mean": 0.0}, accel_y={"mean": 0.0})
    downhill, along, flat = (place.direction for place in locate_effects([slope, grain, level]))
    assert downhill is not None and downhill.along.tolist() == pytest.approx([-0.6, 0.8])
    assert not downhill.both
    assert along is not None and along.along.tolist() == pytest.approx([0.0, 1.0]) and along.both
    assert flat is None


def test_each_effect_has_a_name_other_than_its_key() -> None:
    assert len(EFFECTS) == 18
    for name in EFFECTS:
        assert "_" not in wording.effect_name(name) and wording.effect_name(name) != name.replace("_", " ")
    assert wording.effect_name("an_effect_of_tomorrow") == "an effect of tomorrow"
    assert wording.effect_name("latency + tether") == "a delay of the force sensor and a tether"


def test_places_are_numbered_as_the_cards_are() -> None:
    assert [place.number for place in locate_effects([effect_entry(name) for name in EFFECTS])] == list(
        range(1, 19)
    )


def test_regions_need_three_corners() -> None:
    assert polygon(SQUARE[:2]) is None
    corners = polygon(SQUARE)
    assert corners is not None and corners.shape == (4, 2)


@pytest.mark.parametrize(
    ("share", "text"), [(1.0, "> 99 %"), (0.98, "98 %"), (0.004, "< 1 %"), (0.0, "< 1 %"), (0.5, "50 %")]
)
def test_nothing_is_certain(share: float, text: str) -> None:
    assert wording.format_percent(share) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("at (-0.5, 0.3) m", "at (−0.5, 0.3) m"),
        ("1-3 times, x-axis, 2e-3", "1-3 times, x-axis, 2e-3"),
        ("14.2 ± 0.3 N acts", "14.2 ± 0.3\xa0N acts"),
        ("5 mornings", "5 mornings"),
    ],
)
def test_sentences_are_typeset(text: str, shown: str) -> None:
    assert wording.typeset(text) == shown
