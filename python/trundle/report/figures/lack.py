"""The missing force on the floor: arrows along the recorded paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures import marks
from trundle.report.figures.motion import poses_at
from trundle.report.figures.plan import Plan
from trundle.report.given import Array, Episode
from trundle.report.markup import Html

__all__ = ["arrows"]

_LONGEST, _APART, _CLEAR = 46.0, 11.0, 3.0
"""Of an arrow and between arrows, user units; standard deviations from which a force is clear of noise."""


def arrows(plan: Plan, episodes: Sequence[Episode]) -> tuple[list[Html], float]:
    """Return the missing force along the paths where it is clear of noise, and the greatest, N."""
    feet, forces = zip(*(_forces(plan, episode) for episode in episodes), strict=True)
    foot, force = np.concatenate(feet), np.concatenate(forces)
    longest = float(np.hypot(*force.T).max(initial=0.0))
    if longest <= 0.0:
        return [], 0.0
    tips = plan.at(foot) + force * np.array([1.0, -1.0]) * (_LONGEST / longest)
    return [
        marks.arrow(start, tip, "lack", head=5.0) for start, tip in zip(plan.at(foot), tips, strict=True)
    ], longest


def _forces(plan: Plan, episode: Episode) -> tuple[Array, Array]:
    """Return where (n, 2) m and how (n, 2) N force is missing, world axes, here and there along the path."""
    lack, none = episode.residual, np.empty((0, 2))
    missing = None if lack is None else lack.after if lack.before is None else lack.before
    if lack is None or missing is None or lack.sd is None:
        return none, none
    clear = (np.abs(missing[:, :2]) > _CLEAR * lack.sd[:, :2]).any(axis=1)
    poses = poses_at(lack.t[clear], episode)
    rows = _apart(plan.at(poses[:, :2]))
    (x, y, theta), (fx, fy) = poses[rows].T, missing[clear][rows, :2].T
    turned = [np.cos(theta) * fx - np.sin(theta) * fy, np.sin(theta) * fx + np.cos(theta) * fy]
    return np.column_stack([x, y]), np.column_stack(turned)


def _apart(points: Array) -> list[int]:
    """Return indices of points (n, 2), each some way from the one before it."""
    rows: list[int] = []
    for index, point in enumerate(points):
        if np.isfinite(point).all() and (not rows or np.hypot(*(point - points[rows[-1]])) > _APART):
            rows.append(index)
    return rows
