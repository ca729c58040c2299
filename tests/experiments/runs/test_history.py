"""Histories: wheels sorted by drag, identifiability, and descriptions."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.experiments.runs.samples import episode, history
from trundle.experiments.runs import sentences
from trundle.experiments.runs.config import Settings
from trundle.experiments.runs.history import Episode, Wheel, parse_history, select_stages
from trundle.experiments.runs.page import render


def header(episode: Episode) -> str:
    """Return the text at the top of the page."""
    page = render(Settings("trundle/PushAround-v0"), "run.toml", [episode])
    top = page[page.index("<h1") : page.index("<nav")].replace("\N{NO-BREAK SPACE}", " ")
    return re.sub(r"<[^>]*>", "", top)


def test_a_rotated_wheel_with_exchanged_drags_is_the_same() -> None:
    one = Wheel.of({"x": 1.0, "y": 2.0, "angle": 0.3, "mu_x": 10.0, "mu_y": 90.0})
    other = Wheel.of({"x": 1.0, "y": 2.0, "angle": 0.3 - math.pi / 2, "mu_x": 90.0, "mu_y": 10.0})
    assert (one.least, one.most) == (other.least, other.most) == (10.0, 90.0)
    assert math.remainder(one.angle - other.angle, math.pi) == pytest.approx(0.0, abs=1e-12)


def test_drags_are_sorted_with_their_deviations() -> None:
    kept = history()
    law = kept["updates"][-1]["model"]["effect"][0]
    law["mu_x"], law["mu_y"] = law["mu_y"], law["mu_x"]
    means = {"viscous_wheel.mu_x": (law["mu_x"], 3.0), "viscous_wheel.mu_y": (law["mu_y"], 1.0)}
    for entry in kept["updates"][-1]["estimate"]:
        if entry["name"] in means:
            entry["mean"], entry["sd"] = means[entry["name"]]
    last = parse_history(kept).updates[-1]
    least, most = last.estimates["least"], last.estimates["most"]
    assert (least["mean"], least["sd"]) == (law["mu_y"], 1.0)
    assert (most["mean"], most["sd"]) == (law["mu_x"], 3.0)


def test_unidentifiable_parameters_are_infinitely_uncertain() -> None:
    first, second = episode().updates[:2]
    assert first.wheel_covariance is not None and second.wheel_covariance is not None
    assert math.isfinite(first.wheel_covariance[0, 0]) and math.isinf(first.wheel_covariance[1, 1])
    assert np.isfinite(second.wheel_covariance).all()
    assert "?" in sentences.belief_line(first) and "?" not in sentences.belief_line(second)


def test_the_true_wheel_is_the_one_with_most_drag() -> None:
    kept = history()
    rolling = {"kind": "viscous_wheel", "x": -0.5, "y": 0.3, "angle": 0.0, "mu_x": 5.0, "mu_y": 5.0}
    kept["truth"]["effect"].insert(0, rolling)
    found = parse_history(kept)
    assert found.wheel is not None and found.wheel.at[0] == 0.5
    assert found.hidden == ()


def test_the_summary_states_the_outcome_and_when_the_wheel_was_known() -> None:
    found = episode(friction=True)
    text = header(found)
    assert "Reached the goal after 3.5 s." in text
    assert "From fit 3 of 6 on, 1.5 s after the start" in text
    assert "Dry friction was named after 1.5 s" in text
    assert "Other hidden effects: dry friction at (−0.40, 0.25) m." in text
    assert "not touched" in text


def test_unnamed_effects_are_marked_as_supposed() -> None:
    kept = history(pushes=10)
    kept["updates"][7]["supposed"] = ["com_offset", "caster_swivel"]
    found = parse_history(kept)
    text = header(found)
    assert "was supposed after 4.0 s: the diagnosis does not confirm it" in text
    assert "was named" not in text
    assert "supposed: " in sentences.belief_line(found.updates[7])
    assert [update.time for update in select_stages(found, 4)] == [0.5, 1.5, 4.0, 5.0]


def test_a_distant_estimate_does_not_count_as_found() -> None:
    kept = history()
    kept["truth"]["effect"][0] = {**kept["truth"]["effect"][0], "x": -0.5}
    text = header(parse_history(kept))
    assert "The wheel was estimated at" in text and "still" in text and "was found" not in text


def test_a_wheel_that_is_not_identifiable_has_no_position() -> None:
    found = episode()
    last = replace(found.updates[-1], wheel_covariance=np.diag([np.inf, np.inf]))
    lost = replace(found, updates=(*found.updates[:-1], last))
    text = header(lost)
    assert "The pushes did not show where the wheel is; its true position is (" in text
    assert "?" not in text and "still off" not in text
    assert "wheel not located" in sentences.belief_line(last)
    half = replace(last, wheel_covariance=np.diag([np.inf, 1e-4]))
    assert "wheel at (?, " in sentences.belief_line(half)


def test_a_regression_has_no_wheel() -> None:
    found = episode(lawless=True)
    assert "regression model" in header(found)
    assert sentences.belief_line(found.updates[0]) == "regression model"


def test_missing_belief_and_failure_are_reported() -> None:
    found = episode(pushes=0, success=False)
    assert sentences.headline(found).startswith("Time limit reached")
    assert "did not update its initial model" in header(found)
    assert select_stages(found, 6) == []


def test_the_first_stage_and_the_last_are_shown_and_some_between() -> None:
    found = episode(pushes=10)
    assert [update.time for update in select_stages(found, 3)] == [0.5, 1.5, 5.0]
    assert [update.time for update in select_stages(found, 20)] == [0.5 * number for number in range(1, 11)]


def test_the_stage_at_which_a_law_was_added_is_shown() -> None:
    kept = history(pushes=10)
    kept["updates"][7]["named"] = ["coulomb_friction"]
    assert [update.time for update in select_stages(parse_history(kept), 4)] == [0.5, 1.5, 4.0, 5.0]
