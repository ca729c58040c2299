"""What remains: the wrench that the simulation with the named effects misses, and what was missing before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables
from trundle.report.figures import residual as residuals
from trundle.report.gallery import gallery, of
from trundle.report.given import Series, finite
from trundle.report.legend import legend
from trundle.report.markup import Html, tag
from trundle.report.quantity import listed, measured, shown
from trundle.report.section import fold, section
from trundle.report.verdict import is_single
from trundle.report.where import places
from trundle.report.words import percent

__all__ = ["depends", "residual", "size"]

_MOST = 9
_TITLES = {
    "explained": "What remains with the named effects",
    "reparameterised": "What remains with the refitted values",
}


def residual(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return the wrench that is still missing in time, and folded away the one that was missing before."""
    named = diagnosis.get("verdict") in ("explained", "reparameterised")
    given = diagnosis.get("residual") or {}
    windows = given.get("windows") or ()
    panels = _panels(diagnosis, series, windows, ("after",) if named else ("before", "after"))
    earlier = _before(diagnosis, series) if named else None
    words = [] if diagnosis.get("verdict") == "unexplained" else [*size(given, series), *depends(given)]
    if not (panels or windows or earlier or words):
        return None
    listing = tables.windows(windows)
    return section(
        "residual",
        _TITLES.get(str(diagnosis.get("verdict")), "What the simulation lacks in time"),
        tag(
            "p", "Force and torque that the seen motion needs and the simulation lacks, in the object's axes."
        ),
        tag("ul", [tag("li", sentence) for sentence in words]) if words else None,
        panels,
        fold("The windows in numbers", listing) if listing else None,
        earlier,
    )


def size(given: Mapping[str, Any], series: Series) -> list[str]:
    """Return how large the missing wrench is, in a sentence."""
    force, torque, share = (finite(given.get(key)) for key in ("force_rms", "torque_rms", "share"))
    parts = [f"a force of {shown('N', force)}"] if force is not None else []
    if torque is not None and "theta" in series.dof:
        parts.append(f"a torque of {shown('N·m', torque)}")
    if not parts:
        return []
    of_all = f", {percent(share)} of the misfit before" if share is not None and share < 1.0 else ""
    return [f"Size: {listed(parts)} (rms){of_all}."]


def depends(given: Mapping[str, Any]) -> list[str]:
    """Return in which motions it shows and with which periods, a sentence each."""
    found = [f"It shows {given['regime']}."] if given.get("regime") else []
    return found + [_period(entry) for entry in given.get("periods") or () if isinstance(entry, Mapping)]


def _period(entry: Mapping[str, Any]) -> str:
    of, unit = str(entry.get("of")), str(entry.get("unit") or "")
    period, amplitude = finite(entry.get("period")), shown("N", entry.get("amplitude"))
    text = shown(unit, period) if unit == "m" else measured(period, None, unit)
    return f"It repeats with the {of}, every {text}, with an amplitude of {amplitude}."


def _before(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return what the refitted simulation misses without the effects, folded away."""
    mismatch = diagnosis.get("mismatch") or {}
    windows = mismatch.get("windows") or ()
    panels, listing = _panels(diagnosis, series, windows, ("before",)), tables.windows(windows)
    if not (panels or listing):
        return None
    return fold(
        "Before: what the simulation as given lacks"
        if diagnosis.get("verdict") == "reparameterised"
        else "Before: what the refitted simulation lacks without them",
        tag("p", shares(mismatch, series)),
        panels,
        listing,
    )


def shares(mismatch: Mapping[str, Any], series: Series) -> str:
    """Return how the misfit divides among the axes, in a sentence."""
    given = mismatch.get("channels") or {}
    found = [(name, value) for name in series.dof if (value := finite(given.get(name))) is not None]
    names = {"theta": "heading"}
    if len(found) < 2:
        return ""
    return f"Shares of the misfit: {listed([f'{names.get(n, n)} {100.0 * s:.0f} %' for n, s in found])}."


def _panels(
    diagnosis: Mapping[str, Any], series: Series, windows: Sequence[Mapping[str, Any]], sides: Sequence[str]
) -> Html | None:
    named = places(diagnosis.get("missing") or ())
    single = is_single(diagnosis, series.unnamed)
    episodes = residuals.chosen(series, windows, _MOST, sides)
    figures = [
        residuals.draw(f"{sides[0]}-{index}", episode, episode.residual, series, windows, named, sides)
        for index, episode in enumerate(episodes)
        if episode.residual is not None
    ]
    if not figures:
        return None
    total = len(residuals.chosen(series, windows, len(series.episodes), sides))
    entries = [("band", "what noise alone explains (two standard deviations)")]
    entries += [("window", "windows that noise cannot explain")] if windows else []
    entries += [] if single or len(sides) < 2 else [("before whole", "before"), ("after whole", "after")]
    return tag("div", tag("p", of(len(figures), total)), legend(*entries), gallery(figures))
