"""The animated top view of an episode: object, goal, obstacle, push, and the estimated wheel."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trundle.experiments.runs.figures.wheel import estimate_marks, true_marks
from trundle.experiments.runs.history import Episode, Update
from trundle.experiments.runs.sentences import GAP
from trundle.picture import place_outline
from trundle.report.figures.canvas import Figure, figure
from trundle.report.figures.data import Table
from trundle.report.figures.marks import arrow, arrow_path
from trundle.report.figures.top_view import TopView
from trundle.report.quantity import format_fixed, format_point
from trundle.report.series import Array
from trundle.report.svg import Markup, format_number, join, tag

__all__ = ["draw", "frames"]

OUTLINES_ALONG_PATH = 6
"""Outlines of the object at earlier samples."""
FORCE_SCALE = 0.6
"""Length of a force arrow, user units per newton."""
ELLIPSE_REACH = 60.0
"""Largest half axis of the ellipse, user units."""


def draw(identity: str, episode: Episode) -> Figure:
    """Return the scene at the end of the episode."""
    view, end = scene_view(episode), len(episode.t) - 1
    before = episode.pose[np.linspace(0, end, OUTLINES_ALONG_PATH + 1)[:-1].astype(int)]
    points = " ".join(f"{format_number(x)},{format_number(y)}" for x, y in view.to_page(episode.pose[:, :2]))
    drawing = view.with_frame(
        [view.outline(shape, "obstacle") for shape in episode.obstacles],
        [view.outline(shape, "goal") for shape in outlines_at(episode, episode.goal[None])],
        [view.outline(shape, "start") for shape in outlines_at(episode, before)],
        tag("polyline", points=points, class_="track"),
        object_group(view, episode, end),
    )
    text = "Top view at the end of the episode; dashed outlines: earlier poses of the object."
    names = ("x, m", "y, m", "heading, rad", "force along the object, N", "force across it, N", "torque, N·m")
    data = Table(names, episode.t, np.column_stack([episode.pose, episode.wrench])).data()
    return figure(f"{identity}-scene", "Top view of the episode", text, view.total_height, drawing, data=data)


def frames(episode: Episode) -> dict[str, Any]:
    """Return the data of the animation: poses, forces and texts by sample, estimates by update."""
    view, samples = scene_view(episode), range(len(episode.t))
    estimates = [
        [int(np.searchsorted(episode.t, update.time - 1e-9)), estimate_group(view, update)]
        for update in episode.updates
    ]
    return {
        "period": float(np.median(np.diff(episode.t))),
        "poses": [[round(value, 2) for value in page_pose(view, pose)] for pose in episode.pose],
        "forces": [force_path(view, episode, index) for index in samples],
        "estimates": [[0, ""], *estimates],
        "texts": [moment_text(episode, index) for index in samples],
    }


def scene_view(episode: Episode) -> TopView:
    """Return the map of the whole scene."""
    few = episode.pose[np.linspace(0, len(episode.t) - 1, 60).astype(int)]
    shapes = [*outlines_at(episode, few), *outlines_at(episode, episode.goal[None])]
    return TopView.around([episode.pose[:, :2], *shapes, *episode.obstacles])


def outlines_at(episode: Episode, poses: Array) -> list[Array]:
    """Return the outlines of the object in the world at poses (n, 3)."""
    return [place_outline(shape, pose) for pose in poses for shape in episode.outline]


def object_group(view: TopView, episode: Episode, index: int) -> Markup:
    """Return the object and its marks at a sample, in a group that moves with it."""
    local = view.at_origin()
    ahead = 0.6 * max(float(shape[:, 0].max()) for shape in episode.outline) * view.scale
    x, y, turn = page_pose(view, episode.pose[index])
    return tag(
        "g",
        [local.outline(shape, "footprint") for shape in episode.outline],
        [tag("circle", cx=u, cy=v, r=2.5, class_="support") for u, v in local.to_page(episode.support)],
        arrow(np.zeros(2), np.array([ahead, 0.0]), "heading", head=7.0),
        true_marks(local, episode),
        tag("g", estimate_group(view, update_at(episode, index)), class_="estimate-marks"),
        tag("path", d=force_path(view, episode, index), class_="force"),
        transform=f"translate({x:.2f} {y:.2f}) rotate({turn:.2f})",
        class_="moving",
    )


def estimate_group(view: TopView, update: Update | None) -> Markup:
    """Return the marks of a belief in the frame of the moving group."""
    return join(estimate_marks(view.at_origin(), update, ELLIPSE_REACH))


def page_pose(view: TopView, pose: Array) -> tuple[float, float, float]:
    """Return a pose (3,) as position in user units and clockwise rotation, degrees."""
    x, y = view.to_page(pose[None, :2])[0]
    return float(x), float(y), -math.degrees(pose[2])


def force_path(view: TopView, episode: Episode, index: int) -> str:
    """Return the arrow of the force on the object, in its frame; empty before the first push."""
    push = episode.wrench[index, :2] * np.array([1.0, -1.0]) * FORCE_SCALE
    grasp = view.at_origin().to_page(episode.grasp[index])
    length = float(np.hypot(*push))
    return "" if index == 0 or length < 2.0 else arrow_path(grasp, grasp + push, min(8.0, length))


def update_at(episode: Episode, index: int) -> Update | None:
    """Return the belief at a sample."""
    time = episode.t[index] + 1e-9
    return next((each for each in reversed(episode.updates) if each.time <= time), None)


def moment_text(episode: Episode, index: int) -> str:
    """Return the text of a sample."""
    update, distance = update_at(episode, index), episode.distance[index]
    parts = [f"{format_fixed(episode.t[index], 2)}{GAP}s"]
    parts += [f"{format_fixed(distance, 2)}{GAP}m to go"] if math.isfinite(distance) else []
    if update is not None and update.wheel is not None:
        parts += [f"wheel at {format_point(update.wheel.at, update.wheel_sd)}"]
    return ", ".join(parts)
