"""The missing force on the floor: arrows along the recorded paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures import marks
from trundle.report.figures.motion import interpolate_poses
from trundle.report.figures.top_view import TopView
from trundle.report.series import Array, Episode
from trundle.report.svg import Markup

__all__ = ["arrows"]

_MAX_ARROW_LENGTH, _MIN_ARROW_SPACING, _MIN_FORCE_SD = 46.0, 11.0, 3.0
"""Arrow length and spacing, user units, and the force from which an arrow is drawn, standard deviations."""


def arrows(view: TopView, episodes: Sequence[Episode]) -> tuple[list[Markup], float]:
    """Return arrows for the missing force where it exceeds the noise, and the largest force, N."""
    feet, forces = zip(*(_forces(view, episode) for episode in episodes), strict=True)
    foot, force = np.concatenate(feet), np.concatenate(forces)
    longest = float(np.hypot(*force.T).max(initial=0.0))
    if longest <= 0.0:
        return [], 0.0
    tips = view.to_page(foot) + force * np.array([1.0, -1.0]) * (_MAX_ARROW_LENGTH / longest)
    return [
        marks.arrow(start, tip, "missing-force", head=5.0)
        for start, tip in zip(view.to_page(foot), tips, strict=True)
    ], longest


def _forces(view: TopView, episode: Episode) -> tuple[Array, Array]:
    """Return spaced points (n, 2), m, and the missing forces (n, 2), N, there, both in world axes."""
    residual, none = episode.residual, np.empty((0, 2))
    missing = None if residual is None else residual.after if residual.before is None else residual.before
    if residual is None or missing is None or residual.sd is None:
        return none, none
    clear = (np.abs(missing[:, :2]) > _MIN_FORCE_SD * residual.sd[:, :2]).any(axis=1)
    poses = interpolate_poses(residual.t[clear], episode)
    rows = _spaced_rows(view.to_page(poses[:, :2]))
    (x, y, theta), (fx, fy) = poses[rows].T, missing[clear][rows, :2].T
    turned = [np.cos(theta) * fx - np.sin(theta) * fy, np.sin(theta) * fx + np.cos(theta) * fy]
    return np.column_stack([x, y]), np.column_stack(turned)


def _spaced_rows(points: Array) -> list[int]:
    """Return the indices of points (n, 2) that are at least `_MIN_ARROW_SPACING` from the one before."""
    rows: list[int] = []
    for index, point in enumerate(points):
        if np.isfinite(point).all() and (
            not rows or np.hypot(*(point - points[rows[-1]])) > _MIN_ARROW_SPACING
        ):
            rows.append(index)
    return rows
