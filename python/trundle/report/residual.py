"""Data of the section "Residual": the missing wrench with the named effects, and the one without them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables
from trundle.report.figures import residual as residuals
from trundle.report.location import locate_effects
from trundle.report.quantity import format_estimate, format_quantity, join_words
from trundle.report.series import Series, finite
from trundle.report.verdict import is_single
from trundle.report.wording import drawn_note, format_percent

__all__ = ["axis_shares_sentence", "dependence_sentences", "residual_section", "size_sentences"]

_MAX_PANELS = 9
_TITLES = {
    "explained": "Residual with the named effects",
    "reparameterised": "Residual with the refitted values",
}
"""Heading by verdict."""


def residual_section(diagnosis: Mapping[str, Any], series: Series) -> dict[str, Any] | None:
    """Return the missing wrench, and in `before` the one without the named effects; None if there is none."""
    named = diagnosis.get("verdict") in ("explained", "reparameterised")
    given = diagnosis.get("residual") or {}
    windows = given.get("windows") or ()
    if diagnosis.get("verdict") == "unexplained":
        windows = windows or (diagnosis.get("mismatch") or {}).get("windows") or ()
    panels = _panels(diagnosis, series, windows, ("after",) if named else ("before", "after"))
    before = _residual_before(diagnosis, series) if named else None
    sentences = (
        []
        if diagnosis.get("verdict") == "unexplained"
        else [*size_sentences(given, series), *dependence_sentences(given)]
    )
    if not (panels or windows or before or sentences):
        return None
    return {
        "title": _TITLES.get(str(diagnosis.get("verdict")), "Missing wrench over time"),
        "sentences": sentences,
        "panels": panels,
        "windows": tables.windows(windows),
        "before": before,
    }


def size_sentences(given: Mapping[str, Any], series: Series) -> list[str]:
    """Return a sentence on the size of the missing wrench; an empty list if it is unknown."""
    force, torque, share = (finite(given.get(key)) for key in ("force_rms", "torque_rms", "share"))
    parts = [f"a force of {format_quantity('N', force)}"] if force is not None else []
    if torque is not None and "theta" in series.dof:
        parts.append(f"a torque of {format_quantity('N·m', torque)}")
    if not parts:
        return []
    part = f", {format_percent(share)} of the initial misfit" if share is not None and share < 1.0 else ""
    return [f"Size (RMS): {join_words(parts)}{part}."]


def dependence_sentences(given: Mapping[str, Any]) -> list[str]:
    """Return one sentence for the regime in which the residual occurs, and one for each period."""
    found = [f"It occurs {given['regime']}."] if given.get("regime") else []
    return found + [
        _period_sentence(entry) for entry in given.get("periods") or () if isinstance(entry, Mapping)
    ]


def _period_sentence(entry: Mapping[str, Any]) -> str:
    of, unit = str(entry.get("of")), str(entry.get("unit") or "")
    period, amplitude = finite(entry.get("period")), format_quantity("N", entry.get("amplitude"))
    text = format_quantity(unit, period) if unit == "m" else format_estimate(period, None, unit)
    return f"It is periodic in {of}: period {text}, amplitude {amplitude}."


def _residual_before(diagnosis: Mapping[str, Any], series: Series) -> dict[str, Any] | None:
    """Return the missing wrench of the simulation without the effects; None if there is none."""
    mismatch = diagnosis.get("mismatch") or {}
    windows = mismatch.get("windows") or ()
    panels = _panels(diagnosis, series, windows, ("before",))
    if not (panels or windows):
        return None
    refitted = diagnosis.get("verdict") != "reparameterised"
    simulation = "refitted simulation without these effects" if refitted else "simulation as given"
    return {
        "title": f"Before: missing wrench of the {simulation}",
        "shares": axis_shares_sentence(mismatch, series),
        "panels": panels,
        "windows": tables.windows(windows),
    }


def axis_shares_sentence(mismatch: Mapping[str, Any], series: Series) -> str:
    """Return a sentence on the share of each axis in the misfit; empty for fewer than two axes."""
    given = mismatch.get("channels") or {}
    found = [(name, value) for name in series.dof if (value := finite(given.get(name))) is not None]
    names = {"theta": "heading"}
    if len(found) < 2:
        return ""
    return f"Misfit by axis: {join_words([f'{names.get(n, n)} {100.0 * s:.0f} %' for n, s in found])}."


def _panels(
    diagnosis: Mapping[str, Any], series: Series, windows: Sequence[Mapping[str, Any]], sides: Sequence[str]
) -> dict[str, Any] | None:
    """Return figures, legend and note of the missing wrench; None without a figure."""
    named = locate_effects(diagnosis.get("missing") or ())
    episodes = residuals.select_episodes(series, windows, sides)
    figures = [
        residuals.draw(f"{sides[0]}-{index}", episode, episode.residual, series, windows, named, sides)
        for index, episode in enumerate(episodes[:_MAX_PANELS])
        if episode.residual is not None
    ]
    if not figures:
        return None
    entries = [("band", "noise (two standard deviations)")]
    entries += [("window", "windows that exceed the noise")] if windows else []
    single = is_single(diagnosis, series.discrepancy_inputs) or len(sides) < 2
    entries += [] if single else [("before whole", "before"), ("after whole", "after")]
    return {"figures": figures, "legend": entries, "note": drawn_note(len(figures), len(episodes))}
