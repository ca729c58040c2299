"""The animated top view of an episode: object, goal, obstacle, push, and the estimated wheel."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from trundle.experiments.runs.figures.marks import box, cross, effect_marks, ellipse, ellipse_axes
from trundle.experiments.runs.figures.wheel import legend
from trundle.experiments.runs.history import Episode, Update
from trundle.experiments.runs.sentences import GAP, format_point, place_sd
from trundle.report.figures import marks as arrows
from trundle.report.figures.canvas import figure
from trundle.report.figures.top_view import TopView, transform_polygon
from trundle.report.markup import Child, Html, format_number, tag
from trundle.report.quantity import format_fixed
from trundle.report.series import Array

__all__ = ["draw"]

MAX_START_OUTLINES = 6
FORCE_SCALE = 0.6
"""Length of a force arrow, user units per newton."""


def draw(identity: str, episode: Episode) -> Html:
    """Return the scene at the end of the episode, with the data of the animation."""
    plan, end = scene_plan(episode), len(episode.t) - 1
    before = [
        transform_polygon(shape, episode.pose[k]) for k in outline_samples(end) for shape in episode.outline
    ]
    drawing = plan.with_frame(
        [plan.outline(shape, "stands") for shape in episode.obstacles],
        [plan.outline(transform_polygon(shape, episode.goal[-1]), "goal") for shape in episode.outline],
        [plan.outline(shape, "start") for shape in before],
        tag("polyline", points=svg_points(plan.to_page(episode.pose[:, :2])), class_="way"),
        object_group(plan, episode, end),
    )
    text = "Top view at the end of the episode; dashed outlines: earlier poses of the object."
    panel = figure(
        f"{identity}-scene", "Top view of the episode", text, plan.total_height, drawing, caption(episode)
    )
    script = json.dumps(frame_data(plan, episode), separators=(",", ":")).replace("<", "\\u003c")
    return tag("div", panel, tag("script", Html(script), type="application/json"), class_="player")


def caption(episode: Episode) -> list[Child]:
    """Return the controls, which a script shows, and the legend."""
    end = len(episode.t) - 1
    slider = Html(f'<input type="range" min="0" max="{end}" value="{end}" aria-label="time in the episode">')
    controls = tag("span", tag("button", "Play", type="button"), slider, class_="controls", hidden="")
    stands = "; grey: the obstacle" if episode.obstacles else ""
    wheel = "; box: the true wheel" if episode.wheel is not None else ""
    return [
        controls,
        tag("output", moment_text(episode, end)),
        f"Green: the goal{stands}; line: path of the object's origin; arrow: force on the object. "
        f"Cross and ellipse (95{GAP}%): the estimated wheel{wheel}.",
        legend(episode),
    ]


def scene_plan(episode: Episode) -> TopView:
    """Return the map of the whole scene."""
    few = np.linspace(0, len(episode.t) - 1, 60).astype(int)
    shapes = [transform_polygon(shape, episode.pose[k]) for k in few for shape in episode.outline]
    shapes += [transform_polygon(shape, episode.goal[-1]) for shape in episode.outline]
    return TopView.around([episode.pose[:, :2], *shapes, *episode.obstacles])


def outline_samples(end: int) -> list[int]:
    """Return the samples whose outlines are drawn."""
    return [int(k) for k in np.linspace(0, end, MAX_START_OUTLINES + 1)[:-1]]


def svg_points(points: Array) -> str:
    """Return points (n, 2) as an SVG list."""
    return " ".join(f"{format_number(x)},{format_number(y)}" for x, y in points)


def object_group(plan: TopView, episode: Episode, index: int) -> Html:
    """Return the object and its marks at a sample, in a group that moves with it."""
    local = np.array([plan.scale, -plan.scale])
    ahead = 0.6 * max(float(shape[:, 0].max()) for shape in episode.outline) * plan.scale
    nose = arrows.arrow(np.zeros(2), np.array([ahead, 0.0]), "nose", head=7.0)
    wheel = episode.wheel
    x, y, turn = svg_pose(plan, episode.pose[index])
    return tag(
        "g",
        [tag("polygon", points=svg_points(shape * local), class_="footprint") for shape in episode.outline],
        [tag("circle", cx=u, cy=v, r=2.5, class_="support") for u, v in episode.support * local],
        nose,
        belief_group(plan, update_at(episode, index)),
        effect_marks((), episode.hidden, lambda at: at * local),
        None if wheel is None else box(wheel.at * local, wheel.angle),
        tag("path", d=force_path(plan, episode, index), class_="force"),
        transform=f"translate({x:.2f} {y:.2f}) rotate({turn:.2f})",
        class_="moving",
    )


def belief_group(plan: TopView, update: Update | None) -> Html:
    """Return the marks of a belief; an empty group, which a script fills, without one."""
    local = np.array([plan.scale, -plan.scale])
    drawn: list[Child] = []
    if update is not None and update.wheel is not None:
        middle, shape = update.wheel.at * local, ellipse_axes(update.wheel_covariance, plan.scale, 60.0)
        drawn = [None if shape is None else ellipse(middle, shape), cross(middle)]
    if update is not None:
        drawn += effect_marks(update.other_effects, (), lambda at: at * local)
    return tag("g", drawn, class_="belief")


def svg_pose(plan: TopView, at_: Array) -> tuple[float, float, float]:
    """Return a pose (3,) as position in user units and clockwise rotation, degrees."""
    x, y = plan.to_page(at_[None, :2])[0]
    return float(x), float(y), -math.degrees(at_[2])


def force_path(plan: TopView, episode: Episode, index: int) -> str:
    """Return the arrow of the force on the object, in its frame; empty before the first push."""
    push = episode.wrench[index, :2] * np.array([1.0, -1.0]) * FORCE_SCALE
    foot = episode.grasp[index] * np.array([plan.scale, -plan.scale])
    length = float(np.hypot(*push))
    if index == 0 or length < 2.0:
        return ""
    back = push / length * min(8.0, length)
    side = 0.5 * np.array([-back[1], back[0]])
    head = svg_points(np.array([foot + push - back + side, foot + push, foot + push - back - side]))
    return f"M{svg_points(np.array([foot]))}L{svg_points(np.array([foot + push]))}M{head.replace(' ', 'L')}"


def update_at(episode: Episode, index: int) -> Update | None:
    """Return the belief at a sample."""
    time = episode.t[index] + 1e-9
    return next((each for each in reversed(episode.updates) if each.time <= time), None)


def frame_data(plan: TopView, episode: Episode) -> dict[str, Any]:
    """Return the data of the animation: poses, arrows and texts by sample, beliefs by update."""
    indices = range(len(episode.t))
    starts = [int(np.searchsorted(episode.t, update.time - 1e-9)) for update in episode.updates]
    poses = [[round(value, 2) for value in svg_pose(plan, row)] for row in episode.pose]
    way = plan.to_page(episode.pose[:, :2])
    return {
        "period": float(np.median(np.diff(episode.t))),
        "poses": poses,
        "way": [svg_points(point[None]) for point in way],
        "force": [force_path(plan, episode, index) for index in indices],
        "beliefs": [
            [0, ""],
            *([k, group_content(plan, u)] for k, u in zip(starts, episode.updates, strict=True)),
        ],
        "said": [moment_text(episode, index) for index in indices],
    }


def group_content(plan: TopView, update: Update) -> str:
    """Return the content of the group of a belief."""
    whole = belief_group(plan, update)
    return whole[whole.index(">") + 1 : whole.rindex("</g>")]


def moment_text(episode: Episode, index: int) -> str:
    """Return the text of a sample."""
    update, distance = update_at(episode, index), episode.distance[index]
    parts = [f"{format_fixed(episode.t[index], 2)}{GAP}s"]
    parts += [f"{format_fixed(distance, 2)}{GAP}m to go"] if math.isfinite(distance) else []
    if update is not None and update.wheel is not None:
        parts += [f"wheel at {format_point(update.wheel.at, place_sd(update))}"]
    return ", ".join(parts)
