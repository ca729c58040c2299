"""Plots of diagnoses and posteriors."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

import trundle
from tests.plots.figures import caption, diagnosis_of, labels, legend_texts, lines, title, titled, widths
from tests.report.samples import SAMPLES
from trundle.plots.evidence import changed_values, probabilities
from trundle.report import wording
from trundle.report.verdict import headline


def test_the_missing_effect_is_marked_where_it_acts() -> None:
    answer, series = SAMPLES["table"]()
    figure = diagnosis_of((answer, series)).plot()
    axes = titled(figure, "object from above")
    (mark,) = [line for line in axes.lines if line.get_label() == "1: dry friction"]
    where = answer["missing"][0]["where"]["body_point"]["mean"]
    np.testing.assert_array_equal(np.ravel(mark.get_xydata()), where)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m), object frame", "y (m)")
    assert str(figure.get_suptitle()).startswith("office table, run 3: Dry friction is missing")
    assert "falls from 12.3 cm to 8.0 mm" in caption(figure)


def test_held_out_episodes_are_drawn_before_and_after() -> None:
    answer, series = SAMPLES["table"]()
    figure = trundle.plots.diagnosis(diagnosis_of((answer, series)))
    shown = [title(axes) for axes in figure.axes if title(axes).startswith("episode")]
    assert shown == ["episode_04 (held out)", "episode_05 (held out)", "episode_00 (training)"]
    drawn = dict(lines(titled(figure, "episode_04")))
    given = series["episodes"][4]
    for side in ("before", "after"):
        np.testing.assert_array_equal(drawn[side], np.array(given[side])[:, :2])
    assert legend_texts(figure) >= {"recorded", "before", "after"}


def test_bars_show_the_probabilities() -> None:
    answer, series = SAMPLES["table"]()
    axes = titled(trundle.plots.diagnosis(diagnosis_of((answer, series))), "probability of each explanation")
    assert widths(axes) == pytest.approx([98.0, 2.0])
    assert [label.get_text() for label in axes.get_yticklabels()] == ["dry friction", "a second wheel"]
    assert axes.get_xlabel() == "probability (%)"


def test_without_an_effect_the_bars_are_those_of_the_candidates() -> None:
    answer, series = SAMPLES["consistent"]()
    found = probabilities(answer, series["candidates"])
    assert [(name, share) for name, share, _ in found][:2] == [
        ("no missing effect", 0.97),
        ("a sloping floor", 0.018),
    ]


def test_an_unexplained_misfit_has_no_probabilities() -> None:
    figure = diagnosis_of(SAMPLES["unexplained"]()).plot()
    axes = titled(figure, "misfit by axis")
    assert widths(axes) == pytest.approx([10.0, 20.0, 70.0])
    assert "where the residual acts" in legend_texts(figure)
    assert not any("probability" in text for text in labels(figure))


def test_changed_values_are_relative_to_the_given_ones() -> None:
    answer = {
        "nominal": {
            "given": {"mass": 20.0, "mu": 0.0, "x": 1.0},
            "after": {
                "mass": {"mean": 25.0, "sd": 0.5, "identifiable": True},
                "x": {"mean": 2.0, "sd": 9.0, "identifiable": False},
            },
        }
    }
    ((name, change, half),) = changed_values(answer)
    assert (name, change) == ("mass", 0.25)
    assert half == pytest.approx(0.049)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_every_sample_has_a_figure_with_its_headline(name: str) -> None:
    answer, series = SAMPLES[name]()
    figure = trundle.plots.diagnosis(diagnosis_of((answer, series)))
    title = " ".join(str(figure.get_suptitle()).split())
    expected = f"{answer['recording']}: {wording.typeset(headline(answer))}"
    assert title == " ".join(expected.split())
    assert len(figure.axes) >= 2
    assert all(axes.get_xlabel() or axes.get_ylabel() for axes in figure.axes)


def test_required_wrenches_are_drawn_over_recorded_ones() -> None:
    answer, series = SAMPLES["quasi_static"]()
    axes = titled(
        trundle.plots.diagnosis(diagnosis_of((answer, series))), "force along x, 20 held-out pushes"
    )
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("recorded (N)", "required (N)")
    held_out = [each["wrench"] for each in series["episodes"] if each["held_out"]]
    drawn = dict(lines(axes))
    for side in ("before", "after"):
        np.testing.assert_array_equal(
            drawn[side][:, 1], np.concatenate([each[side] for each in held_out])[:, 0]
        )


def test_residual_wrenches_are_drawn_before_and_after() -> None:
    answer, series = SAMPLES["table"]()
    figure = trundle.plots.residual(diagnosis_of((answer, series)), episodes="episode_05")
    assert [title(axes) for axes in figure.axes] == ["force along x (N)", "force along y (N)", "torque (N·m)"]
    drawn = dict(lines(figure.axes[2]))
    for side in ("before", "after"):
        np.testing.assert_array_equal(
            drawn[side][:, 1], np.array(series["episodes"][5]["residual"][side])[:, 2]
        )
    with pytest.raises(trundle.TrundleError, match="no episode `push`"):
        trundle.plots.residual(diagnosis_of((answer, series)), episodes="push")


def test_a_diagnosis_without_residual_wrenches_is_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="has no residual wrenches"):
        trundle.plots.residual(diagnosis_of(SAMPLES["quasi_static"]()))


@pytest.fixture
def posterior() -> trundle.Posterior:
    draw = np.random.default_rng(0)
    entries = [
        ("body.mass", "kg", True),
        ("viscous_wheel.x", "m", True),
        ("viscous_wheel.mu_y", "N·s/m", False),
    ]
    summary = {
        "recording": "table",
        "method": "nuts",
        "verdict": "converged",
        "parameters": [{"name": n, "unit": u, "identifiable": i} for n, u, i in entries],
    }
    draws = {name: draw.normal(size=(2, 100)) for name, *_ in entries}
    return trundle.Posterior(summary, draws, {}, 0, cast(Any, None))


def test_a_posterior_shows_identifiable_parameters_with_units(posterior: trundle.Posterior) -> None:
    figure = posterior.plot()
    assert len(figure.axes) == 4
    assert {axes.get_xlabel() for axes in figure.axes[2:]} == {"body\nmass (kg)", "viscous_wheel\nx (m)"}
    drawn = next(points for _, points in lines(figure.axes[2]))
    names = ("body.mass", "viscous_wheel.x")
    np.testing.assert_array_equal(drawn, np.column_stack([posterior.draws[name].ravel() for name in names]))
    assert "1 other parameter is not shown" in caption(figure)


def test_parameters_are_chosen_by_name(posterior: trundle.Posterior) -> None:
    assert len(trundle.plots.posterior(posterior, ["viscous_wheel.mu_y"]).axes) == 1
    with pytest.raises(trundle.TrundleError, match=r"no parameter `mass`; the parameters are body\.mass"):
        trundle.plots.posterior(posterior, ["mass"])
