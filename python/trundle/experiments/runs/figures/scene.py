"""The episode from above, which can be played: object, goal, obstacle, push, and the belief of the wheel."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from trundle.experiments.runs.figures.marks import box, cross, ellipse, others, oval
from trundle.experiments.runs.figures.wheel import legend
from trundle.experiments.runs.sentences import GAP, deviation, place
from trundle.experiments.runs.told import Episode, Update
from trundle.report.figures import marks as arrows
from trundle.report.figures.canvas import figure
from trundle.report.figures.top_view import TopView, transform_polygon
from trundle.report.markup import Child, Html, format_number, tag
from trundle.report.quantity import format_fixed
from trundle.report.series import Array

__all__ = ["draw"]

GHOSTS = 6
FORCE = 0.6
"""Length of the arrow of a force, user units a newton."""


def draw(identity: str, episode: Episode) -> Html:
    """Return the scene at the end of the episode, with what a script needs to show it at any other time."""
    plan, end = around(episode), len(episode.t) - 1
    before = [transform_polygon(shape, episode.pose[k]) for k in ghosts(end) for shape in episode.outline]
    drawing = plan.with_frame(
        [plan.outline(shape, "stands") for shape in episode.obstacles],
        [plan.outline(transform_polygon(shape, episode.goal[-1]), "goal") for shape in episode.outline],
        [plan.outline(shape, "start") for shape in before],
        tag("polyline", points=corners(plan.to_page(episode.pose[:, :2])), class_="way"),
        thing(plan, episode, end),
    )
    text = "The scene from above at the end of the episode; dashed outlines: where the object was before."
    panel = figure(
        f"{identity}-scene", "The episode from above", text, plan.total_height, drawing, caption(episode)
    )
    script = json.dumps(frames(plan, episode), separators=(",", ":")).replace("<", "\\u003c")
    return tag("div", panel, tag("script", Html(script), type="application/json"), class_="player")


def caption(episode: Episode) -> list[Child]:
    """Return the controls, hidden until the script is there, and what is to be seen."""
    end = len(episode.t) - 1
    slider = Html(f'<input type="range" min="0" max="{end}" value="{end}" aria-label="time in the episode">')
    controls = tag("span", tag("button", "Play", type="button"), slider, class_="controls", hidden="")
    stands = "; grey: the obstacle" if episode.obstacles else ""
    wheel = "; box: where it is" if episode.wheel is not None else ""
    return [
        controls,
        tag("output", moment(episode, end)),
        f"Green: the goal{stands}; line: the way of the object's frame; arrow: the force on the object. "
        f"Cross and ellipse (95{GAP}%): where the wheel is believed{wheel}.",
        legend(episode),
    ]


def around(episode: Episode) -> TopView:
    """Return a map of everything that is to be seen at some time."""
    few = np.linspace(0, len(episode.t) - 1, 60).astype(int)
    shapes = [transform_polygon(shape, episode.pose[k]) for k in few for shape in episode.outline]
    shapes += [transform_polygon(shape, episode.goal[-1]) for shape in episode.outline]
    return TopView.around([episode.pose[:, :2], *shapes, *episode.obstacles])


def ghosts(end: int) -> list[int]:
    """Return the samples at which the outline is drawn, beside the last."""
    return [int(k) for k in np.linspace(0, end, GHOSTS + 1)[:-1]]


def corners(points: Array) -> str:
    """Return points (n, 2) as SVG lists them."""
    return " ".join(f"{format_number(x)},{format_number(y)}" for x, y in points)


def thing(plan: TopView, episode: Episode, index: int) -> Html:
    """Return the object and what belongs to it at a sample, in a group that moves as it does."""
    local = np.array([plan.scale, -plan.scale])
    ahead = 0.6 * max(float(shape[:, 0].max()) for shape in episode.outline) * plan.scale
    nose = arrows.arrow(np.zeros(2), np.array([ahead, 0.0]), "nose", head=7.0)
    wheel = episode.wheel
    x, y, turn = pose(plan, episode.pose[index])
    return tag(
        "g",
        [tag("polygon", points=corners(shape * local), class_="footprint") for shape in episode.outline],
        [tag("circle", cx=u, cy=v, r=2.5, class_="support") for u, v in episode.support * local],
        nose,
        believed(plan, at(episode, index)),
        others((), episode.hidden, lambda at: at * local),
        None if wheel is None else box(wheel.at * local, wheel.angle),
        tag("path", d=force(plan, episode, index), class_="force"),
        transform=f"translate({x:.2f} {y:.2f}) rotate({turn:.2f})",
        class_="moving",
    )


def believed(plan: TopView, update: Update | None) -> Html:
    """Return the belief of the wheel; an empty group that a script fills where there is none."""
    local = np.array([plan.scale, -plan.scale])
    drawn: list[Child] = []
    if update is not None and update.wheel is not None:
        middle, shape = update.wheel.at * local, oval(update.spread, plan.scale, 60.0)
        drawn = [None if shape is None else ellipse(middle, shape), cross(middle)]
    if update is not None:
        drawn += others(update.others, (), lambda at: at * local)
    return tag("g", drawn, class_="belief")


def pose(plan: TopView, at_: Array) -> tuple[float, float, float]:
    """Return a pose (3,) as place in user units and turn, degrees, clockwise on the page."""
    x, y = plan.to_page(at_[None, :2])[0]
    return float(x), float(y), -math.degrees(at_[2])


def force(plan: TopView, episode: Episode, index: int) -> str:
    """Return the arrow of the force on the object, in its frame; nothing before the first push."""
    push = episode.wrench[index, :2] * np.array([1.0, -1.0]) * FORCE
    foot = episode.grasp[index] * np.array([plan.scale, -plan.scale])
    length = float(np.hypot(*push))
    if index == 0 or length < 2.0:
        return ""
    back = push / length * min(8.0, length)
    side = 0.5 * np.array([-back[1], back[0]])
    head = corners(np.array([foot + push - back + side, foot + push, foot + push - back - side]))
    return f"M{corners(np.array([foot]))}L{corners(np.array([foot + push]))}M{head.replace(' ', 'L')}"


def at(episode: Episode, index: int) -> Update | None:
    """Return what was believed at a sample."""
    time = episode.t[index] + 1e-9
    return next((each for each in reversed(episode.updates) if each.time <= time), None)


def frames(plan: TopView, episode: Episode) -> dict[str, Any]:
    """Return what changes: poses and arrows by sample, beliefs by update, and what is said of each sample."""
    indices = range(len(episode.t))
    starts = [int(np.searchsorted(episode.t, update.time - 1e-9)) for update in episode.updates]
    poses = [[round(value, 2) for value in pose(plan, row)] for row in episode.pose]
    way = plan.to_page(episode.pose[:, :2])
    return {
        "period": float(np.median(np.diff(episode.t))),
        "poses": poses,
        "way": [corners(point[None]) for point in way],
        "force": [force(plan, episode, index) for index in indices],
        "beliefs": [[0, ""], *([k, inner(plan, u)] for k, u in zip(starts, episode.updates, strict=True))],
        "said": [moment(episode, index) for index in indices],
    }


def inner(plan: TopView, update: Update) -> str:
    """Return the content of the group of a belief."""
    whole = believed(plan, update)
    return whole[whole.index(">") + 1 : whole.rindex("</g>")]


def moment(episode: Episode, index: int) -> str:
    """Return what is to be said of a sample."""
    update, distance = at(episode, index), episode.distance[index]
    parts = [f"{format_fixed(episode.t[index], 2)}{GAP}s"]
    parts += [f"{format_fixed(distance, 2)}{GAP}m to go"] if math.isfinite(distance) else []
    if update is not None and update.wheel is not None:
        parts += [f"wheel at {place(update.wheel.at, deviation(update))}"]
    return ", ".join(parts)
