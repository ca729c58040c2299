"""Figures of a blind benchmark's document."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from trundle.experiments import figure_style
from trundle.experiments.blind.score import (
    hidden_label,
    is_right,
    named_probabilities,
    names_of,
    relative_gain,
)
from trundle.experiments.results import Row
from trundle.experiments.sampling import Floats
from trundle.experiments.statistics import Share, calibration, share

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["confusion", "detection_limits", "gains", "reliability_diagram"]

BLUE = figure_style.COLOURS["pbr"]


def confusion(path: Path, rows: Sequence[Row]) -> None:
    """Draw hidden effects against answers: single effects, out-of-catalogue families and clean recordings."""
    cells: dict[tuple[str, str], int] = {}
    for row in rows:
        if len(row["truth"]["names"]) <= 1:
            key = (hidden_label(row["truth"]), confusion_label(row["answer"], row["truth"]))
            cells[key] = cells.get(key, 0) + 1
    labels_in_order = dict.fromkeys(label for _, label in sorted(sort_key(row["truth"]) for row in rows))
    order = {name: k for k, name in enumerate(labels_in_order)}
    down = [name for name in order if any(key[0] == name for key in cells)]
    across = sorted({key[1] for key in cells}, key=lambda name: (order.get(name, 500), name))
    counts = np.array([[cells.get((a, b), 0) for b in across] for a in down], dtype=float)
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    figure, (axes,) = figure_style.sheet(1, 1, (2.6 + 0.42 * len(across), 1.8 + 0.24 * len(down)))
    labels = [[f"{count:.0f}" if count else "" for count in line] for line in counts]
    draw_heat_map(axes, shares, labels, down)
    axes.set_xticks(range(len(across)), across, rotation=60, ha="right")
    axes.set(xlabel="answer", ylabel="hidden")
    figure_style.save(figure, path)


def confusion_label(answer: Row, truth: Row) -> str:
    """Return the column of an answer; a tie with the true name counts as that name."""
    names = names_of(answer)
    if answer["verdict"] != "explained" or len(names) > 1:
        return "several" if len(names) > 1 else str(answer["verdict"])
    near = {*names, *chain(*(tie for tie in answer["tied"] if names[0] in tie))}
    return next((true for true in truth["names"] if true in near), names[0])


def sort_key(truth: Row) -> tuple[int, str]:
    """Return effects of the catalogue first, then out-of-catalogue families, then clean recordings."""
    return (2 if not truth["names"] else 1 if truth["outside"] else 0, hidden_label(truth))


def reliability_diagram(path: Path, rows: Sequence[Row]) -> None:
    """Draw the share of correct names against the reported probability."""
    found = calibration([one for row in rows for one in named_probabilities(row["answer"], row["truth"])])
    figure, (axes,) = figure_style.sheet(1, 1, (4.2, 3.6))
    axes.plot([0, 1], [0, 1], color=figure_style.GREY, linewidth=0.8)
    for p, right in found:
        low, high = right.interval
        axes.plot([p, p], [low, high], color=BLUE, linewidth=1.0)
        axes.plot(p, right.value, "o", color=BLUE, markersize=5)
        axes.annotate(str(right.total), (p, right.value), (4, -9), textcoords="offset points", fontsize=7)
    axes.set(xlabel="reported probability", ylabel="share of correct names", xlim=(0, 1.03), ylim=(0, 1.03))
    figure_style.save(figure, path)


def gains(path: Path, rows: Sequence[Row]) -> None:
    """Draw the cumulative distribution of the held-out gain relative to the oracle's."""
    found = [relative_gain(row["answer"], row["truth"]) for row in rows]
    values = np.sort([gain for gain in found if gain is not None])
    figure, (axes,) = figure_style.sheet(1, 1, (4.2, 3.2))
    if len(values):
        axes.step(np.clip(values, -0.2, 1.5), np.arange(1, len(values) + 1) / len(values), color=BLUE)
    axes.axvline(0.8, color=figure_style.GREY, linewidth=0.8)
    axes.axhline(0.1, color=figure_style.GREY, linewidth=0.8)
    axes.set(xlabel="logarithmic held-out gain relative to the oracle", ylabel="share of cases", ylim=(0, 1))
    figure_style.save(figure, path)


def detection_limits(path: Path, rows: Sequence[Row]) -> None:
    """Draw the share of answers that name each effect, by relative size of the effect."""
    names = sorted({row["truth"]["names"][0] for row in rows})
    sizes = sorted({row["truth"]["size"] for row in rows}, reverse=True)
    cells = [[naming_rate(rows, name, size) for size in sizes] for name in names]
    figure, (axes,) = figure_style.sheet(1, 1, (2.2 + 0.6 * len(sizes), 1.2 + 0.24 * len(names)))
    shares = np.array([[cell.value for cell in line] for line in cells])
    labels = [[f"{cell.hits}/{cell.total}" if cell.total else "–" for cell in line] for line in cells]
    draw_heat_map(axes, shares, labels, names)
    axes.set_xticks(range(len(sizes)), [f"{size:g}" for size in sizes])
    axes.set(xlabel="size relative to the drawn one")
    figure_style.save(figure, path)


def draw_heat_map(axes: Axes, shares: Floats, labels: Sequence[Sequence[str]], rows: Sequence[str]) -> None:
    """Draw shares as shades of blue with a label in each cell, and name the rows."""
    axes.grid(visible=False)
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.2, aspect="auto")
    axes.set_yticks(range(len(rows)), rows)
    for (i, j), value in np.ndenumerate(shares):
        color = "white" if value > 0.6 else "black"
        axes.text(j, i, labels[i][j], ha="center", va="center", fontsize=7, color=color)


def naming_rate(rows: Sequence[Row], name: str, size: float) -> Share:
    """Return the share of answers that name an effect of a given size."""
    mine = [row for row in rows if row["truth"]["names"] == [name] and row["truth"]["size"] == size]
    return share(is_right(row["answer"], row["truth"]) for row in mine)
