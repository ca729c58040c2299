"""Bars of a diagnosis: probabilities of effects, or the misfit by axis if nothing explains it."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from trundle import palette
from trundle.plots.style import plain
from trundle.report import wording
from trundle.report.series import Series, finite

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_evidence", "probabilities"]

MAX_BARS = 6
_NAMES = {"x": "along x", "y": "along y", "theta": "heading"}

Bar = tuple[str, float, str]


def draw_evidence(
    axes: Axes, answer: Mapping[str, Any], candidates: Sequence[Mapping[str, Any]], series: Series
) -> None:
    """Draw the probabilities of effects; for the verdict "unexplained", the misfit by axis."""
    unexplained = answer.get("verdict") == "unexplained"
    bars = _misfit(answer, series) if unexplained else probabilities(answer, candidates)
    title = "misfit by axis" if unexplained else "probability of each explanation"
    axes.set_title(title, loc="left", fontsize=9)
    axes.set(xlim=(0.0, 100.0), xlabel="share of the misfit (%)" if unexplained else "probability (%)")
    names = [textwrap.fill(name, 26) for name, _, _ in bars]
    axes.barh(names, [100.0 * share for _, share, _ in bars], color=[colour for *_, colour in bars], height=0.55)
    for row, (_, share, _) in enumerate(bars):
        inside = share > 0.8
        style = {"fontsize": 8.5, "color": palette.PAPER if inside else palette.INK, "va": "center"}
        at, align = (98.0 * share, "right") if inside else (100.0 * share + 1.5, "left")
        axes.text(at, row, wording.format_percent(share), ha=align, **style)
    plain(axes)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, labelcolor=palette.INK, labelsize=8.5)
    axes.set_ylim(max(len(bars), 3) - 0.5, -0.6)


def probabilities(answer: Mapping[str, Any], candidates: Sequence[Mapping[str, Any]]) -> list[Bar]:
    """Return name, probability and colour of the named effects and their alternatives.

    If no effect is named, the candidates are the models of the search: no effect, or sets of effects.
    """
    named = [_bar(entry, palette.MARK) for entry in answer.get("missing") or ()]
    if not named:
        entries = [(wording.effect_names(each.get("effects") or ()), each) for each in candidates]
        found = [
            (name or "no missing effect", share, palette.AFTER if not each.get("effects") else palette.MUTED)
            for name, each in entries
            if (share := finite(each.get("probability"))) is not None
        ]
        return _distinct(found)
    others = [_bar(entry, palette.MUTED) for entry in answer.get("alternatives") or ()]
    return _distinct([bar for bar in (*named, *others) if bar is not None])


def _bar(entry: Mapping[str, Any], colour: str) -> Bar | None:
    share = wording.probability_of(entry)
    names = str(entry.get("effect")).split(" + ")
    return None if share is None else (wording.effect_names(names), share, colour)


def _distinct(bars: Sequence[Bar]) -> list[Bar]:
    """Return the first bar of each name, at most `MAX_BARS`."""
    first: dict[str, Bar] = {}
    for bar in bars:
        first.setdefault(bar[0], bar)
    return list(first.values())[:MAX_BARS]


def _misfit(answer: Mapping[str, Any], series: Series) -> list[Bar]:
    shares = (answer.get("mismatch") or {}).get("channels") or {}
    found = [(name, finite(shares.get(name))) for name in series.dof]
    return [(_NAMES.get(name, name), share, palette.MARK) for name, share in found if share is not None]
