"""Common style of figures: colours by learner, light axes, one font size."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle._optional import require
from trundle.atomic import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "GREY",
    "MARKERS",
    "NAMES",
    "OBSERVED",
    "PREDICTED",
    "legend",
    "plain",
    "save",
    "share_limits",
    "sheet",
]

COLOURS = {
    "pbr": "#0059a8",
    "lr": "#c04a00",
    "lwr": "#b0186f",
    "lr_body": "#e0a070",
    "lwr_body": "#d58ab4",
}
"""By learner; also where two models are compared. Lighter colours are the stronger baselines."""
MARKERS = {"pbr": "o", "lr": "s", "lwr": "^", "lr_body": "s", "lwr_body": "^"}
NAMES = {
    "pbr": "PBR",
    "lr": "LR",
    "lwr": "LWR",
    "lr_body": "LR, object axes",
    "lwr_body": "LWR, object axes",
}
OBSERVED = "#2e8b57"
"""Observed motion: green, as in the paper's Fig. 5."""
PREDICTED = COLOURS["pbr"]
GREY = "#5a6470"
DPI = 130


def sheet(rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Return a figure of `size` inches and its axes, row by row."""
    matplotlib = require("matplotlib.figure", "experiments", "figures of experiments")
    figure: Figure = matplotlib.Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    axes: Sequence[Axes] = list(grid.flat)
    for one in axes:
        plain(one)
    return figure, list(axes)


def plain(axes: Axes) -> None:
    """Apply the common style to axes."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(GREY)
    axes.tick_params(colors=GREY, labelsize=8)
    axes.grid(color="#e3e6ea", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.title.set_fontsize(9)
    axes.xaxis.label.set_fontsize(9)
    axes.yaxis.label.set_fontsize(9)


def save(figure: Figure, path: Path) -> None:
    """Save a figure as PNG or SVG; the same figure gives the same bytes."""
    matplotlib = require("matplotlib", "experiments", "figures of experiments")
    kind = path.suffix[1:]
    with atomic_file(path) as part, matplotlib.rc_context({"svg.hashsalt": "trundle"}):
        varying = {"svg": "Date"}.get(kind, "Software")
        figure.savefig(part, format=kind, dpi=DPI, metadata={varying: None})


def share_limits(axes: Sequence[Axes]) -> None:
    """Give axes the same limits, with equal scales of x and y."""
    x = [limit for one in axes for limit in one.get_xlim()]
    y = [limit for one in axes for limit in one.get_ylim()]
    for one in axes:
        one.set(xlim=(min(x), max(x)), ylim=(min(y), max(y)), aspect="equal")


def legend(of: Axes | Figure, fontsize: int = 8, **more: Any) -> None:
    """Add a legend in the common style to axes or to a figure."""
    of.legend(fontsize=fontsize, frameon=False, **more)
