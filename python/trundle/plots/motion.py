"""Recorded and simulated motion of an episode: top view, or over time on a rail, and the error over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle.picture import place_outline
from trundle.plots import top_view
from trundle.plots.style import legend
from trundle.plots.time_axes import common_scale, draw_marks, label_lanes
from trundle.report.figures.motion import events_in
from trundle.report.location import Place
from trundle.report.quantity import Scale, display_scale
from trundle.report.series import Array, Episode, Series, pose_error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.gridspec import SubplotSpec

__all__ = ["SIDES", "MotionPanels", "simulated"]

SIDES: dict[str, dict[str, Any]] = {
    "before": {"color": palette.BEFORE, "linewidth": 1.5, "linestyle": (0, (5, 2))},
    "after": {"color": palette.AFTER, "linewidth": 1.3, "linestyle": "-"},
}
"""Style of the lines of each simulation."""
_MAX_REACH = 0.6
"""Part of the size of the recorded motion by which simulations enlarge a map."""


def simulated(episode: Episode) -> list[tuple[str, Array]]:
    """Return the simulations of an episode that exist: side and poses (n, 3)."""
    return [(side, curve) for side in SIDES if (curve := getattr(episode, side)) is not None]


@dataclass(frozen=True)
class MotionPanels:
    """Panels of some episodes with common units and the same names of the simulations.

    Attributes
    ----------
    episodes
        What to draw; each has at least one simulation.
    series
        For the shape of the object.
    names
        Name of each side in the legend.
    named
        Locations of missing effects, whose events and points in the world are marked.
    """

    episodes: Sequence[Episode]
    series: Series
    names: dict[str, str]
    named: Sequence[Place] = ()

    @property
    def on_rail(self) -> bool:
        """Whether the object moves along one axis."""
        return "theta" not in self.series.dof

    def draw(self, on: Figure | SubFigure, cells: Sequence[SubplotSpec]) -> None:
        """Draw each episode into a cell of a grid; the first one has the legend."""
        panels = [
            self._draw_episode(on, cell, episode) for episode, cell in zip(self.episodes, cells, strict=True)
        ]
        handles, labels = panels[0][0].get_legend_handles_labels()
        legend(on, handles=handles, labels=labels, loc="outside upper right", ncols=4)
        for lanes in zip(*(lanes for _, lanes in panels), strict=True):
            _share_values(lanes)

    def _draw_episode(
        self, on: Figure | SubFigure, cell: SubplotSpec, episode: Episode
    ) -> tuple[Axes, list[Axes]]:
        rail = self.on_rail
        grid = cell.subgridspec(
            2 if rail else 3, 1, height_ratios=[1, 1] if rail else [3.2, 1, 1], hspace=0.05
        )
        top = on.add_subplot(grid[0])
        kind = "held out" if episode.held_out else "training"
        lanes = [on.add_subplot(grid[1], sharex=top if rail else None)]
        if rail:
            self._draw_position(top, episode)
            label_lanes([top, *lanes], [f"position ({self._metres.unit})", f"error ({self._distance.unit})"])
        else:
            lanes.append(on.add_subplot(grid[2], sharex=lanes[0]))
            self._draw_map(top, episode)
            names = [f"position\nerror ({self._distance.unit})", "heading\nerror (°)"]
            label_lanes(lanes, names)
        top.set_title(f"{episode.name} ({kind})", loc="left", fontsize=9)
        self._draw_errors(lanes, episode)
        return top, lanes

    @property
    def _metres(self) -> Scale:
        return common_scale("m", [episode.observed[:, 0] for episode in self.episodes])

    @property
    def _distance(self) -> Scale:
        rail = self.on_rail
        gaps = [pose_error(each, curve, rail)[0] for each in self.episodes for _, curve in simulated(each)]
        return common_scale("m", gaps)

    def _draw_position(self, axes: Axes, episode: Episode) -> None:
        factor = self._metres.factor
        recorded: dict[str, Any] = {"color": palette.RECORDED, "linewidth": 4.0, "label": "recorded"}
        axes.plot(episode.t, factor * episode.observed[:, 0], **recorded)
        for side, curve in simulated(episode):
            axes.plot(episode.t, factor * curve[:, 0], label=self.names[side], **SIDES[side])

    def _draw_map(self, axes: Axes, episode: Episode) -> None:
        shape = self.series.footprint
        ends = top_view.first_and_last(episode.observed)
        for pose in ends[:1]:
            top_view.draw_outlines(axes, shape, pose, palette.MUTED, ":")
        for pose in ends[1:]:
            top_view.draw_outlines(axes, shape, pose, palette.RECORDED, fill=palette.SOFT)
        top_view.draw_path(axes, episode.observed, palette.RECORDED, linewidth=4.0, label="recorded")
        for side, curve in simulated(episode):
            for pose in top_view.first_and_last(curve)[1:]:
                top_view.draw_outlines(
                    axes, shape, pose, palette.BEFORE if side == "before" else palette.AFTER
                )
            axes.plot(curve[:, 0], curve[:, 1], label=self.names[side], **SIDES[side])
        for pose in ends[:1]:
            top_view.draw_start(axes, pose)
        for place in self.named:
            if place.world is not None:
                axes.plot(*place.world.mean, marker="+", markersize=11, color=palette.MARK, linestyle="none")
        top_view.finish(axes, "world", self._around(episode))

    def _around(self, episode: Episode) -> list[Array]:
        """Return the points to show: recorded motion, and simulations and effects within a reach."""
        shape = self.series.footprint

        def placed(poses: Array) -> list[Array]:
            return [place_outline(polygon, pose) for pose in poses for polygon in shape]

        recorded = np.concatenate(
            [episode.observed[:, :2], *placed(top_view.first_and_last(episode.observed))]
        )
        seen = recorded[np.isfinite(recorded).all(axis=1)]
        if not len(seen):
            return []
        low, high = seen.min(axis=0), seen.max(axis=0)
        reach = _MAX_REACH * float((high - low).max())
        others = [curve[:, :2] for _, curve in simulated(episode)]
        others += [
            each for _, curve in simulated(episode) for each in placed(top_view.first_and_last(curve)[1:])
        ]
        others += [place.world.mean[None] for place in self.named if place.world is not None]
        return [recorded, *(np.clip(other, low - reach, high + reach) for other in others)]

    def _draw_errors(self, lanes: Sequence[Axes], episode: Episode) -> None:
        """Draw the error of each simulation, position and, except on a rail, heading."""
        scales = (self._distance, display_scale("rad", 1.0))
        for side, curve in simulated(episode):
            errors = pose_error(episode, curve, self.on_rail)
            for axes, scale, error in zip(lanes, scales, errors, strict=False):
                axes.plot(episode.t, scale.factor * error, **{**SIDES[side], "linewidth": 0.9})
        for axes in lanes:
            draw_marks(axes, (), events_in(episode, self.named))
            if not self.on_rail:
                axes.set_ylim(bottom=0.0)


def _share_values(lanes: Sequence[Axes]) -> None:
    """Give lanes the limits of the largest."""
    low, high = zip(*(axes.get_ylim() for axes in lanes), strict=True)
    for axes in lanes:
        axes.set_ylim(min(low), max(high))
