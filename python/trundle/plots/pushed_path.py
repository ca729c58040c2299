"""The path of one push from above, with outlines of the object and arrows of the force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle.plots import top_view
from trundle.plots.style import legend
from trundle.report.series import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_pushed_path"]

_OUTLINES, _ARROWS = 5, 14


def draw_pushed_path(axes: Axes, each: Mapping[str, Any], shape: Sequence[Array]) -> None:
    """Draw the path, outlines along it, and the force on the object at the origin of its frame."""
    poses = each["pose"][np.isfinite(each["pose"]).all(axis=1)]
    for at in np.unique(np.linspace(0, len(poses) - 1, _OUTLINES).astype(int)):
        last = at == len(poses) - 1
        colour = palette.INK if last else palette.RECORDED
        top_view.draw_outlines(axes, shape, poses[at], colour, "-" if last else ":")
    top_view.draw_path(axes, poses, palette.RECORDED, linewidth=3.0, label="path of the origin")
    if len(poses):
        top_view.draw_start(axes, poses[0])
    longest = _draw_forces(axes, each)
    if longest > 0.0:
        axes.plot([], [], color=palette.BEFORE, label=f"force, at most {longest:.3g} N")
    top_view.finish(axes, "world")
    legend(axes, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)


def _draw_forces(axes: Axes, each: Mapping[str, Any]) -> float:
    """Draw arrows of the force where it acts, at even times, and return the largest force, N."""
    t, wrench, frame = each["wrench_t"], each["on_object"], each["frame"]
    rows = np.unique(np.linspace(0, len(t) - 1, _ARROWS + 2).astype(int))[1:-1]
    rows = rows[(t[rows] >= each["contact"]) & np.isfinite(wrench[rows]).all(axis=1)]
    seen = np.isfinite(each["pose"]).all(axis=1)
    if not len(rows) or not seen.any():
        return 0.0
    x, y, theta = (
        np.interp(t[rows], each["pose_t"][seen], column)
        for column in (each["pose"][seen, 0], each["pose"][seen, 1], np.unwrap(each["pose"][seen, 2]))
    )
    cos, sin = np.cos(theta), np.sin(theta)
    (fx, fy), (gx, gy) = wrench[rows, :2].T, frame[rows, :2].T
    grasp = np.column_stack([x + cos * gx - sin * gy, y + sin * gx + cos * gy])
    force = np.column_stack([cos * fx - sin * fy, sin * fx + cos * fy])
    longest = float(np.hypot(*wrench[:, :2].T).max())
    if longest <= 0.0:
        return 0.0
    size = 0.3 * float(max(np.ptp(np.vstack([grasp, np.column_stack([x, y])]), axis=0).max(), 1e-3))
    for start, arrow in zip(grasp, force * size / longest, strict=True):
        axes.plot(*start, marker=".", markersize=3, color=palette.BEFORE, linestyle="none")
        top_view.draw_arrow(axes, start, start + arrow, palette.BEFORE)
    axes.update_datalim(np.vstack([grasp, grasp + force * size / longest]))
    axes.autoscale_view()
    return longest
