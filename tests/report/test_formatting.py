"""Decimation, rounding and ticks, case by case and by property."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trundle.report.decimate import envelope, simplify
from trundle.report.figures.canvas import ticks
from trundle.report.quantity import format_estimate, format_quantity, format_significant
from trundle.report.svg import Markup, tag
from trundle.report.wording import explained_by_effect


def test_envelope_keeps_a_single_spike_and_the_order_of_time() -> None:
    t = np.linspace(0.0, 25.0, 25_000)
    y = np.sin(t)
    y[12_345] = 40.0
    y[20_000:20_400] = np.nan
    short, kept = envelope(t, y, 300)
    assert len(short) <= 600
    assert np.nanmax(kept) == 40.0
    assert (np.diff(short) > 0.0).all()
    assert np.isnan(kept).any(), "the gap is gone"


def test_envelope_leaves_a_short_curve_alone() -> None:
    t = np.arange(50.0)
    assert envelope(t, t, 300)[1] is t


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 1.0))
def test_simplify_stays_within_its_tolerance(seed: int, tolerance: float) -> None:
    walk = np.cumsum(np.random.default_rng(seed).normal(size=(80, 2)), axis=0)
    thin = simplify(walk, tolerance)
    assert (thin[[0, -1]] == walk[[0, -1]]).all()
    for point in walk:
        assert min(distance(point, *ends) for ends in pairwise(thin)) <= tolerance + 1e-9


def distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    share = np.clip((point - start) @ (end - start) / ((end - start) @ (end - start)), 0.0, 1.0)
    return float(np.linalg.norm(point - start - share * (end - start)))


def test_simplify_makes_two_points_of_a_straight_line() -> None:
    assert len(simplify(np.column_stack([np.arange(100.0), np.arange(100.0)]), 0.1)) == 2


@pytest.mark.parametrize(
    ("mean", "sd", "text"),
    [
        (14.23, 0.31, "14.2 ± 0.3 N"),
        (21.934, 0.12, "21.93 ± 0.12 N"),
        (-0.0004, 0.03, "0.00 ± 0.03 N"),
        (1234567.0, 4000.0, "1\N{NARROW NO-BREAK SPACE}235\N{NARROW NO-BREAK SPACE}000 ± 4000 N"),
        (2.5, None, "2.5 N"),
        (None, 1.0, "\N{EN DASH}"),
        (float("nan"), 1.0, "\N{EN DASH}"),
        (3.0, 0.0, "3 N"),
        (0.0, float("nan"), "0 N"),
    ],
)
def test_measured_rounds_to_what_is_known(mean: float | None, sd: float | None, text: str) -> None:
    assert format_estimate(mean, sd, "N") == text


@pytest.mark.parametrize(
    ("unit", "value", "text"),
    [
        ("m", 0.0041, "4.1\xa0mm"),
        ("m", 0.123, "12.3\xa0cm"),
        ("m", -2.5, "\N{MINUS SIGN}2.5\xa0m"),
        ("rad", 0.0349, "2.0°"),
        ("N", None, "\N{EN DASH}"),
        ("", 0.86, "0.86"),
    ],
)
def test_units_suit_the_size(unit: str, value: float | None, text: str) -> None:
    assert format_quantity(unit, value) == text


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(1, 5))
def test_significant_writes_any_number_without_a_machine_exponent(value: float, digits: int) -> None:
    text = format_significant(value, digits)
    assert "e" not in text and "-" not in text


@given(st.floats(-1e6, 1e6), st.floats(1e-4, 1e6), st.integers(2, 6))
def test_ticks_lie_within_and_are_few(low: float, span: float, most: int) -> None:
    values, places = ticks(low, low + span, most)
    assert len(values) <= most
    assert all(low - 1e-6 * span <= value <= low + span * (1.0 + 1e-6) for value in values)
    assert len({f"{value:.{places}f}" for value in values}) == len(values)


def test_symmetric_axes_have_more_than_a_zero() -> None:
    for reach in np.geomspace(1e-3, 1e3, 200):
        assert len(ticks(-reach, reach, 3)[0]) == 3


def test_markup_escapes_text_but_not_markup() -> None:
    drawn = tag("text", "<b>", Markup("<tspan></tspan>"), None, class_='"', x=1.0)
    assert drawn == '<text class="&#34;" x="1">&lt;b&gt;<tspan></tspan></text>'


def test_an_effect_that_increases_the_held_out_misfit_is_not_said_to_explain_it() -> None:
    share, text = explained_by_effect(0.87) or ("", "")
    assert share.startswith("87") and text.startswith("of the misfit")
    share, text = explained_by_effect(-0.4) or ("", "")
    assert share.startswith("40") and text.startswith("larger misfit")
    assert explained_by_effect(None) is None
