"""Required and recorded wrench of quasi-static pushes, before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle.plots.motion import SIDES
from trundle.plots.style import legend, plain
from trundle.plots.time_axes import reach
from trundle.report.figures.residual import CHANNELS
from trundle.report.series import Array, Series, Wrench, held_out_first

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.gridspec import SubplotSpec

__all__ = ["draw_agreement"]


def draw_agreement(on: Figure | SubFigure, cell: SubplotSpec, series: Series) -> None:
    """Draw the wrench that each model requires for the recorded motion over the recorded wrench.

    There is one panel per channel, of the held-out pushes, or of all if none is held out.
    """
    episodes = [each for each in held_out_first(series.episodes) if each.wrench is not None]
    judged = [each for each in episodes if each.held_out] or episodes
    kind = "held-out" if judged[0].held_out else "training"
    grid = cell.subgridspec(1, len(series.channels))
    for column, channel in enumerate(series.channels):
        axes = on.add_subplot(grid[column])
        wrenches = [each.wrench for each in judged if each.wrench is not None]
        _draw_channel(axes, wrenches, channel)
        name, unit = CHANNELS[channel]
        axes.set_title(f"{name}, {len(judged)} {kind} pushes", loc="left", fontsize=9)
        axes.set(xlabel=f"recorded ({unit})", ylabel=f"required ({unit})" if column in (0, 2) else "")
        if column == 0:
            handles, labels = axes.get_legend_handles_labels()
            legend(on, handles=handles, labels=labels, loc="outside upper right", ncols=3, markerscale=2.5)


def _draw_channel(axes: Axes, wrenches: list[Wrench], channel: int) -> None:
    recorded = np.concatenate([each.recorded[:, channel] for each in wrenches])
    limit = 1.25 * reach([recorded])
    axes.axline((0.0, 0.0), slope=1.0, color=palette.MUTED, linewidth=0.8)
    for side, marker in (("before", "s"), ("after", "o")):
        required = np.concatenate([_required(each, side, channel) for each in wrenches])
        if np.isfinite(required).any():
            style: dict[str, Any] = {
                "color": SIDES[side]["color"],
                "markersize": 3.0,
                "alpha": 0.45,
                "markeredgewidth": 0,
            }
            axes.plot(recorded, required, marker, linestyle="none", label=side, **style)
    plain(axes)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
    axes.set_aspect("equal", adjustable="box")


def _required(wrench: Wrench, side: str, channel: int) -> Array:
    curve: Array | None = getattr(wrench, side)
    return np.full(len(wrench.recorded), np.nan) if curve is None else curve[:, channel]
