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

__all__ = ["changed_values", "draw_evidence", "probabilities"]

MAX_BARS = 6
_NAMES = {"x": "along x", "y": "along y", "theta": "heading"}

Bar = tuple[str, float, str]


def draw_evidence(
    axes: Axes, answer: Mapping[str, Any], candidates: Sequence[Mapping[str, Any]], series: Series
) -> None:
    """Draw probabilities of explanations.

    For the verdict "unexplained", draw the misfit by axis; for "reparameterised", the changes of the given
    values.
    """
    changes = changed_values(answer) if answer.get("verdict") == "reparameterised" else []
    if changes:
        _draw_changes(axes, changes)
    elif answer.get("verdict") == "unexplained":
        _draw_shares(axes, _misfit(answer, series), "misfit by axis", "share of the misfit (%)")
    else:
        bars = probabilities(answer, candidates)
        _draw_shares(axes, bars, "probability of each explanation", "probability (%)")
    plain(axes)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, labelcolor=palette.INK, labelsize=8.5)
    axes.set_ylim(max(len(axes.get_yticks()), 3) - 0.5, -0.6)


def _draw_shares(axes: Axes, bars: Sequence[Bar], title: str, label: str) -> None:
    """Draw horizontal bars of shares with their values."""
    axes.set_title(title, loc="left", fontsize=9)
    axes.set(xlim=(0.0, 100.0), xlabel=label)
    rows = range(len(bars))
    axes.barh(
        rows, [100.0 * share for _, share, _ in bars], color=[colour for *_, colour in bars], height=0.55
    )
    axes.set_yticks(list(rows), [textwrap.fill(name, 26) for name, _, _ in bars])
    for row, (_, share, _) in enumerate(bars):
        inside = share > 0.8
        at, align = (98.0 * share, "right") if inside else (100.0 * share + 1.5, "left")
        colour = palette.PAPER if inside else palette.INK
        axes.text(at, row, wording.format_percent(share), ha=align, va="center", fontsize=8.5, color=colour)


def _draw_changes(axes: Axes, changes: Sequence[tuple[str, float, float]]) -> None:
    """Draw the change of each given value with its 95 % interval, per cent of the given value."""
    axes.set_title("change of each given value, with 95 % interval", loc="left", fontsize=9)
    axes.set_xlabel("fitted minus given (% of the given value)")
    rows = list(range(len(changes)))
    axes.axvline(0.0, color=palette.MUTED, linewidth=0.9)
    style: dict[str, Any] = {
        "fmt": "o",
        "color": palette.AFTER,
        "markersize": 5,
        "elinewidth": 1.5,
        "capsize": 3,
    }
    sizes, half = [100.0 * size for _, size, _ in changes], [100.0 * sd for *_, sd in changes]
    axes.errorbar(sizes, rows, xerr=half, **style)
    axes.set_yticks(rows, [name for name, *_ in changes])


def changed_values(answer: Mapping[str, Any]) -> list[tuple[str, float, float]]:
    """Return name, relative change and half its 95 % interval of each given value, largest first."""
    nominal = answer.get("nominal") or {}
    fitted, found = nominal.get("after") or {}, []
    for name, value in (nominal.get("given") or {}).items():
        now, was = fitted.get(name) or {}, finite(value)
        mean, sd = finite(now.get("mean")), finite(now.get("sd"))
        if was and mean is not None and sd is not None and now.get("identifiable", True):
            found.append((str(name), mean / was - 1.0, 1.96 * sd / abs(was)))
    return sorted(found, key=lambda each: -abs(each[1]))[:MAX_BARS]


def probabilities(answer: Mapping[str, Any], candidates: Sequence[Mapping[str, Any]]) -> list[Bar]:
    """Return name, probability and colour of the named effects and their alternatives.

    If no effect is named, the candidates are the models of the search: no effect, or sets of effects.
    """
    missing = list(answer.get("missing") or ())
    if not missing:
        entries = [(wording.effect_names(each.get("effects") or ()), each) for each in candidates]
        found = [
            (name or "no missing effect", share, palette.AFTER if not each.get("effects") else palette.MUTED)
            for name, each in entries
            if (share := finite(each.get("probability"))) is not None
        ]
        return _distinct(found)[:MAX_BARS]
    numbers = [f"{index}: " if len(missing) > 1 else "" for index in range(1, len(missing) + 1)]
    named = [_bar(each, palette.MARK, number) for each, number in zip(missing, numbers, strict=True)]
    others = [_bar(entry, palette.MUTED) for entry in answer.get("alternatives") or ()]
    bars = [*named, *_distinct([bar for bar in others if bar is not None])]
    return [bar for bar in bars if bar is not None][:MAX_BARS]


def _bar(entry: Mapping[str, Any], colour: str, number: str = "") -> Bar | None:
    share = wording.probability_of(entry)
    names = str(entry.get("effect")).split(" + ")
    return None if share is None else (f"{number}{wording.effect_names(names)}", share, colour)


def _distinct(bars: Sequence[Bar]) -> list[Bar]:
    """Return the first bar of each name."""
    first: dict[str, Bar] = {}
    for bar in bars:
        first.setdefault(bar[0], bar)
    return list(first.values())


def _misfit(answer: Mapping[str, Any], series: Series) -> list[Bar]:
    shares = (answer.get("mismatch") or {}).get("channels") or {}
    found = [(name, finite(shares.get(name))) for name in series.dof]
    return [(_NAMES.get(name, name), share, palette.MARK) for name, share in found if share is not None]
