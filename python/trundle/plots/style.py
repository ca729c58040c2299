"""Common style of figures: light axes, one font size, and PNG or SVG files without dates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle import palette
from trundle._optional import require
from trundle.atomic import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

__all__ = ["DPI", "heading", "legend", "new_figure", "on_figure", "plain", "save", "sheet"]

DPI = 130
"""Resolution of saved figures, dots per inch."""


def new_figure(size: tuple[float, float]) -> Figure:
    """Return an empty figure of `size` inches, which a notebook displays.

    Raises
    ------
    TrundleError
        If matplotlib is not installed.
    """
    require("matplotlib", "plots", "plots")
    from trundle.plots.notebook_figure import NotebookFigure

    return NotebookFigure(figsize=size, layout="constrained")


def on_figure(
    given: Figure | SubFigure | None, size: tuple[float, float]
) -> tuple[Figure | SubFigure, Figure]:
    """Return the figure or subfigure to draw on, and the whole figure; both new if none is given."""
    if given is None:
        created = new_figure(size)
        return created, created
    whole: Figure = given.canvas.figure
    if whole.get_layout_engine() is None:
        whole.set_layout_engine("constrained")
    return given, whole


def sheet(rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Return a figure of `size` inches and its axes, row by row."""
    figure = new_figure(size)
    grid = figure.subplots(rows, columns, squeeze=False)
    axes: Sequence[Axes] = list(grid.flat)
    for one in axes:
        plain(one)
    return figure, list(axes)


def plain(axes: Axes) -> None:
    """Apply the common style to axes."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(palette.MUTED)
    axes.tick_params(colors=palette.MUTED, labelsize=8)
    axes.grid(color=palette.LINE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.title.set_fontsize(9)
    axes.xaxis.label.set_fontsize(9)
    axes.yaxis.label.set_fontsize(9)


def heading(on: Figure | SubFigure, title: str, *sentences: str) -> None:
    """Write a title at the top left of a figure, and sentences at its bottom, in a smaller type.

    The title leaves room for a legend at the top right.
    """
    width = on.bbox.width / on.figure.dpi
    on.suptitle(
        _wrap(title, int(5.8 * width)), x=0.01, ha="left", fontsize=11, weight="bold", color=palette.INK
    )
    caption = _wrap(" ".join(text for text in sentences if text), int(14.0 * width))
    on.supxlabel(caption, x=0.01, ha="left", fontsize=8.5, color=palette.MUTED, linespacing=1.4)


def _wrap(text: str, characters: int) -> str:
    import textwrap

    return textwrap.fill(text, max(20, characters))


def save(figure: Figure, path: Path) -> None:
    """Save a figure as PNG, SVG or PDF; the same figure gives the same bytes."""
    matplotlib = require("matplotlib", "plots", "plots")
    kind = path.suffix[1:].lower()
    with atomic_file(path) as part, matplotlib.rc_context({"svg.hashsalt": "trundle"}):
        varying = {"svg": "Date", "pdf": "CreationDate"}.get(kind, "Software")
        figure.savefig(part, format=kind, dpi=DPI, metadata={varying: None})


def legend(of: Axes | Figure | SubFigure, fontsize: float = 8, **more: Any) -> None:
    """Add a legend in the common style to axes, a figure or a subfigure."""
    of.legend(fontsize=fontsize, frameon=False, **more)
