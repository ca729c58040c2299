"""The figure of an effect: its push with and without the effect, and the residual wrench."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.report.svg import Markup, join
from website.chart import Panel, key, svg
from website.effect_push import GRASP, WHEEL_POSITION, Motion, effect_values, residual, simulate

__all__ = ["changes_motion", "draw_effect"]

WIDTH, HEIGHT = 760.0, 330.0
LEFT = (40.0, 40.0, 310.0, 262.0)
FORCE, TORQUE = (430.0, 40.0, 322.0, 124.0), (430.0, 200.0, 322.0, 102.0)
CORNERS = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4], [-0.6, -0.4]])
DURATION_S = 6.0
EDGE_S = 0.02
"""Time at both ends of the push that is not shown: derivatives are one-sided there."""
SHOWN_EVERY = 4
"""Every which sample is drawn."""
CLIPPED_PERCENTILE = 99.0
"""Percentile of the residual that the axes contain: an impact is a spike."""

Points = NDArray[np.float64]


def changes_motion(effect: dict[str, Any]) -> bool:
    """Return whether the recorded poses of an effect's push differ from those without it."""
    return not np.allclose(effect_motion(effect).pose, simulate().pose, atol=1e-9)


def effect_motion(effect: dict[str, Any]) -> Motion:
    """Return the push with the effect."""
    return simulate(("kind", effect["kind"]), *effect_values(effect).items())


def draw_effect(effect: dict[str, Any]) -> str:
    """Return the figure as an SVG element; the same effect gives the same text."""
    motion = effect_motion(effect)
    left = paths(motion, effect) if changes_motion(effect) else readings(motion)
    description = f"A push with and without {effect['kind']}, and the residual wrench"
    return svg(WIDTH, HEIGHT, description, [left, residual_panels(motion)])


def paths(motion: Motion, effect: dict[str, Any]) -> Markup:
    """Return the path of the object's origin from above, with its outline at the start and at the end."""
    nominal, values = simulate(), effect_values(effect)
    outlines = [outline(np.zeros(3)), outline(nominal.pose[-1]), outline(motion.pose[-1])]
    shown = [*outlines, nominal.pose[:, :2], motion.pose[:, :2]]
    panel = Panel.equal(*LEFT, np.concatenate(shown))
    parts = [
        panel.axes("Path from above", "x, m", "y, m"),
        *([panel.area(region(values), "region")] if "half_length" in values else []),
        panel.area(outlines[0], "start"),
        panel.text("▸", GRASP, "without"),
        panel.text("■", WHEEL_POSITION, "without"),
        *(panel.text("✕", place, "with") for place in places(values)),
    ]
    for one, end, style in ((nominal, outlines[1], "without"), (motion, outlines[2], "with")):
        parts += [panel.line(one.pose[::SHOWN_EVERY, :2], style), panel.line(end, f"{style} thin")]
    return join([*parts, key([("without", "without"), ("with", "with effect")], LEFT[0] + LEFT[2], 32)])


def places(values: dict[str, float]) -> list[tuple[float, float]]:
    """Return the points of the body and of the world to which an effect's values refer."""
    pairs = (("x", "y"), ("com_x", "com_y"), ("anchor_x", "anchor_y"))
    return [(values[x], values[y]) for x, y in pairs if x in values and "half_length" not in values]


def region(values: dict[str, float]) -> Points:
    """Return the corners of the rectangle to which an effect's values refer."""
    half = np.array([values["half_length"], values["half_width"]])
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return moved(signs * half, np.array([values["x"], values["y"], values["angle"]]))


def outline(pose: Points) -> Points:
    """Return the corners of the object at a pose."""
    return moved(CORNERS, pose)


def moved(points: Points, pose: Points) -> Points:
    """Return points of a frame at a pose."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + pose[:2])


def readings(motion: Motion) -> Markup:
    """Return the forces of the same motion, as they acted and as they were read."""
    acted, read = simulate().reading, motion.reading
    top = 1.25 * float(np.abs(np.concatenate([acted, read])[:, :2]).max())
    panel = Panel(*LEFT, (0.0, DURATION_S), (-top, top))
    names = [("without", "acted"), ("with", "read"), ("with dashed", "read, y")]
    parts = [panel.axes("Force", "time, s", "N")]
    for column, extra in ((0, ""), (1, " dashed")):
        parts.append(panel.line(over_time(motion.t, acted[:, column]), f"without{extra}"))
        parts.append(panel.line(over_time(motion.t, read[:, column]), f"with{extra}"))
    return join([*parts, key(names, LEFT[0] + LEFT[2], 32)])


def residual_panels(motion: Motion) -> Markup:
    """Return the residual wrench of the nominal model over time."""
    wrench = residual(motion)
    shown = visible(motion.t)
    force, torque = wrench[shown, :2], wrench[shown, 2:]
    upper = Panel(*FORCE, (0.0, DURATION_S), limits(force, 2.0))
    lower = Panel(*TORQUE, (0.0, DURATION_S), limits(torque, 0.5))
    return join(
        [
            upper.axes("Residual force", None, "N"),
            upper.line(over_time(motion.t, wrench[:, 0]), "with"),
            upper.line(over_time(motion.t, wrench[:, 1]), "second dashed"),
            key([("with", "x"), ("second dashed", "y")], FORCE[0] + FORCE[2], 32),
            lower.axes("Residual torque", "time, s", "N·m"),
            lower.line(over_time(motion.t, wrench[:, 2]), "third"),
        ]
    )


def limits(values: Points, least: float) -> tuple[float, float]:
    """Return symmetric limits of an axis, at least ±`least`."""
    top = max(1.35 * float(np.percentile(np.abs(values), CLIPPED_PERCENTILE)), least)
    return -top, top


def over_time(t: Points, values: Points) -> Points:
    """Return the points (time, value) that a figure shows."""
    shown = visible(t)
    return np.column_stack([t[shown], values[shown]])


def visible(t: Points) -> Any:
    """Return the indices of the samples that a figure shows."""
    return np.flatnonzero((t >= EDGE_S) & (t <= DURATION_S - EDGE_S))[::SHOWN_EVERY]
