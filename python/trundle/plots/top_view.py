"""Elements of top views: outlines of the object, paths, ellipses and arrows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle._optional import require
from trundle.picture import place_outline
from trundle.plots.style import plain
from trundle.report.series import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_arrow", "draw_outlines", "draw_path", "draw_start", "finish", "first_and_last"]


def draw_outlines(
    axes: Axes, shape: Iterable[Array], pose: Array, colour: str, style: str = "-", fill: str = "none"
) -> None:
    """Draw the outline of the object, polygons (n, 2) in m, at a pose (3,), m, m, rad."""
    patches = require("matplotlib.patches", "plots", "plots")
    for polygon in shape:
        axes.add_patch(
            patches.Polygon(
                place_outline(polygon, pose),
                closed=True,
                edgecolor=colour,
                facecolor=fill,
                linestyle=style,
                linewidth=0.9,
            )
        )
    axes.autoscale_view()


def draw_path(axes: Axes, poses: Array, colour: str, **more: object) -> None:
    """Draw the path of the object's origin through poses (n, 3)."""
    axes.plot(poses[:, 0], poses[:, 1], color=colour, solid_joinstyle="round", **more)  # type: ignore[arg-type]


def draw_start(axes: Axes, pose: Array) -> None:
    """Mark where a path starts."""
    axes.plot(*pose[:2], marker="o", markersize=4, color=palette.INK, linestyle="none", label="start")


def draw_arrow(
    axes: Axes, start: Array, end: Array, colour: str, both: bool = False, width: float = 1.2
) -> None:
    """Draw an arrow between two points (2,), m; with `both`, it has a head at each end."""
    style: dict[str, Any] = {"arrowstyle": "<->" if both else "->", "color": colour, "linewidth": width}
    axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops={**style, "shrinkA": 0, "shrinkB": 0})


def first_and_last(poses: Array) -> Array:
    """Return the first and the last finite pose, (2, 3) or (0, 3)."""
    seen = poses[np.isfinite(poses).all(axis=1)]
    return seen[[0, -1]] if len(seen) else seen


def finish(axes: Axes, frame: str = "", around: Sequence[Array] = ()) -> None:
    """Give a top view equal scales, labels, and limits around points (n, 2), m; `frame` is its frame."""
    plain(axes)
    of = f", {frame} frame" if frame else ""
    axes.set(xlabel=f"x (m){of}", ylabel="y (m)")
    cloud = np.concatenate([np.empty((0, 2)), *around])
    cloud = cloud[np.isfinite(cloud).all(axis=1)]
    if len(cloud):
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        margin = 0.06 * float(max((high - low).max(), 1e-3))
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set_aspect("equal", adjustable="box")
